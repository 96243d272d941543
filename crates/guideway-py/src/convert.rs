//! Records between Rust and Python, by JSON values; points and arrays.

use guideway::error::PlanError;
use numpy::{PyArray2, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::IntoPyDict;
use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::errors::{OrPy, to_py};

/// A serialisable record as plain Python objects.
pub fn to_python<'py>(py: Python<'py>, record: &impl Serialize) -> PyResult<Bound<'py, PyAny>> {
    let text = serde_json::to_string(record).or_py(py)?;
    py.import("json")?.call_method1("loads", (text,))
}

/// Plain Python objects (or dataclass-like ones with `to_dict`) as a record; `name` appears in the error.
pub fn from_python<T: DeserializeOwned>(name: &str, object: &Bound<'_, PyAny>) -> PyResult<T> {
    let py = object.py();
    let plain = if object.hasattr("to_dict")? { object.call_method0("to_dict")? } else { object.clone() };
    let bad = |e: &dyn std::fmt::Display| to_py(py, &PlanError::bad(name, "the value given", e.to_string()));
    let strict = [("allow_nan", false)].into_py_dict(py)?;
    let text: String = py.import("json")?.call_method("dumps", (plain,), Some(&strict)).map_err(|e| bad(&e.value(py)))?.extract()?;
    serde_json::from_str(&text).map_err(|e| bad(&e))
}

/// An (n, 2) float array.
pub fn points<'py>(py: Python<'py>, rows: &[[f64; 2]]) -> PyResult<Bound<'py, PyArray2<f64>>> {
    table(py, rows.as_flattened(), 2)
}

/// An (n, `columns`) float array from rows laid end to end.
pub fn table<'py>(py: Python<'py>, values: &[f64], columns: usize) -> PyResult<Bound<'py, PyArray2<f64>>> {
    numpy::PyArray1::from_slice(py, values).reshape([values.len() / columns.max(1), columns])
}

/// Points from anything array-like of shape (n, 2).
pub fn rows(name: &str, object: &Bound<'_, PyAny>) -> PyResult<Vec<[f64; 2]>> {
    let py = object.py();
    let bad = || to_py(py, &PlanError::bad(name, "the value given", "an array of shape (n, 2) of numbers in m"));
    let array = py.import("numpy")?.call_method1("asarray", (object, "float64")).map_err(|_| bad())?;
    let array = array.cast_into::<PyArray2<f64>>().map_err(|_| bad())?.readonly();
    let view = array.as_array();
    if view.ncols() != 2 {
        return Err(bad());
    }
    Ok(view.rows().into_iter().map(|r| [r[0], r[1]]).collect())
}

/// Numbers from a number or anything array-like of one dimension.
pub fn values(name: &str, object: &Bound<'_, PyAny>) -> PyResult<Vec<f64>> {
    let py = object.py();
    let bad = || to_py(py, &PlanError::bad(name, "the value given", "a number or a one-dimensional array of numbers"));
    let numpy = py.import("numpy")?;
    let array = numpy.call_method1("asarray", (object, "float64")).and_then(|a| numpy.call_method1("atleast_1d", (a,))).map_err(|_| bad())?;
    array.extract().map_err(|_| bad())
}
