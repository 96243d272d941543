//! A Python function as an objective.

use guideway::error::PlanError;
use guideway::optimize::{Cost, Objective};
use numpy::{PyArray1, PyArray2, PyArrayMethods};
use pyo3::prelude::*;
use pyo3::types::{PyFloat, PyTuple};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

/// Most numbers of a candidate that an error shows.
const SHOWN: usize = 20;

/// A Python function in its box.
pub struct Called {
    f: Py<PyAny>,
    /// `numpy.asarray`
    asarray: Py<PyAny>,
    vectorized: bool,
    bounds: Vec<(f64, f64)>,
    hints: Vec<Vec<f64>>,
    raised: Mutex<Option<PyErr>>,
    /// How long a call took lately, us, as bits.
    effort: AtomicU64,
}

/// Why there are no costs.
enum Failure {
    Raised(PyErr),
    Bad(PlanError),
}

impl From<PyErr> for Failure {
    fn from(error: PyErr) -> Self {
        Self::Raised(error)
    }
}

impl Called {
    pub fn new(py: Python<'_>, f: &Bound<'_, PyAny>, vectorized: bool, bounds: Vec<(f64, f64)>, hints: Vec<Vec<f64>>) -> PyResult<Self> {
        let asarray = py.import("numpy")?.getattr("asarray")?.unbind();
        let effort = AtomicU64::new(1000.0f64.to_bits());
        Ok(Self { f: f.clone().unbind(), asarray, vectorized, bounds, hints, raised: Mutex::new(None), effort })
    }

    /// What the function raised.
    pub fn raised(&self) -> Option<PyErr> {
        self.raised.lock().unwrap_or_else(PoisonError::into_inner).take()
    }

    /// One call for each.
    fn each(&self, py: Python<'_>, xs: &[Vec<f64>]) -> Result<Vec<Cost>, Failure> {
        let f = self.f.bind(py);
        xs.iter().map(|x| judged(&f.call1((PyArray1::from_slice(py, x),))?, x)).collect()
    }

    /// One call for all.
    fn at_once(&self, py: Python<'_>, xs: &[Vec<f64>]) -> Result<Vec<Cost>, Failure> {
        let wrong =
            |what: String| Failure::Bad(PlanError::bad("f(X)", what, format!("shape ({0},), or two of them: values and violations", xs.len())));
        let columns = |answer: &Bound<'_, PyAny>| -> Result<Vec<f64>, Failure> {
            let array = self.asarray.bind(py).call1((answer, "float64")).map_err(|_| wrong(answer.get_type().to_string()))?;
            let shape = array.getattr("shape")?.to_string();
            match array.cast_into::<PyArray1<f64>>() {
                Ok(array) if array.len()? == xs.len() => Ok(array.readonly().as_array().to_vec()),
                _ => Err(wrong(format!("an array of shape {shape}"))),
            }
        };
        let table: Bound<'_, PyArray2<f64>> = PyArray1::from_vec(py, xs.concat()).reshape([xs.len(), self.bounds.len()])?;
        let answer = self.f.bind(py).call1((table,))?;
        let (values, violations) = match answer.cast::<PyTuple>() {
            Ok(two) if two.len() == 2 => (columns(&two.get_item(0)?)?, columns(&two.get_item(1)?)?),
            _ => (columns(&answer)?, vec![0.0; xs.len()]),
        };
        values.into_iter().zip(violations).zip(xs).map(|((value, violation), x)| cost(value, violation, x)).collect()
    }
}

impl Objective for Called {
    fn bounds(&self) -> &[(f64, f64)] {
        &self.bounds
    }

    fn costs(&self, xs: &[Vec<f64>]) -> Result<Vec<Cost>, PlanError> {
        let begun = Instant::now();
        let costs = Python::attach(|py| if self.vectorized { self.at_once(py, xs) } else { self.each(py, xs) });
        let each = begun.elapsed().as_secs_f64() * 1e6 / xs.len().max(1) as f64;
        self.effort.store(each.max(1e-3).to_bits(), Ordering::Relaxed);
        costs.map_err(|failure| match failure {
            Failure::Bad(error) => error,
            Failure::Raised(error) => {
                self.raised.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(error);
                PlanError::Cancelled
            }
        })
    }

    fn hints(&self) -> &[Vec<f64>] {
        &self.hints
    }

    fn effort(&self) -> f64 {
        if self.vectorized { 0.0 } else { f64::from_bits(self.effort.load(Ordering::Relaxed)) }
    }
}

/// The cost that an answer for one candidate means.
fn judged(answer: &Bound<'_, PyAny>, x: &[f64]) -> Result<Cost, Failure> {
    if let Ok(number) = answer.cast::<PyFloat>() {
        return cost(number.value(), 0.0, x);
    }
    let two = answer.cast::<PyTuple>().ok().and_then(|two| two.extract::<(f64, f64)>().ok());
    if let Some((value, violation)) = two {
        return cost(value, violation, x);
    }
    if let Ok(value) = answer.extract::<f64>() {
        return cost(value, 0.0, x);
    }
    let shape = answer.getattr("shape").map_or_else(|_| String::new(), |shape| format!(" of shape {shape}"));
    let name = answer.get_type().name().map_or_else(|_| "something else".into(), |name| name.to_string());
    Err(Failure::Bad(PlanError::bad("f(x)", format!("{name}{shape}"), "a number, or (value, violation)")))
}

fn cost(value: f64, violation: f64, x: &[f64]) -> Result<Cost, Failure> {
    if value == f64::INFINITY || violation == f64::INFINITY {
        return Ok(Cost { violation: f64::MAX, value: f64::MAX, tie: 0.0 });
    }
    if value.is_finite() && violation >= 0.0 {
        return Ok(Cost { violation, value, tie: 0.0 });
    }
    let more = if x.len() > SHOWN { ", ..." } else { "" };
    let numbers = x.iter().take(SHOWN).map(|v| format!("{v:?}")).collect::<Vec<_>>().join(", ");
    let (name, bad) = if violation >= 0.0 { ("f(x)", value) } else { ("violation of f(x)", violation) };
    Err(Failure::Bad(PlanError::bad(name, bad, format!("a number, no negative violation. x = [{numbers}{more}]"))))
}
