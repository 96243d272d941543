//! `Pilot`: the two layers for a control loop of one's own.

use crate::convert::{from_python, points, to_python, values};
use crate::errors::{OrPy, to_py};
use crate::motion::Trajectory;
use crate::query::Query;
use crate::speed_map::SpeedMap;
use guideway::Point;
use guideway::context::{Context, stream};
use guideway::drive as core;
use guideway::error::PlanError;
use guideway::plan;
use guideway::world::Footprint;
use numpy::PyArray2;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use serde::Deserialize;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// Drives a robot along a motion in a control loop of your own: perception, planning and control behind `step`.
///
/// It follows `trajectory`, made for `query`, with one of :func:`controllers`; `set` holds the controller's parameters. Where the way is blocked `planner` plans anew.
/// With `lidar` (a dictionary or :class:`Lidar`: beams, `field_of_view` in rad, range in m, noise in m, rate in Hz) steps take scans instead of tracks; with `map="none"` the
/// world of the query gives the bounds only. `mover_speed` (m/s) is the top speed of whatever moves on the site, which no scan can tell (default: guessed from each track). `speed_map` (:class:`SpeedMap`) says how fast may be driven where.
///
/// A step that needs a plan makes it, and takes as long. With `wait=False` no step ever does: where `plan_due` is true another thread is to call :meth:`plan`, and
/// the step after that takes what came of it.
#[pyclass(frozen, module = "guideway")]
pub struct Pilot {
    inner: Mutex<State>,
    lidar: Option<core::Lidar>,
    planning: Arc<core::Planning>,
}

struct State {
    pilot: core::Pilot<'static>,
    seed: u64,
    steps: u64,
}

/// What moves, as Python tells it.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Seen {
    id: Option<usize>,
    position: Point,
    #[serde(default)]
    velocity: Point,
    shape: Footprint,
    bound: Option<f64>,
    #[serde(default)]
    doubt: f64,
}

impl Seen {
    fn track(self, py: Python<'_>, i: usize) -> PyResult<core::Track> {
        let speed = self.velocity[0].hypot(self.velocity[1]);
        let bound = self.bound.unwrap_or(if speed < 0.05 { 0.0 } else { (1.2 * speed).max(1.0) });
        let numbers = [self.position[0], self.position[1], speed, bound, self.doubt];
        if !numbers.iter().all(|v| v.is_finite() && v.abs() <= 1e9) || bound < 0.0 || self.doubt < 0.0 {
            return Err(to_py(py, &PlanError::bad(format!("tracks[{i}]"), "its numbers", "finite ones; bound and doubt 0 or more")));
        }
        let outline = core::Outline::of(&self.shape.validated().or_py(py)?);
        Ok(core::Track { id: self.id.unwrap_or(i), outline, position: self.position, velocity: self.velocity, bound, doubt: self.doubt })
    }
}

impl Pilot {
    fn state(&self) -> MutexGuard<'_, State> {
        self.inner.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The scan that a list of ranges is.
    fn scan(&self, py: Python<'_>, time: f64, ranges: &Bound<'_, PyAny>) -> PyResult<core::Scan> {
        let Some(lidar) = self.lidar else {
            return Err(to_py(py, &PlanError::bad("scan", "given to a pilot without a lidar", "Pilot(..., lidar={...}) first")));
        };
        let (first, step) = lidar.rays();
        Ok(core::Scan { time, first, step, range: lidar.range, ranges: values("scan", ranges)? })
    }
}

#[pymethods]
impl Pilot {
    #[new]
    #[pyo3(signature = (query, trajectory, controller, *, planner="visibility", set=None, seed=0, lidar=None, map="known", speed_map=None, mover_speed=None, wait=true))]
    #[expect(clippy::too_many_arguments, reason = "keyword arguments of a Python constructor")]
    fn new(
        py: Python<'_>,
        query: &Query,
        trajectory: &Trajectory,
        controller: &str,
        planner: &str,
        set: Option<&Bound<'_, PyDict>>,
        seed: u64,
        lidar: Option<&Bound<'_, PyAny>>,
        map: &str,
        speed_map: Option<&SpeedMap>,
        mover_speed: Option<f64>,
        wait: bool,
    ) -> PyResult<Self> {
        let lidar = lidar.map(|l| from_python::<core::Lidar>("lidar", l)).transpose()?;
        let known = match map {
            "known" => true,
            "none" => false,
            other => return Err(to_py(py, &PlanError::bad("map", other, "known or none"))),
        };
        let parameters = set.map_or(Ok(serde_json::Value::Null), |s| from_python("set", s))?;
        let planning = core::Planning::new(plan::planner(planner, serde_json::Value::Null).or_py(py)?, trajectory.inner.limits)
            .with_speed_map(speed_map.map(|m| Arc::clone(&m.inner)));
        let mut job = core::Job::new(&query.inner, &trajectory.inner).or_py(py)?;
        job.sense = lidar.map_or(core::Sense::Truth, core::Sense::Lidar);
        (job.map_known, job.mover_speed) = (known, mover_speed);
        job.speed_map = speed_map.map(|m| Arc::clone(&m.inner));
        let world = if known { Arc::clone(&query.inner.world) } else { Arc::new(query.inner.world.emptied().or_py(py)?) };
        let setup = core::Setup { world, robot: job.robot.clone(), clearance: query.inner.clearance };
        let controller = core::controller(controller, parameters, &setup).or_py(py)?;
        job.delivery = if wait { core::Delivery::AtOnce } else { core::Delivery::Elsewhere };
        let planning = Arc::new(planning);
        let own = Arc::clone(&planning);
        let replanner: Box<core::OwnReplanner<'static>> = Box::new(move |ask, ctx| own.motion(ask, ctx));
        let pilot = core::Pilot::owned(&job, controller, Some(replanner)).or_py(py)?;
        Ok(Self { inner: Mutex::new(State { pilot, seed, steps: 0 }), lidar, planning })
    }

    /// Does the last step ask for a plan that nobody has begun with? Only with `wait=False`.
    #[getter]
    fn plan_due(&self) -> bool {
        self.state().pilot.plan_due()
    }
    /// Makes the plan that is due, if one is, in the thread that calls; steps go on meanwhile. True if one was made, whatever came of it.
    fn plan(&self, py: Python<'_>) -> bool {
        py.detach(|| {
            let Some(request) = self.state().pilot.request() else { return false };
            let found = request.solve(|ask, ctx| self.planning.motion(ask, ctx));
            self.state().pilot.deliver(found);
            true
        })
    }

    /// One control step. `time` in s, `pose` (x, y in m, yaw in rad), `v` in m/s and `w` in rad/s as measured. `tracks` are what moves around: dictionaries with
    /// `position`, `shape` (as in a scene's movers) and, where known, `velocity`, `id`, `bound` (largest speed it may take up, m/s) and `doubt` (m). `scan`
    /// holds the newest ranges in m (infinite: nothing in range, not a number: not measured), from `scan_time` (s, default `time`).
    ///
    /// Returns a dictionary: `v`, `w` to command, `stop` (why, or None), `events` (`t`, `kind`, `reason`), `replanned`, `sub_goal`, `tracks` (rows x, y, radius, vx, vy).
    #[pyo3(signature = (time, pose, v, w, *, tracks=None, scan=None, scan_time=None))]
    #[expect(clippy::too_many_arguments, reason = "keyword arguments of a Python method")]
    fn step<'py>(
        &self,
        py: Python<'py>,
        time: f64,
        pose: [f64; 3],
        v: f64,
        w: f64,
        tracks: Option<Vec<Bound<'py, PyAny>>>,
        scan: Option<&Bound<'py, PyAny>>,
        scan_time: Option<f64>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let mut seen = core::Observation::new(time, pose, v, w);
        for (i, track) in tracks.unwrap_or_default().iter().enumerate() {
            seen.tracks.push(from_python::<Seen>(&format!("tracks[{i}]"), track)?.track(py, i)?);
        }
        let scan = scan.map(|ranges| self.scan(py, scan_time.unwrap_or(time), ranges)).transpose()?;
        let (step, sub_goal) = py.detach(|| {
            let mut state = self.state();
            state.steps += 1;
            // A stream of its own for each step: a context does not travel between threads.
            let mut ctx = Context::new(state.seed);
            ctx.rng = stream(state.seed, state.steps, 0);
            (state.pilot.step(&mut seen, scan, &mut ctx), state.pilot.sub_goal())
        });
        let tracks: Vec<[f64; 5]> =
            seen.tracks.iter().map(|t| [t.position[0], t.position[1], t.outline.circumscribed(), t.velocity[0], t.velocity[1]]).collect();
        let record = serde_json::json!({
            "v": step.command.v, "w": step.command.w, "stop": step.stop, "events": step.events, "replanned": step.replanned, "sub_goal": sub_goal, "tracks": tracks,
        });
        to_python(py, &record)
    }

    /// Share of the planned speed, 0 to 1; changes are driven within the limits of acceleration and jerk.
    #[getter(r#override)]
    fn share(&self) -> f64 {
        self.state().pilot.share()
    }
    #[setter(r#override)]
    fn set_share(&self, py: Python<'_>, share: f64) -> PyResult<()> {
        self.state().pilot.set_share(share).or_py(py)
    }
    /// Stops on the path, within the limits of deceleration and jerk, and stays until :meth:`go`.
    fn stop(&self) {
        self.state().pilot.hold(true);
    }
    /// Goes on after :meth:`stop`.
    fn go(&self) {
        self.state().pilot.hold(false);
    }
    /// New plans so far.
    #[getter]
    fn replans(&self) -> u32 {
        self.state().pilot.replans()
    }
    /// The path that is followed now, m, shape (n, 2), a point every 0.05 m or so.
    #[getter]
    fn path<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let course = Arc::clone(&self.state().pilot.guide().course);
        let n = (course.length() / 0.05).ceil().clamp(1.0, 1e5) as u32;
        let at = |k: u32| course.at_length(course.length() * f64::from(k) / f64::from(n)).pose;
        points(py, &(0..=n).map(|k| [at(k)[0], at(k)[1]]).collect::<Vec<_>>())
    }
    /// Turning points of the path, the goal last, m, shape (n, 2).
    #[getter]
    fn sub_goals<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        points(py, &self.state().pilot.guide().sub_goals)
    }
}
