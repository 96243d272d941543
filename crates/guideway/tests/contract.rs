//! The contract that every registered planner keeps.

use guideway::Point;
use guideway::certify;
use guideway::context::{Budget, Context, Progress, Stop};
use guideway::error::PlanError;
use guideway::plan::{self, REGISTRY, Solution};
use guideway::query::Query;
use guideway::world::{Bits, Corners, Footprint, Grid, Shape, World};
use proptest::prelude::*;
use rayon::prelude::*;
use std::sync::Arc;

fn grid_world(rows: &[&str], resolution: f64, origin: [f64; 3]) -> Arc<World> {
    let (w, h) = (rows[0].len() as u32, rows.len() as u32);
    let mut blocked = Bits::new(w, h);
    for (i, row) in rows.iter().enumerate() {
        for (x, c) in row.bytes().enumerate() {
            blocked.set(x as u32, h - 1 - i as u32, c == b'#');
        }
    }
    Arc::new(World::from_grid(Grid::new(blocked, None, resolution, origin).expect("a valid grid")))
}

fn run(name: &str, query: &Query, threads: usize, budget: Budget) -> Result<Solution, PlanError> {
    let planner = plan::planner(name, serde_json::Value::Null).expect("a registered planner with its defaults");
    let mut ctx = Context::new(7).with_budget(budget).expect("a valid budget").with_threads(threads);
    planner.plan(query, &mut ctx)
}

fn assert_good(name: &str, query: &Query, solution: &Solution) {
    let path = &solution.path;
    let (first, last) = (path.point(0), path.point(path.count() - 1));
    assert_eq!(first, query.start, "{name}: the path starts at the start");
    assert_eq!(last, query.goal, "{name}: the path ends at the goal");
    let checked = certify::collision(path, query, None);
    assert!(checked.ok, "{name}: collision at {:?} (clearance {})", checked.worst, checked.min_clearance);
    let length = solution.length();
    assert!(solution.cost.is_finite() && length >= straight(query) - 1e-9, "{name}: length {length} below the straight line");
    assert!((path.length() - length).abs() <= 1e-5 * (1.0 + length), "{name}: {length} is the length {}", path.length());
    if let Some(cells) = &solution.cells {
        for pair in cells.windows(2) {
            let (dx, dy) = (pair[0][0].abs_diff(pair[1][0]), pair[0][1].abs_diff(pair[1][1]));
            assert!(dx <= 1 && dy <= 1 && dx + dy > 0, "{name}: every step goes to a neighbour");
        }
    }
}

fn straight(query: &Query) -> f64 {
    query.stops().windows(2).map(|p| (p[1][0] - p[0][0]).hypot(p[1][1] - p[0][1])).sum()
}

const ROOMS: [&str; 10] = [
    "............",
    ".####.#####.",
    ".#....#...#.",
    ".#.##...#.#.",
    ".#.##.###.#.",
    ".#........#.",
    ".####.#####.",
    "............",
    "..##....##..",
    "............",
];

fn ask(world: &Arc<World>, a: Point, b: Point) -> Query {
    Query::new(Arc::clone(world), world.cell_to_map(a), world.cell_to_map(b))
}

fn solvable() -> Vec<Query> {
    let rooms = grid_world(&ROOMS, 0.5, [-1.0, 2.0, 0.0]);
    let turned = grid_world(&ROOMS, 0.5, [-1.0, 2.0, 0.4]);
    let mut queries = vec![ask(&rooms, [0.5, 0.5], [5.5, 5.5]), ask(&rooms, [0.3, 0.8], [11.9, 9.2]), ask(&turned, [0.5, 0.5], [3.5, 7.5])];
    for corners in [Corners::Clear, Corners::Squeeze] {
        let mut query = ask(&rooms, [0.5, 9.5], [9.5, 6.5]);
        query.corners = corners;
        queries.push(query);
    }
    let mut wide = ask(&rooms, [0.5, 0.5], [11.5, 9.5]);
    wide.footprint = Footprint::Disc(0.2);
    queries.push(wide);
    let mut via = ask(&rooms, [0.5, 0.5], [11.5, 0.5]);
    via.via = vec![rooms.cell_to_map([2.5, 5.5]), rooms.cell_to_map([0.5, 9.5])];
    queries.push(via);
    queries.push(ask(&rooms, [4.5, 0.5], [4.5, 0.5]));
    let shapes = vec![Shape::disc([2.0, 1.0], 0.6).expect("a disc"), Shape::polygon(vec![[3.0, 1.4], [4.0, 1.5], [3.4, 2.6]]).expect("a triangle")];
    let scene = Arc::new(World::from_shapes([0.0, 0.0, 6.0, 3.0], shapes, 0.05).expect("a scene"));
    let mut query = Query::new(scene, [0.2, 0.9], [5.7, 1.6]);
    query.footprint = Footprint::Disc(0.15);
    query.clearance = 0.05;
    queries.push(query);
    queries
}

#[test]
fn solvable_cases_are_solved_by_every_planner_and_alike_with_any_number_of_threads() {
    // planners side by side: some take ten times as long as others
    REGISTRY.par_iter().for_each(|entry| {
        for query in solvable() {
            let [one, two] =
                [1, 2].map(|threads| run(entry.name, &query, threads, Budget::default()).unwrap_or_else(|e| panic!("{}: {e}", entry.name)));
            assert_good(entry.name, &query, &one);
            assert_eq!(one.cells.is_some(), entry.lattice, "{}: lattice planners return their cells", entry.name);
            assert_eq!(one.path, two.path, "{}", entry.name);
            assert_eq!(one.cost.to_bits(), two.cost.to_bits(), "{}", entry.name);
            assert_eq!((one.iterations, one.evaluations), (two.iterations, two.evaluations), "{}", entry.name);
        }
    });
}

#[test]
fn a_closed_room_is_a_proved_no_path_or_says_that_it_is_not_proved() {
    let world = grid_world(&["........", ".#####..", ".#...#..", ".#...#..", ".#####..", "........"], 1.0, [0.0; 3]);
    let query = Query::new(world, [0.5, 0.5], [3.5, 3.5]);
    for entry in REGISTRY {
        match run(entry.name, &query, 1, Budget { iterations: Some(50), ..Budget::default() }) {
            Err(PlanError::NoPath(no)) => assert!(no.proved && no.widest.is_none() || no.reason.is_some(), "{}: {no:?}", entry.name),
            other => panic!("{}: expected NoPath, got {:?}", entry.name, other.map(|s| s.cost)),
        }
    }
}

#[test]
fn blocked_and_outside_ends_are_named() {
    let world = grid_world(&["....", ".##.", "...."], 1.0, [0.0; 3]);
    for entry in REGISTRY {
        let ask = |start, goal| run(entry.name, &Query::new(Arc::clone(&world), start, goal), 1, Budget::default()).map(|s| s.cost);
        assert!(matches!(ask([1.5, 1.5], [3.5, 0.5]), Err(PlanError::StartBlocked { .. })), "{}", entry.name);
        assert!(matches!(ask([0.5, 0.5], [1.5, 1.5]), Err(PlanError::GoalBlocked { .. })), "{}", entry.name);
        assert!(matches!(ask([0.5, 0.5], [9.0, 1.5]), Err(PlanError::OutsideMap { .. })), "{}", entry.name);
        assert!(matches!(ask([f64::NAN, 0.5], [0.5, 1.5]), Err(PlanError::BadParameter { .. })), "{}", entry.name);
    }
}

#[test]
fn cancel_and_a_spent_budget_stop_every_planner() {
    let query = hard();
    for entry in REGISTRY {
        let planner = plan::planner(entry.name, serde_json::Value::Null).expect("a registered planner");
        let mut cancel = |_: &Progress| true;
        let mut ctx = Context::new(1).with_observer(&mut cancel);
        match planner.plan(&query, &mut ctx) {
            Err(PlanError::Cancelled) => {}
            Ok(solution) => assert!(solution.stop == Stop::Cancelled || solution.iterations < 20_000, "{}: ran on after cancel", entry.name),
            Err(other) => panic!("{}: {other}", entry.name),
        }
        match run(entry.name, &query, 1, Budget { seconds: Some(0.0), ..Budget::default() }) {
            Err(PlanError::NoPath(no)) => assert!(!no.proved && no.reason.is_some(), "{}: {no:?}", entry.name),
            Ok(solution) => assert!(solution.stop == Stop::Budget || solution.iterations < 20_000, "{}: ran on over its budget", entry.name),
            Err(other) => panic!("{}: {other}", entry.name),
        }
    }
}

/// Walls with a gap at alternating ends: long enough a way to be interrupted.
fn hard() -> Query {
    let n = 801;
    let mut blocked = Bits::new(n, n);
    for (i, x) in (2..n).step_by(4).enumerate() {
        let gap = if i % 2 == 0 { n - 1 } else { 0 };
        for y in (0..n).filter(|&y| y != gap) {
            blocked.set(x, y, true);
        }
    }
    let world = Arc::new(World::from_grid(Grid::new(blocked, None, 1.0, [0.0; 3]).expect("a valid grid")));
    Query::new(world, [0.5, 0.5], [f64::from(n) - 0.5, 0.5])
}

/// Heuristics off the lattice improve for as long as they may: little of that is enough here.
fn small(entry: &plan::Entry) -> Budget {
    let endless = !entry.lattice && entry.paper.is_some();
    Budget { evaluations: endless.then_some(300), ..Budget::default() }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, failure_persistence: None, ..ProptestConfig::default() })]
    #[test]
    fn random_maps(cells in proptest::collection::vec(0u8..100, 15 * 12), density in 0u8..45, radius in 0usize..3, corners in 0usize..3, ends in any::<(u8, u8, u8, u8)>()) {
        let mut blocked = Bits::new(15, 12);
        for (i, c) in cells.iter().enumerate() {
            blocked.set(i as u32 % 15, i as u32 / 15, *c < density);
        }
        let world = Arc::new(World::from_grid(Grid::new(blocked, None, 0.5, [0.0; 3]).expect("a valid grid")));
        let spot = |a: u8, b: u8| [f64::from(a % 15) + 0.5, f64::from(b % 12) + 0.5];
        let mut query = ask(&world, spot(ends.0, ends.1), spot(ends.2, ends.3));
        query.corners = [Corners::Touch, Corners::Clear, Corners::Squeeze][corners];
        query.footprint = Footprint::Disc([0.0, 0.2, 0.4][radius]);
        let exact = run("visibility", &query, 1, Budget::default());
        for entry in REGISTRY {
            match (run(entry.name, &query, 1, small(entry)), &exact) {
                (Ok(solution), Ok(exact)) => {
                    assert_good(entry.name, &query, &solution);
                    let (length, least) = (solution.length(), exact.length());
                    prop_assert!(length >= least * (1.0 - 1e-9), "{}: {length} below the optimum {least}", entry.name);
                }
                (Ok(_), Err(e)) => prop_assert!(false, "{} found a path where the exact planner says {e}", entry.name),
                (Err(PlanError::NoPath(no)), Ok(_)) => prop_assert!(!no.proved || entry.lattice, "{}: proved NoPath, but there is one", entry.name),
                (Err(_), _) => {}
            }
        }
    }
}
