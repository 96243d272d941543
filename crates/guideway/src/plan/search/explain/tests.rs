use super::*;
use crate::error::PlanError;
use crate::plan::{Planner, search::Visibility};
use crate::world::{Grid, Shape};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::sync::Arc;

fn with_disc(world: &Arc<World>, ends: [Point; 2], radius: f64) -> Query {
    let mut query = Query::new(Arc::clone(world), ends[0], ends[1]);
    query.footprint = Footprint::Disc(radius);
    query
}

/// Two rooms with a door of the given width in the wall between them.
fn rooms(door: u32) -> Arc<World> {
    let mut bits = Bits::new(40, 20);
    for y in 0..20 {
        bits.set(20, y, !(8..8 + door).contains(&y));
    }
    Arc::new(World::from_grid(Grid::new(bits, None, 0.1, [0.0; 3]).unwrap()))
}

#[test]
fn a_door_is_found_and_measured() {
    let ends = [[0.55, 1.0], [3.45, 1.0]];
    let query = with_disc(&rooms(5), ends, 0.3);
    let Err(PlanError::NoPath(why)) = Visibility::default().plan(&query, &mut Context::new(0)) else { panic!("a path") };
    assert!(why.proved);
    assert!((why.widest.unwrap() - 0.25).abs() < 1e-6, "{why:?}");
    let p = why.narrowest.unwrap();
    assert!((p[0] - 2.05).abs() < 0.11 && (p[1] - 1.05).abs() < 0.02, "{p:?}");
    let closed = with_disc(&rooms(0), ends, 0.0);
    let Err(PlanError::NoPath(why)) = Visibility::default().plan(&closed, &mut Context::new(0)) else { panic!("a path") };
    assert_eq!((why.proved, why.widest), (true, None));
}

#[test]
fn a_long_footprint_may_still_pass() {
    let ends = [[0.55, 1.0], [3.45, 1.0]];
    let mut query = with_disc(&rooms(5), ends, 0.0);
    query.footprint = Footprint::Box([0.9, 0.3]);
    let why = explain(&query, &mut Context::new(0));
    assert!(!why.proved && why.reason.is_some() && (why.widest.unwrap() - 0.25).abs() < 1e-6);
    query.footprint = Footprint::Box([0.9, 0.6]);
    assert!(explain(&query, &mut Context::new(0)).proved);
}

fn random_world(rng: &mut ChaCha8Rng, grid: bool) -> World {
    let density = [0.1, 0.4][rng.random_range(0..2)];
    let mut bits = Bits::new(16, 12);
    for y in 0..12 {
        for x in 0..16 {
            bits.set(x, y, rng.random_bool(density));
        }
    }
    if grid {
        return World::from_grid(Grid::new(bits, None, 0.5, [0.0; 3]).unwrap());
    }
    let shapes = (0..9).map(|_| Shape::disc([rng.random_range(0.0..8.0), rng.random_range(0.0..6.0)], rng.random_range(0.1..1.0)).unwrap());
    World::from_shapes([0.0, 0.0, 8.0, 6.0], shapes.collect(), 0.25).unwrap()
}

fn find(root: &mut [usize], mut i: usize) -> usize {
    while root[i] != i {
        root[i] = root[root[i]];
        i = root[i];
    }
    i
}

/// Largest radius with connected cells of a fine lattice: a lower bound within two half diagonals of the truth.
fn sampled(world: &World, ends: [Point; 2], step: f64) -> f64 {
    let (nx, ny) = ((8.0 / step) as usize, (6.0 / step) as usize);
    let at = |i: usize| [((i % nx) as f64 + 0.5) * step, ((i / nx) as f64 + 0.5) * step];
    let values: Vec<f64> = (0..nx * ny).map(|i| world.clearance(at(i))).collect();
    let cell = |p: Point| ((p[1] / step) as usize).min(ny - 1) * nx + ((p[0] / step) as usize).min(nx - 1);
    let (start, goal) = (cell(ends[0]), cell(ends[1]));
    let mut order: Vec<usize> = (0..nx * ny).collect();
    order.sort_by(|&a, &b| values[b].total_cmp(&values[a]));
    let mut root: Vec<usize> = (0..nx * ny).collect();
    let mut on = vec![false; nx * ny];
    for i in order {
        on[i] = true;
        let (x, y) = (i % nx, i / nx);
        let near = [(x > 0, i.wrapping_sub(1)), (x + 1 < nx, i + 1), (y > 0, i.wrapping_sub(nx)), (y + 1 < ny, i + nx)];
        for (_, j) in near.into_iter().filter(|&(inside, j)| inside && on[j]) {
            let (a, b) = (find(&mut root, i), find(&mut root, j));
            root[a] = b;
        }
        if on[start] && on[goal] && find(&mut root, start) == find(&mut root, goal) {
            return values[i].min(world.clearance(ends[0])).min(world.clearance(ends[1]));
        }
    }
    f64::NEG_INFINITY
}

#[test]
fn widest_equals_a_finely_sampled_clearance() {
    let mut rng = ChaCha8Rng::seed_from_u64(4);
    let (mut wide, mut none) = (0, 0);
    for i in 0..60 {
        let world = Arc::new(random_world(&mut rng, i % 2 == 0));
        let mut point = || loop {
            let p = [rng.random_range(0.0..8.0), rng.random_range(0.0..6.0)];
            if world.clearance(p) > 0.02 {
                return p;
            }
        };
        let ends = [point(), point()];
        let step = 0.04;
        let sampled = sampled(&world, ends, step);
        let why = explain(&with_disc(&world, ends, 10.0), &mut Context::new(0));
        assert!(why.proved);
        match why.widest {
            None => {
                assert!(sampled < 0.04, "case {i}: none, but {sampled} passes from {ends:?}");
                none += 1;
            }
            Some(w) => {
                assert!(w >= sampled - step / 2.0 - 0.01 && w <= sampled + 2.0 * step, "case {i}: {w}, sampled {sampled}");
                let free = |r: f64| Visibility::default().plan(&with_disc(&world, ends, r), &mut Context::new(0)).is_ok();
                assert!(free(w) && !free(w + 0.5 / 60.0), "case {i}: {w}");
                wide += 1;
            }
        }
    }
    println!("{wide} connected, {none} not");
    assert!(wide > 30 && none > 5);
}
