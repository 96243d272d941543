//! Scenario rows of the Moving AI maps against their published optima: a thinned set by default, every row with the feature `slow`.

mod moving_ai;

use guideway::context::Context;
use guideway::error::PlanError;
use guideway::plan::{Solution, planner};
use guideway::query::Query;
use guideway::world::{Corners, World};
use moving_ai::Row;
use std::sync::Arc;

/// Published lengths carry 5 to 6 digits.
const ROUNDING: f64 = 0.01;

fn solve(world: &Arc<World>, row: &Row, name: &str) -> Result<Solution, PlanError> {
    let grid = world.grid().unwrap();
    let mut query = Query::new(Arc::clone(world), grid.center(row.start), grid.center(row.goal));
    query.corners = Corners::Clear;
    planner(name, serde_json::Value::Null)?.plan(&query, &mut Context::new(0))
}

/// Solves every `step`-th row and returns (solved, refused because an end is blocked).
fn check(name: &str, thin: usize) -> Option<(usize, usize)> {
    let root = moving_ai::folder()?;
    let (mut solved, mut refused) = (0, 0);
    for map in moving_ai::names(&root) {
        let (world, rows) = moving_ai::load(&root, &map);
        let world = Arc::new(world);
        let blocked = |c: [u32; 2]| world.grid().unwrap().blocked().at(c[0], c[1]);
        for (k, row) in rows.iter().enumerate().step_by(thin) {
            match solve(&world, row, name) {
                Ok(s) => {
                    assert!((s.cost - row.optimum).abs() < ROUNDING, "{map} row {k}: {} instead of {}", s.cost, row.optimum);
                    solved += 1;
                }
                Err(e) => {
                    let ends = [blocked(row.start), blocked(row.goal)];
                    let expected = if ends[0] { "StartBlocked" } else { "GoalBlocked" };
                    assert!(ends[0] || ends[1], "{map} row {k}: {e}");
                    assert_eq!(e.name(), expected, "{map} row {k}");
                    refused += 1;
                }
            }
        }
    }
    println!("{name}: {solved} rows solved, {refused} refused because an end is blocked");
    assert!(solved > 0);
    Some((solved, refused))
}

#[test]
fn jump_points_reach_published_optima_thinned() {
    check("jump-point", 8);
}

#[test]
fn astar_reaches_published_optima_thinned() {
    check("astar", 60);
}

#[cfg(feature = "slow")]
#[test]
fn jump_points_reach_every_published_optimum() {
    check("jump-point", 1);
}

#[cfg(feature = "slow")]
#[test]
fn astar_reaches_every_published_optimum() {
    check("astar", 1);
}

#[cfg(feature = "slow")]
#[test]
fn dijkstra_reaches_published_optima_thinned() {
    check("dijkstra", 20);
}

#[test]
fn blocked_ends_are_errors() {
    let Some(root) = moving_ai::folder() else { return };
    let (world, _) = moving_ai::load(&root, "dao/arena");
    let world = Arc::new(world);
    let wall = (0..world.grid().unwrap().width()).map(|x| [x, 0]).find(|c| world.grid().unwrap().blocked().at(c[0], c[1])).unwrap();
    let row = Row { start: wall, goal: wall, optimum: 0.0 };
    assert_eq!(solve(&world, &row, "jump-point").err().map(|e| e.name()), Some("StartBlocked"));
}
