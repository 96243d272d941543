//! Swarms on the stand-in scenes.

use guideway::context::{Budget, Context, Stop};
use guideway::plan::score::counts;
use guideway::plan::{self, Solution};
use guideway::query::{Material, Query};
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

/// Walls with a gap at alternating ends.
fn serpentine(n: u32) -> Query {
    let row = |y: u32| (0..n).map(|x| if x % 2 == 1 && y != if x % 4 == 1 { n - 1 } else { 0 } { '#' } else { '.' }).collect::<String>();
    scene(&(0..n).rev().map(row).collect::<Vec<_>>().join("\n"))
}

#[test]
fn walks_find_mazes_and_a_limit_that_ends_them_is_told_apart_from_no_path() {
    let query = serpentine(41);
    for name in NAMES {
        let found = run(name, Value::Null, &query, 1, 200).expect("walks without a limit arrive");
        assert!(certify::collision(&found.path, &query, None).ok, "{name}");
        match run(name, json!({ "preset": "paper" }), &query, 1, 200) {
            Err(PlanError::NoPath(no)) => {
                assert!(!no.proved && no.reason.as_ref().is_some_and(|r| r.contains("walk_limit")), "{name}: {no:?}");
            }
            other => panic!("{name}: {:?}", other.map(|s| s.cost)),
        }
    }
}

#[test]
fn several_legs_share_a_budget_and_still_arrive() {
    let mut query = scene(SCENES[0]);
    query.via = vec![[0.5, 10.5], [10.5, 15.5]];
    for name in NAMES {
        let found = run(name, Value::Null, &query, 3, 1).expect("the walk straight at the goal");
        assert_eq!((found.stop, found.evaluations), (Stop::Budget, 3), "{name}: one walk for each leg");
        assert!(certify::collision(&found.path, &query, None).ok, "{name}");
        let long = run(name, json!({ "patience": 5 }), &query, 3, 10_000).expect("a path");
        assert!(long.cost <= found.cost && long.trace["legs"].as_array().is_some_and(|l| l.len() == 3), "{name}");
        let last = long.history.last().expect("an improvement");
        assert!((last.1 - long.cost).abs() < 1e-9 && long.history.windows(2).all(|w| w[1].1 <= w[0].1 + 1e-9), "{name}: {:?}", long.history);
    }
}

#[test]
fn the_least_energy_is_what_heavy_loads_ask_for() {
    let mut query = scene(SCENES[1]);
    query.material = Material::Heavy;
    for (name, preset) in NAMES.iter().flat_map(|n| [(n, "paper"), (n, "default")]) {
        let parameters = if *name == "ga" { json!({ "preset": preset }) } else { json!({ "preset": preset, "prune": false }) };
        let found = run(name, parameters, &query, 1, 1500).expect("a path");
        let [straight, diagonal, turns] = counts(found.cells.as_ref().expect("cells")).map(f64::from);
        let length = straight + diagonal * 2f64.sqrt();
        let asked = if preset == "paper" { length } else { length + 0.5 * turns };
        let last = found.trace["legs"][0]["convergence"].as_array().and_then(|c| c.last()).expect("a point")[1].as_f64().expect("a cost");
        assert!((last - asked).abs() < 1e-9, "{name} {preset}: {last} {asked}");
    }
}

#[test]
fn pruned_paths_are_any_angle_and_free() {
    let query = scene(SCENES[0]);
    for name in ["pso", "grouped-pso", "sparrow"] {
        let found = run(name, json!({ "prune": true }), &query, 1, 1000).expect("a path");
        assert!(found.cells.is_none() && (found.cost - found.path.length()).abs() < 1e-9, "{name}");
        // The exact optimum over cell centres is 27.3808.
        assert!(found.cost < 28.0 && found.cost > 27.38 && certify::collision(&found.path, &query, None).ok, "{name}: {}", found.cost);
    }
}

#[test]
fn groups_find_more_than_the_plain_swarm_and_loop_cutting_more_still() {
    let query = scene(include_str!("scenes/m30.txt"));
    let hits = |name, cut| {
        let cost =
            |seed| run(name, json!({ "preset": "paper", "cut": cut, "iterations": 1000, "patience": 0 }), &query, seed, 5000).expect("a path").cost;
        (0..8).map(cost).filter(|c| (c - 41.598).abs() < 1e-4).count()
    };
    let (plain, grouped, cut) = (hits("pso", false), hits("grouped-pso", false), hits("pso", true));
    assert!(grouped > plain && cut > plain && grouped >= 6, "{plain} {grouped} {cut}");
}

#[test]
fn way_points_are_a_switch() {
    let query = scene(include_str!("scenes/m20.txt"));
    let found = run("grouped-pso", json!({ "encoding": "way-points" }), &query, 1, 5000).expect("a path");
    assert!(found.cells.is_some() && found.cost < 30.0 && certify::collision(&found.path, &query, None).ok, "{}", found.cost);
    let hard = run("sparrow", json!({ "encoding": "way-points", "points": 1 }), &scene(SCENES[1]), 1, 100);
    assert!(matches!(hard, Err(PlanError::NoPath(no)) if !no.proved && no.reason.is_some()));
}

#[test]
fn traces_show_convergence_and_paths() {
    let query = scene(SCENES[1]);
    for name in NAMES {
        let found = run(name, json!({ "iterations": 3 }), &query, 1, 5000).expect("a path");
        let leg = &found.trace["legs"][0];
        let last = leg["convergence"].as_array().and_then(|c| c.last()).expect("a point").clone();
        assert!((last[1].as_f64().expect("a cost") - found.cost).abs() < 1e-9, "{name}: {last}");
        let paths = leg["paths"].as_array().expect("paths");
        assert!(!paths.is_empty() && paths.len() <= 8, "{name}");
        assert!(paths.iter().all(|p| p[0] == json!([0.5, 0.5]) && p.as_array().and_then(|p| p.last()) == Some(&json!([19.5, 19.5]))), "{name}");
    }
}

#[test]
fn parameters_that_cannot_be_are_named() {
    let query = scene(SCENES[0]);
    let bad: [(&str, &str, Value); 9] = [
        ("pso", "keys", json!(0)),
        ("pso", "walk_limit", json!(-1.0)),
        ("pso", "points", json!(0)),
        ("pso", "particles", json!(1)),
        ("grouped-pso", "groups", json!(51)),
        ("ga", "individuals", json!(1)),
        ("ga", "piece", json!(1)),
        ("ga", "mutation", json!(1.5)),
        ("sparrow", "safety", json!(-0.1)),
    ];
    for (name, key, value) in bad {
        let error = run(name, json!({ key: value }), &query, 1, 100).err().expect("an error");
        assert!(matches!(&error, PlanError::BadParameter { name: told, .. } if told.contains(key)), "{name}.{key}: {error}");
    }
    for (name, parameters) in [("pso", json!({ "sparrows": 3 })), ("ga", json!({ "keys": "many" })), ("sparrow", json!({ "encoding": "runes" }))] {
        assert_eq!(run(name, parameters, &query, 1, 100).err().expect("an error").name(), "BadParameter");
    }
}
