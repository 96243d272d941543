use super::{Sight, cells_see};
use crate::query::Query;
use crate::world::{Bits, Footprint, Grid, Shape, World};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::sync::Arc;

#[test]
fn sight_in_integers_is_the_exact_test_of_the_world() {
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    let mut seen = [0; 2];
    for _ in 0..3000 {
        let (w, h) = (rng.random_range(1..140), rng.random_range(1..12));
        let density = [0.0, 0.02, 0.1, 0.3][rng.random_range(0..4)];
        let (mut free, mut blocked) = (Bits::new(w, h), Bits::new(w, h));
        for y in 0..h {
            for x in 0..w {
                let b = rng.random_bool(density);
                free.set(x, y, !b);
                blocked.set(x, y, b);
            }
        }
        let world = World::from_grid(Grid::new(blocked, None, 1.0, [0.0; 3]).unwrap());
        let grid = world.grid().unwrap();
        for _ in 0..10 {
            let mut cell = || [rng.random_range(0..w), rng.random_range(0..h)];
            let (a, b) = (cell(), cell());
            let truth = world.segment_free(grid.center(a), grid.center(b), 0.0);
            let rows = [0, h];
            assert_eq!(cells_see(&free, [a, b], false, rows), truth, "{a:?} {b:?}");
            assert!(cells_see(&free, [a, b], true, rows) || !truth);
            let [low, high] = [a[1].min(b[1]), a[1].max(b[1])];
            let parts = (low..=high).all(|y| cells_see(&free, [a, b], false, [y, y]));
            assert_eq!(parts, truth, "{a:?} {b:?} row by row");
            seen[usize::from(truth)] += 1;
        }
    }
    assert!(seen[0] > 1000 && seen[1] > 1000, "{seen:?}");
}

/// Steps of any length and exact tests of short stretches say what one exact test of the whole way says.
#[test]
fn marching_sees_what_the_world_sees() {
    let mut rng = ChaCha8Rng::seed_from_u64(8);
    let mut seen = [0; 2];
    for case in 0..300 {
        let (w, h) = (rng.random_range(1..90), rng.random_range(1..60));
        let density = [0.0, 0.003, 0.02, 0.1][rng.random_range(0..4)];
        let mut blocked = Bits::new(w, h);
        for (x, y) in (0..h).flat_map(|y| (0..w).map(move |x| (x, y))) {
            blocked.set(x, y, rng.random_bool(density));
        }
        let mut world = World::from_grid(Grid::new(blocked, None, 0.1, [2.0, -1.0, [0.0, 0.4][case % 2]]).unwrap());
        if case % 3 == 0 {
            world = world.with_shapes(vec![Shape::disc([rng.random_range(2.0..9.0), rng.random_range(-1.0..4.0)], 0.7).unwrap()]);
        }
        let mut query = Query::new(Arc::new(world), [0.0; 2], [0.0; 2]);
        query.footprint = Footprint::Disc([0.0, 0.05, 0.13, 0.3][rng.random_range(0..4)]);
        let lattice = query.world.lattice(query.radius());
        let sight = Sight::new(&query, &lattice);
        for _ in 0..60 {
            let mut cell = || [rng.random_range(0..w), rng.random_range(0..h)];
            let (a, b) = (cell(), cell());
            if lattice.free().at(a[0], a[1]) && lattice.free().at(b[0], b[1]) {
                let truth = query.world.segment_free(lattice.center(a), lattice.center(b), query.radius());
                assert_eq!(sight.see(a, b), truth, "case {case}: {a:?} {b:?}");
                seen[usize::from(truth)] += 1;
            }
        }
    }
    assert!(seen[0] > 2000 && seen[1] > 2000, "{seen:?}");
}
