//! One axis, freed of positions: speeds and accelerations at the ends, and limits.

use super::AxisLimits;

/// From speed and acceleration `start` to `end` under limits that both keep.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Line {
    pub(super) start: (f64, f64),
    pub(super) end: (f64, f64),
    /// Lowest and highest speed.
    pub(super) speed: (f64, f64),
    /// Largest acceleration.
    pub(super) up: f64,
    /// Largest deceleration, positive.
    pub(super) down: f64,
    pub(super) jerk: f64,
    /// One over the jerk.
    pub(super) inverse: f64,
}

impl Line {
    /// Limits that the ends overstep by rounding alone are widened to them.
    pub(super) fn new(start: (f64, f64), end: (f64, f64), limits: &AxisLimits) -> Self {
        let jerk = limits.jerk;
        let rests = [settled(start, jerk), settled((end.0, -end.1), jerk)];
        let (low, high) = (rests[0].min(rests[1]).min(start.0).min(end.0), rests[0].max(rests[1]).max(start.0).max(end.0));
        Self {
            start,
            end,
            speed: (limits.velocity.0.min(low), limits.velocity.1.max(high)),
            up: limits.acceleration.1.max(start.1).max(end.1),
            down: (-limits.acceleration.0).max(-start.1).max(-end.1),
            jerk,
            inverse: 1.0 / jerk,
        }
    }

    /// Speed at which the acceleration is zero if it falls (or has risen) straight at the jerk limit, at the start and at the end.
    #[inline]
    pub(super) fn rests(&self) -> [f64; 2] {
        [settled(self.start, self.jerk), settled((self.end.0, -self.end.1), self.jerk)]
    }

    /// The second of [`Line::rests`] minus the first, without the rounding of either.
    #[inline]
    pub(super) fn gap(&self) -> f64 {
        let ((v0, a0), (v1, a1)) = (self.start, self.end);
        (v1 - v0) - (a0 * a0.abs() + a1 * a1.abs()) * (0.5 * self.inverse)
    }

    /// The mirror image.
    #[inline]
    pub(super) fn flipped(&self) -> Self {
        Self {
            start: (-self.start.0, -self.start.1),
            end: (-self.end.0, -self.end.1),
            speed: (-self.speed.1, -self.speed.0),
            up: self.down,
            down: self.up,
            ..*self
        }
    }

    /// Seen in reversed time, positions turned: the speeds stay, accelerations change their sign.
    #[inline]
    pub(super) fn reversed(&self) -> Self {
        Self { start: (self.end.0, -self.end.1), end: (self.start.0, -self.start.1), up: self.down, down: self.up, ..*self }
    }
}

/// Speed at which the acceleration is zero if it goes there straight at the jerk limit.
#[inline]
pub(super) fn settled((v, a): (f64, f64), jerk: f64) -> f64 {
    v + a * a.abs() / (2.0 * jerk)
}
