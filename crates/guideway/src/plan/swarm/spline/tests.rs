use super::*;
use crate::certify;
use crate::context::Context;
use crate::optimize::Objective;
use crate::plan::Planner;
use crate::plan::search::Visibility;
use crate::query::{Limits, Query};
use crate::world::{Shape, World};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::sync::Arc;

/// The room of section 8.
pub(in crate::plan) fn w0() -> Query {
    let discs = [
        (1.20, 0.95, 0.8),
        (2.35, 1.55, 0.6),
        (2.10, 3.00, 1.0),
        (3.70, 2.05, 0.9),
        (4.10, 0.60, 0.7),
        (6.50, 1.50, 1.2),
        (7.50, 4.20, 1.0),
        (0.90, 3.90, 0.5),
    ];
    let shapes = discs.iter().map(|(x, y, d)| Shape::disc([*x, *y], 0.5 * d).unwrap()).collect();
    let world = Arc::new(World::from_shapes([0.0, 0.0, 10.0, 6.0], shapes, 0.05).unwrap());
    let limits = Limits {
        speed: 2.0,
        acceleration: 5.0,
        deceleration: 5.0,
        jerk: 10.0,
        turn_rate: Some(2.0),
        turn_acceleration: None,
        lateral_acceleration: Some(2.0),
    };
    Query { clearance: 0.3, limits, ..Query::new(world, [0.0, 0.0], [5.0, 3.0]) }
}

/// A route along the exact one, a little wider.
fn route(query: &Query) -> Vec<crate::Point> {
    let wider = Query { clearance: query.clearance + 0.05, ..query.clone() };
    Visibility::default().plan(&wider, &mut Context::new(1)).unwrap().path.points()
}

/// Half of the draws come from all over the box, half are near the route.
fn draw(curves: &Curves, along: &[f64], rng: &mut ChaCha8Rng) -> Vec<f64> {
    let spread = if rng.random_bool(0.5) { 1.0 } else { 0.1 * rng.random::<f64>() };
    let place = |(b, a): (&(f64, f64), &f64), r: f64| (a + spread * (b.1 - b.0) * (2.0 * r - 1.0)).clamp(b.0, b.1);
    curves.bounds().iter().zip(along).map(|pair| place(pair, rng.random())).collect()
}

#[test]
fn candidates_are_free_exactly_when_the_certificate_says_so() {
    let query = w0();
    let curves = Curves::new(&query, &Settings { points: 5, ..Settings::default() }).unwrap();
    let along = curves.fit(&route(&query));
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let mut free = 0;
    for _ in 0..400 {
        let x = draw(&curves, &along, &mut rng);
        let judged = curves.judge(&x);
        let path = curves.path(&x).unwrap();
        // Curves near a cusp are measured less well.
        let off = (path.length() / judged.length - 1.0).abs();
        assert!(off < if judged.violation == 0.0 { 1e-6 } else { 1e-2 }, "{} {}", path.length(), judged.length);
        let checked = certify::collision(&path, &query, Some(0.05));
        assert_eq!(checked.ok, judged.violation == 0.0, "{judged:?} {checked:?}");
        free += usize::from(checked.ok);
    }
    assert!(free > 20, "{free}");
}
