//! The baseline without a jerk limit: full acceleration, full deceleration, or the ceiling.
//!
//! Source: bang-bang control of the squared speed, exact here because the ceiling is constant in each cell.

use super::ceiling::Ceiling;
use super::method::Step;
use super::scurve::Bounds;
use crate::error::PlanError;

/// The fastest motion under the ceiling and the acceleration limits alone, from `ends.0` to `ends.1` (m/s).
/// # Errors
/// [`PlanError::Infeasible`] if the end speeds do not fit the ceiling or the length.
pub(super) fn trapezoid(ceiling: &Ceiling, bounds: &Bounds, ends: (f64, f64)) -> Result<Vec<Step>, PlanError> {
    let (cells, h, n) = (ceiling.cells(), ceiling.step(), ceiling.cells().len());
    let (up, down) = (2.0 * bounds.acceleration * h, 2.0 * bounds.deceleration * h);
    let limit = |k: usize| cells[k.saturating_sub(1)].min(cells[k.min(n - 1)]).min(bounds.speed);
    // Squared speeds at the boundaries of cells.
    let mut square: Vec<f64> = (0..=n).map(|k| limit(k).powi(2)).collect();
    (square[0], square[n]) = (square[0].min(ends.0 * ends.0), square[n].min(ends.1 * ends.1));
    for k in 1..=n {
        square[k] = square[k].min(square[k - 1] + up);
    }
    for k in (0..n).rev() {
        square[k] = square[k].min(square[k + 1] + down);
    }
    let kept = |square: f64, v: f64| square >= v * v * (1.0 - 1e-12);
    if !kept(square[0], ends.0) || !kept(square[n], ends.1) {
        let reason = format!("start speed {} m/s or end speed {} m/s cannot be kept under the speed ceiling of the path", ends.0, ends.1);
        return Err(PlanError::Infeasible { reason, best_end_speed: None });
    }
    let mut out: Vec<Step> = Vec::new();
    for k in 0..n {
        cell((h * k as f64, h), [square[k], square[k + 1]], cells[k].min(bounds.speed), bounds, &mut out);
    }
    Ok(out)
}

/// One cell from `s` over `h` (m) between two squared speeds under the ceiling `c` (m/s): up, along, down.
fn cell((s, h): (f64, f64), [from, to]: [f64; 2], c: f64, bounds: &Bounds, out: &mut Vec<Step>) {
    let (a, b) = (bounds.acceleration, bounds.deceleration);
    let free = (2.0 * a * b * h + b * from + a * to) / (a + b);
    let top = free.min(c * c).max(from).max(to);
    let (v0, v1, v) = (from.sqrt(), to.sqrt(), top.sqrt());
    let (rise, fall) = ((top - from) / (2.0 * a), (top - to) / (2.0 * b));
    let flat = (h - rise - fall).max(0.0);
    let parts = [(s, v0, a, (v - v0) / a), (s + rise, v, 0.0, if v > 0.0 { flat / v } else { 0.0 }), (s + rise + flat, v, -b, (v - v1) / b)];
    for (s, speed, acceleration, duration) in parts {
        // Shorter ones are rounding.
        if duration * v.max(1e-9) <= 1e-13 * h {
            continue;
        }
        match out.last_mut() {
            Some(last) if last.acceleration == acceleration => last.duration += duration,
            _ => out.push(Step { s, speed, acceleration, jerk: 0.0, duration }),
        }
    }
}
