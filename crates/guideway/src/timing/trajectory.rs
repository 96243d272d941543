//! A motion in time: pieces along a path with constant jerk, and turns in place.

use crate::path::Path;
use crate::query::Limits;
use serde::{Deserialize, Serialize};

/// One piece of a trajectory.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Piece {
    /// Along the path with constant jerk; values at the start of the piece.
    Along {
        /// Start time, s.
        t: f64,
        /// Arc length, m.
        s: f64,
        /// m/s.
        speed: f64,
        /// m/s2.
        acceleration: f64,
        /// m/s3.
        jerk: f64,
        /// s.
        duration: f64,
    },
    /// In place at arc length `s`, by `turn` rad from heading `from` rad, with a rest-to-rest profile that is symmetric in time.
    Turn {
        /// Signed angle, rad.
        turn: f64,
        /// Start time, s.
        t: f64,
        /// s.
        duration: f64,
        /// Arc length where it happens, m.
        s: f64,
        /// Heading before the turn, rad.
        from: f64,
    },
}

/// State of a motion at one time.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct State {
    /// s.
    pub t: f64,
    /// Arc length, m.
    pub s: f64,
    /// m, m, rad.
    pub pose: [f64; 3],
    /// m/s.
    pub speed: f64,
    /// m/s2.
    pub acceleration: f64,
    /// m/s3.
    pub jerk: f64,
    /// 1/m.
    pub curvature: f64,
    /// rad/s.
    pub turn_rate: f64,
}

/// A timed motion along a path.
#[derive(Debug, Clone, PartialEq)]
pub struct Trajectory {
    /// The path it follows.
    pub path: Path,
    /// In time order, without gaps.
    pub pieces: Vec<Piece>,
    /// Limits it was certified against.
    pub limits: Limits,
}

impl Trajectory {
    /// Total time, s.
    pub fn duration(&self) -> f64 {
        match self.pieces.last() {
            Some(Piece::Along { t, duration, .. } | Piece::Turn { t, duration, .. }) => t + duration,
            None => 0.0,
        }
    }
}
