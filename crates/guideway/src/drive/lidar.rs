//! A planar range sensor on the robot.

use serde::{Deserialize, Serialize};

/// A 2-D lidar at the robot's reference point, its middle beam straight ahead.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Lidar {
    /// Rays of one scan.
    pub beams: u32,
    /// Angle between the first and the last ray, rad; a full circle has no ray twice.
    pub field_of_view: f64,
    /// Farthest that is seen, m.
    pub range: f64,
    /// Standard deviation of a range, m.
    pub noise: f64,
    /// Scans per second, Hz.
    pub rate: f64,
}

impl Default for Lidar {
    fn default() -> Self {
        Self { beams: 360, field_of_view: std::f64::consts::TAU, range: 10.0, noise: 0.01, rate: 20.0 }
    }
}

/// One turn of a lidar.
#[derive(Debug, Clone, PartialEq)]
pub struct Scan {
    /// When it was taken, s.
    pub time: f64,
    /// Direction of the first ray against the heading, rad.
    pub first: f64,
    /// From ray to ray, rad, positive to the left.
    pub step: f64,
    /// Farthest that is seen, m.
    pub range: f64,
    /// m; infinite: nothing within range; not a number: no measurement.
    pub ranges: Vec<f64>,
}
