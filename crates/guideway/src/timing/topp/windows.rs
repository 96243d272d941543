//! Windows of time: places that the motion may not reach before a time, or must have reached by one.
//!
//! A motion that would be early is slowed down before the place by lowering its squared speed there by one factor, under all limits as before; the factor is
//! found by bisection. At the end of a motion from rest to rest without other demands the whole motion is slowed down, which is exact.

use super::motion::legs;
use super::problem::Problem;
use crate::error::PlanError;
use serde::{Deserialize, Serialize};

/// Bisections of the factor, and the smallest one.
const HALVINGS: usize = 50;
const LEAST: f64 = 1e-10;

/// When a place may be passed.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Window {
    /// Arc length, rad; [`Window::END`]: the end of the path, however long it is.
    pub s: f64,
    /// Not before, s.
    pub earliest: f64,
    /// Not after, s.
    pub latest: f64,
}

/// By how much a place may be beyond the end of a path, as a share of it.
const BEYOND: f64 = 1e-9;

impl Window {
    /// The place of a window at the end of any path, rad.
    pub const END: f64 = f64::MAX;

    pub(super) fn validate(&self, length: f64) -> Result<(), PlanError> {
        let ordered = self.earliest >= 0.0 && self.earliest.is_finite() && self.latest >= self.earliest;
        if !(self.s > 0.0 && ordered) {
            let shown = format!("{} rad, {} to {} s", self.s, self.earliest, self.latest);
            return Err(PlanError::bad("windows", shown, "a place above 0 rad, 0 <= earliest <= latest"));
        }
        if self.s > length * (1.0 + BEYOND) && self.s < Self::END {
            return Err(PlanError::bad("windows", format!("a place at {} rad", self.s), format!("a place on the path, up to {length} rad")));
        }
        Ok(())
    }

    /// That the motion is not late at its place, but for `late` as a share.
    pub(super) fn met(&self, arrival: f64) -> Result<(), PlanError> {
        if arrival <= self.latest * (1.0 + 1e-9) {
            return Ok(());
        }
        let reason = format!("s = {:.6} rad cannot be reached before {arrival:.6} s; the window ends at {:.6} s", self.s, self.latest);
        Err(PlanError::Infeasible { reason, best_end_speed: None })
    }
}

/// When a profile reaches an arc length, s.
pub(super) fn arrival(problem: &Problem, x: &[f64], s: f64) -> f64 {
    let (mut t, nodes) = (0.0, &problem.s);
    for (k, leg) in legs(nodes, x, &problem.bend).iter().enumerate() {
        if s < nodes[k + 1] {
            let way = (s - nodes[k]).max(0.0);
            let v = leg.at(way)[0].sqrt();
            return t + if way > 0.0 { 2.0 * way / (leg.speed + v) } else { 0.0 };
        }
        t += leg.duration;
    }
    t
}

/// Slows `x` down between two arc lengths, by `solve` under lowered ceilings, so that the window is not reached early.
pub(super) fn delay(
    problem: &mut Problem,
    x: &mut Vec<f64>,
    from: f64,
    window: &Window,
    mut solve: impl FnMut(&Problem) -> Result<Vec<f64>, PlanError>,
) -> Result<(), PlanError> {
    if arrival(problem, x, window.s) >= window.earliest {
        return Ok(());
    }
    let (before, bend, free) = (problem.ceiling.clone(), problem.bend.clone(), x.clone());
    let inside = |s: f64| s > from && s <= window.s;
    let mut attempt = |problem: &mut Problem, factor: f64| {
        for k in 0..free.len() {
            problem.ceiling[k] = if inside(problem.s[k]) { before[k].min(factor * free[k]) } else { before[k] };
        }
        let middles = problem.s.windows(2).map(|w| 0.5 * (w[0] + w[1]));
        problem.bend = middles.zip(&bend).map(|(s, bend)| if inside(s) { factor * bend } else { *bend }).collect();
        solve(problem)
    };
    let (mut slow, mut fast) = (LEAST, 1.0f64);
    *x = attempt(problem, slow)?;
    for _ in 0..HALVINGS {
        let middle = (slow * fast).sqrt();
        let next = attempt(problem, middle)?;
        if arrival(problem, &next, window.s) >= window.earliest {
            (slow, *x) = (middle, next);
        } else {
            fast = middle;
        }
        if fast - slow <= 1e-12 * fast {
            break;
        }
    }
    *x = attempt(problem, slow)?;
    Ok(())
}
