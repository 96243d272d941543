//! Swarms on the stand-in scenes.

use guideway::context::{Budget, Context};
use guideway::plan::score::counts;
use guideway::plan::{self, Solution};
use guideway::query::Query;
use guideway::world::{Bits, Grid, World};
use guideway::{certify, error::PlanError};
use serde_json::{Value, json};
use std::sync::Arc;

const SCENES: [&str; 2] = [include_str!("scenes/pso-aco-1.txt"), include_str!("scenes/pso-aco-2.txt")];

/// From the lower left to the upper right corner of a scene.
fn scene(text: &str) -> Query {
    let rows: Vec<&str> = text.lines().collect();
    let (w, h) = (rows[0].len() as u32, rows.len() as u32);
    let mut blocked = Bits::new(w, h);
    for (i, row) in rows.iter().enumerate() {
        row.bytes().enumerate().for_each(|(x, c)| blocked.set(x as u32, h - 1 - i as u32, c == b'#'));
    }
    let world = World::from_grid(Grid::new(blocked, None, 1.0, [0.0; 3]).expect("a scene"));
    Query::new(Arc::new(world), [0.5, 0.5], [f64::from(w) - 0.5, f64::from(h) - 0.5])
}

fn run(name: &str, parameters: Value, query: &Query, seed: u64, evaluations: u64) -> Result<Solution, PlanError> {
    let mut ctx = Context::new(seed).with_budget(Budget { evaluations: Some(evaluations), ..Budget::default() })?;
    plan::planner(name, parameters)?.plan(query, &mut ctx)
}

const NAMES: [&str; 4] = ["pso", "grouped-pso", "ga", "sparrow"];

#[test]
fn every_path_on_the_stand_ins_is_free_and_the_lattice_optimum_is_found() {
    for (text, steps) in SCENES.iter().zip([[6, 16], [10, 14]]) {
        let query = scene(text);
        for (name, preset) in NAMES.iter().flat_map(|n| [(n, "paper"), (n, "default")]) {
            for seed in 0..5 {
                let found = run(name, json!({ "preset": preset }), &query, seed, 2500).expect("a path");
                let check = certify::collision(&found.path, &query, None);
                assert!(check.ok, "{name} {preset} {seed}: {check:?}");
                assert!(found.evaluations <= 2500 && (found.history.last().expect("one").1 - found.cost).abs() < 1e-9, "{name} {preset} {seed}");
                let Some(cells) = found.cells else {
                    assert_eq!((*name, preset), ("sparrow", "paper"));
                    continue;
                };
                assert_eq!(counts(&cells)[..2], steps, "{name} {preset} {seed}");
            }
        }
    }
}
