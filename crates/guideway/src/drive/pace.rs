//! Speed override and the controlled stop: a share of the planned speed that changes within limits.

use super::Robot;

/// Longest step that is followed, s; after a longer gap the share stays where it was.
const LONGEST: f64 = 0.5;

/// The share of the speed, on its way to what is asked for. The speed that a share of the top speed stands for changes within the limits of acceleration and jerk.
#[derive(Debug, Clone)]
pub(super) struct Pace {
    /// Asked for, 0 to 1.
    pub share: f64,
    /// Is the robot to stand?
    pub held: bool,
    /// The share in force.
    pub now: f64,
    /// Its rate, 1/s.
    rate: f64,
    /// Limits of the rate, falling and rising, 1/s, and of its change, 1/s2.
    limits: [f64; 2],
    jerk: f64,
    time: Option<f64>,
}

impl Pace {
    pub fn new(robot: &Robot, jerk: f64) -> Self {
        let limits = [robot.deceleration / robot.speed, robot.acceleration / robot.speed];
        Self { share: 1.0, held: false, now: 1.0, rate: 0.0, limits, jerk: jerk / robot.speed, time: None }
    }

    /// The share at time `t`, s.
    pub fn step(&mut self, t: f64) -> f64 {
        let dt = self.time.map_or(0.0, |before| t - before);
        if t.is_finite() {
            self.time = Some(t);
        }
        let target = if self.held { 0.0 } else { self.share };
        let left = target - self.now;
        if !(dt > 0.0 && dt <= LONGEST) || left == 0.0 {
            return self.now;
        }
        // The rate from which the target is met with the rate falling to zero at the limit; a step less, so that it is not overrun.
        let most = if left < 0.0 { self.limits[0] } else { self.limits[1] };
        let change = self.jerk * dt;
        let gentle = (0.25 * change * change + 2.0 * self.jerk * left.abs()).sqrt() - 0.5 * change;
        let wanted = gentle.min(most).copysign(left);
        self.rate += (wanted - self.rate).clamp(-change, change);
        let next = self.now + self.rate * dt;
        if (target - next) * left <= 0.0 || left.abs() < 1e-4 {
            (self.now, self.rate) = (target, 0.0);
        } else {
            self.now = next.clamp(0.0, 1.0);
        }
        self.now
    }
}

#[cfg(test)]
mod tests {
    use super::super::testing::limits;
    use super::*;
    use crate::world::Footprint;

    #[test]
    fn shares_change_within_the_limits_and_arrive() {
        let robot = Robot::new(Footprint::Disc(0.2), &limits()).unwrap();
        let mut pace = Pace::new(&robot, 5.0);
        let (mut now, mut rate, mut t) = (pace.step(0.0), 0.0, 0.0);
        for (share, held) in [(0.4, false), (0.4, true), (1.0, false), (0.9, false), (1.0, true)] {
            (pace.share, pace.held) = (share, held);
            for _ in 0..150 {
                t += 0.02;
                let next = pace.step(t);
                let fresh = (next - now) / 0.02;
                assert!(fresh.abs() <= 1.0 + 1e-9, "{fresh}");
                assert!((fresh - rate).abs() / 0.02 <= 5.0 * 1.5, "{rate} {fresh}");
                (now, rate) = (next, fresh);
            }
            assert!((now - if held { 0.0 } else { share }).abs() < 1e-12, "{now} {share}");
        }
        assert_eq!((pace.step(f64::NAN), pace.step(t + 100.0)), (now, now), "clocks that jump change nothing");
    }
}
