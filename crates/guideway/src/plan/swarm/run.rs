//! One leg after the other: what a swarm found, reported as a solution.

use super::decoding::{Decoding, Judge};
use crate::context::{Context, Stop};
use crate::error::PlanError;
use crate::optimize::{Minimum, Optimizer};
use crate::path::Path;
use crate::plan::Solution;
use crate::plan::legs::{self, Leg};
use crate::plan::score::{Aim, Score};
use crate::plan::search::{self as exact, Engine, no_path, turns};
use crate::query::Query;
use crate::world::Cell;
use serde_json::{Value, json};

/// What a swarm found on a leg.
pub(in crate::plan) struct Found {
    /// The best path, cell by cell.
    pub cells: Vec<Cell>,
    /// Its way points, if it is an any-angle path along those cells.
    pub points: Option<Vec<Cell>>,
    /// Its worth.
    pub score: Score,
    /// (iteration, best cost in cells) at each improvement.
    pub history: Vec<(u64, f64)>,
    /// Iterations.
    pub iterations: u64,
    /// Candidates costed, the straight walk that goes ahead among them.
    pub evaluations: u64,
    /// Why it stopped.
    pub stop: Stop,
    /// For pictures.
    pub trace: Value,
}

/// Paths of the last population that the trace keeps at most, and their turning points.
const SHOWN: [usize; 2] = [8, 2000];

/// Runs an optimizer on a leg.
/// # Errors
/// [`PlanError::NoPath`], proved by an exact search if there is none, [`PlanError::Cancelled`], [`PlanError::BadParameter`].
pub(in crate::plan) fn search(leg: &Leg, optimizer: &dyn Optimizer, decoding: &Decoding, aim: Aim, ctx: &mut Context) -> Result<Found, PlanError> {
    let (mut judge, before) = (Judge::new(leg, decoding, aim)?, ctx.evaluations());
    if leg.start == leg.goal {
        let points = decoding.prune.then(|| vec![leg.start]);
        return Ok(Found { points, ..standing(leg.start, aim) });
    }
    let probe = judge.probe(ctx);
    if probe.is_none() {
        // The fastest proof that there is no path, if there is none.
        exact::search(Engine::JumpPoint, leg, ctx)?;
    }
    let minimum = optimizer.minimize(&judge, ctx)?;
    let cells = if minimum.best.is_empty() { probe } else { judge.decode(&minimum.best) };
    let Some(cells) = cells else {
        return Err(nothing(leg.query, minimum.stop, minimum.evaluations));
    };
    let evaluations = ctx.evaluations() - before;
    Ok(Found { evaluations, ..found(&judge, cells, &minimum, decoding.prune) })
}

/// The path of a leg from a cell to itself.
pub(super) fn standing(cell: Cell, aim: Aim) -> Found {
    let history = vec![(0, 0.0)];
    let (cells, score, trace) = (vec![cell], aim.score(0.0, 0), json!({ "convergence": history, "paths": [] }));
    Found { cells, points: None, score, history, iterations: 0, evaluations: 0, stop: Stop::Converged, trace }
}

/// Nothing was found, though there is a path.
pub(super) fn nothing(query: &Query, stop: Stop, evaluations: u64) -> PlanError {
    if stop == Stop::Cancelled {
        return PlanError::Cancelled;
    }
    let spent = if stop == Stop::Budget { "the budget is spent" } else { "the method ended" };
    let advice = "give it more iterations or keys, no walk_limit, or take an exact planner such as jump-point";
    no_path(query, false, Some(format!("{spent}: none of {evaluations} candidates reached the goal; {advice}")))
}

fn found(judge: &Judge, cells: Vec<Cell>, minimum: &Minimum, prune: bool) -> Found {
    let (points, score) = if prune {
        let (points, score) = judge.pruned(&cells);
        (Some(points), score)
    } else {
        (None, judge.aim.of_cells(&cells))
    };
    let mut history: Vec<(u64, f64)> = minimum.history.iter().filter(|h| h.1.feasible()).map(|h| (h.0, h.1.value)).collect();
    if history.is_empty() {
        history.push((0, score.cost));
    }
    // Improvements of turns alone leave the cost as it was.
    history.dedup_by_key(|h| h.1);
    let mut order: Vec<usize> = (0..minimum.costs.len()).filter(|&i| minimum.costs[i].feasible()).collect();
    order.sort_by(|&a, &b| minimum.costs[a].order(minimum.costs[b]));
    order.dedup_by(|a, b| minimum.costs[*a] == minimum.costs[*b]);
    let paths = order.iter().take(SHOWN[0]).filter_map(|&i| judge.decode(&minimum.population[i]));
    let trace = trace(judge.leg, &history, paths);
    let (iterations, evaluations, stop) = (minimum.iterations, minimum.evaluations, minimum.stop);
    Found { cells, points, score, history, iterations, evaluations, stop, trace }
}

/// What pictures show of a leg.
pub(super) fn trace(leg: &Leg, history: &[(u64, f64)], paths: impl Iterator<Item = Vec<Cell>>) -> Value {
    let corners = paths.map(|p| turns(&p)).filter(|p| p.len() <= SHOWN[1]);
    let paths: Vec<Vec<[f64; 2]>> = corners.map(|p| p.into_iter().map(|c| leg.lattice.center(c)).collect()).collect();
    json!({ "convergence": history, "paths": paths })
}

/// Plans a query leg by leg.
pub(super) fn plan(
    query: &Query,
    ctx: &mut Context,
    mut solve: impl FnMut(&Leg, &mut Context) -> Result<Found, PlanError>,
) -> Result<Solution, PlanError> {
    let mut legs: Vec<Found> = Vec::new();
    let mut points = vec![query.start];
    let route = legs::plan(query, ctx, |leg, ctx| {
        let mut found = solve(leg, ctx)?;
        if let Some(way) = &found.points {
            points.extend(way.iter().map(|&c| leg.lattice.center(c)));
            points.push(leg.ends[1]);
        }
        let cells = std::mem::take(&mut found.cells);
        legs.push(found);
        Ok(cells)
    })?;
    let pruned = points.len() > 1;
    let path = if pruned { Path::polyline(&points) } else { route.path() };
    let cost = if pruned { path.length() } else { route.length };
    let stop = legs.iter().map(|l| l.stop).find(|s| *s != Stop::Converged).unwrap_or(Stop::Converged);
    let iterations = legs.iter().map(|l| l.iterations).sum();
    let parts: Vec<_> = legs.iter().map(|l| (l.history.clone(), l.score.cost)).collect();
    let history = legs::joined(&parts, cost, query.world.resolution());
    let evaluations = legs.iter().map(|l| l.evaluations).sum();
    let trace = json!({ "legs": legs.into_iter().map(|l| l.trace).collect::<Vec<_>>() });
    let cells = (!pruned).then_some(route.cells);
    Ok(Solution { path, cells, cost, trajectory: None, stop, iterations, evaluations, seconds: ctx.seconds(), history, trace, memory: None })
}
