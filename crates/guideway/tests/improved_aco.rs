//! The improved ant colony on the stand-ins of its source's maps.

use guideway::certify;
use guideway::context::Context;
use guideway::plan::{self, Solution};
use guideway::query::Query;
use guideway::world::{Bits, Grid, World};
use serde_json::{Value, json};
use std::f64::consts::SQRT_2;
use std::sync::Arc;

/// A packaged scene of `n` x `n` cells, corner to corner.
fn scene(name: &str) -> Query {
    let file = format!("{}/../../python/guideway/data/scenes/{name}.txt", env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(&file).expect("a packaged scene");
    let rows: Vec<&str> = text.lines().filter(|row| !row.is_empty()).collect();
    let n = rows.len() as u32;
    let mut blocked = Bits::new(n, n);
    for (i, row) in rows.iter().enumerate() {
        for (x, c) in row.bytes().enumerate() {
            blocked.set(x as u32, n - 1 - i as u32, c == b'#');
        }
    }
    let end = f64::from(n) - 0.5;
    Query::new(Arc::new(World::from_grid(Grid::new(blocked, None, 1.0, [0.0; 3]).expect("a valid grid"))), [0.5, 0.5], [end, end])
}

fn solve(query: &Query, parameters: Value, seed: u64, threads: usize) -> Solution {
    let planner = plan::planner("improved-aco", parameters).expect("valid parameters");
    planner.plan(query, &mut Context::new(seed).with_threads(threads)).expect("a path")
}

#[test]
fn the_default_finds_the_lattice_optimum_with_every_seed_by_itself() {
    for (name, optimum) in [("m20", 18.0 * SQRT_2 + 2.0), ("m30", 28.0 * SQRT_2 + 2.0)] {
        let query = scene(name);
        for seed in 0..30 {
            let solution = solve(&query, json!({"seeding": "off"}), seed, 1);
            assert!((solution.cost - optimum).abs() < 1e-9, "{name}, seed {seed}: {} is not {optimum}", solution.cost);
            assert!(certify::collision(&solution.path, &query, None).ok, "{name}, seed {seed}");
        }
    }
}

#[test]
fn every_preset_and_reading_is_the_same_with_any_number_of_threads() {
    let query = scene("m30");
    for parameters in [
        json!({"preset": "paper", "iterations": 20}),
        json!({"preset": "paper", "iterations": 20, "o1_reading": "literal", "conversion": "rate", "king_cutting": true}),
        json!({"iterations": 20, "seeding": "exact"}),
        json!({"iterations": 20, "bounds": "max-min", "conversion": "entropy", "restart": 0.5}),
    ] {
        let (a, b) = (solve(&query, parameters.clone(), 5, 1), solve(&query, parameters.clone(), 5, 3));
        assert_eq!((a.path, a.history, a.evaluations, a.trace), (b.path, b.history, b.evaluations, b.trace), "{parameters}");
    }
}

#[test]
fn the_marked_cells_are_not_on_the_path_and_no_path_is_shorter_than_the_optimum() {
    let query = scene("m30");
    for seed in 0..5 {
        let solution = solve(&query, json!({"preset": "paper"}), seed, 1);
        assert!(solution.cost >= 28.0 * SQRT_2 + 2.0 - 1e-9);
        let cells = solution.cells.as_ref().expect("a lattice planner");
        let tabu = solution.trace["legs"][0]["tabu"].as_array().expect("a list");
        assert!(cells.iter().all(|cell| !tabu.contains(&json!(cell))));
    }
}

/// The printed length on 20 x 20 cells, 25.87, is below the straight line between opposite corner cells.
#[test]
fn the_printed_length_cannot_be() {
    let query = scene("m20");
    let straight = (query.goal[0] - query.start[0]).hypot(query.goal[1] - query.start[1]);
    assert!((straight - 26.870).abs() < 1e-3 && 25.87 < straight);
    assert!(solve(&query, json!({}), 0, 1).cost > straight);
}
