use super::brute::Map;
use guideway::plan::score::{Aim, counts};
use guideway::plan::search::{Optimum, Stopped, lexicographic};
use guideway::world::{Cell, Corners, Grid, World};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

const RULES: [Corners; 3] = [Corners::Touch, Corners::Clear, Corners::Squeeze];

fn world(map: &Map) -> World {
    World::from_grid(Grid::new(map.blocked(), None, 1.0, [0.0; 3]).unwrap())
}

fn solve(map: &Map, ends: [Cell; 2], corners: Corners, aim: Aim) -> Option<Optimum> {
    lexicographic(&world(map).lattice(0.0), ends, corners, aim, &mut || false).unwrap()
}

fn certify(map: &Map, ends: [Cell; 2], corners: Corners, found: &Optimum) {
    assert_eq!([found.cells[0], found.cells[found.cells.len() - 1]], ends);
    for pair in found.cells.windows(2) {
        let [a, b] = [pair[0], pair[1]].map(|c| [i64::from(c[0]), i64::from(c[1])]);
        let step = [b[0] - a[0], b[1] - a[1]];
        assert!(step != [0, 0] && step.iter().all(|d| d.abs() <= 1) && map.step(a, step, corners), "{pair:?}");
    }
    assert_eq!([found.straight, found.diagonal, found.score.turns], counts(&found.cells));
}

#[test]
fn thousands_of_small_maps_against_plain_relaxation() {
    let mut rng = ChaCha8Rng::seed_from_u64(31);
    let mut solved = 0;
    for round in 0..4000u32 {
        let (w, h) = (rng.random_range(1..12), rng.random_range(1..12));
        let density = f64::from(round % 9) * 0.06;
        let map = Map { free: (0..h).map(|_| (0..w).map(|_| !rng.random_bool(density)).collect()).collect() };
        let mut cell = || [rng.random_range(0..w), rng.random_range(0..h)];
        let ends = [cell(), cell()];
        for corners in RULES {
            for (aim, turn) in [(Aim::Shortest, 0.0), (Aim::LeastEnergy, 0.5)] {
                let (found, best) = (solve(&map, ends, corners, aim), map.best(ends[0], ends[1], corners, turn));
                assert_eq!(found.is_some(), best.is_some(), "{ends:?} {corners:?}");
                if let (Some(found), Some((cost, turns))) = (found, best) {
                    certify(&map, ends, corners, &found);
                    assert!((found.score.cost - cost).abs() < 1e-9, "{ends:?} {corners:?} {aim:?}: {} for {cost}", found.score.cost);
                    assert_eq!(found.score.turns, turns, "{ends:?} {corners:?} {aim:?}");
                    solved += 1;
                }
            }
        }
    }
    assert!(solved > 5000, "only {solved} had a path");
}

#[test]
fn larger_maps_with_rooms() {
    let mut rng = ChaCha8Rng::seed_from_u64(32);
    for _ in 0..30 {
        let mut free = vec![vec![true; 45]; 40];
        for _ in 0..25 {
            let (x, y, w, h) = (rng.random_range(0..40), rng.random_range(0..36), rng.random_range(1..9), rng.random_range(1..9));
            free[y..(y + h).min(40)].iter_mut().for_each(|row| row[x..(x + w).min(45)].fill(false));
        }
        (free[0][0], free[39][44]) = (true, true);
        let map = Map { free };
        for (aim, turn) in [(Aim::Shortest, 0.0), (Aim::LeastEnergy, 0.5)] {
            let (found, best) = (solve(&map, [[0, 0], [44, 39]], Corners::Touch, aim), map.best([0, 0], [44, 39], Corners::Touch, turn));
            let close = |a: f64, b: f64| (a - b).abs() < 1e-9;
            assert!(found.as_ref().map(|f| f.score.turns) == best.map(|b| b.1), "{aim:?}: {:?} for {best:?}", found.map(|f| f.score));
            assert!(found.is_none_or(|f| best.is_some_and(|b| close(f.score.cost, b.0))));
        }
    }
}

/// Diagonals, straights and turns.
fn figures(map: &Map, corners: Corners, aim: Aim) -> [u32; 3] {
    let [w, h] = map.size();
    let found = solve(map, [[0, 0], [w - 1, h - 1]], corners, aim).unwrap();
    [found.diagonal, found.straight, found.score.turns]
}

#[test]
fn the_stand_in_scenes_have_their_known_numbers() {
    let read =
        |name| Map::parse(&std::fs::read_to_string(format!("{}/../../python/guideway/data/scenes/{name}.txt", env!("CARGO_MANIFEST_DIR"))).unwrap());
    let [one, two, m20, m30] = ["pso-aco-1", "pso-aco-2", "m20", "m30"].map(read);
    let shortest = |map, corners| figures(map, corners, Aim::Shortest);
    assert_eq!((shortest(&one, Corners::Touch), shortest(&one, Corners::Clear)), ([16, 6, 3], [15, 8, 7]));
    assert_eq!((shortest(&two, Corners::Touch), shortest(&two, Corners::Clear)), ([14, 10, 6], [10, 18, 13]));
    assert_eq!((shortest(&m20, Corners::Touch), shortest(&m20, Corners::Clear)[..2].to_vec()), ([18, 2, 2], vec![17, 4]));
    assert_eq!((shortest(&m30, Corners::Touch), shortest(&m30, Corners::Clear)[..2].to_vec()), ([28, 2, 3], vec![25, 8]));
    for map in [&one, &two, &m20, &m30] {
        let [w, h] = map.size();
        let best = map.best([0, 0], [w - 1, h - 1], Corners::Touch, 0.5).unwrap();
        let [diagonal, straight, turns] = figures(map, Corners::Touch, Aim::LeastEnergy);
        assert!((f64::from(diagonal) * 2f64.sqrt() + f64::from(straight) + 0.5 * f64::from(turns) - best.0).abs() < 1e-9 && turns == best.1);
    }
}

#[test]
fn a_cell_alone_blocked_ends_and_a_stop() {
    let map = Map::parse(".#.\n.#.\n...");
    assert_eq!(solve(&map, [[0, 0], [0, 0]], Corners::Touch, Aim::LeastEnergy).unwrap().cells, [[0, 0]]);
    assert_eq!(solve(&map, [[0, 0], [1, 1]], Corners::Touch, Aim::Shortest), None);
    assert_eq!(solve(&map, [[0, 0], [7, 0]], Corners::Touch, Aim::Shortest), None);
    let open = Map { free: vec![vec![true; 200]; 200] };
    let stopped = lexicographic(&world(&open).lattice(0.0), [[0, 0], [199, 120]], Corners::Touch, Aim::Shortest, &mut || true);
    assert_eq!(stopped, Err(Stopped));
}

#[test]
fn lengths_near_the_limit_of_32_bit_costs_are_exact() {
    // A comb so long that 32-bit costs do not suffice: one way only, of known length and turns.
    let (n, m) = (161, 401);
    let free = (0..n).map(|y: usize| (0..m).map(|x: usize| x.is_multiple_of(2) || y == if x % 4 == 1 { n - 1 } else { 0 }).collect()).collect();
    let found = solve(&Map { free }, [[0, 0], [m as u32 - 1, n as u32 - 1]], Corners::Clear, Aim::Shortest).unwrap();
    let (columns, passes) = ((m as u32 - 1) / 2 + 1, (m as u32 - 1) / 2);
    assert!(found.straight > 19601);
    assert_eq!([found.diagonal, found.straight, found.score.turns], [0, columns * (n as u32 - 1) + 2 * passes, 2 * passes]);
}
