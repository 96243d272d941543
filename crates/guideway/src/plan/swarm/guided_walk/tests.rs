use super::*;
use crate::world::{Bits, Grid, World};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

fn world(width: u32, height: u32, blocked: impl Fn(u32, u32) -> bool) -> World {
    let mut bits = Bits::new(width, height);
    (0..height).for_each(|y| (0..width).for_each(|x| bits.set(x, y, blocked(x, y))));
    World::from_grid(Grid::new(bits, None, 1.0, [0.0; 3]).unwrap())
}

fn gait(cut: bool) -> Gait {
    Gait { limit: u64::MAX, stride: 1, cut }
}

/// The walk of the specification, word by word, with angles.
fn literal(ground: &Ground, [from, to]: [Cell; 2], keys: &[f64]) -> Option<Vec<Cell>> {
    let angle = |a: Cell, b: Cell| (f64::from(b[1]) - f64::from(a[1])).atan2(f64::from(b[0]) - f64::from(a[0]));
    let span = |a: Cell, b: Cell| (f64::from(b[1]) - f64::from(a[1])).hypot(f64::from(b[0]) - f64::from(a[0]));
    let wrap = |v: f64| (v + std::f64::consts::PI).rem_euclid(2.0 * std::f64::consts::PI) - std::f64::consts::PI;
    let (mut cell, mut path, mut visited, mut k) = (from, vec![from], vec![from], 0);
    while cell != to {
        let way = angle(cell, to) + keys[k % keys.len()] * FRAC_PI_2;
        k += 1;
        let mut best: Option<(f64, f64, Cell)> = None;
        for step in 0..8 {
            let next = stepped(cell, step);
            if ground.allows(cell, next) && !visited.contains(&next) {
                let (off, far) = (wrap(angle(cell, next) - way).abs(), span(next, to));
                if best.is_none_or(|b| off < b.0 - 1e-9 || (off <= b.0 + 1e-9 && far < b.1 - 1e-9)) {
                    best = Some((off, far, next));
                }
            }
        }
        if let Some((_, _, next)) = best {
            path.push(next);
            visited.push(next);
            cell = next;
        } else {
            path.pop();
            cell = *path.last()?;
        }
    }
    Some(path)
}

#[test]
fn walks_are_those_of_the_specification() {
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    let mut scratch = Scratch::default();
    let (mut arrived, mut failed) = (0, 0);
    for round in 0..400 {
        let blocked: Vec<bool> = (0..12 * 9).map(|_| rng.random_bool(0.3)).collect();
        let world = world(12, 9, |x, y| blocked[(y * 12 + x) as usize] && [x, y] != [0, 0] && [x, y] != [11, 8]);
        let lattice = world.lattice(0.0);
        let ground = Ground::new(&lattice, [Corners::Touch, Corners::Clear, Corners::Squeeze][round % 3]);
        // Keys at the ends make ties on purpose; whole ones never meet the middle between two steps that are as far from the goal.
        let keys: Vec<f64> =
            (0..40).map(|_| if rng.random_bool(0.2) { 1.0 - 2.0 * f64::from(rng.random_bool(0.5)) } else { rng.random_range(-1.0..1.0) }).collect();
        let expected = literal(&ground, [[0, 0], [11, 8]], &keys);
        let found = ground.walk([[0, 0], [11, 8]], &keys, gait(false), &mut scratch);
        assert_eq!(found, expected.is_some());
        if let Some(expected) = expected {
            assert_eq!(scratch.cells, expected);
            arrived += 1;
        } else {
            failed += 1;
        }
    }
    assert!(arrived > 100 && failed > 20, "{arrived} {failed}");
}

#[test]
fn without_a_limit_a_walk_arrives_wherever_there_is_a_path_and_with_one_it_gives_up() {
    let maze = world(41, 41, |x, y| x % 2 == 1 && y != if x % 4 == 1 { 40 } else { 0 });
    let lattice = maze.lattice(0.0);
    let ground = Ground::new(&lattice, Corners::Touch);
    let mut scratch = Scratch::default();
    assert!(ground.walk([[0, 0], [40, 0]], &[0.3, -0.2], gait(true), &mut scratch));
    assert!(scratch.cells.windows(2).all(|w| ground.allows(w[0], w[1])));
    assert!(!ground.walk([[0, 0], [40, 0]], &[0.3, -0.2], Gait { limit: 246, ..gait(true) }, &mut scratch));
}

#[test]
fn loops_are_cut_to_the_latest_cell_one_step_away() {
    let open = world(10, 10, |_, _| false);
    let lattice = open.lattice(0.0);
    let ground = Ground::new(&lattice, Corners::Touch);
    let path = [[0, 0], [1, 0], [2, 0], [3, 0], [3, 1], [3, 2], [2, 2], [1, 2], [1, 3], [1, 4], [2, 5]];
    let mut scratch = Scratch::default();
    ground.cut_path(&path, &mut scratch);
    assert_eq!(scratch.cells, [[0, 0], [1, 0], [2, 0], [3, 1], [2, 2], [1, 3], [1, 4], [2, 5]]);
    ground.cut_path(&[[0, 0], [1, 1], [2, 1], [2, 2], [1, 1], [1, 2]], &mut scratch);
    assert_eq!(scratch.cells, [[0, 0], [1, 1], [1, 2]]);
}

#[test]
fn turns_by_keys_are_right() {
    for k in -1000..=1000 {
        let key = f64::from(k) / 1000.0;
        let [c, s] = quarters(key);
        assert!((c - (key * FRAC_PI_2).cos()).abs() < 1e-9 && (s - (key * FRAC_PI_2).sin()).abs() < 1e-9, "{key}");
    }
    assert_eq!((quarters(1.0), quarters(-1.0), quarters(0.0)), ([0.0, 1.0], [0.0, -1.0], [1.0, 0.0]));
}
