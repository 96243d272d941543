use super::open::{Cost, Open};
use super::{Ask, End, Engine, Steps, every_cell, leg, shortest_cells, step, turns};
use crate::context::Context;
use crate::plan::{Planner, planner};
use crate::query::Query;
use crate::world::{Bits, Cell, Corners, Grid, Lattice, World};
use proptest::prelude::*;
use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::sync::Arc;

const RULES: [Corners; 3] = [Corners::Touch, Corners::Clear, Corners::Squeeze];

fn random(width: u32, height: u32, blocked: f64, rng: &mut impl Rng) -> World {
    let mut bits = Bits::new(width, height);
    for y in 0..height {
        for x in 0..width {
            bits.set(x, y, rng.random_bool(blocked));
        }
    }
    World::from_grid(Grid::new(bits, None, 1.0, [0.0; 3]).unwrap())
}

fn solve(lattice: &Lattice, engine: Engine, ends: [Cell; 2], corners: Corners) -> Option<(Steps, Vec<Cell>)> {
    let mut out = Vec::new();
    let mut ask = Ask { lattice, start: ends[0], goal: ends[1], corners, stop: &mut || false };
    match leg::run(engine, &mut ask, &mut out) {
        End::Found(steps) => Some((steps, every_cell(&out))),
        End::Exhausted => None,
        End::Stopped | End::Overflow => panic!("a search without limits stopped"),
    }
}

/// Every step legal, ends right, counts right.
fn certify(lattice: &Lattice, ends: [Cell; 2], corners: Corners, found: &(Steps, Vec<Cell>)) {
    let (steps, cells) = found;
    assert_eq!([cells[0], cells[cells.len() - 1]], ends);
    let (mut straight, mut diagonal) = (0, 0);
    for pair in cells.windows(2) {
        let (dx, dy) = (i64::from(pair[1][0]) - i64::from(pair[0][0]), i64::from(pair[1][1]) - i64::from(pair[0][1]));
        assert!(dx.abs() <= 1 && dy.abs() <= 1 && lattice.step_free(pair[0], dx, dy, corners), "{pair:?} under {corners:?}");
        if dx != 0 && dy != 0 { diagonal += 1 } else { straight += 1 }
    }
    assert_eq!((straight, diagonal), (steps.straight, steps.diagonal));
}

/// All three engines agree on every rule.
fn agree(world: &World, ends: [Cell; 2]) {
    agree_for(world, 0.0, ends);
}

fn agree_for(world: &World, radius: f64, ends: [Cell; 2]) {
    let lattice = world.lattice(radius);
    if !ends.iter().all(|c| lattice.free().at(c[0], c[1])) {
        return;
    }
    for corners in RULES {
        let [a, b, c] = [Engine::Dijkstra, Engine::AStar, Engine::JumpPoint].map(|e| solve(&lattice, e, ends, corners));
        for found in [&a, &b, &c].into_iter().flatten() {
            certify(&lattice, ends, corners, found);
        }
        let [a, b, c] = [a, b, c].map(|f| f.map(|(s, _)| (s.straight, s.diagonal)));
        assert_eq!(a, b, "{corners:?} {ends:?}");
        assert_eq!(a, c, "{corners:?} {ends:?}");
    }
}

#[test]
fn engines_agree_on_thousands_of_small_maps() {
    let mut rng = ChaCha8Rng::seed_from_u64(11);
    for round in 0..6000u32 {
        let (w, h) = (rng.random_range(1..14), rng.random_range(1..14));
        let world = random(w, h, f64::from(round % 10) * 0.07, &mut rng);
        let mut cell = || [rng.random_range(0..w), rng.random_range(0..h)];
        let ends = [cell(), cell()];
        agree(&world, ends);
    }
}

#[test]
fn engines_agree_for_robots_with_a_size() {
    let mut rng = ChaCha8Rng::seed_from_u64(15);
    for round in 0..1500u32 {
        let (w, h) = (rng.random_range(5..25), rng.random_range(5..25));
        let world = random(w, h, f64::from(round % 6) * 0.02, &mut rng);
        let mut cell = || [rng.random_range(0..w), rng.random_range(0..h)];
        let ends = [cell(), cell()];
        agree_for(&world, f64::from(1 + round % 8) * 0.25, ends);
    }
}

#[test]
fn engines_agree_across_word_borders() {
    let mut rng = ChaCha8Rng::seed_from_u64(12);
    for round in 0..300u32 {
        let (w, h) =
            if round % 2 == 0 { (rng.random_range(50..200), rng.random_range(1..9)) } else { (rng.random_range(1..9), rng.random_range(50..200)) };
        let world = random(w, h, f64::from(round % 7) * 0.04, &mut rng);
        let mut cell = || [rng.random_range(0..w), rng.random_range(0..h)];
        let ends = [cell(), cell()];
        agree(&world, ends);
    }
    for round in 0..60u32 {
        let world = random(150, 140, 0.01 * f64::from(1 + round % 35), &mut rng);
        let mut cell = || [rng.random_range(0..150), rng.random_range(0..140)];
        let ends = [cell(), cell()];
        agree(&world, ends);
    }
}

#[test]
fn what_earlier_searches_found_changes_nothing() {
    let mut rng = ChaCha8Rng::seed_from_u64(14);
    for round in 0..40u32 {
        let world = random(30, 70, f64::from(round % 8) * 0.05, &mut rng);
        let warm = world.lattice(0.0);
        for _ in 0..25 {
            let mut cell = || [rng.random_range(0..30), rng.random_range(0..70)];
            let ends = [cell(), cell()];
            if !ends.iter().all(|c| warm.free().at(c[0], c[1])) {
                continue;
            }
            for corners in RULES {
                let cold = World::from_grid(world.grid().unwrap().clone());
                let [a, b] = [&*warm, &*cold.lattice(0.0)].map(|l| solve(l, Engine::JumpPoint, ends, corners));
                assert_eq!(a, b);
                let count = |f: Option<(Steps, Vec<Cell>)>| f.map(|(s, _)| (s.straight, s.diagonal));
                assert_eq!(count(a), count(solve(&warm, Engine::AStar, ends, corners)));
            }
        }
    }
}

proptest! {
    #[test]
    fn engines_agree_on_any_map(w in 1u32..10, h in 1u32..10, seed in any::<u64>(), blocked in 0.0..0.6f64) {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let world = random(w, h, blocked, &mut rng);
        agree(&world, [[0, 0], [w - 1, h - 1]]);
    }
}

#[test]
fn wide_costs_agree_with_narrow_ones() {
    let mut rng = ChaCha8Rng::seed_from_u64(13);
    for _ in 0..50 {
        let world = random(40, 40, 0.25, &mut rng);
        let lattice = world.lattice(0.0);
        let ends = [[0, 0], [39, 39]];
        if !ends.iter().all(|c| lattice.free().at(c[0], c[1])) {
            continue;
        }
        let mut out = [Vec::new(), Vec::new()];
        let mut ask = Ask { lattice: &lattice, start: ends[0], goal: ends[1], corners: Corners::Clear, stop: &mut || false };
        let narrow = matches!(step::search::<u32, true>(&mut ask, &mut out[0]), End::Found(_));
        let wide = matches!(step::search::<u64, true>(&mut ask, &mut out[1]), End::Found(_));
        assert_eq!(narrow, wide);
        assert_eq!(out[0], out[1]);
    }
}

#[test]
fn costs_are_convergents_of_the_root_of_two() {
    let error = |p: u64, q: u64| i128::from(p) * i128::from(p) - 2 * i128::from(q) * i128::from(q);
    assert_eq!(error(u32::DIAGONAL.into(), u32::STRAIGHT.into()).abs(), 1);
    assert_eq!(error(u64::DIAGONAL, u64::STRAIGHT).abs(), 1);
}

#[test]
fn long_lanes_do_not_overflow() {
    let world = World::from_grid(Grid::new(Bits::new(30_000, 3), None, 1.0, [0.0; 3]).unwrap());
    let lattice = world.lattice(0.0);
    let mut out = Vec::new();
    let steps = shortest_cells(&lattice, [0, 0], [29_999, 2], Corners::Clear, &mut out).unwrap();
    assert_eq!((steps.straight, steps.diagonal), (29_997, 2));
    // A snake longer than 32-bit costs reach, on a map small enough to start with them.
    let mut bits = Bits::new(400, 401);
    for y in (1..400).step_by(2) {
        for x in 0..400 {
            bits.set(x, y, if y % 4 == 1 { x != 399 } else { x != 0 });
        }
    }
    let world = World::from_grid(Grid::new(bits, None, 1.0, [0.0; 3]).unwrap());
    let steps = shortest_cells(&world.lattice(0.0), [0, 0], [399, 400], Corners::Clear, &mut out).unwrap();
    assert_eq!((steps.straight, steps.diagonal), (200 * 399 + 400 + 399, 0));
}

#[test]
fn the_slot_table_survives_reuse_by_other_searches() {
    let mut open = Open::<u32>::default();
    open.begin(10, 3);
    open.relax(4, 10, 10, 0, 1);
    open.begin(10, 4);
    open.relax(3, 7, 7, 0, 1);
    assert_eq!(open.pop().map(|(f, id)| (f, open.nodes[id as usize].place)), Some((0, 4)));
    assert_eq!(open.pop().map(|(f, id)| (f, open.nodes[id as usize].place)), Some((7, 3)));
    assert_eq!(open.pop(), None);
}

#[test]
fn turning_points_and_cells_are_the_same_path() {
    let cells = every_cell(&[[0, 0], [3, 3], [5, 3], [5, 1]]);
    assert_eq!(cells.len(), 8);
    assert_eq!(turns(&cells), [[0, 0], [3, 3], [5, 3], [5, 1]]);
    assert_eq!(turns(&[[2, 2]]), [[2, 2]]);
}

fn open_world() -> Arc<World> {
    Arc::new(World::from_grid(Grid::new(Bits::new(10, 10), None, 0.5, [0.0; 3]).unwrap()))
}

#[test]
fn planners_connect_points_off_the_centres_and_pass_via_points() {
    let mut query = Query::new(open_world(), [0.3, 0.2], [4.6, 0.2]);
    query.via = vec![[2.25, 4.25]];
    for name in ["dijkstra", "astar", "jump-point"] {
        let solution = planner(name, serde_json::Value::Null).unwrap().plan(&query, &mut Context::new(1)).unwrap();
        let points = solution.path.points();
        assert_eq!((points[0], points[points.len() - 1]), (query.start, query.goal));
        assert!(points.contains(&[2.25, 4.25]));
        let length: f64 = points.windows(2).map(|p| (p[0][0] - p[1][0]).hypot(p[0][1] - p[1][1])).sum();
        assert!((length - solution.cost).abs() < 1e-9, "{name}: {length} {}", solution.cost);
        let cells = solution.cells.unwrap();
        assert!(cells.windows(2).all(|p| p[0] != p[1] && p[0][0].abs_diff(p[1][0]) <= 1 && p[0][1].abs_diff(p[1][1]) <= 1));
    }
}

/// Between two posts with hardly any room no centre near is free; the nearest that a straight line reaches is three cells away.
#[test]
fn ends_are_joined_up_to_the_radius_away() {
    let mut bits = Bits::new(40, 30);
    bits.set(20, 11, true);
    bits.set(20, 18, true);
    let world = Arc::new(World::from_grid(Grid::new(bits, None, 1.0, [0.0; 3]).unwrap()));
    let mut query = Query::new(world, [20.5, 15.0], [35.5, 15.5]);
    query.footprint = crate::world::Footprint::Disc(2.85);
    for name in ["dijkstra", "astar", "jump-point", "theta-star", "lazy-theta-star"] {
        for (start, goal) in [([20.5, 15.0], [35.5, 15.5]), ([35.5, 15.5], [20.5, 15.0])] {
            (query.start, query.goal) = (start, goal);
            let found = planner(name, serde_json::Value::Null).unwrap().plan(&query, &mut Context::new(1)).unwrap();
            let check = crate::certify::collision(&found.path, &query, None);
            assert!(found.cost < 40.0 && check.ok, "{name}: {} {check:?} {:?}", found.cost, found.path.points());
        }
    }
}

#[test]
fn no_path_is_proved_and_cancel_is_heard() {
    let mut bits = Bits::new(200, 200);
    (0..200).for_each(|y| bits.set(100, y, true));
    let world = Arc::new(World::from_grid(Grid::new(bits, None, 1.0, [0.0; 3]).unwrap()));
    let query = Query::new(world, [0.5, 0.5], [199.5, 0.5]);
    for name in ["dijkstra", "astar", "jump-point"] {
        let error = planner(name, serde_json::Value::Null).unwrap().plan(&query, &mut Context::new(1)).err().unwrap();
        assert!(matches!(&error, crate::error::PlanError::NoPath(n) if n.proved), "{name}: {error}");
    }
    let mut observer = |_: &crate::context::Progress| true;
    let mut ctx = Context::new(1).with_observer(&mut observer);
    let error = super::AStar {}.plan(&query, &mut ctx).err().unwrap();
    assert_eq!(error.name(), "Cancelled");
}
