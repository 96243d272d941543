//! Incremental replanning of the colonies: a way that gets blocked is repaired, not planned anew.

use guideway::certify;
use guideway::context::Context;
use guideway::error::PlanError;
use guideway::plan::score::Aim;
use guideway::plan::{self, Planner, Solution};
use guideway::query::Query;
use guideway::world::{Bits, Cell, Grid, World};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use std::sync::Arc;

const PLANNERS: [&str; 3] = ["bidirectional-aco", "improved-aco", "pso-aco"];

fn world(blocked: &Bits) -> Arc<World> {
    Arc::new(World::from_grid(Grid::new(blocked.clone(), None, 1.0, [0.0; 3]).expect("a grid")))
}

fn ask(blocked: &Bits, start: Cell, goal: Cell) -> Query {
    let center = |c: Cell| c.map(|v| f64::from(v) + 0.5);
    Query::new(world(blocked), center(start), center(goal))
}

fn method(name: &str, set: &str) -> Box<dyn Planner> {
    plan::planner(name, serde_json::from_str(set).expect("parameters")).expect("a planner")
}

/// A 30 x 30 map with a fifth of its cells blocked.
fn map(seed: u64) -> Bits {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut blocked = Bits::new(30, 30);
    for y in 0..30 {
        for x in 0..30 {
            blocked.set(x, y, rng.random_bool(0.2) && (x + y) > 2 && (x + y) < 56);
        }
    }
    blocked
}

/// Plans, then blocks a block of cells across the way ahead of a robot that has gone a third of it.
fn blocked_ahead(name: &str, seed: u64) -> Option<(Solution, Bits, Query)> {
    let mut blocked = map(seed);
    let first = method(name, r#"{"seeding": "off"}"#).plan(&ask(&blocked, [0, 0], [29, 29]), &mut Context::new(seed)).ok()?;
    let cells = first.cells.clone().expect("a lattice path");
    let (at, wall) = (cells[cells.len() / 3], cells[cells.len() / 2]);
    for x in wall[0].saturating_sub(1)..=wall[0] + 1 {
        for y in wall[1].saturating_sub(1)..=wall[1] + 1 {
            if [x, y] != at && [x, y] != [29, 29] && x < 30 && y < 30 {
                blocked.set(x, y, true);
            }
        }
    }
    let query = ask(&blocked, at, [29, 29]);
    Some((first, blocked, query))
}

#[test]
fn a_blocked_way_is_repaired_with_little_work() {
    for name in PLANNERS {
        let (mut tried, mut gaps) = (0, Vec::new());
        for seed in 0..40 {
            let Some((first, _, query)) = blocked_ahead(name, seed) else { continue };
            let Ok(exact) = method("jump-point", "{}").plan(&query, &mut Context::new(0)) else { continue };
            let again = method(name, "{}").replan(&first, &query, &mut Context::new(seed)).expect("there is a way");
            assert!(certify::collision(&again.path, &query, None).ok);
            assert!(again.cost >= exact.cost - 1e-9, "{name} {seed}: {} below {}", again.cost, exact.cost);
            assert!(again.evaluations <= 2 * 20 * 10, "{name} {seed}: {} evaluations", again.evaluations);
            gaps.push(again.cost / exact.cost - 1.0);
            tried += 1;
        }
        assert!(tried > 20, "{name}: {tried}");
        let optimal = gaps.iter().filter(|g| **g < 1e-9).count();
        assert!(optimal * 10 >= tried * 9 && gaps.iter().all(|g| *g < 0.05), "{name}: {optimal} of {tried}, {gaps:?}");
    }
}

#[test]
fn the_old_way_is_not_lost_where_nothing_changed() {
    for name in PLANNERS {
        let blocked = map(3);
        let first = method(name, "{}").plan(&ask(&blocked, [0, 0], [29, 29]), &mut Context::new(1)).expect("a way");
        let cells = first.cells.clone().expect("a lattice path");
        let again = method(name, "{}").replan(&first, &ask(&blocked, cells[5], [29, 29]), &mut Context::new(2)).expect("a way");
        let (kept, found) = (Aim::Shortest.of_cells(&cells[5..]), Aim::Shortest.of_cells(&again.cells.expect("a lattice path")));
        assert!(!kept.beats(found), "{name}: {found:?} is worse than the old way {kept:?}");
    }
}

#[test]
fn a_closed_way_and_another_map_are_told_apart() {
    for name in PLANNERS {
        let mut blocked = map(3);
        let first = method(name, "{}").plan(&ask(&blocked, [0, 0], [29, 29]), &mut Context::new(1)).expect("a way");
        let smaller = ask(&Bits::new(9, 9), [0, 0], [8, 8]);
        let other = method(name, "{}").replan(&first, &smaller, &mut Context::new(1)).expect("planned anew");
        assert_eq!(other.cells.map(|c| c.len()), Some(9));
        for x in 0..30 {
            blocked.set(x, 15, true);
        }
        let closed = method(name, "{}").replan(&first, &ask(&blocked, [0, 0], [29, 29]), &mut Context::new(1));
        assert!(matches!(closed, Err(PlanError::NoPath(no)) if no.proved), "{name}");
    }
}

#[test]
fn threads_do_not_change_a_repair() {
    for name in PLANNERS {
        let (first, _, query) = (0..40).find_map(|seed| blocked_ahead(name, seed)).expect("a case");
        let run = |threads| method(name, "{}").replan(&first, &query, &mut Context::new(5).with_threads(threads)).map(|s| s.cells);
        assert_eq!(run(1).ok(), run(2).ok());
    }
}
