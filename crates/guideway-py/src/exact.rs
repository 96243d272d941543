//! Exact references on the lattice.

use crate::errors::to_py;
use crate::plan::watched;
use crate::world::World;
use guideway::context::Budget;
use guideway::error::PlanError;
use guideway::plan::score::Aim;
use guideway::plan::search::lexicographic;
use pyo3::prelude::*;
use pyo3::types::PyDict;

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
