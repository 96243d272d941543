//! From a path and limits to a motion in time.

pub mod scurve;
mod trajectory;

pub use scurve::{Bounds, Jerks, Profile, SCurve};
pub use trajectory::{Piece, State, Trajectory};

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
