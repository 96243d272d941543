//! Certificates and exact references.

use crate::convert::to_python;
use crate::errors::{OrPy, to_py};
use crate::motion::Trajectory;
use crate::path::Path;
use crate::plan::{Solution, watched};
use crate::query::Query;
use crate::speed_map::SpeedMap;
use guideway::certify::{self as checker, Check, motion};
use guideway::context::{Budget, Stop};
use guideway::error::PlanError;
use guideway::plan::search;
use guideway::world::shape::distance;
use pyo3::prelude::*;
use serde_json::json;

/// Checks a path, and the motion along it, with code that shares nothing with planners, smoother and timing.
///
/// Returns `ok`, `collision_free`, `step` (m), `min_clearance` (m) and `checks`: name, ok, worst, limit, at. A curvature above `max_curvature` (1/m) is
/// reported in its check (`reported` true) and does not make the certificate fail: there is not always room for a gentle bend.
#[pyfunction]
#[pyo3(signature = (path, query, trajectory=None, *, max_curvature=None, step=None, speed_map=None))]
pub fn certify<'py>(
    py: Python<'py>,
    path: &Path,
    query: &Query,
    trajectory: Option<&Trajectory>,
    max_curvature: Option<f64>,
    step: Option<f64>,
    speed_map: Option<&SpeedMap>,
) -> PyResult<Bound<'py, PyAny>> {
    let (path, query) = (path.on_the_ground(py)?, &query.inner);
    if !(0.0..=1e6).contains(&query.clearance) {
        return Err(to_py(py, &PlanError::bad("clearance", query.clearance, "0 to 1e6 m")));
    }
    for (name, value) in [("step", step), ("max_curvature", max_curvature)] {
        if let Some(value) = value.filter(|v| !(v.is_finite() && *v > 0.0)) {
            return Err(to_py(py, &PlanError::bad(name, value, "a finite number above 0")));
        }
    }
    if trajectory.is_some_and(|motion| motion.inner.path != *path) {
        return Err(to_py(py, &PlanError::bad("trajectory", "it follows another path", "a motion along the path that is certified")));
    }
    let (collision, marking, mut checks) = py.detach(|| {
        let (collision, marking) = (checker::collision(path, query, step), checker::marking(path, query, step));
        let mut checks = vec![ends(path, query)];
        if let Some(motion) = trajectory {
            let asked = motion::Asked { start_yaw: query.start_yaw, goal_yaw: query.goal_yaw, ..motion::Asked::default() };
            checks.extend(motion::motion(&motion.inner, &asked));
            checks.extend(speed_map.map(|map| checker::zones(&motion.inner, &map.inner)));
        }
        (collision, marking, checks)
    });
    let gap = json!({"name": "clearance", "ok": collision.ok, "worst": collision.min_clearance, "limit": query.clearance, "at": null});
    let ok = collision.ok && marking.as_ref().is_none_or(|m| m.ok) && checks.iter().all(|check| check.ok);
    let mut rows = vec![gap];
    rows.extend(marking.map(|m| json!({"name": "security marking", "ok": m.ok, "worst": m.min_clearance, "limit": query.radius(), "at": null})));
    rows.extend(checks.drain(..).map(|check| json!(check)));
    if max_curvature.is_some() {
        let mut row = json!(checker::curvature(path, max_curvature));
        row["reported"] = json!(true);
        rows.push(row);
    }
    to_python(
        py,
        &json!({"ok": ok, "collision_free": collision.ok, "step": collision.step, "samples": collision.samples,
                "min_clearance": collision.min_clearance, "worst": collision.worst, "checks": rows}),
    )
}

/// Does the path start and end where it should, and pass every via point?
fn ends(path: &guideway::path::Path, query: &guideway::query::Query) -> Check {
    let mut check = Check::below("path ends", Some(0.0));
    check.see(distance(path.planar(0.0).point, query.start), 0.0, 1e-9);
    check.see(distance(path.planar(path.length()).point, query.goal), path.length(), 1e-9);
    let mut from = 0.0;
    for via in &query.via {
        let (s, _) = path.project(*via, from, path.length() - from);
        check.see(distance(path.planar(s).point, *via), s, 1e-6);
        from = s;
    }
    check
}

/// The exact optima of the solution's own model and its gaps to them; None where there is no exact reference.
#[pyfunction]
#[pyo3(signature = (query, solution, *, observe=None))]
pub fn reference<'py>(py: Python<'py>, query: &Query, solution: &Solution, observe: Option<&Bound<'py, PyAny>>) -> PyResult<Bound<'py, PyAny>> {
    let (inner, cost, lattice) = (&query.inner, solution.inner.length(), solution.inner.cells.is_some());
    let known = (solution.planner == "visibility" && solution.inner.stop != Stop::Cancelled).then(|| solution.inner.clone());
    let (result, raised) = watched(py, 0, Budget::default(), 1, observe, |ctx| {
        let reference = search::reference(inner, cost, known, ctx)?;
        Ok::<_, PlanError>((reference, crate::exact::beside_length(inner, &solution.inner, ctx)?))
    })?;
    raised.map_or(Ok(()), Err)?;
    let (reference, beside) = result.or_py(py)?;
    let gap = |optimum: Option<f64>| optimum.map(|best| search::gap(cost, best)).transpose().or_py(py);
    let grid = reference.grid_optimum.filter(|_| lattice);
    to_python(
        py,
        &json!({"grid_optimum": reference.grid_optimum, "grid_gap": gap(grid)?, "grid_turns": beside["grid_turns"], "grid_energy": beside["grid_energy"],
                "grid_energy_gap": beside["grid_energy_gap"], "any_angle_optimum": reference.any_angle_optimum,
                "any_angle_gap": gap(reference.any_angle_optimum)?, "any_angle_bound": reference.any_angle_bound, "proved": reference.proved,
                "path": reference.any_angle_path.map(|path| path.points())}),
    )
}
