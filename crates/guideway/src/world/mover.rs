//! Obstacles that move: a shape carried along a timed polyline.

use super::footprint::Footprint;
use super::shape::{Shape, sub};
use crate::Point;
use crate::error::PlanError;
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

/// Most rows of a track.
pub const MAX_ROWS: usize = 1_000_000;

impl Mover {
    /// A mover on `track`, from the start of its track, present from the beginning, staying at the end.
    /// # Errors
    /// As [`Mover::validated`].
    pub fn new(shape: Footprint, track: Vec<[f64; 3]>) -> Result<Self, PlanError> {
        Self { shape, track, repeat: Loop::Once, phase: 0.0, appears: None }.validated()
    }

    /// The same mover if its values make sense; a polygon's corners are brought into counter-clockwise order.
    /// # Errors
    /// [`PlanError::BadParameter`] for an outline that [`Footprint::validated`] refuses, an empty or endless track, values that are not finite, times that
    /// do not start at 0 or do not increase, or a negative distance or time of appearance.
    pub fn validated(mut self) -> Result<Self, PlanError> {
        self.shape = self.shape.validated()?;
        if self.track.is_empty() || self.track.len() > MAX_ROWS {
            return Err(PlanError::bad("mover.track", format!("{} rows", self.track.len()), format!("1 to {MAX_ROWS} rows (t, x, y)")));
        }
        if let Some(i) = self.track.iter().position(|row| !row.iter().all(|v| v.is_finite() && v.abs() <= 1e9)) {
            return Err(PlanError::bad("mover.track", format!("{:?} in row {i}", self.track[i]), "finite numbers up to 1e9: t in s, x and y in m"));
        }
        if self.track[0][0] != 0.0 {
            return Err(PlanError::bad("mover.track", format!("first time {} s", self.track[0][0]), "times that start at 0 s"));
        }
        if let Some(i) = self.track.windows(2).position(|w| w[1][0] <= w[0][0]) {
            return Err(PlanError::bad(
                "mover.track",
                format!("t = {} s in row {}", self.track[i + 1][0], i + 1),
                "times that increase from row to row",
            ));
        }
        if !(self.phase.is_finite() && self.phase.abs() <= 1e9) {
            return Err(PlanError::bad("mover.phase", self.phase, "a finite time in s"));
        }
        match self.appears {
            Some(Appears::Within(v) | Appears::At(v)) if !(v.is_finite() && v >= 0.0) => {
                Err(PlanError::bad("mover.appears", v, "a distance in m or a time in s, 0 or more"))
            }
            _ => Ok(self),
        }
    }

    /// Position (m) and velocity (m/s) at time `t` (s); the origin without a track.
    pub fn at(&self, t: f64) -> (Point, Point) {
        if self.track.is_empty() {
            return ([0.0; 2], [0.0; 2]);
        }
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

    /// Signed distance from `p` (m) to the outline at time `t` (s), m; negative inside.
    pub fn distance(&self, p: Point, t: f64) -> f64 {
        self.outline().distance(sub(p, self.at(t).0))
    }

    /// Distance between a robot at `pose` (x, y in m, yaw in rad) and the outline at time `t` (s), m; negative when they overlap.
    pub fn gap(&self, footprint: &Footprint, pose: [f64; 3], t: f64) -> f64 {
        let center = self.at(t).0;
        match footprint.at(pose) {
            None => self.outline().distance(sub([pose[0], pose[1]], center)) - footprint.circumscribed(),
            Some(corners) => self.outline().body_distance(&corners.into_iter().map(|c| sub(c, center)).collect::<Vec<_>>()),
        }
    }

    /// Smallest signed distance from the resting point `p` (m) to the outline while time runs from `t0` to `t1` (s), m. Exact: seen from the mover, `p` moves
    /// along straight pieces.
    pub fn least_distance(&self, p: Point, t0: f64, t1: f64) -> f64 {
        let outline = self.outline();
        let mut best = self.distance(p, t0).min(self.distance(p, t1));
        for [from, to] in self.stretches(t0.min(t1), t0.max(t1)) {
            let inner = self.track.iter().filter(|row| row[0] > from && row[0] < to).map(|row| [row[1], row[2]]);
            let places: Vec<Point> = std::iter::once(self.place(from)).chain(inner).chain(std::iter::once(self.place(to))).collect();
            best = places.windows(2).map(|w| outline.segment_distance(sub(p, w[0]), sub(p, w[1]))).fold(best, f64::min);
        }
        best
    }

    /// The outline around the origin.
    pub(crate) fn outline(&self) -> Shape {
        match self.shape.corners() {
            Some(points) => Shape::Polygon { points },
            None => Shape::Disc { center: [0.0; 2], radius: self.shape.circumscribed() },
        }
    }

    /// Position at a time of the track itself, s, which must lie on it, m.
    fn place(&self, tau: f64) -> Point {
        let i = self.track.partition_point(|row| row[0] <= tau).clamp(1, self.track.len() - 1);
        let ([t0, x0, y0], [t1, x1, y1]) = (self.track[i - 1], self.track[i]);
        let r = (tau - t0) / (t1 - t0);
        [x0 + r * (x1 - x0), y0 + r * (y1 - y0)]
    }

    /// The stretches of the track (times of the track, s) that the mover covers from `t0` to `t1`, in whatever direction.
    fn stretches(&self, t0: f64, t1: f64) -> Vec<[f64; 2]> {
        let period = self.track.last().map_or(0.0, |row| row[0]);
        let (a, b) = (t0 + self.phase, t1 + self.phase);
        if period <= 0.0 {
            return Vec::new();
        }
        let turns = match self.repeat {
            Loop::Once => return vec![[a.clamp(0.0, period), b.clamp(0.0, period)]],
            Loop::Cycle => 1.0,
            Loop::Shuttle => 2.0,
        };
        if b - a >= turns * period {
            return vec![[0.0, period]];
        }
        let start = a.rem_euclid(turns * period);
        let end = start + (b - a);
        let lap = |k: i32| {
            let base = f64::from(k) * period;
            let (from, to) = (start.max(base) - base, end.min(base + period) - base);
            let back = self.repeat == Loop::Shuttle && k % 2 == 1;
            (from <= to).then_some(if back { [period - to, period - from] } else { [from, to] })
        };
        (0..4).filter_map(lap).collect()
    }

    /// Largest speed along the track, m/s.
    pub fn top_speed(&self) -> f64 {
        self.track.windows(2).map(|w| (w[1][1] - w[0][1]).hypot(w[1][2] - w[0][2]) / (w[1][0] - w[0][0])).fold(0.0, f64::max)
    }
}
