//! From a path and limits to a motion in time.

pub mod axes;
mod ceiling;
mod correction;
mod csv;
mod energy;
mod jerk_limited;
mod method;
pub mod movers;
mod overspeed;
mod profile;
pub mod scurve;
pub mod topp;
mod trace;
mod trajectory;
mod trapezoid;
mod turn;

pub use ceiling::{Ceiling, ceiling};
pub use correction::{Corrected, Pass, correct, first_pass};
pub use csv::CSV_HEADER;
pub use energy::Drive;
pub use jerk_limited::{JerkLimited, Loop, composed, corrected, time};
pub use method::Method;
pub use overspeed::{Region, extremes, overspeed, regions};
pub use profile::fastest;
pub use scurve::{Bounds, Jerks, Profile, SCurve};
pub use trace::SpeedTrace;
pub use trajectory::{Piece, State, Trajectory};

pub use turn::{DEFAULT_TURN_ACCELERATION, DEFAULT_TURN_RATE, turn_time};

use crate::context::Context;
use crate::error::PlanError;
use crate::path::Path;
use crate::query::Limits;

/// Puts a path into time.
pub trait Timing: Send + Sync {
    /// The motion along `path` under `limits`.
    /// # Errors
    /// [`PlanError::Infeasible`] or [`PlanError::BadParameter`].
    fn time(&self, path: &Path, limits: &Limits, ctx: &mut Context) -> Result<Trajectory, PlanError>;
}

/// What a motion along a path is asked besides its limits.
#[derive(Clone, Copy, Default)]
pub struct TimingOptions<'a> {
    /// Heading before the motion, rad; a turn in place leads to that of the path. `None`: that of the path.
    pub start_yaw: Option<f64>,
    /// Heading after the motion, rad. `None`: that of the path.
    pub goal_yaw: Option<f64>,
    /// Speed at the start, m/s.
    pub start_speed: f64,
    /// Speed at the end, m/s.
    pub end_speed: f64,
    /// How the speed is found.
    pub method: Method,
    /// A further ceiling (m/s) of the arc length (m), e.g. [`safe_speed`] of the clearance there. Sampled every few millimetres.
    pub clearance_ceiling: Option<&'a dyn Fn(f64) -> f64>,
}

impl TimingOptions<'_> {
    fn validate(&self, limits: &Limits) -> Result<(), PlanError> {
        for (name, yaw) in [("start_yaw", self.start_yaw), ("goal_yaw", self.goal_yaw)] {
            if let Some(y) = yaw.filter(|y| !y.is_finite()) {
                return Err(PlanError::bad(name, y, "a finite angle, rad"));
            }
        }
        for (name, v) in [("start_speed", self.start_speed), ("end_speed", self.end_speed)] {
            if !(v >= 0.0 && v <= limits.speed) {
                return Err(PlanError::bad(name, v, format!("0 to the speed limit {} m/s", limits.speed)));
            }
        }
        Ok(())
    }
}

/// Distance in which a motion at `speed` (m/s) without acceleration can stop, m. Acceleration falls to `-deceleration` and
/// rises to zero at the jerk limit.
pub fn stopping_distance(speed: f64, limits: &Limits) -> f64 {
    let (b, j) = (limits.deceleration, limits.jerk);
    if speed * j >= b * b { 0.5 * speed * (speed / b + b / j) } else { speed * (speed / j).sqrt() }
}

/// Distance in which a motion at `speed` (m/s) stops if the brake takes effect after `latency` (s), m: `v t_lat` and [`stopping_distance`].
pub fn stop_distance(speed: f64, latency: f64, limits: &Limits) -> f64 {
    speed * latency + stopping_distance(speed, limits)
}

/// Highest speed from which the motion stops within `distance` (m), m/s: the inverse of [`stopping_distance`].
pub fn safe_speed(distance: f64, limits: &Limits) -> f64 {
    let (b, j) = (limits.deceleration, limits.jerk);
    let d = distance.max(0.0);
    let gentle = (d * d * j).cbrt();
    if gentle * j <= b * b { gentle } else { 0.5 * b * (((b / j).powi(2) + 8.0 * d / b).sqrt() - b / j) }
}
