use crate::certify;
use crate::context::{Budget, Context, Stop};
use crate::error::PlanError;
use crate::plan::search::Visibility;
use crate::plan::{self, Planner, Solution};
use crate::query::Query;
use crate::world::{Bits, Grid, Shape, World};
use std::sync::Arc;

const NAMES: [&str; 3] = ["rrt-connect", "rrt-star", "informed-rrt-star"];

fn room() -> Query {
    let discs = [(1.20, 0.95, 0.8), (2.35, 1.55, 0.6), (2.10, 3.00, 1.0), (3.70, 2.05, 0.9), (4.10, 0.60, 0.7), (6.50, 1.50, 1.2)];
    let shapes = discs.iter().map(|d| Shape::disc([d.0, d.1], d.2 / 2.0).unwrap()).collect();
    let world = Arc::new(World::from_shapes([0.0, 0.0, 10.0, 6.0], shapes, 0.05).unwrap());
    Query { clearance: 0.3, ..Query::new(world, [0.0, 0.0], [5.0, 3.0]) }
}

fn run(name: &str, set: serde_json::Value, query: &Query, budget: Budget) -> Result<Solution, PlanError> {
    plan::planner(name, set).unwrap().plan(query, &mut Context::new(5).with_budget(budget).unwrap())
}

fn shortest(query: &Query) -> f64 {
    Visibility {}.plan(query, &mut Context::new(0)).unwrap().cost
}

#[test]
fn the_room_is_solved_near_the_optimum() {
    let query = room();
    let best = shortest(&query);
    for (name, gap) in [("rrt-connect", 0.5), ("rrt-star", 0.01), ("informed-rrt-star", 0.005)] {
        let found = run(name, serde_json::Value::Null, &query, Budget::default()).unwrap();
        assert!(certify::collision(&found.path, &query, None).ok, "{name}");
        assert!(found.cost >= best - 1e-9 && found.cost <= best * (1.0 + gap), "{name}: {} of {best}", found.cost);
        assert!(found.history.windows(2).all(|h| h[1].1 < h[0].1) && found.history.last().unwrap().1 == found.cost, "{name}: {:?}", found.history);
        let edges = found.trace["tree"].as_array().unwrap();
        assert!(!edges.is_empty() && edges.len() <= 3000, "{name}");
    }
}

#[test]
fn settings_of_the_sources_get_shorter_with_samples() {
    let query = room();
    let best = shortest(&query);
    for name in ["rrt-star", "informed-rrt-star"] {
        let gap = |samples: u64| {
            run(name, serde_json::json!({"preset": "paper", "samples": samples}), &query, Budget::default()).unwrap().cost / best - 1.0
        };
        let (few, many) = (gap(500), gap(8000));
        assert!(many < few && many < 0.03, "{name}: {few} {many}");
    }
}

#[test]
fn informed_samples_beat_uniform_ones() {
    let query = room();
    let set = |samples: u64| serde_json::json!({"preset": "paper", "samples": samples});
    let mean = |name: &str| {
        let runs = (0..10).map(|seed| plan::planner(name, set(3000)).unwrap().plan(&query, &mut Context::new(seed)).unwrap().cost);
        runs.sum::<f64>() / 10.0
    };
    assert!(mean("informed-rrt-star") < mean("rrt-star"));
}

#[test]
fn narrow_passages() {
    // A wall with a slot of 4 cm for the disc.
    let wall = |y: [f64; 2]| Shape::polygon(vec![[4.9, y[0]], [5.1, y[0]], [5.1, y[1]], [4.9, y[1]]]).unwrap();
    let world = Arc::new(World::from_shapes([0.0, 0.0, 10.0, 6.0], vec![wall([-1.0, 1.0]), wall([1.44, 7.0])], 0.05).unwrap());
    let query = Query { clearance: 0.2, ..Query::new(world, [1.0, 5.0], [9.0, 5.0]) };
    for name in NAMES {
        let found = run(name, serde_json::Value::Null, &query, Budget::default()).unwrap();
        assert!(certify::collision(&found.path, &query, None).ok, "{name}");
    }
}

/// Corridors of one cell, in a spiral.
fn spiral(n: u32) -> Query {
    let mut blocked = Bits::new(n, n);
    for y in 0..n {
        for x in 0..n {
            let ring = x.min(y).min(n - 1 - x).min(n - 1 - y);
            let door = x == ring && y == ring + 1 || ring % 4 == 3 && x == n / 2 && y == ring;
            blocked.set(x, y, ring % 2 == 1 && !(ring % 4 == 1 && door) && !(ring % 4 == 3 && x == n - 1 - ring && y == n - 2 - ring));
        }
    }
    let world = Arc::new(World::from_grid(Grid::new(blocked, None, 1.0, [0.0; 3]).unwrap()));
    let middle = f64::from(n / 2) + 0.5;
    Query::new(world, [0.5, 0.5], [middle, middle])
}

#[test]
fn corridors_of_one_cell() {
    let query = spiral(17);
    let best = shortest(&query);
    for name in NAMES {
        let found = run(name, serde_json::Value::Null, &query, Budget::default()).unwrap();
        assert!(found.cost <= 2.0 * best, "{name}: {} of {best}", found.cost);
    }
}

#[test]
fn no_path_is_proved() {
    let ring = (0..24).map(|i| f64::from(i) * std::f64::consts::TAU / 24.0).map(|t| Shape::disc([5.0 + t.cos(), 3.0 + t.sin()], 0.2).unwrap());
    let world = Arc::new(World::from_shapes([0.0, 0.0, 10.0, 6.0], ring.collect(), 0.05).unwrap());
    let query = Query { clearance: 0.1, ..Query::new(world, [0.5, 0.5], [5.0, 3.0]) };
    for name in NAMES {
        for budget in [Budget::default(), Budget { iterations: Some(20), ..Budget::default() }, Budget { evaluations: Some(20), ..Budget::default() }]
        {
            match run(name, serde_json::Value::Null, &query, budget) {
                Err(PlanError::NoPath(no)) => assert!(no.proved, "{name}: {no:?}"),
                other => panic!("{name}: {:?}", other.map(|s| s.cost)),
            }
        }
    }
}

#[test]
fn budgets_are_kept_and_shared_between_legs() {
    let query = Query { via: vec![[8.0, 0.5]], ..room() };
    for name in ["rrt-star", "informed-rrt-star"] {
        let budget = Budget { iterations: Some(900), ..Budget::default() };
        let found = run(name, serde_json::json!({"samples": 100_000}), &query, budget).unwrap();
        assert_eq!((found.stop, found.iterations <= 900), (Stop::Budget, true), "{name}");
        assert!(certify::collision(&found.path, &query, None).ok, "{name}");
        let few = Budget { evaluations: Some(5000), ..Budget::default() };
        let found = run(name, serde_json::json!({"samples": 100_000}), &query, few).unwrap();
        assert!((5000..8000).contains(&found.evaluations), "{name}: {}", found.evaluations);
    }
}

#[test]
fn parameters_out_of_range_are_named() {
    let bad = [
        ("rrt-connect", serde_json::json!({"step": 0.0}), "step"),
        ("rrt-connect", serde_json::json!({"halvings": 21}), "halvings"),
        ("rrt-star", serde_json::json!({"goal_bias": 1.5}), "goal_bias"),
        ("rrt-star", serde_json::json!({"samples": 0}), "samples"),
        ("informed-rrt-star", serde_json::json!({"rewire": -1.0}), "rewire"),
    ];
    for (name, set, word) in bad {
        let error = run(name, set, &room(), Budget::default()).map(|s| s.cost).unwrap_err().to_string();
        assert!(error.contains(word) && error.contains(name), "{error}");
    }
}
