//! Exact references on the lattice, the fallback to them, and the set of alternatives.

use crate::convert::to_python;
use crate::errors::{OrPy, to_py};
use crate::plan::{Solution, watched};
use crate::query::Query;
use crate::world::World;
use guideway::certify;
use guideway::context::{Budget, Context};
use guideway::error::PlanError;
use guideway::path::Path;
use guideway::plan::front::Alternative;
use guideway::plan::score::Aim;
use guideway::plan::search::{self, Effort, Pareto, lexicographic};
use guideway::plan::{self as core, REGISTRY};
use guideway::query;
use pyo3::exceptions::PyKeyboardInterrupt;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use serde_json::{Value, json};

/// The exact best lattice path of a disc of `radius` (m) between two cells (column, row), row 0 on top: shortest with the fewest turns, or with `aim`
/// "energy" of the least energy (one per cell, half a unit per turn).
///
/// Returns `cells` ((column, row) from start to goal), `diagonals`, `straights`, `turns`, `length` and `energy` (cells), `expansions`; None if a cell is blocked
/// or outside or there is no path. `corners` as in `Query`.
#[pyfunction]
#[pyo3(signature = (world, start_cell, goal_cell, corners="touch", radius=0.0, aim="length"))]
pub fn lattice_optimum<'py>(
    py: Python<'py>,
    world: &World,
    start_cell: (u32, u32),
    goal_cell: (u32, u32),
    corners: &str,
    radius: f64,
    aim: &str,
) -> PyResult<Option<Bound<'py, PyDict>>> {
    let corners = crate::query::corner_rule(py, corners)?;
    if !(0.0..=1e6).contains(&radius) {
        return Err(to_py(py, &PlanError::bad("radius", radius, "0 to 1e6 m")));
    }
    let aim = match aim {
        "length" => Aim::Shortest,
        "energy" => Aim::LeastEnergy,
        other => return Err(to_py(py, &PlanError::bad("aim", other, "one of length, energy"))),
    };
    let Some(top) = world.inner.cells()[1].checked_sub(1).filter(|top| start_cell.1 <= *top && goal_cell.1 <= *top) else { return Ok(None) };
    let ends = [start_cell, goal_cell].map(|c| [c.0, top - c.1]);
    let inner = &world.inner;
    let (found, raised) =
        watched(py, 0, Budget::default(), 1, None, |ctx| lexicographic(&inner.lattice(radius), ends, corners, aim, &mut || ctx.poll().is_some()))?;
    raised.map_or(Ok(()), Err)?;
    let Ok(Some(found)) = found else { return Ok(None) };
    let record = PyDict::new(py);
    record.set_item("cells", found.cells.iter().map(|c| (c[0], top - c[1])).collect::<Vec<_>>())?;
    record.set_item("diagonals", found.diagonal)?;
    record.set_item("straights", found.straight)?;
    record.set_item("turns", found.score.turns)?;
    record.set_item("length", Aim::Shortest.of_cells(&found.cells).cost)?;
    record.set_item("energy", Aim::LeastEnergy.of_cells(&found.cells).cost)?;
    record.set_item("expansions", found.expansions)?;
    Ok(Some(record))
}

/// Refuses planners that do not plan on the lattice.
pub fn needs_lattice(py: Python<'_>, planner: &str) -> PyResult<()> {
    if REGISTRY.iter().any(|entry| entry.name == planner && entry.lattice) {
        return Ok(());
    }
    Err(to_py(
        py,
        &PlanError::bad("exact_fallback", planner, "a planner on the lattice; the other planners have no exact path of their kind to fall back to"),
    ))
}

/// The solution of a lattice planner, or the exact path where that is better or the planner found none. The exact search has no budget.
pub fn instead(
    found: Result<Solution, PlanError>,
    query: &Bound<'_, Query>,
    (planner, seed): (&str, u64),
    observe: Option<&Bound<'_, PyAny>>,
) -> PyResult<Solution> {
    let py = query.py();
    let found = match found {
        Err(PlanError::NoPath(no)) if !no.proved => None,
        other => Some(other.or_py(py)?),
    };
    let inner = &query.get().inner;
    let known = found.as_ref().map(|solution| &solution.inner);
    let (exact, raised) = watched(py, seed, Budget::default(), 1, observe, |ctx| search::exact_instead(inner, known, ctx))?;
    raised.map_or(Ok(()), Err)?;
    match (exact.or_py(py)?, found) {
        (None, Some(found)) => Ok(found),
        (None, None) => Err(to_py(py, &PlanError::Cancelled)),
        (Some(inner), found) => {
            let heuristic = found.map(|solution| Py::new(py, solution)).transpose()?;
            Ok(Solution { inner, query: query.clone().unbind(), planner: planner.to_owned(), seed, fallback: true, heuristic })
        }
    }
}

/// What a lattice solution is measured against beside the shortest length: fewest turns, and for heavy loads the least energy and the gap to it.
pub fn beside_length(query: &query::Query, solution: &core::Solution, ctx: &mut Context) -> Result<Value, PlanError> {
    let none = json!({"grid_turns": null, "grid_energy": null, "grid_energy_gap": null});
    let Some(cells) = &solution.cells else { return Ok(none) };
    let Some(shortest) = search::grid_best(query, Aim::Shortest, ctx)? else { return Ok(none) };
    let turns = shortest.cells.as_deref().map(|cells| Aim::Shortest.of_cells(cells).turns);
    let (mut energy, mut gap) = (None, None);
    if query.material == query::Material::Heavy
        && let Some(best) = search::grid_best(query, Aim::LeastEnergy, ctx)?
    {
        let of = |cells: &[[u32; 2]]| Aim::LeastEnergy.of_cells(cells).cost;
        let least = best.cells.as_deref().map_or(0.0, of);
        // The ways to the centres of the first and the last cell are the same for all.
        let stubs = best.cost / query.world.resolution() - best.cells.as_deref().map_or(0.0, |cells| Aim::Shortest.of_cells(cells).cost);
        let least = least + stubs.max(0.0);
        energy = Some(least);
        gap = Some(search::gap(of(cells) + stubs.max(0.0), least)?);
    }
    Ok(json!({"grid_turns": turns, "grid_energy": energy, "grid_energy_gap": gap}))
}

/// Every lattice path from start to goal worth choosing from: the nondominated set of length, turns, clearance (and energy, a function of the first two).
///
/// Returns `alternatives` (`length` in m, `turns`, `min_clearance` in m as in the metrics or None without obstacles, `energy`, `grid_path`; shortest first, each
/// certified), `complete` (False: time or effort ended first), `searches`, `labels`, `seconds`, `stop`. `seconds` bounds the time, `searches` and `labels` the
/// effort. Ctrl-C raises `KeyboardInterrupt` whose attribute `found` holds what was found, or None.
#[pyfunction]
#[pyo3(signature = (query, *, seconds=None, searches=None, labels=None, observe=None))]
pub fn pareto<'py>(
    py: Python<'py>,
    query: &Query,
    seconds: Option<f64>,
    searches: Option<u32>,
    labels: Option<u64>,
    observe: Option<&Bound<'py, PyAny>>,
) -> PyResult<Bound<'py, PyAny>> {
    let default = Effort::default();
    let effort = Effort { searches: searches.unwrap_or(default.searches), labels: labels.unwrap_or(default.labels) };
    let inner = &query.inner;
    let work = |ctx: &mut Context<'_>| {
        let found = search::pareto(inner, effort, ctx)?;
        record(inner, &found, ctx.seconds())
    };
    let (found, raised) = watched(py, 0, Budget { seconds, ..Budget::default() }, 1, observe, work)?;
    if let Some(error) = raised {
        if error.is_instance_of::<PyKeyboardInterrupt>(py) {
            error.value(py).setattr("found", found.ok().map(|value| to_python(py, &value)).transpose()?)?;
        }
        return Err(error);
    }
    to_python(py, &found.or_py(py)?)
}

fn record(query: &query::Query, found: &Pareto, seconds: f64) -> Result<Value, PlanError> {
    let rows: Vec<_> = found.front.alternatives().iter().map(|one| alternative(query, one, found.stubs)).collect::<Result<_, _>>()?;
    Ok(
        json!({"alternatives": rows, "complete": found.complete, "searches": found.searches, "labels": found.labels, "seconds": seconds, "stop": found.stop}),
    )
}

fn alternative(query: &query::Query, one: &Alternative, stubs: f64) -> Result<Value, PlanError> {
    let cell = query.world.resolution();
    let centers: Vec<_> = one.cells.iter().map(|&c| query.world.cell_center(c)).collect();
    let mut points = vec![query.start];
    points.extend(&centers);
    points.push(query.goal);
    let checked = certify::collision(&Path::polyline(&points), query, Some(cell / 10.0));
    if !checked.ok {
        let detail = format!("an alternative collides near {:?}", checked.worst);
        return Err(PlanError::CertificateFailed { stage: "alternatives", detail });
    }
    let clearance = one.clearance.is_finite().then(|| one.clearance - query.footprint.circumscribed());
    Ok(
        json!({"length": one.length * cell + stubs, "turns": one.turns, "min_clearance": clearance, "energy": one.energy() + stubs / cell, "grid_path": centers}),
    )
}
