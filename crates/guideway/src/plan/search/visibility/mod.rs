//! The exact any-angle optimum: the default planner, and the reference every other result is measured against.
//!
//! Sources: \[harabor2016\], \[cui2017\] for a point on a grid (`rows.rs`). No parameters.
//! Departures: see `rows.rs`.

mod rows;
mod runs;

use super::leg::no_path;
use crate::Point;
use crate::context::{Context, Stop};
use crate::error::PlanError;
use crate::path::Path;
use crate::plan::{Planner, Solution};
use crate::query::Query;
use crate::world::{Corners, Grid, shape};
use rows::{Found, Rows};
use serde::{Deserialize, Serialize};
use serde_json::json;

/// Exact shortest path in the plane.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Visibility {}

impl Planner for Visibility {
    fn plan(&self, query: &Query, ctx: &mut Context) -> Result<Solution, PlanError> {
        query.validate()?;
        let Some(grid) = query.world.grid().filter(|_| query.radius() == 0.0 && query.world.shapes().is_empty()) else {
            return super::ThetaStar::default().plan(query, ctx);
        };
        let mut expansions = 0;
        let points = crate::plan::through(query, |from, to| point_leg(query, grid, [from, to], ctx, &mut expansions))?;
        let cost = points.windows(2).map(|w| shape::distance(w[0], w[1])).sum();
        Ok(Solution {
            path: Path::polyline(&points),
            cells: None,
            cost,
            trajectory: None,
            stop: Stop::Converged,
            iterations: expansions,
            evaluations: 0,
            seconds: ctx.seconds(),
            history: vec![(expansions, cost)],
            trace: json!({}),
            memory: None,
        })
    }
}

/// One leg of a point robot on a grid, m.
fn point_leg(query: &Query, grid: &Grid, [from, to]: [Point; 2], ctx: &mut Context, expansions: &mut u64) -> Result<Vec<Point>, PlanError> {
    let lattice = query.world.lattice(0.0);
    let mut rows = Rows::new(lattice.free(), query.corners == Corners::Squeeze, grid.to_cells(from), grid.to_cells(to));
    let mut stopped = None;
    let found = rows.solve(&mut || {
        stopped = ctx.poll();
        stopped.is_some()
    });
    *expansions += rows.expansions;
    match found {
        Found::Path(points) => {
            let mut points: Vec<Point> = points.into_iter().map(|q| grid.to_map(q)).collect();
            let last = points.len() - 1;
            (points[0], points[last]) = (from, to);
            Ok(points)
        }
        Found::Nothing => Err(no_path(query, true, None)),
        Found::Stopped { .. } if stopped == Some(Stop::Cancelled) => Err(PlanError::Cancelled),
        Found::Stopped { .. } => Err(no_path(query, false, Some("the budget of time was spent".into()))),
    }
}
