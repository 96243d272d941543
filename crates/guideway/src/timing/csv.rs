//! A trajectory as rows of numbers at a fixed rate.

use super::{State, Trajectory};
use std::fmt::Write;

/// Columns of [`Trajectory::csv`]: s, m, m, rad, m/s, m/s2, m/s3, 1/m.
pub const CSV_HEADER: &str = "t,x,y,yaw,speed,acceleration,jerk,curvature";

impl Trajectory {
    /// States at `rate` (1/s) from 0 on, and the last one at the duration.
    pub fn samples(&self, rate: f64) -> Vec<State> {
        let duration = self.duration();
        let count = (duration * rate * (1.0 - 1e-12)).floor() as usize;
        let mut out: Vec<State> = (0..=count).map(|k| self.at(k as f64 / rate)).collect();
        if out.last().is_some_and(|s| s.t < duration) {
            out.push(self.at(duration));
        }
        out
    }

    /// CSV text with a header at `rate` (1/s, 100 in files), numbers to 9 decimals.
    pub fn csv(&self, rate: f64) -> String {
        let mut out = format!("{CSV_HEADER}\n");
        for s in self.samples(rate) {
            let [x, y, yaw] = s.pose;
            let row = [s.t, x, y, yaw, s.speed, s.acceleration, s.jerk, s.curvature];
            for (i, value) in row.iter().enumerate() {
                let comma = if i == 0 { "" } else { "," };
                // Writing to a string cannot fail; adding zero turns -0 into 0.
                let _ = write!(out, "{comma}{:.9}", value + 0.0);
            }
            out.push('\n');
        }
        out
    }
}
