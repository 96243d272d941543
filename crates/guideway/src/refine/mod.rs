//! From a planner's raw path to one that a robot likes to drive.

mod arcs;
mod belt;
mod bspline;
mod cells;
mod chords;
mod fit;
mod merge;
mod metric;
mod security_marking;
mod simplify;
mod smooth;
mod spline;
#[cfg(test)]
mod tests;

pub use bspline::BSpline;
pub use chords::polyline;
pub use security_marking::SecurityMarking;
pub use simplify::Simplify;
pub use smooth::Smooth;

use crate::context::Context;
use crate::error::PlanError;
use crate::path::Path;
use crate::query::Query;

/// Improves a path without making it unsafe.
pub trait Refiner: Send + Sync {
    /// A better path for the same query, and what could not be met.
    /// # Errors
    /// [`PlanError::CertificateFailed`] if the result is not provably free.
    fn refine(&self, path: &Path, query: &Query, ctx: &mut Context) -> Result<Refined, PlanError>;
}

/// A refined path and what could not be met.
#[derive(Debug, Clone)]
pub struct Refined {
    /// The new path.
    pub path: Path,
    /// In words for the report, e.g. where the curvature limit is exceeded.
    pub unmet: Vec<String>,
}
