//! Time-optimal motion of joints along a path.

use crate::convert::{from_python, table, to_python, values};
use crate::errors::{OrPy, to_py};
use crate::path::Path;
use guideway::error::PlanError;
use guideway::timing::topp::{self, Demands, JointLimits, Rows, TopMethod, TopOptions, Window};
use numpy::{PyArray1, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::cell::RefCell;

/// A timed motion of joints along a path.
#[pyclass(frozen, module = "guideway")]
pub struct JointMotion {
    inner: topp::JointMotion,
}

#[pymethods]
impl JointMotion {
    /// The path it follows.
    #[getter]
    fn path(&self) -> Path {
        Path { inner: self.inner.path.clone() }
    }
    /// Total time, s.
    #[getter]
    fn duration(&self) -> f64 {
        self.inner.duration()
    }
    /// Arc lengths of the grid, rad, shape (n,).
    #[getter]
    fn s<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_slice(py, &self.inner.s)
    }
    /// Squared path speed at the grid, rad2/s2, shape (n,).
    #[getter]
    fn x<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_slice(py, &self.inner.x)
    }
    /// Path acceleration at the start of every interval, rad/s2, shape (n - 1,).
    #[getter]
    fn u<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_slice(py, &self.inner.u)
    }
    /// Maximum velocity curve: squared path speed that no motion exceeds, rad2/s2, shape (n,).
    #[getter]
    fn mvc<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_slice(py, &self.inner.mvc)
    }
    /// What is nearest to its bound on the interval that begins at each grid point, n names.
    #[getter]
    fn active(&self) -> Vec<String> {
        self.inner.active.clone()
    }
    /// Stretches of constant path jerk, as in `plan.json`: `t`, `s`, `speed`, `acceleration`, `jerk`, `duration`.
    #[getter]
    fn pieces<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        to_python(py, &self.inner.pieces)
    }
    /// With `jerk`: pairs (limit, seconds that it costs against the motion without limits of jerk).
    #[getter]
    fn price(&self) -> Vec<(String, f64)> {
        self.inner.price.clone()
    }
    /// How it was found, a dictionary: grid points tried, refinements, largest excess on the dense check ...
    #[getter]
    fn report<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        to_python(py, &self.inner.report)
    }
    /// State at time `t` (s): a dictionary with `t`, `s`, `speed`, `acceleration`, `jerk` of the path and `q`, `qd`, `qdd`, `qddd`, shape (joints,).
    fn at<'py>(&self, py: Python<'py>, t: f64) -> PyResult<Bound<'py, PyDict>> {
        if t.is_nan() {
            return Err(to_py(py, &PlanError::bad("t", t, "a time in s")));
        }
        let state = self.inner.at(t);
        let row = PyDict::new(py);
        for (name, value) in [("t", state.t), ("s", state.s), ("speed", state.speed), ("acceleration", state.acceleration), ("jerk", state.jerk)] {
            row.set_item(name, value)?;
        }
        for (name, values) in ["q", "qd", "qdd", "qddd"].into_iter().zip(&state.joints) {
            row.set_item(name, PyArray1::from_slice(py, values))?;
        }
        Ok(row)
    }
    /// States at `times` (s), or at `rate` (Hz) and at the end: a dictionary of `t`, `s`, `speed`, `acceleration`, `jerk`, shape (n,), and `q`, `qd`, `qdd`,
    /// `qddd`, shape (n, joints).
    #[pyo3(signature = (rate=None, *, times=None))]
    fn sample<'py>(&self, py: Python<'py>, rate: Option<f64>, times: Option<&Bound<'py, PyAny>>) -> PyResult<Bound<'py, PyDict>> {
        let duration = self.inner.duration();
        let times = if let Some(times) = times {
            values("times", times)?
        } else {
            let rate = rate.unwrap_or(500.0);
            if !(rate.is_finite() && rate > 0.0 && rate * duration <= 1e7) {
                return Err(to_py(py, &PlanError::bad("rate", rate, "a positive rate in Hz that gives at most 1e7 rows")));
            }
            let count = (duration * rate * (1.0 - 1e-12)).ceil() as usize;
            (0..count).map(|i| i as f64 / rate).chain([duration]).collect()
        };
        if let Some(t) = times.iter().find(|t| t.is_nan()) {
            return Err(to_py(py, &PlanError::bad("times", t, "times in s")));
        }
        let states = py.detach(|| self.inner.sample(&times));
        let out = PyDict::new(py);
        let column = |f: &dyn Fn(&topp::JointState) -> f64| PyArray1::from_vec(py, states.iter().map(f).collect());
        out.set_item("t", column(&|q| q.t))?;
        out.set_item("s", column(&|q| q.s))?;
        out.set_item("speed", column(&|q| q.speed))?;
        out.set_item("acceleration", column(&|q| q.acceleration))?;
        out.set_item("jerk", column(&|q| q.jerk))?;
        for (k, name) in ["q", "qd", "qdd", "qddd"].into_iter().enumerate() {
            let flat: Vec<f64> = states.iter().flat_map(|q| q.joints[k].iter().copied()).collect();
            out.set_item(name, table(py, &flat, self.inner.path.dimension())?)?;
        }
        Ok(out)
    }
    fn __repr__(&self) -> String {
        format!("JointMotion({:.6} s, {} joints, {} grid points)", self.inner.duration(), self.inner.path.dimension(), self.inner.s.len())
    }
}

/// Arrays of one callback's answer: (n, r), or (r,) for every place.
fn array(answer: &Bound<'_, PyAny>, name: &str, places: usize) -> PyResult<(Vec<f64>, usize)> {
    let py = answer.py();
    let bad = || to_py(py, &PlanError::bad(format!("rows.{name}"), "the value given", format!("an array of shape ({places}, rows) or (rows,)")));
    let value = answer.get_item(name).map_err(|_| bad())?;
    let array = py.import("numpy")?.call_method1("asarray", (value, "float64")).map_err(|_| bad())?;
    if let Ok(array) = array.extract::<PyReadonlyArray2<'_, f64>>() {
        let view = array.as_array();
        return if view.nrows() == places { Ok((view.iter().copied().collect(), view.ncols())) } else { Err(bad()) };
    }
    let row: Vec<f64> = array.extract::<PyReadonlyArray1<'_, f64>>().map_err(|_| bad())?.as_array().iter().copied().collect();
    Ok((row.repeat(places), row.len()))
}

/// Rows from a callback's dictionary.
fn rows(answer: &Bound<'_, PyAny>, places: usize) -> PyResult<Rows> {
    let (a, count) = array(answer, "a", places)?;
    let has = |name: &str| answer.contains(name);
    let or_zero = |name: &str| if has(name)? { array(answer, name, places).map(|v| v.0) } else { Ok(vec![0.0; places * count]) };
    let d = if has("d")? { array(answer, "d", places)?.0 } else { Vec::new() };
    let bound = |name: &str, none: f64| if has(name)? { array(answer, name, places).map(|v| v.0) } else { Ok(vec![none; places * count]) };
    Ok(Rows { count, b: or_zero("b")?, c: or_zero("c")?, d, low: bound("low", f64::NEG_INFINITY)?, high: bound("high", f64::INFINITY)?, a })
}

/// Calls back with arc lengths; what Python raises is kept and the search ends.
fn call<T>(
    callback: &Py<PyAny>,
    s: &[f64],
    raised: &RefCell<Option<PyErr>>,
    read: impl Fn(&Bound<'_, PyAny>) -> PyResult<T>,
) -> Result<T, PlanError> {
    Python::attach(|py| {
        let answer = callback.bind(py).call1((PyArray1::from_slice(py, s),)).and_then(|answer| read(&answer));
        answer.map_err(|error| {
            *raised.borrow_mut() = Some(error);
            PlanError::Cancelled
        })
    })
}

/// Windows from rows of place, earliest and latest time, and the duration asked for.
fn windowed(rows: Option<Vec<Vec<f64>>>, duration: Option<f64>) -> Result<Vec<Window>, PlanError> {
    let mut windows = Vec::new();
    for row in rows.into_iter().flatten() {
        windows.push(match row[..] {
            [s, earliest] => Window { s, earliest, latest: f64::INFINITY },
            [s, earliest, latest] => Window { s, earliest, latest },
            _ => return Err(PlanError::bad("windows", format!("{} values", row.len()), "rows of place, earliest and, if need be, latest time")),
        });
    }
    windows.extend(duration.map(|d| Window { s: Window::END, earliest: d, latest: f64::INFINITY }));
    Ok(windows)
}

/// The fastest motion of joints along `path` (arc length in joint space, rad) under `limits`: `speed`, `acceleration`, `deceleration` (against the motion of the
/// joint; default: as acceleration), each one value or one per joint.
///
/// `rows(s)`: further limits `low <= a u + b x + d sqrt(x) + c <= high` at arc lengths `s`, in the path acceleration `u` and the squared path speed `x`: a
/// dictionary of `a`, `b`, `c`, `d`, `low`, `high`, each (n, r) or (r,); all but `a` may be left out. `row_names`: r names. `ceiling(s)`: the largest `x`, shape
/// (n,). `grid`: number of intervals; None: chosen by the time it may cost (`tolerance`, a share of the duration). All limits hold between grid points,
/// checked at `check` places per interval; with a grid and `tighten=False` only at the grid points. `jerk`: the
/// limits `jerk` (rad/s3) are kept too, in pieces of constant path jerk. `start_speed`, `end_speed`: path speeds at the ends, rad/s; the path acceleration there
/// is free within the limits. `rates(s)`, with `jerk`: rows as of `rows` whose change by time
/// stays between `low` < 0 and `high` > 0 (torque rate); jumps of theirs do not count. `rate_names`: their names. A limit of jerk may then be left out.
/// `windows`: rows of place (rad, on the path), earliest and, if need be, latest time (s) to pass it; `duration` (s): not faster than that in all. Raises `Infeasible` with the limit and the place.
#[pyfunction]
#[pyo3(signature = (path, limits, *, method="reachability", rows=None, row_names=None, ceiling=None, rates=None, rate_names=None, start_speed=0.0, end_speed=0.0, grid=None, tolerance=3e-4, check=20, windows=None, duration=None, jerk=false, tighten=true))]
#[expect(clippy::too_many_arguments, reason = "keyword arguments of a Python function")]
pub fn time_joints(
    py: Python<'_>,
    path: &Path,
    limits: &Bound<'_, PyAny>,
    method: &str,
    rows: Option<Py<PyAny>>,
    row_names: Option<Vec<String>>,
    ceiling: Option<Py<PyAny>>,
    rates: Option<Py<PyAny>>,
    rate_names: Option<Vec<String>>,
    start_speed: f64,
    end_speed: f64,
    grid: Option<usize>,
    tolerance: f64,
    check: usize,
    windows: Option<Vec<Vec<f64>>>,
    duration: Option<f64>,
    jerk: bool,
    tighten: bool,
) -> PyResult<JointMotion> {
    let limits: JointLimits = from_python("limits", limits)?;
    let method = TopMethod::named(method).or_py(py)?;
    let windows = windowed(windows, duration).or_py(py)?;
    let options = TopOptions { method, start_speed, end_speed, grid, tolerance, check, windows, jerk, tighten };
    let (rows_of, names, ceiling_of, rates_of, rate_names) = (rows, row_names.unwrap_or_default(), ceiling, rates, rate_names.unwrap_or_default());
    let (result, raised) = py.detach(|| {
        let raised = RefCell::new(None);
        let mut demands = Demands { names, rate_names, ..Demands::default() };
        if let Some(callback) = &rates_of {
            demands.rates = Some(Box::new(|s: &[f64]| call(callback, s, &raised, |answer| self::rows(answer, s.len()))));
        }
        if let Some(callback) = &rows_of {
            demands.rows = Some(Box::new(|s: &[f64]| call(callback, s, &raised, |answer| self::rows(answer, s.len()))));
        }
        if let Some(callback) = &ceiling_of {
            demands.ceiling = Some(Box::new(|s: &[f64]| call(callback, s, &raised, |answer| values("ceiling", answer))));
        }
        let result = topp::time_joints(&path.inner, &limits, &options, &mut demands);
        drop(demands);
        (result, raised.into_inner())
    });
    raised.map_or(Ok(()), Err)?;
    result.map(|inner| JointMotion { inner }).or_py(py)
}

/// The fastest squared path speed at the points `s` of a fixed grid: `x_max` (n,), rows `a`, `b`, `c`, `d` (n, r), `low`, `high` (n, r) or (r,), limits
/// `low <= a u + b x + d sqrt(x) + c <= high` at the grid points, at both ends of every interval. `ends`: squared path speed at both ends. Returns (n,).
#[pyfunction]
#[pyo3(signature = (s, x_max, a, b, c, low, high, d=None, *, ends=(0.0, 0.0)))]
#[expect(clippy::too_many_arguments, clippy::needless_pass_by_value, reason = "arrays of a Python function")]
pub fn topp_kernel<'py>(
    py: Python<'py>,
    s: PyReadonlyArray1<'py, f64>,
    x_max: PyReadonlyArray1<'py, f64>,
    a: PyReadonlyArray2<'py, f64>,
    b: PyReadonlyArray2<'py, f64>,
    c: Option<PyReadonlyArray2<'py, f64>>,
    low: &Bound<'py, PyAny>,
    high: &Bound<'py, PyAny>,
    d: Option<PyReadonlyArray2<'py, f64>>,
    ends: (f64, f64),
) -> PyResult<Bound<'py, PyArray1<f64>>> {
    let places = s.as_array().len();
    let count = a.as_array().ncols();
    let flat = |array: &PyReadonlyArray2<'py, f64>| -> Vec<f64> {
        array.as_slice().map_or_else(|_| array.as_array().iter().copied().collect(), <[f64]>::to_vec)
    };
    let bound = |name: &str, value: &Bound<'py, PyAny>| {
        let dictionary = PyDict::new(py);
        dictionary.set_item(name, value)?;
        array(dictionary.as_any(), name, places).map(|v| v.0)
    };
    let rows = Rows {
        count,
        a: flat(&a),
        b: flat(&b),
        c: c.as_ref().map_or_else(|| vec![0.0; places * count], flat),
        d: d.as_ref().map_or_else(Vec::new, flat),
        low: bound("low", low)?,
        high: bound("high", high)?,
    };
    let (s, x_max): (Vec<f64>, Vec<f64>) = (s.as_array().to_vec(), x_max.as_array().to_vec());
    let x = py.detach(|| rows.checked(places).and_then(|rows| topp::kernel(&s, &x_max, &rows, [ends.0, ends.1])));
    x.map(|x| PyArray1::from_vec(py, x)).or_py(py)
}
