//! The one-axis S-curve.

use crate::convert::{table, values};
use crate::errors::OrPy;
use guideway::timing::{self, Bounds, Jerks, SCurve};
use numpy::PyArray2;
use pyo3::prelude::*;

/// A one-axis motion of up to nine phases of constant jerk.
#[pyclass(frozen, module = "guideway")]
pub struct Profile {
    inner: timing::Profile,
}

#[pymethods]
impl Profile {
    /// Total time, s.
    #[getter]
    fn duration(&self) -> f64 {
        self.inner.duration()
    }
    /// Largest speed on the way, m/s.
    #[getter]
    fn top_speed(&self) -> f64 {
        self.inner.top_speed()
    }
    /// (duration in s, jerk in m/s3) of each phase.
    #[getter]
    fn phases(&self) -> Vec<(f64, f64)> {
        self.inner.phases().iter().map(|p| (p.duration, p.jerk)).collect()
    }
    /// Rows (position, speed, acceleration, jerk) at times t (s), shape (len(t), 4).
    fn at<'py>(&self, py: Python<'py>, t: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let rows = values("t", t)?.into_iter().map(|t| self.inner.at(t));
        table(py, &rows.flat_map(<[f64; 4]>::from).collect::<Vec<_>>(), 4)
    }
    fn __repr__(&self) -> String {
        format!("Profile({:.6} s, {} phases)", self.inner.duration(), self.inner.phases().len())
    }
}

/// The fastest jerk-limited motion over `distance` (m) between `start` and `end`, each (speed, acceleration), in the direction of motion.
///
/// A deceleration left out equals the acceleration; `jerk` is one limit or four: build-up and release of acceleration, of braking. Raises `Infeasible` with
/// the best end speed that can be reached. Guaranteed to find the optimum for a start acceleration >= 0 and an end acceleration <= 0.
#[pyfunction]
#[pyo3(signature = (distance, *, speed, acceleration, jerk, deceleration=None, start=(0.0, 0.0), end=(0.0, 0.0)))]
#[expect(clippy::too_many_arguments, reason = "keyword arguments of a Python function")]
pub fn scurve(
    py: Python<'_>,
    distance: f64,
    speed: f64,
    acceleration: f64,
    jerk: &Bound<'_, PyAny>,
    deceleration: Option<f64>,
    start: (f64, f64),
    end: (f64, f64),
) -> PyResult<Profile> {
    let jerk = match values("jerk", jerk)?[..] {
        [j] => Jerks::all(j),
        [build, release, brake, unbrake] => Jerks { build, release, brake, unbrake },
        _ => return Err(guideway::error::PlanError::bad("jerk", "the value given", "one limit or four, m/s3")).or_py(py),
    };
    let bounds = Bounds { speed, acceleration, deceleration: deceleration.unwrap_or(acceleration), jerk };
    SCurve { distance, start, end, bounds }.plan().map(|inner| Profile { inner }).or_py(py)
}
