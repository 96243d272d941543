//! Obstacles that move: a shape carried along a timed polyline.

use super::footprint::Footprint;
use crate::Point;
use serde::{Deserialize, Serialize};

/// What a mover does at the end of its path.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Loop {
    /// Stays at the end.
    #[default]
    Once,
    /// Jumps back to the start.
    Cycle,
    /// Goes back and forth.
    Shuttle,
}

/// When a mover becomes real.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Appears {
    /// Once the robot is that near, m.
    Within(f64),
    /// At that time, s.
    At(f64),
}

/// A moving obstacle whose motion is known (`Known` of the house).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Mover {
    /// Its outline; boxes and polygons keep their orientation (they do not turn with the motion).
    pub shape: Footprint,
    /// Rows (t in s, x, y in m), times strictly increasing from 0; one row is a parked obstacle.
    pub track: Vec<[f64; 3]>,
    /// At the end of the track.
    #[serde(rename = "loop")]
    pub repeat: Loop,
    /// Time along its motion at t = 0, s.
    pub phase: f64,
    /// Present from the start if `None`.
    pub appears: Option<Appears>,
}

impl Mover {
    /// Position (m) and velocity (m/s) at time `t` (s).
    pub fn at(&self, t: f64) -> (Point, Point) {
        let last = self.track.len() - 1;
        let period = self.track[last][0];
        let tau = t + self.phase;
        if last == 0 || period <= 0.0 {
            return ([self.track[0][1], self.track[0][2]], [0.0; 2]);
        }
        let (tau, sign) = match self.repeat {
            Loop::Once if tau >= period => return ([self.track[last][1], self.track[last][2]], [0.0; 2]),
            Loop::Once if tau <= 0.0 => return ([self.track[0][1], self.track[0][2]], [0.0; 2]),
            Loop::Once => (tau, 1.0),
            Loop::Cycle => (tau.rem_euclid(period), 1.0),
            Loop::Shuttle => {
                let u = tau.rem_euclid(2.0 * period);
                if u <= period { (u, 1.0) } else { (2.0 * period - u, -1.0) }
            }
        };
        let i = self.track.partition_point(|row| row[0] <= tau).clamp(1, last);
        let ([t0, x0, y0], [t1, x1, y1]) = (self.track[i - 1], self.track[i]);
        let (dt, r) = (t1 - t0, (tau - t0) / (t1 - t0));
        ([x0 + r * (x1 - x0), y0 + r * (y1 - y0)], [sign * (x1 - x0) / dt, sign * (y1 - y0) / dt])
    }

    /// Largest speed along the track, m/s.
    pub fn top_speed(&self) -> f64 {
        self.track.windows(2).map(|w| (w[1][1] - w[0][1]).hypot(w[1][2] - w[0][2]) / (w[1][0] - w[0][0])).fold(0.0, f64::max)
    }
}
