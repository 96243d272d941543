//! A goal of speed and acceleration without a position: the same questions, one order lower.
//!
//! For a fixed duration the changes of speed form an interval again; its upper end is a ramp of acceleration up, a hold at the limit
//! and a ramp down. Everything is in closed form.

use super::leg::{Leg, Shape};

/// One axis without positions.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct SpeedGoal {
    /// Change of speed.
    change: f64,
    /// Accelerations at the ends.
    ends: (f64, f64),
    /// Largest acceleration and deceleration, positive.
    limits: (f64, f64),
    jerk: f64,
    slack: f64,
}

impl SpeedGoal {
    pub(super) fn new((v0, a0): (f64, f64), (v1, a1): (f64, f64), (least, most): (f64, f64), jerk: f64) -> Self {
        let limits = (most.max(a0).max(a1), (-least).max(-a0).max(-a1));
        let slack = 1e-16 + 1e-12 * (v0.abs().max(v1.abs()) + (a0 * a0 + a1 * a1) / jerk);
        Self { change: v1 - v0, ends: (a0, a1), limits, jerk, slack }
    }

    fn flipped(&self) -> Self {
        Self { change: -self.change, ends: (-self.ends.0, -self.ends.1), limits: (self.limits.1, self.limits.0), ..*self }
    }

    /// Change of speed by the straight ramp of acceleration.
    fn direct(&self) -> f64 {
        let (a0, a1) = self.ends;
        0.5 * (a1 + a0) * (a1 - a0).abs() / self.jerk
    }

    /// Square of the peak of a ramp up and down.
    fn square(&self) -> f64 {
        self.jerk * self.change + 0.5 * (self.ends.0 * self.ends.0 + self.ends.1 * self.ends.1)
    }

    fn bump(&self) -> Leg {
        Leg::new(self.square(), self.ends, self.limits.0, (self.jerk, 1.0 / self.jerk))
    }

    /// The shortest duration, s.
    pub(super) fn shortest(&self) -> f64 {
        let more = self.change - self.direct();
        if more.abs() <= self.slack {
            (self.ends.1 - self.ends.0).abs() / self.jerk
        } else if more > 0.0 {
            self.bump().time()
        } else {
            self.flipped().bump().time()
        }
    }

    /// Durations between which the change cannot be made although it can before and after.
    pub(super) fn blocked(&self) -> [Option<(f64, f64)>; 2] {
        [self.blocked_above(), self.flipped().blocked_above()]
    }

    fn blocked_above(&self) -> Option<(f64, f64)> {
        let square = self.square();
        let (a0, a1) = self.ends;
        if a0.max(a1) >= 0.0 || square <= self.jerk * self.slack || self.change > self.direct() + self.slack {
            return None;
        }
        let peak = square.sqrt().min(-a0.max(a1));
        Some(((-2.0 * peak - a0 - a1) / self.jerk, self.bump().time()))
    }

    /// The motion of a duration: to an acceleration, kept, and on.
    pub(super) fn lasting(&self, time: f64) -> Shape {
        let ((a0, a1), jerk) = (self.ends, self.jerk);
        let (low, high) = (a0.min(a1), a0.max(a1));
        let gap = high - low;
        let ramp = 0.5 * gap * gap / jerk;
        let spare = (time - gap / jerk).max(0.0);
        let (at_low, at_high) = (low * time + ramp, high * time - ramp);
        let beyond = |more: f64| {
            let root = spare + (spare * spare - 4.0 * more / jerk).max(0.0).sqrt();
            // At most where nothing is kept: beyond that the ramps would not fit.
            if root > 0.0 { (2.0 * more / root).min(0.5 * spare * jerk) } else { 0.0 }
        };
        let kept = if self.change >= at_high {
            high + beyond(self.change - at_high)
        } else if self.change <= at_low {
            low - beyond(at_low - self.change)
        } else {
            (low + (self.change - at_low) / spare).clamp(low, high)
        };
        let (to, from) = ((kept - a0) / jerk, (a1 - kept) / jerk);
        let mut shape = Shape::new();
        shape.push(to.abs(), jerk.copysign(to));
        shape.push(time - to.abs() - from.abs(), 0.0);
        shape.push(from.abs(), jerk.copysign(from));
        shape
    }
}
