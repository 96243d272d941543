//! `Path`.

use crate::convert::rows;
use crate::errors::OrPy;
use guideway::path;
use numpy::{PyArray1, PyArray2, PyArrayMethods};
use pyo3::prelude::*;

/// A clamped B-spline of any degree and dimension; a polyline is degree 1. Evaluated by arc length.
#[pyclass(frozen, module = "guideway")]
pub struct Path {
    pub inner: path::Path,
}

#[pymethods]
impl Path {
    /// From degree, knots (n + degree + 1) and control points, shape (n, dimension).
    #[new]
    fn new(py: Python<'_>, degree: usize, knots: Vec<f64>, control_points: Vec<Vec<f64>>) -> PyResult<Self> {
        let dimension = control_points.first().map_or(0, Vec::len);
        let inner = path::Path::new(degree, dimension, knots, control_points.into_iter().flatten().collect()).or_py(py)?;
        Ok(Self { inner })
    }

    /// A polyline through points of shape (n, 2), m.
    #[staticmethod]
    fn polyline(points: &Bound<'_, PyAny>) -> PyResult<Self> {
        Ok(Self { inner: path::Path::polyline(&rows("points", points)?) })
    }

    /// Polynomial degree.
    #[getter]
    fn degree(&self) -> usize {
        self.inner.degree()
    }
    /// Knots, clamped, shape (n + degree + 1,).
    #[getter]
    fn knots<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_slice(py, self.inner.knots())
    }
    /// Control points, shape (n, dimension).
    #[getter]
    fn control_points<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        PyArray1::from_slice(py, self.inner.control()).reshape([self.inner.count(), self.inner.dimension()])
    }
}
