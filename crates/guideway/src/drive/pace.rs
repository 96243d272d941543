//! Speed override and the controlled stop: a share of the planned speed that changes within limits.

use super::Robot;
use super::ramp::Ramp;

/// Longest step that is followed, s; after a longer gap the share stays where it was.
const LONGEST: f64 = 0.5;

/// The share of the speed, on its way to what is asked for. The speed that a share of the top speed stands for changes within the limits of acceleration and jerk.
#[derive(Debug, Clone)]
pub(super) struct Pace {
    /// Asked for, 0 to 1.
    pub share: f64,
    /// Is the robot to stand?
    pub held: bool,
    ramp: Ramp,
    time: Option<f64>,
}

impl Pace {
    pub fn new(robot: &Robot, jerk: f64) -> Self {
        let limits = [robot.acceleration / robot.speed, robot.deceleration / robot.speed];
        Self { share: 1.0, held: false, ramp: Ramp::at(1.0, limits, jerk / robot.speed), time: None }
    }

    /// The share in force.
    pub fn now(&self) -> f64 {
        self.ramp.v
    }

    /// The share at time `t`, s.
    pub fn step(&mut self, t: f64) -> f64 {
        let dt = self.time.map_or(0.0, |before| t - before);
        if t.is_finite() {
            self.time = Some(t);
        }
        if dt <= LONGEST {
            self.ramp.step(if self.held { 0.0 } else { self.share }, dt);
        }
        self.ramp.v = self.ramp.v.clamp(0.0, 1.0);
        self.ramp.v
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
                assert!((fresh - rate).abs() / 0.02 <= 5.0 + 1e-6, "{rate} {fresh}");
                (now, rate) = (next, fresh);
            }
            assert!((now - if held { 0.0 } else { share }).abs() < 1e-12, "{now} {share}");
        }
        assert_eq!((pace.step(f64::NAN), pace.step(t + 100.0)), (now, now), "clocks that jump change nothing");
    }
}
