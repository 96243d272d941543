//! From one speed and acceleration to another in minimum time (velocity transition).

use super::{Bounds, MAX_PHASES, Phase, Profile};

/// Speed (m/s) and acceleration (m/s2).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct State1 {
    /// m/s.
    pub v: f64,
    /// m/s2.
    pub a: f64,
}

impl From<(f64, f64)> for State1 {
    fn from((v, a): (f64, f64)) -> Self {
        Self { v, a }
    }
}

/// Phases under construction.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Builder {
    phases: [Phase; MAX_PHASES],
    count: usize,
}

impl Builder {
    /// Adds a phase; an empty one is dropped, one with the jerk of its predecessor prolongs that.
    pub(super) fn push(&mut self, duration: f64, jerk: f64) {
        if duration <= 0.0 {
            return;
        }
        if self.count > 0 && self.phases[self.count - 1].jerk == jerk {
            self.phases[self.count - 1].duration += duration;
        } else if self.count < MAX_PHASES {
            self.phases[self.count] = Phase { duration, jerk };
            self.count += 1;
        }
    }

    /// A ramp of acceleration at the jerk limits, in two parts where it crosses zero.
    pub(super) fn ramp(&mut self, from: f64, to: f64, bounds: &Bounds) {
        let j = &bounds.jerk;
        if to > from {
            self.push((to.min(0.0) - from.min(0.0)) / j.unbrake, j.unbrake);
            self.push((to.max(0.0) - from.max(0.0)) / j.build, j.build);
        } else {
            self.push((from.max(0.0) - to.max(0.0)) / j.release, -j.release);
            self.push((from.min(0.0) - to.min(0.0)) / j.brake, -j.brake);
        }
    }

    /// Adds the phases of another motion that follows.
    pub(super) fn extend(&mut self, next: &Profile) {
        for phase in next.phases() {
            self.push(phase.duration, phase.jerk);
        }
    }

    pub(super) fn finish(&self, start: State1) -> Profile {
        Profile::new((start.v, start.a), &self.phases[..self.count])
    }
}

/// Change of speed while the acceleration ramps between two values at the jerk limits, m/s.
pub(super) fn ramp_gain(from: f64, to: f64, bounds: &Bounds) -> f64 {
    let j = &bounds.jerk;
    let half = |x: f64, y: f64| 0.5 * (x * x - y * y);
    if to > from {
        half(to.min(0.0), from.min(0.0)) / j.unbrake + half(to.max(0.0), from.max(0.0)) / j.build
    } else {
        half(from.max(0.0), to.max(0.0)) / j.release + half(from.min(0.0), to.min(0.0)) / j.brake
    }
}

/// The fastest change from one speed and acceleration to another; `None` if the accelerations are outside the limits. Speeds in
/// between are not bounded.
///
/// Source: velocity transition of \[zhang2025\], with a jerk limit per phase: `p^2 (1/J1 + 1/J2) / 2 = sigma dv + a0^2/(2 J) + a1^2/(2 J)`,
/// where the last two jerks are those of the phases in which the boundary accelerations vanish or are reached.
pub fn transition(from: State1, to: State1, bounds: &Bounds) -> Option<Profile> {
    let mut builder = Builder::default();
    let delta = to.v - from.v;
    let direct = ramp_gain(from.a, to.a, bounds);
    let sign = if delta >= direct { 1.0 } else { -1.0 };
    let j = &bounds.jerk;
    // (limit, build-up, release, jerks of an acceleration of the other sign: released at the start, built up at the end)
    let (limit, rise, fall, before, after) = if sign > 0.0 {
        (bounds.acceleration, j.build, j.release, j.unbrake, j.brake)
    } else {
        (bounds.deceleration, j.brake, j.unbrake, j.release, j.build)
    };
    let (a0, a1) = (sign * from.a, sign * to.a);
    if a0 > limit * (1.0 + 1e-9) || a1 > limit * (1.0 + 1e-9) {
        return None;
    }
    let share = |a: f64, own: f64, foreign: f64| 0.5 * a * a / if a > 0.0 { own } else { foreign };
    let energy = (sign * delta + share(a0, rise, before) + share(a1, fall, after)).max(0.0);
    let half = 0.5 / rise + 0.5 / fall;
    // A change beyond the straight ramp always passes through zero acceleration, so the energy is not negative but for rounding.
    let peak = (energy / half).sqrt();
    let top = peak.max(a0.max(a1)).min(limit);
    builder.ramp(from.a, sign * top, bounds);
    if peak > limit {
        builder.push((energy - half * limit * limit) / limit, 0.0);
    }
    builder.ramp(sign * top, to.a, bounds);
    Some(builder.finish(from))
}
