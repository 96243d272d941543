//! `Trajectory`, timing and driving.

use crate::convert::{from_python, table, to_python};
use crate::errors::{OrPy, to_py};
use crate::path::Path;
use crate::plan::watched;
use crate::plant::Called;
use crate::query::Query;
use crate::speed_map::SpeedMap;
use guideway::context::{Budget, Context};
use guideway::drive as core;
use guideway::error::PlanError;
use guideway::plan;
use guideway::query::Limits;
use guideway::timing::movers::{self, Among, Record};
use guideway::timing::{self, Method, Piece, TimingOptions};
use numpy::PyArray2;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::sync::Arc;

/// A motion in time: pieces along a path with constant jerk, and turns in place.
#[pyclass(frozen, module = "guideway")]
pub struct Trajectory {
    pub inner: timing::Trajectory,
    pub among: Option<Record>,
}

#[pymethods]
impl Trajectory {
    /// From a path, limits and pieces as in `plan.json`.
    #[new]
    fn new(py: Python<'_>, path: &Path, limits: &Bound<'_, PyAny>, pieces: &Bound<'_, PyAny>) -> PyResult<Self> {
        let (limits, pieces): (Limits, Vec<Piece>) = (from_python("limits", limits)?, from_python("pieces", pieces)?);
        let inner = timing::Trajectory { path: path.on_the_ground(py)?.clone(), pieces, limits: limits.validated().or_py(py)? };
        Ok(Self { inner, among: None })
    }
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
    /// Energy that a nominal robot takes for it, J: rolling, accelerating and turning without regeneration (40 kg, 2.03 kg m2, rolling resistance 0.015,
    /// efficiency 0.75, copper losses 1.2 W/(m/s2)2). Our own model; good for comparing motions with each other.
    #[getter]
    fn energy(&self, py: Python<'_>) -> f64 {
        py.detach(|| timing::Drive::default().energy(&self.inner))
    }
    /// How it was timed among movers (:func:`time` with `among`), a dictionary: `movers`, `passive`, `delay` (s), `waiting` (s), `tested`; else None.
    #[getter]
    fn among<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        to_python(py, &self.among)
    }
    /// In time order, as in `plan.json`.
    #[getter]
    fn pieces<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        to_python(py, &self.inner.pieces)
    }
    /// Limits it was made for.
    #[getter]
    fn limits<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        to_python(py, &self.inner.limits)
    }
    /// State at time `t` (s), a dictionary: `t` (s), `s` (m), `pose` (m, m, rad), `speed` (m/s), `acceleration` (m/s2), `jerk` (m/s3), `curvature`
    /// (1/m), `turn_rate` (rad/s).
    fn at<'py>(&self, py: Python<'py>, t: f64) -> PyResult<Bound<'py, PyAny>> {
        if t.is_nan() {
            return Err(to_py(py, &PlanError::bad("t", t, "a time in s")));
        }
        to_python(py, &self.inner.at(t))
    }
    /// Rows (t, x, y, yaw, speed, acceleration, jerk, curvature) at `rate` Hz and at the end, shape (n, 8).
    #[pyo3(signature = (rate=100.0))]
    fn sample<'py>(&self, py: Python<'py>, rate: f64) -> PyResult<Bound<'py, PyArray2<f64>>> {
        if !(rate.is_finite() && rate > 0.0 && rate * self.inner.duration() <= 1e7) {
            return Err(to_py(py, &PlanError::bad("rate", rate, "a positive rate in Hz that gives at most 1e7 rows")));
        }
        let row = |q: timing::State| [q.t, q.pose[0], q.pose[1], q.pose[2], q.speed, q.acceleration, q.jerk, q.curvature];
        let rows: Vec<_> = self.inner.samples(rate).into_iter().map(row).collect();
        table(py, rows.as_flattened(), 8)
    }
    fn __repr__(&self) -> String {
        format!("Trajectory({:.4} s, {} pieces)", self.inner.duration(), self.inner.pieces.len())
    }
}

/// Puts a path into time under limits, never stopping where it need not.
///
/// `method`: `time-optimal` (jerk-limited, as fast as curvature, lateral acceleration and turn rate allow), `iascv` (seven-phase S-curves corrected at nodes; see
/// `correct`) or `trapezoid` (no limit of jerk: its acceleration jumps and it passes no certificate; a baseline). `start_yaw` and `goal_yaw` in rad,
/// `start_speed` and `end_speed` in m/s.
///
/// `among` (a query): the motion keeps the query's radius to the movers of its world at all times, by waiting and slowing down, near the earliest arrival; time 0 is
/// that of the movers. With `passive`, a full brake after `latency` (s) ends out of reach of the movers wherever it begins; where no motion has that, it is
/// dropped, and `Trajectory.among` says so. `speed_map` (:class:`SpeedMap`): the motion keeps to its limits. Raises `Infeasible` with the mover and the place where there is no motion.
#[pyfunction]
#[pyo3(signature = (path, limits, *, start_yaw=None, goal_yaw=None, method="time-optimal", start_speed=0.0, end_speed=0.0, among=None, passive=true, latency=0.1, speed_map=None))]
#[expect(clippy::too_many_arguments, reason = "keyword arguments of a Python function")]
pub fn time(
    py: Python<'_>,
    path: &Path,
    limits: &Bound<'_, PyAny>,
    start_yaw: Option<f64>,
    goal_yaw: Option<f64>,
    method: &str,
    start_speed: f64,
    end_speed: f64,
    among: Option<&Query>,
    passive: bool,
    latency: f64,
    speed_map: Option<&SpeedMap>,
) -> PyResult<Trajectory> {
    let limits: Limits = from_python("limits", limits)?;
    let method = Method::named(method).or_py(py)?;
    let (result, raised): (Result<_, PlanError>, _) = watched(py, 0, Budget::default(), 1, None, |ctx| {
        let zones = speed_map.map(|map| |s: f64| map.inner.around(path.inner.planar(s).point));
        let clearance_ceiling = zones.as_ref().map(|f| f as &dyn Fn(f64) -> f64);
        let options = TimingOptions { start_yaw, goal_yaw, method, start_speed, end_speed, clearance_ceiling };
        let Some(query) = among else { return Ok((timing::time(&path.inner, &limits, &options, ctx)?, None)) };
        let around = Among { passive, latency, ..Among::new(query.inner.world.movers(), query.inner.radius()) };
        let timed = movers::among(&path.inner, &limits, &options, &around, ctx)?;
        Ok((timed.trajectory, Some(timed.record)))
    })?;
    raised.map_or(Ok(()), Err)?;
    result.map(|(inner, among)| Trajectory { inner, among }).or_py(py)
}

/// The loop on speed along a path: from the first pass, seven phases over each stretch between stops that know nothing of curvature, to a profile that keeps
/// the speed ceiling.
///
/// A dictionary: `ceiling`, `before`, `after` (rows arc length in m, speed in m/s), `regions_before`, `regions_after` (overspeed regions: `from`, `to`, `worst` in
/// m, `ratio` of speed and ceiling there, `excess` in m), `nodes` (rows arc length in m, speed in m/s, of zero acceleration), `log` (a row per pass: `regions`,
/// `worst`, `nodes`, `duration` in s), `overspeed` (share of the length), `duration` (s) of the motion. `time` with the method `iascv` gives the motion itself.
#[pyfunction]
pub fn correct<'py>(py: Python<'py>, path: &Path, limits: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyAny>> {
    let limits: Limits = from_python("limits", limits)?;
    let (result, raised) = watched(py, 0, Budget::default(), 1, None, |ctx| timing::corrected(&path.inner, &limits, &TimingOptions::default(), ctx))?;
    raised.map_or(Ok(()), Err)?;
    let (trajectory, loops) = result.or_py(py)?;
    let (speed, length) = (timing::SpeedTrace::of(&loops), path.inner.length());
    let nodes: Vec<_> = loops.iter().flat_map(|part| part.corrected.nodes.iter().map(|(s, v)| [part.from + s, *v])).collect();
    let log: Vec<_> = loops.iter().flat_map(|part| &part.corrected.log).collect();
    let mut record = serde_json::json!(speed);
    record["overspeed"] = timing::overspeed(&speed.regions_before, length).into();
    (record["nodes"], record["log"]) = (serde_json::json!(nodes), serde_json::json!(log));
    record["duration"] = trajectory.duration().into();
    to_python(py, &record)
}

/// Speed ceiling along a path, rows (arc length in m, m/s), shape (n, 2).
#[pyfunction]
pub fn ceiling<'py>(py: Python<'py>, path: &Path, limits: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let limits: Limits = from_python("limits", limits)?;
    let rows = timing::ceiling(path.on_the_ground(py)?, &limits.validated().or_py(py)?);
    table(py, &rows.into_iter().flat_map(|(s, v)| [s, v]).collect::<Vec<_>>(), 2)
}

/// Every controller: name, about, source, parameters (name, about, default).
#[pyfunction]
pub fn controllers(py: Python<'_>) -> PyResult<Bound<'_, PyAny>> {
    let rows: Vec<_> = core::CONTROLLERS
        .iter()
        .map(|entry| {
            let parameters = crate::plan::parameter_rows(entry.parameters, &(entry.defaults)());
            serde_json::json!({"name": entry.name, "about": entry.about, "source": entry.source, "parameters": parameters})
        })
        .collect();
    to_python(py, &rows)
}

/// How movers are seen, and whether the map is known.
fn senses(py: Python<'_>, (sense, lidar): (&str, Option<&Bound<'_, PyDict>>), map: &str) -> PyResult<(core::Sense, bool)> {
    let bad = |name: &str, value: &str, allowed: &str| to_py(py, &PlanError::bad(name, value, allowed));
    let lidar = lidar.map_or(Ok(core::Lidar::default()), |l| from_python("lidar", l))?;
    let sense = match sense {
        "truth" => core::Sense::Truth,
        "lidar" => core::Sense::Lidar(lidar.validated().or_py(py)?),
        _ => return Err(bad("sense", sense, "truth or lidar")),
    };
    match map {
        "known" => Ok((sense, true)),
        "none" if matches!(sense, core::Sense::Lidar(_)) => Ok((sense, false)),
        "none" => Err(bad("map", map, "known, where movers are seen as they are (sense truth)")),
        _ => Err(bad("map", map, "known or none")),
    }
}

/// Drives a motion among the movers of the query's world; the record of the run as a dictionary. After Ctrl-C it is partial and says `cancelled`. `plant` is
/// an object with `observe()`, `step(v, w, dt)` and `motion()` (default: the unicycle); what it raises is raised.
#[pyfunction]
#[pyo3(signature = (query, trajectory, controller, *, planner="visibility", seed=0, set=None, arrival=0.1, stop_at_goal=true, time_limit=None, sense="truth", lidar=None, map="known", plant=None, observe=None, trace=false, speed_map=None, mover_speed=None, plan_time=0.0))]
#[expect(clippy::too_many_arguments, reason = "keyword arguments of a Python function")]
pub fn drive<'py>(
    py: Python<'py>,
    query: &Query,
    trajectory: &Trajectory,
    controller: &str,
    planner: &str,
    seed: u64,
    set: Option<&Bound<'py, PyDict>>,
    arrival: f64,
    stop_at_goal: bool,
    time_limit: Option<f64>,
    sense: &str,
    lidar: Option<&Bound<'py, PyDict>>,
    map: &str,
    plant: Option<&Bound<'py, PyAny>>,
    observe: Option<&Bound<'py, PyAny>>,
    trace: bool,
    speed_map: Option<&SpeedMap>,
    mover_speed: Option<f64>,
    plan_time: f64,
) -> PyResult<Bound<'py, PyAny>> {
    let (sense, map_known) = senses(py, (sense, lidar), map)?;
    let parameters = set.map_or(Ok(serde_json::Value::Null), |s| from_python("set", s))?;
    let again = plan::planner(planner, serde_json::Value::Null).or_py(py)?;
    let planning = core::Planning::new(again, trajectory.inner.limits).with_speed_map(speed_map.map(|m| Arc::clone(&m.inner)));
    let replanner = |ask: &core::Ask, ctx: &mut Context<'_>| planning.motion(ask, ctx);
    let mut job = core::Job::new(&query.inner, &trajectory.inner).or_py(py)?;
    (job.arrival, job.stop_at_goal, job.time_limit) = (arrival, stop_at_goal, time_limit);
    job.replanner = Some(&replanner);
    job.delivery = if plan_time == 0.0 { core::Delivery::AtOnce } else { core::Delivery::After(plan_time) };
    job.trace = trace;
    (job.sense, job.map_known, job.mover_speed) = (sense, map_known, mover_speed);
    job.speed_map = speed_map.map(|m| Arc::clone(&m.inner));
    let setup = core::Setup { world: query.inner.world.clone(), robot: job.robot.clone(), clearance: query.inner.clearance };
    let mut controller = core::controller(controller, parameters, &setup).or_py(py)?;
    let mut plant = plant.map(Called::new).transpose()?;
    let (result, raised) = watched(py, seed, Budget::default(), 1, observe, |ctx| match &mut plant {
        Some(plant) => core::execute_on(&job, controller.as_mut(), plant, ctx),
        None => core::execute(&job, controller.as_mut(), ctx),
    })?;
    if let Some(error) = plant.and_then(Called::raised) {
        return Err(error);
    }
    let record = to_python(py, &result.or_py(py)?)?;
    match raised {
        Some(error) if !error.is_instance_of::<pyo3::exceptions::PyKeyboardInterrupt>(py) => Err(error),
        _ => Ok(record),
    }
}
