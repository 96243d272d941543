//! What the sampling planners share: legs, budgets over legs, the proof that there is no path, the solution.

use super::ground::Ground;
use super::shortcut::length;
use crate::Point;
use crate::context::{Context, Stop};
use crate::error::PlanError;
use crate::path::Path;
use crate::plan::legs::joined;
use crate::plan::search::{Visibility, no_path};
use crate::plan::{Planner, Solution};
use crate::query::Query;
use serde_json::json;

/// Samples without a path after which an exact search is asked whether there is one.
const DOUBT: u64 = 2000;
/// Edges of trees that the trace keeps.
pub(super) const EDGES: usize = 3000;

/// One leg at work.
pub(super) struct Leg<'a> {
    query: &'a Query,
    pub ends: [Point; 2],
    pub ground: Ground<'a>,
    /// Iterations, evaluations and seconds (of the whole call) after which a leg with a path makes room for the next.
    share: [Option<f64>; 3],
    samples: u64,
    counted: u64,
    asked: bool,
}

/// What was found on a leg.
pub(super) struct Found {
    pub points: Vec<Point>,
    pub stop: Stop,
    /// Of the trees, as the trace has them.
    pub edges: Vec<[f64; 4]>,
}

impl Leg<'_> {
    /// Ends an iteration: counts it and asks the budget. `best` is the length of the path so far, m.
    pub fn tick(&mut self, best: f64, ctx: &mut Context) -> Result<Option<Stop>, PlanError> {
        self.samples += 1;
        ctx.count_evaluations(self.ground.checks - self.counted);
        self.counted = self.ground.checks;
        let stop = ctx.tick(best);
        if best.is_finite() {
            let done = [ctx.iterations() as f64, ctx.evaluations() as f64, ctx.seconds()];
            let spent = self.share.iter().zip(done).any(|(share, done)| share.is_some_and(|s| done >= s));
            return Ok(stop.or(spent.then_some(Stop::Budget)));
        }
        if self.samples == DOUBT && stop.is_none() {
            self.ask(ctx)?;
        }
        Ok(stop)
    }

    /// Is there a path at all? Asked once.
    fn ask(&mut self, ctx: &mut Context) -> Result<(), PlanError> {
        if !std::mem::replace(&mut self.asked, true) {
            Visibility {}.plan(self.query, ctx)?;
        }
        Ok(())
    }

    /// The error of a leg that ended without a path.
    pub fn nothing(&mut self, stop: Stop, ctx: &mut Context) -> PlanError {
        if stop == Stop::Cancelled {
            return PlanError::Cancelled;
        }
        if let Err(proved) = self.ask(ctx) {
            return proved;
        }
        let spent = if stop == Stop::Budget { "the budget is spent" } else { "the method ended" };
        let advice = "there is one; give it more samples, a shorter step, or take an exact planner such as visibility";
        no_path(self.query, false, Some(format!("{spent}: {} samples found no path; {advice}", self.samples)))
    }
}

/// Plans a query leg by leg; `step` (m) and `halvings` are those of [`Ground`].
pub(super) fn plan(
    query: &Query,
    ctx: &mut Context,
    (step, halvings): (Option<f64>, u32),
    mut solve: impl FnMut(&mut Leg, &mut Context) -> Result<Found, PlanError>,
) -> Result<Solution, PlanError> {
    query.validate()?;
    let stops = query.stops();
    let (mut points, mut parts, mut edges) = (vec![query.start], Vec::new(), Vec::new());
    let (mut stop, mut left) = (Stop::Converged, stops.len() - 1);
    for pair in stops.windows(2) {
        let ground = Ground::new(query, step, halvings);
        let mut leg = Leg { query, ends: [pair[0], pair[1]], ground, share: share(ctx, left), samples: 0, counted: 0, asked: false };
        let found = if pair[0] == pair[1] || leg.ground.free(pair[0], pair[1]) {
            Found { points: vec![pair[0], pair[1]], stop: Stop::Converged, edges: Vec::new() }
        } else {
            solve(&mut leg, ctx)?
        };
        ctx.count_evaluations(leg.ground.checks - leg.counted);
        let cost = length(&found.points);
        let mut history: Vec<(u64, f64)> = ctx.take_history().into_iter().filter(|h| h.1 > cost).collect();
        history.push((ctx.iterations(), cost));
        parts.push((history, cost));
        points.extend(found.points.into_iter().skip(1));
        points.dedup();
        edges.extend(found.edges);
        stop = if stop == Stop::Converged { found.stop } else { stop };
        left -= 1;
    }
    let cost = length(&points);
    let found = Solution::of_search(Path::polyline(&points), cost, ctx.iterations(), ctx);
    let (history, trace) = (joined(&parts, cost, 1.0), json!({ "tree": edges }));
    Ok(Solution { stop, evaluations: ctx.evaluations(), history, trace, ..found })
}

/// Where the share of a leg ends if `left` of them share what is left of the budget.
fn share(ctx: &Context, left: usize) -> [Option<f64>; 3] {
    let budget = ctx.budget();
    let part = |whole: Option<f64>, spent: f64| whole.map(|w| spent + (w - spent) / left as f64);
    [
        part(budget.iterations.map(|n| n as f64), ctx.iterations() as f64),
        part(budget.evaluations.map(|n| n as f64), ctx.evaluations() as f64),
        part(budget.seconds, ctx.seconds()),
    ]
}
