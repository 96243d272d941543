//! The adapter: any optimizer of the library as a continuous planner.

use super::curves::{Curves, Judged};
use super::route::{self, Layout};
use super::settings::{Form, Settings};
use super::watch::{Watch, points};
use crate::context::{Context, Stop};
use crate::error::PlanError;
use crate::optimize::{Minimum, Optimizer};
use crate::path::Path;
use crate::plan::search::{Visibility, no_path};
use crate::plan::{Planner, Preset, Solution};
use crate::query::Query;
use crate::refine::{Refiner, Smooth, polyline};
use crate::timing::{TimingOptions, Trajectory, time};
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

/// Improvements that the trace lists at most.
const LISTED: usize = 400;

/// A continuous planner: an optimizer over splines.
///
/// `Solution.cost` is the objective `f`; `Solution.trajectory` the time-optimal motion along the path under the limits of the query. `trace` has `objective`
/// with its terms, `convergence`, `population` and `encoding`: the number of control points, and `followed`, where no candidate was free and the path is
/// the exact route, smoothed where there is room.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Spline<O> {
    /// Settings: ours or those of the source.
    #[serde(default)]
    pub preset: Preset,
    /// Encoding and objective.
    #[serde(flatten)]
    pub settings: Settings,
    /// The optimizer and its parameters.
    #[serde(flatten)]
    pub optimizer: O,
}

impl<O: Optimizer> Planner for Spline<O> {
    fn plan(&self, query: &Query, ctx: &mut Context) -> Result<Solution, PlanError> {
        plan(query, &self.settings, &self.optimizer, ctx)
    }
}

/// Plans a query with an optimizer.
/// # Errors
/// [`PlanError::NoPath`], proved by an exact search if there is none, [`PlanError::Cancelled`], [`PlanError::BadParameter`].
pub(in crate::plan) fn plan(query: &Query, settings: &Settings, optimizer: &dyn Optimizer, ctx: &mut Context) -> Result<Solution, PlanError> {
    settings.check()?;
    let before = ctx.evaluations();
    // The proof that there is no path, if there is none.
    let exact = Visibility::default().plan(query, ctx)?;
    if exact.length() == 0.0 {
        return follow(query, settings, &exact, ctx);
    }
    let lines = if settings.hints || settings.points == 0 { route::lines(query, &exact, ctx) } else { Vec::new() };
    let Layout { curves, free } = route::layout(query, settings, &lines, ctx)?;
    if settings.hints && settings.points == 0 && free == Some(false) && ctx.poll().is_none() {
        return follow(query, settings, &exact, ctx);
    }
    let watch = Watch::new(&curves);
    let minimum = optimizer.minimize(&watch, ctx)?;
    let picture = watch.picture(&minimum);
    let evaluations = ctx.evaluations() - before;
    if minimum.cost.feasible()
        && let Ok(found) = found(&curves, &minimum, &picture, ctx)
    {
        return Ok(Solution { evaluations, ..found });
    }
    if settings.hints && !minimum.best.is_empty() && minimum.stop != Stop::Cancelled {
        let (stop, iterations) = (minimum.stop, minimum.iterations);
        return Ok(Solution { stop, iterations, evaluations, ..follow(query, settings, &exact, ctx)? });
    }
    Err(nothing(query, minimum.stop, evaluations))
}

/// Nothing was found, though there is a path.
pub(in crate::plan::swarm) fn nothing(query: &Query, stop: Stop, evaluations: u64) -> PlanError {
    if stop == Stop::Cancelled {
        return PlanError::Cancelled;
    }
    let spent = if stop == Stop::Budget { "the budget is spent" } else { "the method ended" };
    let advice = "give it a larger budget, points=0 or hints=true, or take an exact planner such as visibility";
    no_path(query, false, Some(format!("{spent}: none of {evaluations} candidate curves is free; {advice}")))
}

fn motion(query: &Query, path: &Path, ctx: &mut Context) -> Result<Trajectory, PlanError> {
    let options = TimingOptions { start_yaw: query.start_yaw, goal_yaw: query.goal_yaw, ..TimingOptions::default() };
    time(path, &query.limits, &options, ctx)
}

fn found(curves: &Curves, minimum: &Minimum, population: &Value, ctx: &mut Context) -> Result<Solution, PlanError> {
    let path = curves.path(&minimum.best)?;
    let trajectory = motion(curves.query(), &path, ctx)?;
    let judged = curves.judge(&minimum.best);
    let mut history: Vec<(u64, f64)> = minimum.history.iter().filter(|h| h.1.feasible()).map(|h| (h.0, h.1.value)).collect();
    history.dedup_by_key(|h| h.1);
    let convergence = thinned(&history);
    let encoding = json!({ "points": curves.points(), "followed": null, "path": points(curves, &minimum.best) });
    let objective = objective(&judged, curves.settings());
    let trace = json!({ "objective": objective, "convergence": convergence, "population": population, "encoding": encoding });
    let (stop, iterations, evaluations) = (minimum.stop, minimum.iterations, minimum.evaluations);
    let (cost, seconds) = (judged.value, ctx.seconds());
    Ok(Solution { path, cells: None, cost, trajectory: Some(trajectory), stop, iterations, evaluations, seconds, history, trace, memory: None })
}

/// At most [`LISTED`] of the pairs, the first and the last among them.
pub(in crate::plan::swarm) fn thinned(history: &[(u64, f64)]) -> Vec<(u64, f64)> {
    let step = history.len().div_ceil(LISTED - 1).max(1);
    let mut out: Vec<(u64, f64)> = history.iter().copied().step_by(step).collect();
    if let Some(last) = history.last().filter(|last| out.last() != Some(last)) {
        out.push(*last);
    }
    out
}

pub(in crate::plan::swarm) fn objective(judged: &Judged, settings: &Settings) -> Value {
    json!({
        "value": judged.value,
        "length": judged.length,
        "time": judged.time,
        "turning": judged.turning,
        "clearance": judged.clearance.is_finite().then_some(judged.clearance),
        "overspeed": judged.overspeed,
        "weights": settings.weights,
        "form": if settings.objective == Form::Literal { "literal" } else { "repaired" },
    })
}

/// The exact route as a path, smoothed where there is room.
pub(in crate::plan::swarm) fn follow(query: &Query, settings: &Settings, exact: &Solution, ctx: &mut Context) -> Result<Solution, PlanError> {
    let smooth = Smooth::default().refine(&exact.path, query, ctx).map(|r| r.path);
    let timed = smooth.and_then(|path| motion(query, &path, ctx).map(|motion| (path, motion)));
    let (path, trajectory) = match timed {
        Ok(both) => both,
        Err(PlanError::Cancelled) => return Err(PlanError::Cancelled),
        Err(_) => (exact.path.clone(), motion(query, &exact.path, ctx)?),
    };
    let judged = appraise(query, settings, &path, &trajectory);
    let followed = if path.degree() == 1 { "exact route" } else { "exact route, smoothed" };
    let encoding = json!({ "points": 0, "followed": followed });
    let trace = json!({ "objective": objective(&judged, settings), "convergence": [[0, judged.value]], "population": [], "encoding": encoding });
    Ok(Solution {
        path,
        cells: None,
        cost: judged.value,
        trajectory: Some(trajectory),
        stop: exact.stop,
        iterations: 0,
        evaluations: ctx.evaluations(),
        seconds: ctx.seconds(),
        history: vec![(0, judged.value)],
        trace,
        memory: None,
    })
}

/// What a path that is no candidate is worth: as a candidate, but with the motion that stops at its corners.
fn appraise(query: &Query, settings: &Settings, path: &Path, trajectory: &Trajectory) -> Judged {
    let count = (100.0 * trajectory.duration()).ceil().min(1e6);
    let mut turning = 0.0;
    let mut last = 0.0;
    for i in 0..=count as u64 {
        let rate = trajectory.at(trajectory.duration() * i as f64 / count.max(1.0)).turn_rate;
        turning += (rate - last).abs();
        last = rate;
    }
    let line = polyline(path, query);
    let reach = settings.scale(query).safe.max(query.radius()).max(1e-3) * 100.0;
    let clearance = line.windows(2).map(|w| query.world.segment_clearance_within(w[0], w[1], reach)).fold(f64::INFINITY, f64::min);
    let judged = Judged { length: path.length(), time: trajectory.duration(), turning, clearance, overspeed: 0.0, value: 0.0, violation: 0.0 };
    if judged.length == 0.0 { judged } else { Judged { value: settings.value(&judged, settings.scale(query)), ..judged } }
}
