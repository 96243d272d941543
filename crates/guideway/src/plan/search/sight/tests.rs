use super::cells_see;
use crate::world::{Bits, Grid, World};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

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
            assert_eq!(cells_see(&free, a, b, false), truth, "{a:?} {b:?}");
            assert!(cells_see(&free, a, b, true) || !truth);
            seen[usize::from(truth)] += 1;
        }
    }
    assert!(seen[0] > 1000 && seen[1] > 1000, "{seen:?}");
}
