//! A motion in time: pieces along a path with constant jerk, and turns in place.

use super::scurve::advance;
use super::turn::turned;
use crate::path::Path;
use crate::query::Limits;
use crate::world::shape::wrap;
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
    /// In place at arc length `s`, by `turn` rad from heading `from` rad: the turn rate is a trapezoid in time with the turn acceleration of the
    /// limits ([`super::DEFAULT_TURN_ACCELERATION`] if they name none).
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

    /// State at time `t` (s), clamped to the motion. At a change of pieces, that of the later one.
    pub fn at(&self, t: f64) -> State {
        let t = t.clamp(0.0, self.duration());
        let i = self.pieces.partition_point(|p| p.start() <= t).saturating_sub(1);
        match self.pieces.get(i) {
            Some(Piece::Along { t: t0, s, speed, acceleration, jerk, duration }) => {
                let (s, speed, acceleration) = advance((*s, *speed, *acceleration), *jerk, (t - t0).min(*duration));
                let place = self.path.planar(s);
                let pose = [place.point[0], place.point[1], place.heading];
                State { t, s, pose, speed, acceleration, jerk: *jerk, curvature: place.curvature, turn_rate: place.curvature * speed }
            }
            Some(Piece::Turn { turn, t: t0, duration, s, from }) => {
                let (angle, turn_rate) = turned(*turn, *duration, t - t0, &self.limits);
                self.resting(t, *s, Some(wrap(from + angle)), turn_rate)
            }
            None => self.resting(t, 0.0, None, 0.0),
        }
    }

    fn resting(&self, t: f64, s: f64, yaw: Option<f64>, turn_rate: f64) -> State {
        let place = self.path.planar(s);
        let pose = [place.point[0], place.point[1], yaw.unwrap_or(place.heading)];
        State { t, s, pose, speed: 0.0, acceleration: 0.0, jerk: 0.0, curvature: place.curvature, turn_rate }
    }
}

impl Piece {
    /// Start time, s.
    pub fn start(&self) -> f64 {
        match self {
            Self::Along { t, .. } | Self::Turn { t, .. } => *t,
        }
    }

    /// s.
    pub fn duration(&self) -> f64 {
        match self {
            Self::Along { duration, .. } | Self::Turn { duration, .. } => *duration,
        }
    }

    /// The same piece later by `dt` (s).
    #[must_use]
    pub fn shifted(mut self, dt: f64) -> Self {
        let (Self::Along { t, .. } | Self::Turn { t, .. }) = &mut self;
        *t += dt;
        self
    }
}
