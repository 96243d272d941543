//! `minimize`, `Minimum` and the registry of optimizers.

use crate::convert::{from_python, table, to_python};
use crate::errors::{OrPy, to_py};
use crate::objective::Called;
use crate::plan::{parameter_rows, watched};
use guideway::context::Budget;
use guideway::error::PlanError;
use guideway::optimize::functions::{Function, Shifted};
use guideway::optimize::{self as core, Cost, Objective};
use numpy::{PyArray1, PyArray2, PyArrayMethods, PyUntypedArrayMethods};
use pyo3::exceptions::PyKeyboardInterrupt;
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// What an optimizer found.
#[pyclass(frozen, module = "guideway")]
pub struct Minimum {
    inner: core::Minimum,
    #[pyo3(get)]
    method: String,
    #[pyo3(get)]
    seed: u64,
}

#[pymethods]
impl Minimum {
    /// The best candidate, shape (d,).
    #[getter]
    fn x<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_slice(py, &self.inner.best)
    }
    /// Its value; infinite if nothing was costed.
    #[getter]
    fn value(&self) -> f64 {
        shown(self.inner.cost)[0]
    }
    /// How far it breaks constraints, 0 if they hold; infinite where `f` was infinite.
    #[getter]
    fn violation(&self) -> f64 {
        shown(self.inner.cost)[1]
    }
    /// (iteration, value, violation) at each improvement, shape (n, 3); iteration 0 is the first population.
    #[getter]
    fn history<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let rows: Vec<f64> = self.inner.history.iter().flat_map(|(i, c)| [&[*i as f64][..], &shown(*c)].concat()).collect();
        table(py, &rows, 3)
    }
    /// Calls of `f`: candidates costed.
    #[getter]
    fn evaluations(&self) -> u64 {
        self.inner.evaluations
    }
    /// Iterations after the first population.
    #[getter]
    fn iterations(&self) -> u64 {
        self.inner.iterations
    }
    /// Why it stopped: converged, budget or cancelled.
    #[getter]
    fn stop<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        to_python(py, &self.inner.stop)
    }
    /// The last population, shape (n, d).
    #[getter]
    fn population<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let columns = self.inner.population.first().map_or(0, Vec::len);
        table(py, &self.inner.population.concat(), columns)
    }
    /// (value, violation) of the last population, shape (n, 2); infinite for those that the budget left out.
    #[getter]
    fn costs<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        table(py, &self.inner.costs.iter().flat_map(|c| shown(*c)).collect::<Vec<_>>(), 2)
    }
    fn __repr__(&self) -> String {
        let [value, violation] = shown(self.inner.cost);
        let broken = if violation > 0.0 { format!(", violation {violation:.6}") } else { String::new() };
        format!("Minimum({}: {value:.6e}{broken}, {:?}, {} evaluations)", self.method, self.inner.stop, self.inner.evaluations)
    }
}

/// Value and violation; the largest number stands for what `f` called infinite.
fn shown(cost: Cost) -> [f64; 2] {
    if cost.violation == f64::MAX { [f64::INFINITY; 2] } else { [cost.value, cost.violation] }
}

/// Minimises `f` inside `bounds`, a sequence of (low, high), one pair for each of the d numbers.
///
/// `f(x)`, x of shape (d,), returns a float or (value, violation); with `vectorized`, `f(X)`, X of shape (n, d), returns shape (n,) or two of them. A violation
/// above 0 says that constraints are broken and how far: feasible candidates come first. An infinite value means that x is not allowed. `f` may also be
/// the name of a compiled test function: sphere, rosenbrock, rastrigin, ackley, griewank.
/// `budget` is a number of evaluations or a Budget; what changes along a run ends with it. `set` holds the method's parameters, see `optimizers`. `hints` are
/// known good candidates, shape (d,) or (n, d). `observe` is called with a dictionary (iteration, evaluations, best, share, seconds) every few milliseconds
/// and returns true to stop. With `threads` above 1, `f` is called from several threads. The result depends on seed and budget alone.
/// An exception in `f` ends the run and is raised as it is. Ctrl-C raises `KeyboardInterrupt` whose attribute `minimum` holds what was found so far, or None.
#[pyfunction]
#[pyo3(signature = (f, bounds, method="l-shade", *, seed=0, budget=None, set=None, vectorized=false, hints=None, observe=None, threads=1))]
#[expect(clippy::too_many_arguments, reason = "keyword arguments of a Python function")]
pub fn minimize(
    py: Python<'_>,
    f: &Bound<'_, PyAny>,
    bounds: &Bound<'_, PyAny>,
    method: &str,
    seed: u64,
    budget: Option<&Bound<'_, PyAny>>,
    set: Option<&Bound<'_, PyDict>>,
    vectorized: bool,
    hints: Option<&Bound<'_, PyAny>>,
    observe: Option<&Bound<'_, PyAny>>,
    threads: usize,
) -> PyResult<Minimum> {
    let parameters = set.map_or(Ok(serde_json::Value::Null), |s| from_python("set", s))?;
    let optimizer = core::optimizer(method, parameters).or_py(py)?;
    let budget = spend(py, budget)?;
    let bounds: Vec<(f64, f64)> = matrix("bounds", bounds, Some(2))?.iter().map(|b| (b[0], b[1])).collect();
    let hints = hints.map_or(Ok(Vec::new()), |h| matrix("hints", h, Some(bounds.len())))?;
    let called = Called::new(py, f, vectorized, bounds, hints)?;
    let compiled = compiled(f, &called)?;
    let objective: &dyn Objective = compiled.as_ref().map_or(&called, |c| c);
    let (result, raised) = watched(py, seed, budget, threads, observe, |ctx| optimizer.minimize(objective, ctx))?;
    let wrap = |inner| Minimum { inner, method: method.to_owned(), seed };
    if let Some(error) = called.raised().or(raised) {
        if error.is_instance_of::<PyKeyboardInterrupt>(py) {
            let found = result.ok().filter(|m| !m.best.is_empty()).map(wrap).map(|m| Py::new(py, m)).transpose()?;
            error.value(py).setattr("minimum", found)?;
        }
        return Err(error);
    }
    result.map(wrap).or_py(py)
}

/// A test function that is asked for by its name, in the box and with the hints of the caller.
fn compiled(f: &Bound<'_, PyAny>, called: &Called) -> PyResult<Option<Shifted>> {
    let py = f.py();
    if let Ok(name) = f.extract::<String>() {
        let function = Function::named(&name).or_py(py)?;
        return Ok(Some(Shifted::inside(function, called.bounds().to_vec()).with_hints(called.hints().to_vec())));
    }
    if f.is_callable() {
        return Ok(None);
    }
    Err(to_py(py, &PlanError::bad("f", f.get_type(), "a function, or the name of a compiled one")))
}

/// A budget from a number of evaluations or a record.
fn spend(py: Python<'_>, budget: Option<&Bound<'_, PyAny>>) -> PyResult<Budget> {
    let allowed = "a number of evaluations above 0, or a Budget with iterations, evaluations or seconds above 0";
    let bad = |value: String| to_py(py, &PlanError::bad("budget", value, allowed));
    let Some(given) = budget else { return Err(bad("None".into())) };
    let budget = match given.extract::<u64>() {
        Ok(count) => Budget { evaluations: Some(count), ..Budget::default() },
        Err(_) if given.extract::<f64>().is_ok() => return Err(bad(given.to_string())),
        Err(_) => from_python("budget", given)?,
    };
    let none = budget == Budget::default();
    let zero = budget.iterations == Some(0) || budget.evaluations == Some(0) || budget.seconds == Some(0.0);
    if none || zero { Err(bad(given.to_string())) } else { Ok(budget) }
}

/// Rows of numbers from anything array-like of two dimensions (or one: a single row).
fn matrix(name: &str, object: &Bound<'_, PyAny>, columns: Option<usize>) -> PyResult<Vec<Vec<f64>>> {
    let py = object.py();
    let wanted = columns.map_or_else(|| "d".to_owned(), |c| c.to_string());
    let bad = |what: String| to_py(py, &PlanError::bad(name, what, format!("numbers of shape (n, {wanted})")));
    let array = py.import("numpy")?.call_method1("asarray", (object, "float64")).map_err(|_| bad("the value given".into()))?;
    let shape: Vec<usize> = array.getattr("shape")?.extract()?;
    let array = if shape.len() == 1 && name == "hints" { array.call_method1("reshape", ((1, shape[0]),))? } else { array };
    let array = array.cast_into::<PyArray2<f64>>().map_err(|_| bad(format!("shape {shape:?}")))?;
    if columns.is_some_and(|c| c != array.shape()[1]) {
        return Err(bad(format!("shape {shape:?}")));
    }
    Ok(array.readonly().as_array().rows().into_iter().map(|r| r.to_vec()).collect())
}

/// Every optimizer: name, about, source, parameters (name, about, default).
#[pyfunction]
pub fn optimizers(py: Python<'_>) -> PyResult<Bound<'_, PyAny>> {
    let rows: Vec<_> = core::REGISTRY
        .iter()
        .map(|entry| {
            let parameters = parameter_rows(entry.parameters, &(entry.defaults)());
            serde_json::json!({"name": entry.name, "about": entry.about, "source": entry.source, "parameters": parameters})
        })
        .collect();
    to_python(py, &rows)
}
