//! The exact any-angle optimum: the default planner, and the reference every other result is measured against.
//!
//! Sources: \[harabor2016\], \[cui2017\] for a point on a grid (`rows.rs`); visibility graphs \[lozano1979\] with tangents and arcs for
//! everything else (`tangent.rs`). No parameters.
//! Departures: rows are scanned on the fly instead of a mesh; tangents are found lazily inside an ellipse that a lower bound sizes. Footprints
//! other than discs are planned with their circumscribed disc.

mod circles;
mod classes;
mod leg;
mod rows;
pub(in crate::plan) mod runs;
mod tangent;

use super::leg::no_path;
use crate::context::{Context, Stop};
use crate::error::PlanError;
use crate::path::Path;
use crate::plan::{Planner, Solution};
use crate::query::Query;
pub(in crate::plan) use circles::Inflated;
pub(in crate::plan) use classes::{Classes, Taut};
pub(in crate::plan) use leg::{Leg, Route};
use serde::{Deserialize, Serialize};
use serde_json::json;

/// Exact shortest path of a disc (or point) in the plane among squares, discs and convex polygons.
///
/// `Solution.cost` is the exact length; `path` runs around the outside of arcs and is longer by less than 1e-6 of it. `trace.lower_bound` (m) is a proved
/// lower bound on the length of any path, equal to the cost unless a budget of time stopped the search.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Visibility {}

impl Planner for Visibility {
    fn plan(&self, query: &Query, ctx: &mut Context) -> Result<Solution, PlanError> {
        query.validate()?;
        // Under a budget of time the lattice path comes first: it is the result if the proof does not finish.
        let quick = if ctx.budget().seconds.is_some() { super::grid_optimum(query, ctx).ok() } else { None };
        let (mut points, mut cost, mut expansions, mut bound) = (vec![query.start], 0.0, 0, 0.0);
        let mut leg = Leg::new(query);
        for ends in query.stops().windows(2) {
            let route = leg.solve([ends[0], ends[1]], ctx);
            expansions += leg.expansions;
            match route {
                Route::Path { points: part, length } => {
                    points.extend(part.into_iter().skip(1));
                    cost += length;
                    bound += length;
                }
                Route::Nothing => return Err(PlanError::NoPath(Box::new(super::explain(query, ctx)))),
                Route::Stopped { bound: rest } => {
                    let after: f64 =
                        query.stops().windows(2).skip_while(|w| *w != ends).skip(1).map(|w| crate::world::shape::distance(w[0], w[1])).sum();
                    return unfinished(query, ctx, quick, bound + rest + after);
                }
            }
        }
        let found = Solution::of_search(Path::polyline(&points), cost, expansions, ctx);
        Ok(Solution { trace: json!({ "lower_bound": bound }), ..found })
    }
}

/// The quick path with the bound that was proved, or an error if there is none.
fn unfinished(query: &Query, ctx: &mut Context, quick: Option<Solution>, bound: f64) -> Result<Solution, PlanError> {
    let stop = ctx.poll().unwrap_or(Stop::Budget);
    match quick {
        Some(found) => Ok(Solution { cells: None, stop, trace: json!({ "lower_bound": bound }), seconds: ctx.seconds(), ..found }),
        None if stop == Stop::Cancelled => Err(PlanError::Cancelled),
        None => Err(no_path(query, false, Some("the budget of time was spent".into()))),
    }
}

/// Is there a way for a disc of radius `radius` (m) between two points, and how long is the shortest? `None` if the search was stopped.
#[cfg(test)]
fn shortest(query: &Query, ends: [crate::Point; 2]) -> Option<f64> {
    match Leg::new(query).solve(ends, &mut Context::new(0)) {
        Route::Path { length, .. } => Some(length),
        _ => None,
    }
}

#[cfg(test)]
mod tests;
