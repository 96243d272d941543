use super::bound::bound;
use super::polish::{Candidate, polish};
use super::*;
use crate::Point;
use crate::optimize::functions::{Function, Shifted};
use crate::optimize::{Cost, Objective};
use crate::query::Limits;
use crate::world::{Footprint, Shape, World};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::sync::Arc;

const ROOM: [(f64, f64, f64); 8] = [
    (1.20, 0.95, 0.8),
    (2.35, 1.55, 0.6),
    (2.10, 3.00, 1.0),
    (3.70, 2.05, 0.9),
    (4.10, 0.60, 0.7),
    (6.50, 1.50, 1.2),
    (7.50, 4.20, 1.0),
    (0.90, 3.90, 0.5),
];

fn room(discs: &[(f64, f64, f64)], ends: [Point; 2]) -> Query {
    let shapes = discs.iter().map(|&(x, y, d)| Shape::disc([x, y], d / 2.0).unwrap()).collect();
    let world = World::from_shapes([0.0, 0.0, 10.0, 6.0], shapes, 0.1).unwrap();
    let mut query = Query::new(Arc::new(world), ends[0], ends[1]);
    query.footprint = Footprint::Disc(0.3);
    let (turn_rate, lateral_acceleration) = (Some(2.0), Some(2.0));
    query.limits = Limits { speed: 2.0, acceleration: 5.0, deceleration: 5.0, jerk: 10.0, turn_rate, turn_acceleration: None, lateral_acceleration };
    query
}

#[test]
fn descent_finds_the_bottom_of_smooth_bowls_and_valleys() {
    for (function, steps, within) in [(Function::Sphere, 20, 1e-6), (Function::Rosenbrock, 200, 1e-3)] {
        let f = Shifted::aside(function, 6, 0.02);
        let x = vec![1.5; 6];
        let from = Candidate { cost: f.costs(std::slice::from_ref(&x)).unwrap()[0], x };
        let before = from.cost;
        let (found, stop) = polish(&f, from, steps, &mut Context::new(0)).unwrap();
        assert!(stop.is_none() && found.cost.beats(before) && found.cost.value < within, "{function:?}: {}", found.cost.value);
    }
}

/// A bowl whose bottom lies where it is not allowed: `x0 >= 1`, `x1 <= 0.5` by the box.
struct Fenced([(f64, f64); 2]);

impl Objective for Fenced {
    fn bounds(&self) -> &[(f64, f64)] {
        &self.0
    }
    fn costs(&self, xs: &[Vec<f64>]) -> Result<Vec<Cost>, PlanError> {
        let cost = |x: &Vec<f64>| Cost { violation: (1.0 - x[0]).max(0.0), value: x[0] * x[0] + (x[1] - 2.0).powi(2), tie: 0.0 };
        Ok(xs.iter().map(cost).collect())
    }
}

#[test]
fn descent_keeps_constraints_and_the_box() {
    let f = Fenced([(-3.0, 3.0), (-3.0, 0.5)]);
    let x = vec![-2.0, -2.0];
    let from = Candidate { cost: f.costs(std::slice::from_ref(&x)).unwrap()[0], x };
    let (found, _) = polish(&f, from, 60, &mut Context::new(0)).unwrap();
    assert!(found.cost.feasible() && (found.x[0] - 1.0).abs() < 1e-2 && (found.x[1] - 0.5).abs() < 1e-6, "{found:?}");
}

#[test]
fn no_free_curve_is_below_the_bound() {
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    let mut compared = 0;
    for case in 0..12 {
        let discs: Vec<(f64, f64, f64)> =
            (0..4).map(|_| (rng.random_range(1.0..9.0), rng.random_range(1.0..5.0), rng.random_range(0.4..1.2))).collect();
        let query = room(&discs, [[0.2, 0.2 + 0.4 * f64::from(case)], [9.6, 5.5 - 0.4 * f64::from(case)]]);
        let Ok(atlas) = homotopy::atlas(&query, 4, &mut Context::new(0)) else { continue };
        for objective in [crate::plan::swarm::Form::Repaired, crate::plan::swarm::Form::Literal] {
            let settings = Settings { objective, points: 5, ..Settings::default() };
            let bound = bound(&query, &settings, atlas.classes[0].length, &mut Context::new(0));
            let curves = Curves::new(&query, &settings).unwrap();
            for class in &atlas.classes {
                let base = curves.fit(&class.points);
                for _ in 0..40 {
                    let x: Vec<f64> = base.iter().map(|v| v + rng.random_range(-0.3..0.3)).collect();
                    let judged = curves.judge(&x);
                    if judged.violation == 0.0 {
                        assert!(judged.value >= bound.lower, "case {case}: {} is below {}", judged.value, bound.lower);
                        compared += 1;
                    }
                }
            }
        }
    }
    assert!(compared > 100, "{compared}");
}

#[test]
fn the_bound_grows_with_the_steps_and_is_near_what_is_found_in_the_room() {
    let query = room(&ROOM, [[0.0, 0.0], [5.0, 3.0]]);
    let found = Aide::default().plan(&query, &mut Context::new(1)).unwrap();
    let bound = &found.trace["bound"];
    let (lower, gap) = (bound["lower"].as_f64().unwrap(), bound["gap"].as_f64().unwrap());
    assert!(lower <= found.cost && (0.0..0.1).contains(&gap), "{bound}");
    let open = query.stops().into_iter().map(|p| query.world.clearance(p)).fold(f64::INFINITY, f64::min);
    assert!(bound::at_least(&query, &Settings::default(), bound["length"].as_f64().unwrap(), open) < lower);
}

#[test]
fn parameters_that_cannot_be_are_named() {
    let query = room(&ROOM, [[0.0, 0.0], [5.0, 3.0]]);
    for (bad, name) in [
        (Aide { stages: 0, ..Aide::default() }, "stages"),
        (Aide { generations: 2, stages: 3, ..Aide::default() }, "generations"),
        (Aide { classes: 65, ..Aide::default() }, "classes"),
        (Aide { polish: 100_000, ..Aide::default() }, "polish"),
        (Aide { population: 1, ..Aide::default() }, "population"),
    ] {
        let error = bad.plan(&query, &mut Context::new(1)).err().unwrap().to_string();
        assert!(error.contains(name), "{error}");
    }
}
