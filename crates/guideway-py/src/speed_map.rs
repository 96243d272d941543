//! `SpeedMap`.

use crate::errors::{OrPy, to_py};
use guideway::error::PlanError;
use guideway::world;
use numpy::{PyArray2, PyArrayMethods, PyUntypedArrayMethods};
use pyo3::prelude::*;
use std::sync::Arc;

/// How fast may be driven where: `limits` (m/s, infinite without one) of shape (height, width), row 0 on top, cells of side `resolution` (m), the lower-left
/// corner at `origin` (x, y, yaw). The place of the robot's reference point counts.
#[pyclass(frozen, module = "guideway")]
pub struct SpeedMap {
    pub inner: Arc<world::SpeedMap>,
    /// Where it came from and the sha256 of what was read, if it was.
    #[pyo3(get)]
    source: Option<String>,
}

#[pymethods]
impl SpeedMap {
    #[new]
    #[pyo3(signature = (limits, resolution=1.0, origin=[0.0, 0.0, 0.0], *, source=None))]
    fn new(py: Python<'_>, limits: &Bound<'_, PyAny>, resolution: f64, origin: [f64; 3], source: Option<String>) -> PyResult<Self> {
        let bad = || to_py(py, &PlanError::bad("limits", "the value given", "an array of shape (height, width) of speeds in m/s"));
        let array = py.import("numpy")?.call_method1("asarray", (limits, "float64")).map_err(|_| bad())?;
        let array = array.cast_into::<PyArray2<f64>>().map_err(|_| bad())?.readonly();
        let [h, w] = [array.shape()[0], array.shape()[1]];
        let size = [u32::try_from(w).map_err(|_| bad())?, u32::try_from(h).map_err(|_| bad())?];
        let values: Vec<f64> = array.as_array().rows().into_iter().rev().flat_map(|row| row.to_vec()).collect();
        Ok(Self { inner: Arc::new(world::SpeedMap::new(&values, size, resolution, origin).or_py(py)?), source })
    }

    /// Reads a `map_server` mask as Nav2's speed filter does in percent: 0 and unknown cells are free, others allow `base + multiplier * value` percent of `speed` (m/s).
    #[staticmethod]
    #[pyo3(signature = (path, speed, **options))]
    fn load<'py>(
        py: Python<'py>,
        path: &Bound<'py, PyAny>,
        speed: f64,
        options: Option<&Bound<'py, pyo3::types::PyDict>>,
    ) -> PyResult<Bound<'py, PyAny>> {
        py.import("guideway.site_rules")?.getattr("speed_map")?.call((path, speed), options)
    }

    /// Largest speed at a point, m/s; infinite without a limit.
    fn at(&self, x: f64, y: f64) -> f64 {
        self.inner.at([x, y])
    }
}
