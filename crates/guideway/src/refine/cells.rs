//! The cells that a lattice path consists of.

use crate::Point;
use crate::path::Path;
use crate::query::Query;
use crate::world::shape::distance;
use crate::world::{Cell, Lattice};

/// One place of a lattice path.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Station {
    /// m.
    pub point: Point,
    /// The cell whose centre it is; `None` for a start, via point or goal beside the centres.
    pub cell: Option<Cell>,
    /// Start, via point or goal.
    pub fixed: bool,
}

/// Every cell along a lattice path and its stops; `None` if the path leaves the lattice or takes a step that the query does not allow.
pub(super) fn stations(path: &Path, query: &Query, lattice: &Lattice) -> Option<Vec<Station>> {
    if path.degree() != 1 || path.dimension() != 2 {
        return None;
    }
    let points = path.points();
    let mut stations: Vec<Station> = Vec::with_capacity(points.len());
    for (i, &point) in points.iter().enumerate() {
        let fixed = i == 0 || i + 1 == points.len() || query.via.iter().any(|via| distance(*via, point) < 1e-9);
        let cell = lattice.cell_at(point).filter(|cell| distance(lattice.center(*cell), point) <= 1e-7 * lattice.resolution());
        if cell.is_none() && !fixed {
            return None;
        }
        if let (Some(before), Some(cell)) = (stations.last().and_then(|s| s.cell), cell) {
            walk(before, cell, query, lattice, &mut stations)?;
        }
        stations.push(Station { point, cell, fixed });
    }
    stations.iter().any(|s| s.cell.is_some()).then_some(stations)
}

/// Adds the cells strictly between two; `None` if they are not on one of the eight directions or a step is not allowed.
fn walk(from: Cell, to: Cell, query: &Query, lattice: &Lattice, out: &mut Vec<Station>) -> Option<()> {
    let [dx, dy] = [0, 1].map(|k| i64::from(to[k]) - i64::from(from[k]));
    if dx != 0 && dy != 0 && dx.abs() != dy.abs() {
        return None;
    }
    let (mut cell, [sx, sy]) = (from, [dx.signum(), dy.signum()]);
    while cell != to {
        if !lattice.step_free(cell, sx, sy, query.corners) {
            return None;
        }
        cell = [(i64::from(cell[0]) + sx) as u32, (i64::from(cell[1]) + sy) as u32];
        if cell != to {
            out.push(Station { point: lattice.center(cell), cell: Some(cell), fixed: false });
        }
    }
    Some(())
}
