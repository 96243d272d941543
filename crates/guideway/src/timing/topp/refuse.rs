//! Why there is no motion: which limit, where.

use super::limits::Bounds;
use super::problem::{Problem, Raw, scale};
use super::strips::{Strips, Stuck};
use crate::error::PlanError;

/// What stands against a motion.
pub(super) fn explain(problem: &Problem, strips: &Strips, stuck: Stuck, (bounds, names): (&Bounds, &[String])) -> PlanError {
    let s = problem.s[stuck.node];
    if let Some([low, high]) = stuck.boundary {
        let place = if stuck.node == 0 { "start" } else { "end" };
        let range =
            if low > 0.0 { format!("{:.6} to {:.6}", low.sqrt(), high.max(0.0).sqrt()) } else { format!("at most {:.6}", high.max(0.0).sqrt()) };
        let best_end_speed = (stuck.node > 0).then(|| high.max(0.0).sqrt());
        return PlanError::Infeasible { reason: format!("the path speed at the {place} can be {range} rad/s"), best_end_speed };
    }
    let interval = stuck.node.min(problem.s.len() - 2);
    let mut limits = Vec::new();
    problem.limits(interval, bounds, &mut limits);
    let name = |owner: Result<usize, usize>| match owner {
        Ok(joint) => format!("acceleration of joint {}", joint + 1),
        Err(row) => names.get(row).cloned().unwrap_or_else(|| format!("row {}", row + 1)),
    };
    let reason = if let Some((line, share)) = overload(&limits) {
        let name = name(problem.limit(line / 3));
        format!("{name} exceeds its limit by {:.1} % at s = {s:.6} rad even at rest (static load)", 100.0 * share)
    } else {
        let ceiling = strips.ceiling[interval].clamp(0.0, f64::MAX);
        let [low, high] = strips.active(interval, ceiling.min(strips.floor[interval].max(0.0))).map(|line| name(problem.owner(line)));
        format!("{low} and {high} leave no path acceleration at s = {s:.6} rad")
    };
    PlanError::Infeasible { reason, best_end_speed: None }
}

/// The row that is exceeded most without any motion, and by what share of its range.
fn overload(limits: &[Raw]) -> Option<(usize, f64)> {
    let excess = |raw: &Raw| (raw.c - raw.high).max(raw.low - raw.c) / scale([raw.low, raw.high]);
    let worst = limits.iter().enumerate().map(|(i, raw)| (i, excess(raw))).max_by(|a, b| a.1.total_cmp(&b.1));
    worst.filter(|(_, share)| *share > 0.0)
}
