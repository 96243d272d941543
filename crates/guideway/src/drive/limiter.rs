//! Commanded speeds within the limits of acceleration, deceleration and jerk while the speed is overridden.

use super::ramp::Ramp;
use super::{Command, Pacing, Robot};

/// Commands are limited until they have kept the limits by themselves for so long after an override, s.
const CALM: f64 = 1.0;
/// Longest step that is followed, s; after a longer gap commands begin anew.
const LONGEST: f64 = 0.5;

/// What was commanded last, and how fast that changes.
#[derive(Debug, Clone)]
pub(super) struct Limiter {
    ramp: Ramp,
    turn_rate: f64,
    time: f64,
    /// When commands were last changed here, s.
    changed: f64,
}

impl Limiter {
    pub fn new(robot: &Robot, jerk: f64) -> Self {
        let ramp = Ramp::at(0.0, [robot.acceleration, robot.deceleration], jerk);
        Self { ramp, turn_rate: robot.turn_rate, time: f64::NAN, changed: f64::NEG_INFINITY }
    }

    /// The base was told to brake with all it has, and rolls at `v` (m/s).
    pub fn braked(&mut self, v: f64, t: f64) {
        (self.ramp.v, self.ramp.a, self.time) = (if self.ramp.v == 0.0 { 0.0 } else { v.max(0.0) }, 0.0, t);
    }

    /// The command for time `t` (s): what was `asked`, already `cut` at the speed `most` (m/s). It is left as it is where no override is in force and none was lately.
    pub fn step(&mut self, (asked, cut): (Command, Command), most: f64, (t, overridden): (f64, bool), pacing: Pacing) -> Command {
        let dt = t - self.time;
        self.time = t;
        if overridden {
            self.changed = t;
        }
        let limited = matches!(pacing, Pacing::Slower | Pacing::Limited) && t - self.changed <= CALM && dt > 0.0 && dt <= LONGEST && cut.v >= 0.0;
        let v = if limited { self.next(cut.v, most, dt) } else { cut.v };
        let v = if pacing == Pacing::Slower { v.min(asked.v.max(cut.v)) } else { v };
        self.ramp.a = if dt > 0.0 && dt <= LONGEST { ((v - self.ramp.v) / dt).clamp(-self.ramp.limits[1], self.ramp.limits[0]) } else { 0.0 };
        self.ramp.v = v;
        if v == cut.v {
            return cut;
        }
        self.changed = t;
        // Slower on the same arc; faster than asked only as long as the brake takes.
        let share = if asked.v > v { v / asked.v } else { 1.0 };
        Command { v, w: (share * asked.w).clamp(-self.turn_rate, self.turn_rate) }
    }

    /// The speed nearest to what is asked, or on the way to it, from which neither rest nor `most` is overrun.
    fn next(&self, v: f64, most: f64, dt: f64) -> f64 {
        let towards = |target: f64| {
            let mut ramp = self.ramp;
            ramp.step(target, dt)
        };
        if (towards(0.0)..=towards(most)).contains(&v) { v } else { towards(v) }
    }
}
