//! Tours.

use crate::convert::to_python;
use crate::errors::OrPy;
use crate::plan::watched;
use crate::query::Query;
use guideway::context::Budget;
use guideway::plan::tour as core;
use pyo3::prelude::*;

/// The best order in which a query's via points are passed between its start and its goal: proved for up to 15 of them, beyond a good one with a proved bound.
///
/// A dictionary: `order` (indices of the via points), `via` (them in that order, m), `length` and `bound` (m; equal where the order is proved best), `costs` (exact
/// distances between start, via points as given and goal, m).
#[pyfunction]
pub fn tour<'py>(py: Python<'py>, query: &Query) -> PyResult<Bound<'py, PyAny>> {
    let (result, raised) = watched(py, 0, Budget::default(), 1, None, |ctx| core::tour(&query.inner, ctx))?;
    raised.map_or(Ok(()), Err)?;
    let tour = result.or_py(py)?;
    let via = core::ordered(&query.inner, &tour).via;
    to_python(py, &serde_json::json!({"order": tour.order, "via": via, "length": tour.length, "bound": tour.bound, "costs": tour.costs}))
}
