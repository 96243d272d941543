//! Everything that can go wrong, in the vocabulary of the field.
//!
//! Each error carries the value, the allowed range and what to do about it; nothing here is a string that the caller has to parse.

use crate::Point;
use serde::Serialize;

/// Why a call has no result. [`PlanError::name`] is the stable short name used in files and as the Python class name.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum PlanError {
    /// The robot does not fit at the start.
    #[error("start ({:.3}, {:.3}) is blocked: clearance there is {clearance:.3} m, the robot needs {needed:.3} m. Move the start or use a smaller footprint or clearance.", point[0], point[1])]
    StartBlocked {
        /// The start, m.
        point: Point,
        /// Distance from it to the nearest obstacle, m.
        clearance: f64,
        /// Distance that the robot needs there, m.
        needed: f64,
    },
    /// The robot does not fit at the goal (or at a via point).
    #[error("goal ({:.3}, {:.3}) is blocked: clearance there is {clearance:.3} m, the robot needs {needed:.3} m. Move the goal or use a smaller footprint or clearance.", point[0], point[1])]
    GoalBlocked {
        /// The goal or via point, m.
        point: Point,
        /// Distance from it to the nearest obstacle, m.
        clearance: f64,
        /// Distance that the robot needs there, m.
        needed: f64,
    },
    /// A point lies outside the world.
    #[error("{what} ({:.3}, {:.3}) is outside the map, which covers x {:.3} to {:.3} m and y {:.3} to {:.3} m", point[0], point[1], bounds[0], bounds[2], bounds[1], bounds[3])]
    OutsideMap {
        /// Which point it is, in a word.
        what: String,
        /// Where it is, m.
        point: Point,
        /// What the world covers, `[x0, y0, x1, y1]`, m.
        bounds: [f64; 4],
    },
    /// No path exists (`proved`), or none was found within the budget or the method's reach.
    #[error("{0}")]
    NoPath(Box<NoPath>),
    /// A parameter is outside its allowed range.
    #[error("{name} = {value} is not allowed: {allowed}")]
    BadParameter {
        /// The parameter.
        name: String,
        /// The value that was given, as text.
        value: String,
        /// What is allowed, in words.
        allowed: String,
    },
    /// The motion asked for cannot be timed under the limits.
    #[error("infeasible motion: {reason}")]
    Infeasible {
        /// What stands against it, in words.
        reason: String,
        /// The end speed nearest to the one asked for that can be reached, m/s, where that is what failed.
        best_end_speed: Option<f64>,
    },
    /// A result failed the independent checker; it is an error, not a result.
    #[error("the {stage} failed its certificate: {detail}. This is a bug in Guideway, not in your input: please report it")]
    CertificateFailed {
        /// What was checked.
        stage: &'static str,
        /// Which check failed, and where.
        detail: String,
    },
    /// The caller cancelled before anything was found.
    #[error("cancelled before a result was found")]
    Cancelled,
}

/// What is known about a query without a path.
#[derive(Debug, Clone, PartialEq, Serialize, Default)]
pub struct NoPath {
    /// True when an exact method exhausted the free space: no path exists in this model.
    pub proved: bool,
    /// Radius (footprint plus clearance) the query asked for, m.
    pub needed: f64,
    /// Largest radius of a disc that can go from start to goal, m (`None`: none, or not computed).
    pub widest: Option<f64>,
    /// Where the best route is narrowest, m.
    pub narrowest: Option<Point>,
    /// What stopped an unproved search, e.g. `budget of 100 iterations spent`.
    pub reason: Option<String>,
}

impl std::fmt::Display for NoPath {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let how = if self.proved { "no path exists (proved)" } else { "no path found (not proved that none exists)" };
        write!(f, "{how} for a robot that needs {:.3} m on every side", self.needed)?;
        if let Some(reason) = &self.reason {
            write!(f, "; {reason}")?;
        }
        match (self.widest, self.narrowest) {
            (Some(w), Some(p)) => {
                write!(f, ". The widest disc that would pass has radius {w:.3} m; the route is narrowest near ({:.3}, {:.3})", p[0], p[1])
            }
            (None, _) if self.proved => write!(f, ". Start and goal are not connected for any footprint"),
            _ => Ok(()),
        }
    }
}

impl PlanError {
    /// Stable short name, also the name of the Python exception class.
    pub fn name(&self) -> &'static str {
        match self {
            Self::StartBlocked { .. } => "StartBlocked",
            Self::GoalBlocked { .. } => "GoalBlocked",
            Self::OutsideMap { .. } => "OutsideMap",
            Self::NoPath(_) => "NoPath",
            Self::BadParameter { .. } => "BadParameter",
            Self::Infeasible { .. } => "Infeasible",
            Self::CertificateFailed { .. } => "CertificateFailed",
            Self::Cancelled => "Cancelled",
        }
    }

    /// A [`PlanError::BadParameter`]; a number of hundreds of digits is shown by its exponent.
    pub fn bad(name: impl Into<String>, value: impl std::fmt::Display, allowed: impl Into<String>) -> Self {
        let text = value.to_string();
        let value = if text.len() > 24 { text.parse::<f64>().map_or(text, |number| format!("{number:e}")) } else { text };
        Self::BadParameter { name: name.into(), value, allowed: allowed.into() }
    }
}
