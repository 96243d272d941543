//! What may be asked.

use super::solo::{Refusal, inside};
use super::{Axis, AxisLimits, Input};
use crate::error::PlanError;

/// # Errors
/// [`PlanError::BadParameter`] with the axis and what is wrong.
pub(super) fn check(input: &Input) -> Result<(), PlanError> {
    if !(input.minimum_duration >= 0.0 && input.minimum_duration.is_finite()) {
        return Err(PlanError::bad("minimum_duration", input.minimum_duration, "finite and not negative, s"));
    }
    if let Some(cycle) = input.cycle.filter(|c| !(*c > 0.0 && c.is_finite())) {
        return Err(PlanError::bad("cycle", cycle, "finite and positive, s"));
    }
    for (i, axis) in input.axes.iter().enumerate() {
        let states = [
            ("start position", axis.start.position),
            ("start velocity", axis.start.velocity),
            ("start acceleration", axis.start.acceleration),
            ("goal position", axis.goal.position.unwrap_or(0.0)),
            ("goal velocity", axis.goal.velocity),
            ("goal acceleration", axis.goal.acceleration),
        ];
        if let Some((name, value)) = states.into_iter().find(|(_, x)| !x.is_finite()) {
            return Err(PlanError::bad(format!("{name} of axis {i}"), value, "a finite number"));
        }
        if axis.enabled {
            limits(i, &axis.limits)?;
            goal(i, axis)?;
        }
    }
    Ok(())
}

fn limits(i: usize, limits: &AxisLimits) -> Result<(), PlanError> {
    let AxisLimits { velocity, acceleration, jerk } = *limits;
    if !(velocity.0 <= 0.0 && velocity.1 >= 0.0 && velocity.0 < velocity.1) {
        return Err(PlanError::bad(format!("velocity limits of axis {i}"), format!("{} to {}", velocity.0, velocity.1), "a range that holds zero"));
    }
    if !(acceleration.0 < 0.0 && acceleration.1 > 0.0) {
        return Err(PlanError::bad(
            format!("acceleration limits of axis {i}"),
            format!("{} to {}", acceleration.0, acceleration.1),
            "below zero to above zero",
        ));
    }
    if !(jerk > 0.0 && jerk.is_finite()) {
        return Err(PlanError::bad(format!("jerk limit of axis {i}"), jerk, "finite and positive"));
    }
    Ok(())
}

fn goal(i: usize, axis: &Axis) -> Result<(), PlanError> {
    let (goal, limits) = (&axis.goal, &axis.limits);
    let outside = |name: &str, x: f64, (low, high): (f64, f64)| {
        Err(PlanError::bad(format!("goal {name} of axis {i}"), x, format!("within its limits, {low} to {high}")))
    };
    if !inside(goal.acceleration, limits.acceleration) {
        return outside("acceleration", goal.acceleration, limits.acceleration);
    }
    if !inside(goal.velocity, limits.velocity) {
        return outside("velocity", goal.velocity, limits.velocity);
    }
    Ok(())
}

/// The error for an axis that has no motion.
pub(super) fn refused(i: usize, axis: &Axis, why: Refusal) -> PlanError {
    match why {
        Refusal::Unreachable(before) => {
            let (low, high) = axis.limits.velocity;
            let allowed = format!("one that leaves the velocity between {low} and {high} before the goal; it would have come from {before}");
            PlanError::bad(format!("goal acceleration of axis {i}"), axis.goal.acceleration, allowed)
        }
        Refusal::Forbidden => {
            let reason = format!("axis {i} cannot reach its goal: its velocity limit of zero forbids the direction in which it would have to go");
            PlanError::Infeasible { reason, best_end_speed: None }
        }
    }
}
