//! Distance to the truth: the exact optima of a query, and the gap of a result to them.

use super::{Visibility, grid_optimum};
use crate::context::{Context, Stop};
use crate::error::PlanError;
use crate::path::Path;
use crate::plan::{Planner, Solution};
use crate::query::Query;
use serde::Serialize;

/// Largest relative amount by which a result may lie below an optimum: rounding, nothing else.
const ROUNDING: f64 = 1e-9;

/// The exact optima of a query; lengths in m.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Reference {
    /// Shortest path on the 8-connected lattice (`None`: there is none, or it was not finished).
    pub grid_optimum: Option<f64>,
    /// Shortest path in the plane (`None`: it was not finished).
    pub any_angle_optimum: Option<f64>,
    /// That path, or the best one known if it was not finished.
    pub any_angle_path: Option<Path>,
    /// Proved lower bound on every path in the plane; equals the optimum where that is known.
    pub any_angle_bound: Option<f64>,
    /// The any-angle optimum is proved.
    pub proved: bool,
}

/// Relative distance of a length to an optimum, `(length - optimum) / optimum`; 0 where both are 0.
/// # Errors
/// [`PlanError::CertificateFailed`] if the length lies below the optimum by more than 1e-9 of it: then the optimum or the path is wrong.
pub fn gap(length: f64, optimum: f64) -> Result<f64, PlanError> {
    let gap = if length == optimum { 0.0 } else { (length - optimum) / optimum.max(f64::MIN_POSITIVE) };
    if gap >= -ROUNDING {
        return Ok(gap.max(0.0));
    }
    Err(PlanError::CertificateFailed { stage: "reference", detail: format!("a path of {length:.9} m is shorter than the optimum of {optimum:.9} m") })
}

/// Computes the exact optima of a query for a path of length `raw_length` (m) of any planner. `known` is what [`Visibility`] found for this very
/// query, if it has been asked already.
/// # Errors
/// [`PlanError::CertificateFailed`] if the path is shorter than the any-angle optimum (or its bound), those of [`Query::validate`], and
/// [`PlanError::Cancelled`]. That a lattice has no path, or that time ran out, is no error.
pub fn reference(query: &Query, raw_length: f64, known: Option<Solution>, ctx: &mut Context) -> Result<Reference, PlanError> {
    query.validate()?;
    let found = |result: Result<Solution, PlanError>| match result {
        Ok(solution) => Ok(Some(solution)),
        Err(PlanError::NoPath(_)) => Ok(None),
        Err(other) => Err(other),
    };
    let grid = found(grid_optimum(query, ctx))?.filter(|s| s.stop == Stop::Converged);
    let exact = if known.is_some() { known } else { found(Visibility::default().plan(query, ctx))? };
    let proved = exact.as_ref().is_some_and(|s| s.stop == Stop::Converged);
    let bound = exact.as_ref().and_then(|s| s.trace["lower_bound"].as_f64());
    if let Some(bound) = bound {
        gap(raw_length, bound)?;
    }
    Ok(Reference {
        grid_optimum: grid.map(|s| s.cost),
        any_angle_optimum: exact.as_ref().filter(|_| proved).map(|s| s.cost),
        any_angle_bound: bound,
        any_angle_path: exact.map(|s| s.path),
        proved,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::world::{Bits, Grid, World};
    use std::sync::Arc;

    fn one_square() -> Query {
        let mut bits = Bits::new(5, 5);
        bits.set(2, 2, true);
        let world = Arc::new(World::from_grid(Grid::new(bits, None, 1.0, [0.0; 3]).unwrap()));
        Query::new(world, [0.5, 2.5], [4.5, 2.5])
    }

    #[test]
    fn both_optima_by_hand() {
        let found = reference(&one_square(), 5.0, None, &mut Context::new(0)).unwrap();
        assert!((found.grid_optimum.unwrap() - (2.0 + 2.0 * 2f64.sqrt())).abs() < 1e-12);
        let exact = 2.0 * 1.5f64.hypot(0.5) + 1.0;
        assert!((found.any_angle_optimum.unwrap() - exact).abs() < 1e-12);
        assert!(found.proved && found.any_angle_bound == found.any_angle_optimum);
        assert!((gap(5.0, exact).unwrap() - (5.0 - exact) / exact).abs() < 1e-12);
    }

    #[test]
    fn a_path_below_the_optimum_is_refused() {
        let error = reference(&one_square(), 4.1, None, &mut Context::new(0)).unwrap_err();
        assert_eq!(error.name(), "CertificateFailed");
        assert!(gap(1.0 - 1e-12, 1.0).is_ok() && gap(1.0 - 1e-8, 1.0).is_err());
    }
}
