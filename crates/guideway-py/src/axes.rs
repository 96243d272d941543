//! Point-to-point motion of several axes.

use crate::convert::{table, values};
use crate::errors::OrPy;
use guideway::error::PlanError;
use guideway::timing::axes::{Axis, AxisGoal, AxisLimits, AxisSample, AxisState, Input, Motion, Sync, plan};
use numpy::{PyArray1, PyArray2};
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// A problem of several axes that can be planned again and again.
#[pyclass(frozen, module = "guideway")]
pub struct PointToPoint {
    input: Input,
}

/// A motion of several axes in pieces of constant jerk.
#[pyclass(frozen, module = "guideway")]
pub struct PointToPointMotion {
    inner: Motion,
}

/// One number per axis, from one for all or one each; `default` where nothing is given.
fn each(name: &str, given: Option<&Bound<'_, PyAny>>, count: usize, default: f64) -> PyResult<Vec<f64>> {
    let Some(given) = given.filter(|g| !g.is_none()) else { return Ok(vec![default; count]) };
    if let Ok(all) = given.extract::<f64>() {
        return Ok(vec![all; count]);
    }
    let list = values(name, given)?;
    if list.len() == count {
        Ok(list)
    } else {
        Err(PlanError::bad(name, format!("{} numbers", list.len()), format!("one number, or one for each of {count} axes"))).or_py(given.py())
    }
}

/// Goal positions; `None` in place of a number, or of all, means none.
fn positions(given: &Bound<'_, PyAny>, count: usize) -> PyResult<Vec<Option<f64>>> {
    if given.is_none() {
        return Ok(vec![None; count]);
    }
    let list = match given.extract::<Vec<Option<f64>>>() {
        Ok(list) => list,
        Err(_) => values("goal", given)?.into_iter().map(Some).collect(),
    };
    if list.len() == count {
        Ok(list)
    } else {
        Err(PlanError::bad("goal", format!("{} positions", list.len()), format!("one for each of {count} axes"))).or_py(given.py())
    }
}

const LIMITS: [&str; 5] = ["velocity", "acceleration", "jerk", "min_velocity", "min_acceleration"];

/// Limits of every axis from a dict.
fn limits(given: &Bound<'_, PyDict>, count: usize) -> PyResult<Vec<AxisLimits>> {
    let py = given.py();
    for key in given.keys() {
        let key: String = key.extract()?;
        if !LIMITS.contains(&key.as_str()) {
            return Err(PlanError::bad("limits", key, format!("the keys {}", LIMITS.join(", ")))).or_py(py);
        }
    }
    let needed = |key: &str| match given.get_item(key)? {
        Some(value) => each(key, Some(&value), count, 0.0),
        None => {
            Err(PlanError::bad("limits", format!("no {key}"), "velocity, acceleration and jerk; min_velocity and min_acceleration if they differ"))
                .or_py(py)
        }
    };
    let (velocity, acceleration, jerk) = (needed("velocity")?, needed("acceleration")?, needed("jerk")?);
    let lower = |key: &str, upper: &[f64]| match given.get_item(key)?.filter(|v| !v.is_none()) {
        Some(value) => each(key, Some(&value), count, 0.0),
        None => Ok(upper.iter().map(|x| -x).collect()),
    };
    let (least_v, least_a): (Vec<f64>, Vec<f64>) = (lower("min_velocity", &velocity)?, lower("min_acceleration", &acceleration)?);
    let one = |i: usize| AxisLimits { velocity: (least_v[i], velocity[i]), acceleration: (least_a[i], acceleration[i]), jerk: jerk[i] };
    Ok((0..count).map(one).collect())
}

fn sync_named(py: Python<'_>, name: &str) -> PyResult<Sync> {
    match name {
        "time" => Ok(Sync::Time),
        "phase" => Ok(Sync::Phase),
        "none" => Ok(Sync::None),
        _ => Err(PlanError::bad("sync", name, "time, phase or none")).or_py(py),
    }
}

#[pymethods]
impl PointToPoint {
    #[new]
    #[pyo3(signature = (start, goal, *, limits, start_velocity=None, start_acceleration=None, goal_velocity=None, goal_acceleration=None,
                        sync="time", minimum_duration=0.0, cycle=None, enabled=None))]
    #[expect(clippy::too_many_arguments, reason = "keyword arguments of a Python function")]
    fn new(
        py: Python<'_>,
        start: &Bound<'_, PyAny>,
        goal: &Bound<'_, PyAny>,
        limits: &Bound<'_, PyDict>,
        start_velocity: Option<&Bound<'_, PyAny>>,
        start_acceleration: Option<&Bound<'_, PyAny>>,
        goal_velocity: Option<&Bound<'_, PyAny>>,
        goal_acceleration: Option<&Bound<'_, PyAny>>,
        sync: &str,
        minimum_duration: f64,
        cycle: Option<f64>,
        enabled: Option<Vec<bool>>,
    ) -> PyResult<Self> {
        let start = values("start", start)?;
        let count = start.len();
        let goal = positions(goal, count)?;
        let limits = self::limits(limits, count)?;
        let (v0, a0) = (each("start_velocity", start_velocity, count, 0.0)?, each("start_acceleration", start_acceleration, count, 0.0)?);
        let (v1, a1) = (each("goal_velocity", goal_velocity, count, 0.0)?, each("goal_acceleration", goal_acceleration, count, 0.0)?);
        let enabled = enabled.unwrap_or_else(|| vec![true; count]);
        if enabled.len() != count {
            return Err(PlanError::bad("enabled", format!("{} values", enabled.len()), format!("one for each of {count} axes"))).or_py(py);
        }
        let axis = |i: usize| Axis {
            start: AxisState { position: start[i], velocity: v0[i], acceleration: a0[i] },
            goal: AxisGoal { position: goal[i], velocity: v1[i], acceleration: a1[i] },
            limits: limits[i],
            enabled: enabled[i],
        };
        Ok(Self { input: Input { axes: (0..count).map(axis).collect(), sync: sync_named(py, sync)?, minimum_duration, cycle } })
    }

    /// The fastest motion.
    fn plan(&self, py: Python<'_>) -> PyResult<PointToPointMotion> {
        plan(&self.input).map(|inner| PointToPointMotion { inner }).or_py(py)
    }
}

/// The fastest motion of several axes from one state to another, each for itself (`sync="none"`), all arriving together (`"time"`), or on a straight line
/// where states and goals allow one (`"phase"`).
///
/// `start` and `goal` are positions, one per axis; velocities and accelerations there are zero unless given. A goal of `None`, for all or for one axis, asks
/// for velocity and acceleration only. `limits` is a dict of `velocity`, `acceleration`, `jerk`, each one number or one per axis, and `min_velocity` and
/// `min_acceleration` (negative) where they differ by direction. Durations are at least `minimum_duration` and whole multiples of `cycle`, s. Axes that are
/// not `enabled` stay where they are. Raises `BadParameter`, or `Infeasible` where a velocity limit of zero forbids the direction.
#[pyfunction]
#[pyo3(signature = (start, goal, *, limits, start_velocity=None, start_acceleration=None, goal_velocity=None, goal_acceleration=None,
                    sync="time", minimum_duration=0.0, cycle=None, enabled=None))]
#[expect(clippy::too_many_arguments, reason = "keyword arguments of a Python function")]
pub fn point_to_point(
    py: Python<'_>,
    start: &Bound<'_, PyAny>,
    goal: &Bound<'_, PyAny>,
    limits: &Bound<'_, PyDict>,
    start_velocity: Option<&Bound<'_, PyAny>>,
    start_acceleration: Option<&Bound<'_, PyAny>>,
    goal_velocity: Option<&Bound<'_, PyAny>>,
    goal_acceleration: Option<&Bound<'_, PyAny>>,
    sync: &str,
    minimum_duration: f64,
    cycle: Option<f64>,
    enabled: Option<Vec<bool>>,
) -> PyResult<PointToPointMotion> {
    PointToPoint::new(
        py,
        start,
        goal,
        limits,
        start_velocity,
        start_acceleration,
        goal_velocity,
        goal_acceleration,
        sync,
        minimum_duration,
        cycle,
        enabled,
    )?
    .plan(py)
}

/// Samples as a dict of (len(times), axes) arrays.
fn samples<'py>(py: Python<'py>, motion: &Motion, times: &[f64]) -> PyResult<Bound<'py, PyDict>> {
    let rows: Vec<AxisSample> = times.iter().flat_map(|t| motion.at(*t)).collect();
    let dict = PyDict::new(py);
    dict.set_item("t", PyArray1::from_slice(py, times))?;
    let set = |name: &str, of: fn(&AxisSample) -> f64| dict.set_item(name, table(py, &rows.iter().map(of).collect::<Vec<_>>(), motion.axes.len())?);
    set("q", |s| s.position)?;
    set("qd", |s| s.velocity)?;
    set("qdd", |s| s.acceleration)?;
    set("qddd", |s| s.jerk)?;
    Ok(dict)
}

#[pymethods]
impl PointToPointMotion {
    /// The longest duration of an axis, s.
    #[getter]
    fn duration(&self) -> f64 {
        self.inner.duration
    }
    /// Duration of each axis, s.
    #[getter]
    fn durations<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_iter(py, self.inner.axes.iter().map(|a| a.duration))
    }
    /// Whether all axes move on one straight line.
    #[getter]
    fn straight(&self) -> bool {
        self.inner.straight
    }
    /// For each axis the rows (duration, position, velocity, acceleration, jerk) of its pieces of constant jerk; states are those at their begin.
    #[getter]
    fn phases<'py>(&self, py: Python<'py>) -> PyResult<Vec<Bound<'py, PyArray2<f64>>>> {
        let row = |p: &guideway::timing::axes::AxisPiece| [p.duration, p.start.position, p.start.velocity, p.start.acceleration, p.jerk];
        self.inner.axes.iter().map(|axis| table(py, &axis.pieces.iter().flat_map(row).collect::<Vec<_>>(), 5)).collect()
    }
    /// Positions q, velocities qd, accelerations qdd and jerks qddd of all axes at time t (s), clamped to the motion: a dict of arrays.
    fn at<'py>(&self, py: Python<'py>, t: f64) -> PyResult<Bound<'py, PyDict>> {
        if t.is_nan() {
            return Err(PlanError::bad("t", t, "a time in s")).or_py(py);
        }
        let dict = PyDict::new(py);
        let state = self.inner.at(t);
        dict.set_item("t", t)?;
        dict.set_item("q", PyArray1::from_iter(py, state.iter().map(|s| s.position)))?;
        dict.set_item("qd", PyArray1::from_iter(py, state.iter().map(|s| s.velocity)))?;
        dict.set_item("qdd", PyArray1::from_iter(py, state.iter().map(|s| s.acceleration)))?;
        dict.set_item("qddd", PyArray1::from_iter(py, state.iter().map(|s| s.jerk)))?;
        Ok(dict)
    }
    /// The motion at `rate` samples per second (500 unless given), its end included, or at given times (s): a dict of t (m,) and q, qd, qdd, qddd (m, axes).
    #[pyo3(signature = (rate=None, *, times=None))]
    fn sample<'py>(&self, py: Python<'py>, rate: Option<f64>, times: Option<&Bound<'py, PyAny>>) -> PyResult<Bound<'py, PyDict>> {
        let duration = self.inner.duration;
        let times = if let Some(times) = times {
            values("times", times)?
        } else {
            let rate = rate.unwrap_or(500.0);
            if !(rate.is_finite() && rate > 0.0 && rate * duration <= 1e7) {
                return Err(PlanError::bad("rate", rate, "a positive rate in Hz that gives at most 1e7 rows")).or_py(py);
            }
            let count = (duration * rate * (1.0 - 1e-12)).ceil() as usize;
            (0..count).map(|i| i as f64 / rate).chain([duration]).collect()
        };
        if let Some(t) = times.iter().find(|t| t.is_nan()) {
            return Err(PlanError::bad("times", t, "times in s")).or_py(py);
        }
        samples(py, &self.inner, &times)
    }
    fn __repr__(&self) -> String {
        format!("PointToPointMotion({} axes, {:.6} s)", self.inner.axes.len(), self.inner.duration)
    }
}
