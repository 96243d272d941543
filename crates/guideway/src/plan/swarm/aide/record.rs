//! The trace of a run, for reports and pictures.

use super::bound::Bound;
use super::polish::Candidate;
use super::seats::Seats;
use super::stages::{Outcome, Stage};
use crate::Point;
use crate::optimize::Objective;
use crate::plan::homotopy::Atlas;
use crate::plan::swarm::spline::{objective, points, thinned};
use crate::timing::{Region, SpeedTrace};
use serde_json::{Value, json};

/// Points of a path and regions of a stage that are listed at most.
const LISTED: (usize, usize) = (200, 20);

/// Everything that a run tells.
pub(super) fn trace(
    outcome: &Outcome,
    (best, history): (&Candidate, &[(u64, f64)]),
    (atlas, seats): (&Atlas, &Seats),
    speed: &SpeedTrace,
    bound: Option<&Bound>,
) -> Value {
    let curves = &outcome.curves;
    let path = points(curves, &best.x);
    let mut trace = json!({
        "objective": objective(&curves.judge(&best.x), curves.settings()),
        "convergence": thinned(history),
        "population": outcome.population,
        "encoding": { "points": curves.points(), "numbers": curves.bounds().len(), "followed": null, "path": path },
        "classes": classes(atlas, seats, (&curves.chain(&best.x, 2000), best.cost.value)),
        "loop": outcome.stages.iter().enumerate().map(stage).collect::<Vec<_>>(),
        "speed": speed,
    });
    if let Some(bound) = bound {
        trace["bound"] = bound.seen(best.cost.value);
    }
    trace
}

fn classes(atlas: &Atlas, seats: &Seats, (path, value): (&[Point], f64)) -> Vec<Value> {
    let chosen = atlas.signature(path);
    let own = |seat: &super::seats::Seat| atlas.signature(&seat.curves.chain(&seat.best.x, 2000));
    let known: Vec<(String, f64)> = seats.seats.iter().filter(|s| s.best.cost.feasible()).map(|s| (own(s), s.best.cost.value)).collect();
    let rows = atlas.classes.iter().map(|class| {
        let is_chosen = class.signature == chosen;
        let mine = known.iter().filter(|k| k.0 == class.signature).map(|k| k.1).chain(is_chosen.then_some(value));
        let best = mine.reduce(f64::min);
        json!({ "path": spread(&class.points), "length": class.length, "signature": class.signature, "best": best, "chosen": is_chosen })
    });
    rows.collect()
}

/// No more than so many of the points, both ends among them.
fn spread(points: &[Point]) -> Vec<Point> {
    let step = points.len().div_ceil(LISTED.0 - 1).max(1);
    let mut out: Vec<Point> = points.iter().copied().step_by(step).collect();
    if let Some(last) = points.last().filter(|last| out.last() != Some(last)) {
        out.push(*last);
    }
    out
}

fn stage((i, stage): (usize, &Stage)) -> Value {
    let some = |regions: &[Region]| json!(regions.iter().take(LISTED.1).collect::<Vec<_>>());
    json!({
        "stage": i + 1,
        "value": stage.value,
        "found": some(&stage.found),
        "corrected": stage.found.len() - stage.remaining.len().min(stage.found.len()),
        "nodes": stage.nodes,
        "passes": stage.passes,
        "remaining": some(&stage.remaining),
        "fed_back": stage.fed_back,
    })
}
