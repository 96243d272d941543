//! A value that follows a target with bounded rate and bounded change of its rate, exactly in steps.
//!
//! Source: own. With steps of `dt`, rates `a` that change by at most `c = jerk dt` a step and a distance of `d dt` to the target, a rate `a = n c + r`
//! (`0 <= r < c`) can still fall to zero in time if `a + (a - c) + ... + r = (n + 1) a - c n (n + 1) / 2 <= d`. The left side is continuous and increasing,
//! so the largest such rate has a closed form; and where `a` was allowed in one step, `a - c` is in the next, so a target that stays is met and not overrun.

/// Most steps of a stop that are followed one by one.
const LONGEST: u32 = 2000;

/// A speed (m/s) or a share, on its way.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Ramp {
    /// The value now.
    pub v: f64,
    /// Its rate over the last step, 1/s.
    pub a: f64,
    /// Largest rate of growing and of falling size, 1/s.
    pub limits: [f64; 2],
    /// Largest change of the rate, 1/s2.
    pub jerk: f64,
}

impl Ramp {
    /// At rest at `v`.
    pub fn at(v: f64, limits: [f64; 2], jerk: f64) -> Self {
        Self { v, a: 0.0, limits, jerk }
    }

    /// Moves on by `dt` s (nothing happens unless it is positive) towards `target`; the new value.
    pub fn step(&mut self, target: f64, dt: f64) -> f64 {
        let left = target - self.v;
        if !(dt > 0.0 && left.is_finite()) || (left == 0.0 && self.a == 0.0) {
            return self.v;
        }
        let change = self.jerk * dt;
        let most = self.limits[usize::from(self.v * left < 0.0)];
        let wanted = fastest(left.abs() / dt, change).min(most).copysign(left);
        self.a = wanted.clamp(self.a - change, self.a + change);
        self.v += self.a * dt;
        if (self.v - target).abs() < 1e-9 * (1.0 + target.abs()) && self.a.abs() <= change * (1.0 + 1e-9) {
            self.v = target;
        }
        self.v
    }

    /// Way of a speed until it rests at zero, with steps of `dt` s (at least a millisecond), m.
    pub fn stop(mut self, dt: f64) -> f64 {
        let (dt, mut way) = (dt.max(1e-3), 0.0);
        for _ in 0..LONGEST {
            if self.rests() {
                return way;
            }
            way += self.step(0.0, dt) * dt;
        }
        way + 0.5 * self.v * self.v / self.limits[1]
    }

    /// Has it come to rest at zero?
    pub fn rests(self) -> bool {
        self.v == 0.0
    }
}

/// The largest rate that can fall by `c` in each further step and not lead beyond `d` (both in rates).
fn fastest(d: f64, c: f64) -> f64 {
    let n = (0.5 * ((1.0 + 8.0 * d / c).sqrt() - 1.0)).floor();
    (d + 0.5 * c * n * (n + 1.0)) / (n + 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn targets_are_met_within_the_limits_and_not_overrun(
            targets in prop::collection::vec(-2.0..2.0_f64, 1..5), up in 0.2..3.0_f64, down in 0.2..3.0_f64, jerk in 0.5..30.0_f64, dt in 0.005..0.06_f64,
        ) {
            let mut ramp = Ramp::at(0.0, [up, down], jerk);
            for target in targets {
                let mut near = f64::INFINITY;
                for _ in 0..(30.0 / dt) as u32 {
                    let before = ramp;
                    ramp.step(target, dt);
                    prop_assert!((ramp.a - before.a).abs() <= jerk * dt * (1.0 + 1e-6), "{before:?} {ramp:?}");
                    prop_assert!((ramp.v - before.v - ramp.a * dt).abs() < 1e-8);
                    prop_assert!(ramp.a.abs() <= up.max(down) + 1e-9);
                    // Once on its way to a target that stays it does not turn round.
                    let left = (target - ramp.v).abs();
                    if (target - before.v) * before.a > 0.0 && fastest((target - before.v).abs() / dt, jerk * dt) >= before.a.abs() {
                        prop_assert!((target - ramp.v) * (target - before.v) >= -1e-12, "{before:?} {ramp:?} {target}");
                    }
                    near = left;
                }
                prop_assert!(near == 0.0, "{ramp:?} {target}");
            }
        }
    }

    #[test]
    fn a_stop_takes_as_long_as_a_jerk_limited_one() {
        // From 1 m/s at 1 m/s2 and 5 m/s3: v / a + a / j = 1.2 s.
        let (mut ramp, mut steps) = (Ramp::at(1.0, [1.0, 1.0], 5.0), 0);
        while !ramp.rests() {
            ramp.step(0.0, 0.01);
            steps += 1;
        }
        assert!((119..=122).contains(&steps), "{steps}");
        let slow = Ramp::at(1.0, [1.0, 1.0], 5.0).stop(0.001);
        assert!((slow - 0.6).abs() < 0.002, "{slow}");
    }
}
