//! Simplification of a safe lattice path that stays on the lattice.
//!
//! Source: the security marking and the simplified operator of \[han2024\]. The operator there is not spelled out, but the lengths that it leaves are
//! sums of lattice steps, so it cannot take shortcuts at any angle.
//! Departures: (b) merges any two steps whose ends are neighbours, not only orthogonal ones.

use super::cells::{Station, stations};
use super::simplify::Simplify;
use super::{Refined, Refiner};
use crate::Point;
use crate::context::Context;
use crate::error::PlanError;
use crate::path::Path;
use crate::query::Query;
use crate::world::{Cell, Lattice};
use serde::{Deserialize, Serialize};
use std::collections::HashMap;

/// Tidies a lattice path and leaves it on the lattice: (a) loops are cut, (b) two steps become one where that is a legal step (two orthogonal ones a
/// diagonal), (c) cells on a straight line are merged. Never longer; start, goal and via points stay. Any other path is left to [`Simplify`].
///
/// Under the corner rule `clear` (the security marking) a lattice path keeps half a cell from every obstacle cell, and so does the result:
/// a straight step lies on the middle line of two free cells, and the rest of the world begins half a cell beside it; a diagonal step lies inside the block of the
/// two cells and the two beside them, all free, its ends half a cell from the border of the block and everything between them farther. What is nearer
/// than half a cell to a step would have to be in these cells. Half a cell is exact: a wall beside a straight step is just so far away.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct SecurityMarking {}

impl Refiner for SecurityMarking {
    fn refine(&self, path: &Path, query: &Query, ctx: &mut Context) -> Result<Refined, PlanError> {
        let lattice = query.world.lattice(query.radius());
        let Some(stations) = stations(path, query, &lattice) else { return Simplify::default().refine(path, query, ctx) };
        let bounds: Vec<usize> = (0..stations.len()).filter(|&i| stations[i].fixed).collect();
        let mut points = vec![stations[0].point];
        for w in bounds.windows(2) {
            points.extend(tidy(&stations[w[0]..=w[1]], query, &lattice).into_iter().skip(1));
        }
        Ok(Refined { path: Path::polyline(&straightened(&points)), unmet: Vec::new() })
    }
}

/// The points that stay from one stop to the next; the stops may lie beside the centres.
fn tidy(run: &[Station], query: &Query, lattice: &Lattice) -> Vec<Point> {
    let cells: Vec<Cell> = run.iter().filter_map(|s| s.cell).collect();
    let kept = merged(&unlooped(&cells), |from, dx, dy| lattice.step_free(from, dx, dy, query.corners));
    let beside = |s: &Station| s.cell.is_none().then_some(s.point);
    let [first, last] = [beside(&run[0]), beside(&run[run.len() - 1])];
    first.into_iter().chain(kept.into_iter().map(|c| lattice.center(c))).chain(last).collect()
}

/// (a) Goes on from the last visit of every cell.
fn unlooped(cells: &[Cell]) -> Vec<Cell> {
    let last: HashMap<Cell, usize> = cells.iter().enumerate().map(|(i, c)| (*c, i)).collect();
    let (mut out, mut i) = (Vec::with_capacity(cells.len()), 0);
    while i < cells.len() {
        out.push(cells[i]);
        i = last[&cells[i]] + 1;
    }
    out
}

/// (b) Until no two steps in a row can be one.
fn merged(cells: &[Cell], legal: impl Fn(Cell, i64, i64) -> bool) -> Vec<Cell> {
    let mut out: Vec<Cell> = Vec::with_capacity(cells.len());
    for &cell in cells {
        out.push(cell);
        while let [.., a, _, c] = out[..] {
            let [dx, dy] = [0, 1].map(|k| i64::from(c[k]) - i64::from(a[k]));
            if dx.abs().max(dy.abs()) > 1 || !((dx, dy) == (0, 0) || legal(a, dx, dy)) {
                break;
            }
            out.truncate(out.len() - 2 - usize::from((dx, dy) == (0, 0)));
            out.push(c);
        }
    }
    out
}

/// (c) Without points between two others on a straight line of lattice steps.
fn straightened(points: &[Point]) -> Vec<Point> {
    let mut out: Vec<Point> = Vec::with_capacity(points.len());
    for &p in points {
        while let [.., a, b] = out[..] {
            let (u, v) = ([b[0] - a[0], b[1] - a[1]], [p[0] - b[0], p[1] - b[1]]);
            let (cross, dot) = (u[0] * v[1] - u[1] * v[0], u[0] * v[0] + u[1] * v[1]);
            if dot <= 0.0 || cross.abs() > 1e-9 * dot {
                break;
            }
            out.pop();
        }
        out.push(p);
    }
    out
}

#[cfg(test)]
mod tests;
