//! How good can a path be at all? A lower bound of the objective that no curve passes.
//!
//! A path whose least clearance is between `d` and `e` is no shorter than the shortest path with clearance `d`, takes no less time than the seven-phase
//! motion over that length under the limits of the query, and pays at least for clearance `e`. The least of this over steps of the clearance bounds every
//! path; where no path keeps a step's clearance, the steps end. It holds for any path, not for splines alone.

use super::Seen;
use crate::context::Context;
use crate::plan::Planner;
use crate::plan::search::Visibility;
use crate::plan::swarm::{Judged, Settings};
use crate::query::{Material, Query};
use crate::timing::first_pass;

/// Steps of the clearance in scenes and small maps; elsewhere there is one, because every step is an exact search.
const STEPS: u32 = 12;
/// Larger worlds than that have one step, cells.
const CELLS: u64 = 100_000;
/// What exact searches may be off by, relative and m.
const SLACK: (f64, f64) = (1e-9, 1e-8);

/// A lower bound and what it is made of.
#[derive(Debug, Clone, Copy)]
pub(super) struct Bound {
    /// No path has a lower objective.
    pub lower: f64,
    /// Length of the shortest path, m.
    pub length: f64,
    /// Least time over that length, s.
    pub time: f64,
}

/// The bound of a query whose shortest path is `shortest` (m) long.
pub(super) fn bound(query: &Query, settings: &Settings, shortest: f64, ctx: &mut Context) -> Bound {
    let least = |length: f64, clearance: f64| at_least(query, settings, length * (1.0 - SLACK.0), clearance + SLACK.1);
    let time = seven_phases(query, shortest);
    let needed = query.radius();
    let most = query.stops().into_iter().map(|p| query.world.clearance(p)).fold(f64::INFINITY, f64::min);
    let [w, h] = query.world.cells().map(u64::from);
    let many = w * h <= CELLS || query.world.grid().is_none();
    if !many || query.material == Material::Long || !(most.is_finite() && most > needed) {
        return Bound { lower: least(shortest, most), length: shortest, time };
    }
    let step = |i: u32| needed + (most - needed) * (f64::from(i) / f64::from(STEPS)).powf(1.5);
    let (mut lower, mut length) = (f64::INFINITY, shortest);
    for i in 0..STEPS {
        lower = lower.min(least(length, step(i + 1)));
        // Longer paths with more clearance cannot be better than what is known.
        if i + 1 == STEPS || least(length, most) >= lower {
            break;
        }
        let wider = Query { clearance: query.clearance + step(i + 1) - needed, ..query.clone() };
        match Visibility::default().plan(&wider, ctx) {
            Ok(found) if found.trace["lower_bound"].as_f64() == Some(found.cost) => length = length.max(found.cost),
            // Nothing passes with that clearance.
            Err(crate::error::PlanError::NoPath(why)) if why.proved => break,
            // Not known: the length so far stands for all that follow.
            _ => {
                lower = lower.min(least(length, most));
                break;
            }
        }
    }
    Bound { lower, length: shortest, time }
}

fn seven_phases(query: &Query, length: f64) -> f64 {
    if length > 0.0 { first_pass(length, &query.limits).map_or(0.0, |p| p.duration()) } else { 0.0 }
}

/// The objective of a path at least that long with at most that clearance, at best.
pub(super) fn at_least(query: &Query, settings: &Settings, length: f64, clearance: f64) -> f64 {
    let time = seven_phases(query, length);
    settings.worth(&Judged { length, time, turning: 0.0, clearance, overspeed: 0.0, value: 0.0, violation: 0.0 }, query)
}

impl Bound {
    /// For the trace, beside the value that was found.
    pub fn seen(&self, value: f64) -> Seen {
        let gap = if self.lower > 0.0 { Some(value / self.lower - 1.0) } else { None };
        serde_json::json!({ "lower": self.lower, "value": value, "gap": gap, "length": self.length, "time": self.time })
    }
}
