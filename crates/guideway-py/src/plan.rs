//! `plan`, `Solution` and the registry.

use crate::convert::{from_python, points, table, to_python};
use crate::errors::{OrPy, to_py};
use crate::exact;
use crate::path::Path;
use crate::query::Query;
use guideway::context::{Budget, Context, Progress};
use guideway::error::PlanError;
use guideway::plan as core;
use numpy::PyArray2;
use pyo3::exceptions::PyKeyboardInterrupt;
use pyo3::prelude::*;
use pyo3::types::PyDict;

/// What a planner returned.
#[pyclass(frozen, module = "guideway")]
pub struct Solution {
    pub inner: core::Solution,
    #[pyo3(get)]
    pub query: Py<Query>,
    #[pyo3(get)]
    pub planner: String,
    #[pyo3(get)]
    pub seed: u64,
    /// The exact path stands here instead of what the planner found.
    #[pyo3(get)]
    pub fallback: bool,
    /// What the planner found, where the exact path stands here instead; None also if it found nothing.
    #[pyo3(get)]
    pub heuristic: Option<Py<Solution>>,
}

#[pymethods]
impl Solution {
    /// The planner's raw path.
    #[getter]
    fn path(&self) -> Path {
        Path { inner: self.inner.path.clone() }
    }
    /// Cells (column, row) of a lattice planner, row 0 on top, shape (n, 2), or None.
    #[getter]
    fn cells<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyArray2<f64>>>> {
        let top = self.query.get().inner.world.cells()[1] - 1;
        self.inner
            .cells
            .as_ref()
            .map(|cells| points(py, &cells.iter().map(|c| [f64::from(c[0]), f64::from(top - c[1])]).collect::<Vec<_>>()))
            .transpose()
    }
    /// Centres of the cells of a lattice planner, m, shape (n, 2), or None.
    #[getter]
    fn grid_path<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyArray2<f64>>>> {
        let world = &self.query.get().inner.world;
        let center = |c: &[u32; 2]| world.cell_to_map([f64::from(c[0]) + 0.5, f64::from(c[1]) + 0.5]);
        self.inner.cells.as_ref().map(|cells| points(py, &cells.iter().map(center).collect::<Vec<_>>())).transpose()
    }
    /// The motion, for planners that plan path and speed at once, else None.
    #[getter]
    fn trajectory(&self) -> Option<crate::motion::Trajectory> {
        self.inner.trajectory.clone().map(|inner| crate::motion::Trajectory { inner, among: None })
    }
    /// Length of the raw path, m.
    #[getter]
    fn length(&self) -> f64 {
        self.inner.length()
    }
    /// Cost in the planner's own model: its length in m, or the value of its objective where the trace describes one.
    #[getter]
    fn cost(&self) -> f64 {
        self.inner.cost
    }
    /// Why it stopped: converged, budget or cancelled.
    #[getter]
    fn stop<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        to_python(py, &self.inner.stop)
    }
    /// Iterations of the method's loop (expansions for searches).
    #[getter]
    fn iterations(&self) -> u64 {
        self.inner.iterations
    }
    /// Candidates costed.
    #[getter]
    fn evaluations(&self) -> u64 {
        self.inner.evaluations
    }
    /// Wall-clock time of the call, s.
    #[getter]
    fn seconds(&self) -> f64 {
        self.inner.seconds
    }
    /// (iteration, best cost) at each improvement, shape (n, 2).
    #[getter]
    fn history<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        table(py, &self.inner.history.iter().flat_map(|&(i, c)| [i as f64, c]).collect::<Vec<_>>(), 2)
    }
    /// The planner's trace for pictures.
    #[getter]
    fn trace<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        to_python(py, &self.inner.trace)
    }
    fn __repr__(&self) -> String {
        format!(
            "Solution({}: cost {:.6}, {:?}, {} iterations, {:.6} s)",
            self.planner, self.inner.cost, self.inner.stop, self.inner.iterations, self.inner.seconds
        )
    }
}

/// Plans a path for the query.
///
/// `set` holds the planner's parameters; `budget` has `iterations`, `evaluations`, `seconds`; `observe` is called with a dictionary
/// (iteration, evaluations, best, share, seconds) every few milliseconds and returns true to stop. `previous` is a solution of the same planner whose
/// memory is used where the world or the start has changed since (the colonies repair their way with the pheromone they kept). With `exact_fallback` the
/// result of a lattice planner that is worse than the exact path (shortest, for heavy loads of the least energy) is replaced by that path: `Solution.fallback` is
/// true then and `Solution.heuristic` what the planner found. Ctrl-C raises `KeyboardInterrupt` whose
/// attribute `solution` holds what was found so far, or None.
#[pyfunction]
#[pyo3(signature = (query, planner="visibility", *, seed=0, budget=None, set=None, observe=None, threads=1, previous=None, exact_fallback=false))]
#[expect(clippy::too_many_arguments, reason = "keyword arguments of a Python function")]
pub fn plan(
    py: Python<'_>,
    query: &Bound<'_, Query>,
    planner: &str,
    seed: u64,
    budget: Option<&Bound<'_, PyAny>>,
    set: Option<&Bound<'_, PyDict>>,
    observe: Option<&Bound<'_, PyAny>>,
    threads: usize,
    previous: Option<&Bound<'_, Solution>>,
    exact_fallback: bool,
) -> PyResult<Solution> {
    let parameters = set.map_or(Ok(serde_json::Value::Null), |s| from_python("set", s))?;
    let method = core::planner(planner, parameters).or_py(py)?;
    if exact_fallback {
        exact::needs_lattice(py, planner)?;
    }
    let budget: Budget = budget.map_or(Ok(Budget::default()), |b| from_python("budget", b))?;
    let inner = &query.get().inner;
    let previous = previous.map(|solution| &solution.get().inner);
    let (result, raised) = watched(py, seed, budget, threads, observe, |ctx| match previous {
        Some(previous) => method.replan(previous, inner, ctx),
        None => method.plan(inner, ctx),
    })?;
    let wrap = |inner| Solution { inner, query: query.clone().unbind(), planner: planner.to_owned(), seed, fallback: false, heuristic: None };
    if let Some(error) = raised {
        if error.is_instance_of::<PyKeyboardInterrupt>(py) {
            let found = result.ok().map(wrap).map(|s| Py::new(py, s)).transpose()?;
            error.value(py).setattr("solution", found)?;
        }
        return Err(error);
    }
    if exact_fallback {
        return exact::instead(result.map(wrap), query, (planner, seed), observe);
    }
    result.map(wrap).or_py(py)
}

/// Runs `work` without the GIL, polling for Ctrl-C and calling the observer; returns what either of them raised beside the result.
pub fn watched<T: Send>(
    py: Python<'_>,
    seed: u64,
    budget: Budget,
    threads: usize,
    observe: Option<&Bound<'_, PyAny>>,
    work: impl FnOnce(&mut Context<'_>) -> T + Send,
) -> PyResult<(T, Option<PyErr>)> {
    let observe = observe.map(|o| o.clone().unbind());
    let mut raised = None;
    let mut observer = |progress: &Progress| {
        let asked = Python::attach(|py| {
            py.check_signals()?;
            let Some(observe) = &observe else { return Ok(false) };
            observe.call1(py, (shown(py, progress)?,))?.is_truthy(py)
        });
        asked.unwrap_or_else(|error| {
            raised = Some(error);
            true
        })
    };
    let result = py.detach(|| -> Result<T, PlanError> {
        let mut ctx = Context::new(seed).with_budget(budget)?.with_threads(threads).with_observer(&mut observer);
        Ok(work(&mut ctx))
    });
    match result {
        Ok(value) => Ok((value, raised)),
        Err(error) => Err(to_py(py, &error)),
    }
}

fn shown<'py>(py: Python<'py>, progress: &Progress) -> PyResult<Bound<'py, PyDict>> {
    let shown = PyDict::new(py);
    shown.set_item("iteration", progress.iteration)?;
    shown.set_item("evaluations", progress.evaluations)?;
    shown.set_item("best", progress.best)?;
    shown.set_item("share", progress.share)?;
    shown.set_item("seconds", progress.seconds)?;
    Ok(shown)
}

/// Every parameter of a planner by name: those given in `set`, the others as its preset has them. Raises `BadParameter` for unknown ones.
///
/// With a query also those that `preset=recommended` names for its map.
#[pyfunction]
#[pyo3(signature = (planner, set=None, query=None))]
pub fn parameters<'py>(py: Python<'py>, planner: &str, set: Option<&Bound<'py, PyDict>>, query: Option<&Query>) -> PyResult<Bound<'py, PyAny>> {
    let given = set.map_or(Ok(serde_json::Value::Null), |s| from_python("set", s))?;
    let all = match query {
        Some(query) => core::parameters_for(planner, given, &query.inner),
        None => core::parameters(planner, given),
    };
    to_python(py, &all.or_py(py)?)
}

/// Parameters that are better than the defaults of a planner on the map of a query; empty where the defaults are the best that is known.
///
/// The same as `set={"preset": "recommended"}`. Raises `BadParameter` for an unknown planner.
#[pyfunction]
pub fn recommended<'py>(py: Python<'py>, planner: &str, query: &Query) -> PyResult<Bound<'py, PyAny>> {
    core::parameters(planner, serde_json::Value::Null).or_py(py)?;
    to_python(py, &serde_json::Value::Object(core::recommended(planner, &query.inner)))
}

/// What is recommended beside the defaults: planner, place (which maps), `least_share` (of blocked cells), set, evidence (an experiment).
#[pyfunction]
pub fn advice(py: Python<'_>) -> PyResult<Bound<'_, PyAny>> {
    let row = |a: &core::Advice| serde_json::json!({"planner": a.planner, "place": a.place, "least_share": a.least_share, "set": (a.set)(), "evidence": a.evidence});
    to_python(py, &serde_json::Value::Array(core::ADVICE.iter().map(row).collect()))
}

/// Every planner: name, about, source, lattice, parameters (name, about, default), paper (the settings of `preset=paper`, or None).
#[pyfunction]
pub fn planners(py: Python<'_>) -> PyResult<Bound<'_, PyAny>> {
    let rows: Vec<_> = core::REGISTRY
        .iter()
        .map(|entry| {
            let parameters = parameter_rows(entry.parameters, &(entry.defaults)());
            serde_json::json!({"name": entry.name, "about": entry.about, "source": entry.source, "lattice": entry.lattice, "parameters": parameters,
                               "paper": entry.paper.map(|paper| paper())})
        })
        .collect();
    to_python(py, &rows)
}

/// Parameters with their defaults as records.
pub fn parameter_rows(parameters: &[core::Parameter], defaults: &serde_json::Value) -> Vec<serde_json::Value> {
    parameters.iter().map(|p| serde_json::json!({"name": p.name, "about": p.about, "default": defaults.get(p.name)})).collect()
}
