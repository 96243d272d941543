//! `Path`.

use crate::convert::{rows, table, values};
use crate::errors::{OrPy, to_py};
use guideway::error::PlanError;
use guideway::path;
use numpy::{PyArray1, PyArray2, PyArray3, PyArrayMethods};
use pyo3::prelude::*;

/// A clamped B-spline of any degree and dimension; a polyline is degree 1. Evaluated by arc length.
#[pyclass(frozen, module = "guideway")]
pub struct Path {
    pub inner: path::Path,
}

impl Path {
    /// The path, if it is planar.
    pub fn on_the_ground(&self, py: Python<'_>) -> PyResult<&path::Path> {
        let dimension = self.inner.dimension();
        if dimension == 2 { Ok(&self.inner) } else { Err(to_py(py, &PlanError::bad("path.dimension", dimension, "2: a planar path"))) }
    }
}

#[pymethods]
impl Path {
    /// From degree, knots (n + degree + 1) and control points, shape (n, dimension).
    #[new]
    fn new(py: Python<'_>, degree: usize, knots: Vec<f64>, control_points: Vec<Vec<f64>>) -> PyResult<Self> {
        let dimension = control_points.first().map_or(0, Vec::len);
        if let Some(row) = control_points.iter().position(|row| row.len() != dimension) {
            return Err(to_py(py, &PlanError::bad("control_points", format!("row {row}"), format!("{dimension} coordinates, as in the first row"))));
        }
        let inner = path::Path::new(degree, dimension, knots, control_points.into_iter().flatten().collect()).or_py(py)?;
        Ok(Self { inner })
    }

    /// A polyline through points of shape (n, 2), m.
    #[staticmethod]
    fn polyline(points: &Bound<'_, PyAny>) -> PyResult<Self> {
        let rows = rows("points", points)?;
        if rows.is_empty() || !rows.as_flattened().iter().all(|v| v.is_finite()) {
            return Err(to_py(
                points.py(),
                &PlanError::bad("points", format!("{} points", rows.len()), "at least one point, finite coordinates in m"),
            ));
        }
        Ok(Self { inner: path::Path::polyline(&rows) })
    }

    /// The interpolating spline through points of shape (n, dimension): cubic with continuous curvature from four points on, a parabola through three, a
    /// straight line through two. Parameters default to the accumulated distances; a point that repeats the one before it is dropped.
    #[staticmethod]
    #[pyo3(signature = (points, parameters=None))]
    fn through(py: Python<'_>, points: &Bound<'_, PyAny>, parameters: Option<&Bound<'_, PyAny>>) -> PyResult<Self> {
        let bad = || to_py(py, &PlanError::bad("points", "the value given", "an array of shape (n, dimension) of numbers"));
        let array = py.import("numpy")?.call_method1("asarray", (points, "float64")).map_err(|_| bad())?;
        let array = array.cast_into::<PyArray2<f64>>().map_err(|_| bad())?.readonly();
        let (view, dimension) = (array.as_array(), array.as_array().ncols());
        let flat: Vec<f64> = view.iter().copied().collect();
        let inner = match parameters {
            Some(t) => path::Path::through_at(&flat, dimension, &values("parameters", t)?),
            None => path::Path::through(&flat, dimension),
        };
        inner.or_py(py).map(|inner| Self { inner })
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
        table(py, self.inner.control(), self.inner.dimension())
    }
    /// Arc length, m.
    #[getter]
    fn length(&self) -> f64 {
        self.inner.length()
    }

    /// Position and derivatives with respect to arc length at arc lengths `s` (m): shape (order + 1, len(s), dimension). Order is 0 to 3.
    #[pyo3(signature = (s, order=0))]
    fn eval<'py>(&self, py: Python<'py>, s: &Bound<'py, PyAny>, order: usize) -> PyResult<Bound<'py, PyArray3<f64>>> {
        if order > 3 {
            return Err(to_py(py, &PlanError::bad("order", order, "0 to 3")));
        }
        let (s, dimension) = (values("s", s)?, self.inner.dimension());
        let rows: Vec<Vec<Vec<f64>>> = s.iter().map(|&s| self.inner.eval(s, order)).collect();
        let flat: Vec<f64> = (0..=order).flat_map(|k| rows.iter().flat_map(move |row| row[k].iter().copied())).collect();
        PyArray1::from_vec(py, flat).reshape([order + 1, s.len(), dimension])
    }

    /// x (m), y (m), heading (rad), curvature (1/m) at arc lengths `s` (m): shape (len(s), 4).
    fn planar<'py>(&self, py: Python<'py>, s: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let path = self.on_the_ground(py)?;
        let rows = values("s", s)?.into_iter().map(|s| path.planar(s));
        table(py, &rows.flat_map(|p| [p.point[0], p.point[1], p.heading, p.curvature]).collect::<Vec<_>>(), 4)
    }

    fn __repr__(&self) -> String {
        format!("Path(degree {}, {} control points, length {:.6} m)", self.inner.degree(), self.inner.count(), self.inner.length())
    }
}
