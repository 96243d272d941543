//! Rust errors to Python exceptions.

use guideway::error::PlanError;
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;

/// The exception of `guideway.errors` with the error's name, message and values.
pub fn to_py(py: Python<'_>, error: &PlanError) -> PyErr {
    build(py, error).unwrap_or_else(|e| e)
}

fn build(py: Python<'_>, error: &PlanError) -> PyResult<PyErr> {
    let class = py.import("guideway.errors")?.getattr(error.name())?;
    let instance = class.call1((error.to_string(),))?;
    let set = |name: &str, value: Bound<'_, PyAny>| instance.setattr(name, value);
    match error {
        PlanError::StartBlocked { point, clearance, needed } | PlanError::GoalBlocked { point, clearance, needed } => {
            set("point", point.into_pyobject(py)?.into_any())?;
            set("clearance", clearance.into_pyobject(py)?.into_any())?;
            set("needed", needed.into_pyobject(py)?.into_any())?;
        }
        PlanError::OutsideMap { what, point, bounds } => {
            set("what", what.into_pyobject(py)?.into_any())?;
            set("point", point.into_pyobject(py)?.into_any())?;
            set("bounds", bounds.into_pyobject(py)?.into_any())?;
        }
        PlanError::NoPath(no) => {
            set("proved", no.proved.into_pyobject(py)?.to_owned().into_any())?;
            set("needed", no.needed.into_pyobject(py)?.into_any())?;
            set("widest", no.widest.into_pyobject(py)?.into_any())?;
            set("narrowest", no.narrowest.into_pyobject(py)?.into_any())?;
            set("reason", no.reason.clone().into_pyobject(py)?.into_any())?;
        }
        PlanError::BadParameter { name, value, allowed } => {
            set("name", name.into_pyobject(py)?.into_any())?;
            set("value", value.into_pyobject(py)?.into_any())?;
            set("allowed", allowed.into_pyobject(py)?.into_any())?;
        }
        PlanError::Infeasible { reason, best_end_speed } => {
            set("reason", reason.into_pyobject(py)?.into_any())?;
            set("best_end_speed", best_end_speed.into_pyobject(py)?.into_any())?;
        }
        PlanError::CertificateFailed { stage, detail } => {
            set("stage", stage.into_pyobject(py)?.into_any())?;
            set("detail", detail.into_pyobject(py)?.into_any())?;
        }
        PlanError::Cancelled => {}
    }
    Ok(PyErr::from_value(instance))
}

/// `?` on core results.
pub trait OrPy<T> {
    /// Turns the error into its Python exception.
    fn or_py(self, py: Python<'_>) -> PyResult<T>;
}

impl<T> OrPy<T> for Result<T, PlanError> {
    fn or_py(self, py: Python<'_>) -> PyResult<T> {
        self.map_err(|e| to_py(py, &e))
    }
}

impl<T> OrPy<T> for serde_json::Result<T> {
    fn or_py(self, _py: Python<'_>) -> PyResult<T> {
        self.map_err(|e| PyRuntimeError::new_err(format!("internal record does not convert: {e}")))
    }
}
