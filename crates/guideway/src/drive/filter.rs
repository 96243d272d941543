//! A pose filter: odometry between observations, observations against drift.

use super::{Observation, arc};
use crate::world::shape::wrap;
use serde::{Deserialize, Serialize};

/// Longest time that odometry bridges, s.
const LAPSE: f64 = 1.0;

/// Blends the predicted and the observed pose with a fixed gain. 1 believes the observation alone; white noise shrinks by sqrt(gain / (2 - gain)).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub(super) struct Filter {
    gain: f64,
    last: Option<(f64, [f64; 3])>,
}

impl Filter {
    pub fn new(gain: f64) -> Self {
        Self { gain, last: None }
    }

    /// Replaces the observed pose by the filtered one.
    pub fn apply(&mut self, seen: &mut Observation) {
        // A clock that jumped tells nothing about the way driven.
        if let Some((t, pose)) = self.last.filter(|(t, _)| (0.0..=LAPSE).contains(&(seen.time - t))) {
            let ahead = arc(pose, seen.v, seen.w, seen.time - t);
            let mix = |k: usize| ahead[k] + self.gain * (seen.pose[k] - ahead[k]);
            let yaw = ahead[2] + self.gain * wrap(seen.pose[2] - ahead[2]);
            seen.pose = [mix(0), mix(1), wrap(yaw)];
        }
        self.last = Some((seen.time, seen.pose));
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Command, Plant, Unicycle, testing};
    use super::*;
    use crate::world::Footprint;

    #[test]
    fn noise_shrinks_and_motion_is_followed() {
        let robot = super::super::Robot::new(Footprint::Disc(0.2), &testing::limits()).unwrap();
        let mut plant = Unicycle::default().place(&robot, [0.0; 3], 3);
        let (mut filter, mut raw, mut kept) = (Filter::new(0.2), 0.0, 0.0);
        for i in 0..3000 {
            plant.step(Command { v: 1.0, w: (f64::from(i) * 0.01).sin() }, 0.02);
            let mut seen = plant.observe();
            seen.time = f64::from(i) * 0.02;
            let truth = plant.motion().pose;
            let error = |o: &Observation| (o.pose[0] - truth[0]).powi(2) + (o.pose[1] - truth[1]).powi(2);
            raw += error(&seen);
            filter.apply(&mut seen);
            kept += error(&seen);
        }
        assert!(kept < 0.2 * raw, "{kept} {raw}");
    }
}
