//! `Query`.

use crate::convert::from_python;
use crate::errors::{OrPy, to_py};
use crate::world::World;
use guideway::error::PlanError;
use guideway::query::{self, Limits, Material, Soft};
use guideway::world::{Corners, Footprint};
use pyo3::prelude::*;
use std::sync::Arc;

/// From where to where, with which robot, how close to obstacles.
///
/// `start` and `goal` are (x, y) or (x, y, yaw) in m and rad. `corners` defaults by material: standard and heavy touch, long clear.
/// `limits` (:class:`Limits`) are read by planners that plan path and speed at once, such as `aide`; others leave them to :func:`time`.
/// `soft_clearance` is (m, weight): a metre nearer to obstacles than that beyond `clearance` costs up to 1 + weight times; `astar` and `dijkstra` minimise that.
/// `half_width` (m) is that of a long load; with `material="long"` and `clear` every planner keeps off obstacles by at least half a cell.
#[pyclass(frozen, module = "guideway")]
pub struct Query {
    pub inner: query::Query,
    #[pyo3(get)]
    world: Py<World>,
}

#[pymethods]
impl Query {
    #[new]
    #[pyo3(signature = (world, start, goal, *, via=None, footprint=None, clearance=0.0, half_width=0.0, soft_clearance=None, corners=None, material="standard", limits=None))]
    #[expect(clippy::too_many_arguments, reason = "keyword arguments of a Python constructor")]
    #[expect(clippy::needless_pass_by_value, reason = "the binding's extraction hands them over by value")]
    fn new(
        py: Python<'_>,
        world: Py<World>,
        start: Bound<'_, PyAny>,
        goal: Bound<'_, PyAny>,
        via: Option<Vec<[f64; 2]>>,
        footprint: Option<Bound<'_, PyAny>>,
        clearance: f64,
        half_width: f64,
        soft_clearance: Option<(f64, f64)>,
        corners: Option<&str>,
        material: &str,
        limits: Option<Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        let ((start, start_yaw), (goal, goal_yaw)) = (pose("start", &start)?, pose("goal", &goal)?);
        let mut inner = query::Query::new(Arc::clone(&world.get().inner), start, goal);
        (inner.start_yaw, inner.goal_yaw) = (start_yaw, goal_yaw);
        inner.via = via.unwrap_or_default();
        (inner.clearance, inner.half_width) = (clearance, half_width);
        inner.soft = soft_clearance.map(|(clearance, weight)| Soft { clearance, weight }.validated().or_py(py)).transpose()?;
        if let Some(footprint) = footprint {
            inner.footprint = from_python::<Footprint>("footprint", &footprint)?.validated().or_py(py)?;
        }
        inner.material = match material {
            "standard" => Material::Standard,
            "long" => Material::Long,
            "heavy" => Material::Heavy,
            other => return Err(to_py(py, &PlanError::bad("material", other, "one of standard, long, heavy"))),
        };
        if let Some(limits) = limits {
            inner.limits = from_python::<Limits>("limits", &limits)?.validated().or_py(py)?;
        }
        inner.corners = match corners {
            Some(rule) => corner_rule(py, rule)?,
            None if inner.material == Material::Long => Corners::Clear,
            None => Corners::Touch,
        };
        Ok(Self { inner, world })
    }

    /// Start, m.
    #[getter]
    fn start(&self) -> [f64; 2] {
        self.inner.start
    }
    /// Heading at the start, rad, or None.
    #[getter]
    fn start_yaw(&self) -> Option<f64> {
        self.inner.start_yaw
    }
    /// Goal, m.
    #[getter]
    fn goal(&self) -> [f64; 2] {
        self.inner.goal
    }
    /// Heading at the goal, rad, or None.
    #[getter]
    fn goal_yaw(&self) -> Option<f64> {
        self.inner.goal_yaw
    }
    /// Points to pass in order, m.
    #[getter]
    fn via(&self) -> Vec<[f64; 2]> {
        self.inner.via.clone()
    }
    /// Distance to keep between footprint and obstacles, m.
    #[getter]
    fn clearance(&self) -> f64 {
        self.inner.clearance
    }
    /// Half the width of the load, m; it counts for long material.
    #[getter]
    fn half_width(&self) -> f64 {
        self.inner.half_width
    }
    /// Soft clearance (m) and the weight of what is nearer, or None.
    #[getter]
    fn soft_clearance(&self) -> Option<(f64, f64)> {
        self.inner.soft.map(|soft| (soft.clearance, soft.weight))
    }
    /// Footprint as a dictionary.
    #[getter]
    fn footprint<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        crate::convert::to_python(py, &self.inner.footprint)
    }
    /// touch, clear or squeeze.
    #[getter]
    fn corners<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        crate::convert::to_python(py, &self.inner.corners)
    }
    /// standard, long or heavy.
    #[getter]
    fn material<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        crate::convert::to_python(py, &self.inner.material)
    }
    /// What a motion may do, as a dictionary; read by planners that plan path and speed at once.
    #[getter]
    fn limits<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        crate::convert::to_python(py, &self.inner.limits)
    }
    /// Radius of the disc that planners keep free around the reference point, m.
    #[getter]
    fn radius(&self) -> f64 {
        self.inner.radius()
    }
    /// Raises what is wrong with the query, if anything.
    fn validate(&self, py: Python<'_>) -> PyResult<()> {
        self.inner.validate().or_py(py)
    }
    fn __repr__(&self) -> String {
        let q = &self.inner;
        format!("Query({:?} -> {:?}, radius {} m, {:?}, {:?})", q.start, q.goal, q.radius(), q.corners, q.material)
    }
}

/// A corner rule by name.
pub fn corner_rule(py: Python<'_>, name: &str) -> PyResult<Corners> {
    match name {
        "touch" => Ok(Corners::Touch),
        "clear" => Ok(Corners::Clear),
        "squeeze" => Ok(Corners::Squeeze),
        other => Err(to_py(py, &PlanError::bad("corners", other, "one of touch, clear, squeeze"))),
    }
}

fn pose(name: &str, object: &Bound<'_, PyAny>) -> PyResult<([f64; 2], Option<f64>)> {
    if let Ok((x, y)) = object.extract::<(f64, f64)>() {
        return Ok(([x, y], None));
    }
    if let Ok([x, y, yaw]) = object.extract::<[f64; 3]>() {
        return Ok(([x, y], Some(yaw)));
    }
    if let Ok([x, y]) = object.extract::<[f64; 2]>() {
        return Ok(([x, y], None));
    }
    let shown = object.repr().map_or_else(|_| "?".into(), |r| r.to_string());
    Err(to_py(object.py(), &PlanError::bad(name, shown, "(x, y) or (x, y, yaw) in m and rad")))
}
