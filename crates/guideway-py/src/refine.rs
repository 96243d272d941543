//! Refining, measuring and certifying paths.

use crate::convert::{points, to_python};
use crate::errors::{OrPy, to_py};
use crate::path::Path;
use crate::plan::watched;
use crate::query::Query;
use guideway::context::Budget;
use guideway::error::PlanError;
use guideway::path as paths;
use guideway::query::Material;
use guideway::refine::{self as core, BSpline, Refiner, SecurityMarking, Simplify, Smooth};
use numpy::PyArray2;
use pyo3::prelude::*;

/// A refined path and what could not be met.
#[pyclass(frozen, module = "guideway")]
pub struct Refined {
    inner: core::Refined,
}

#[pymethods]
impl Refined {
    /// The new path.
    #[getter]
    fn path(&self) -> Path {
        Path { inner: self.inner.path.clone() }
    }
    /// What could not be met, in words.
    #[getter]
    fn unmet(&self) -> Vec<String> {
        self.inner.unmet.clone()
    }
    fn __repr__(&self) -> String {
        format!("Refined({:.6} m, {} not met)", self.inner.path.length(), self.inner.unmet.len())
    }
}

/// Refines a path for a query: `none`, `simplify` (line of sight; for long loads a lattice path is tidied and stays on the lattice), `smooth` (wide bends, proved
/// free) or `bspline` (all cells as control points, proved free). `max_curvature` in 1/m and `stretch`, the share of their legs that bends may add
/// (default 0.01), are those of `smooth`; `spacing` (cells) is the distance of the control points of `bspline`, above 1 evenly along the path.
#[pyfunction]
#[pyo3(signature = (path, query, method="smooth", *, max_curvature=None, stretch=None, spacing=1.0))]
pub fn refine(
    py: Python<'_>,
    path: &Path,
    query: &Query,
    method: &str,
    max_curvature: Option<f64>,
    stretch: Option<f64>,
    spacing: f64,
) -> PyResult<Refined> {
    let path = path.on_the_ground(py)?;
    let usual = Smooth::default();
    let refiner: Box<dyn Refiner> = match method {
        "none" => return Ok(Refined { inner: core::Refined { path: path.clone(), unmet: Vec::new() } }),
        "simplify" if query.inner.material == Material::Long => Box::new(SecurityMarking::default()),
        "simplify" => Box::new(Simplify::default()),
        "smooth" => Box::new(Smooth { max_curvature, stretch: stretch.unwrap_or(usual.stretch), ..usual }),
        "bspline" => Box::new(BSpline { spacing }),
        other => return Err(to_py(py, &PlanError::bad("refine", other, "one of none, simplify, smooth, bspline"))),
    };
    let (result, raised) = watched(py, 0, Budget::default(), 1, None, |ctx| refiner.refine(path, &query.inner, ctx))?;
    raised.map_or(Ok(()), Err)?;
    result.map(|inner| Refined { inner }).or_py(py)
}

/// Points along a path, shape (n, 2), m, so dense that straight segments between them keep the query's clearance.
#[pyfunction]
pub fn polyline<'py>(py: Python<'py>, path: &Path, query: &Query) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let path = path.on_the_ground(py)?;
    let rows = py.detach(|| core::polyline(path, &query.inner));
    points(py, &rows)
}

/// Measures a path: `length` (m), `turns`, `total_turning` (rad), `min_clearance` (m or None), `max_curvature` (1/m, None at corners), `smoothness` (1 is
/// straight), `energy` (cells and half a unit per turn), as in `plan.json`.
#[pyfunction]
pub fn measure<'py>(py: Python<'py>, path: &Path, query: &Query) -> PyResult<Bound<'py, PyAny>> {
    let radius = query.inner.footprint.circumscribed();
    let path = path.on_the_ground(py)?;
    let metrics = py.detach(|| paths::measure(path, &query.inner.world, radius));
    to_python(py, &metrics)
}
