//! From a query to legs between lattice cells and back: stubs at the ends, via points, one path of neighbouring cells.

use super::search::{anchor, every_cell, no_path, turns};
use crate::Point;
use crate::context::Context;
use crate::error::PlanError;
use crate::path::Path;
use crate::plan::score::counts;
use crate::query::Query;
use crate::world::{Cell, Lattice, shape};
use std::f64::consts::SQRT_2;

/// One leg: from a free cell to a free cell.
pub(super) struct Leg<'a> {
    pub query: &'a Query,
    pub lattice: &'a Lattice,
    pub start: Cell,
    pub goal: Cell,
    /// The points the cells stand for, m.
    pub ends: [Point; 2],
    /// Length of the legs before this one, m.
    pub before: f64,
}

/// The legs planned so far, joined.
pub(super) struct Route {
    /// All cells; empty where nothing has been planned.
    pub cells: Vec<Cell>,
    points: Vec<Point>,
    /// Length, m.
    pub length: f64,
}

impl Route {
    pub fn path(&self) -> Path {
        Path::polyline(&self.points)
    }
}

/// Plans a query leg by leg. `solve` gives the cells of a leg, start and goal included: all of them, or its turning points.
pub(super) fn plan(
    query: &Query,
    ctx: &mut Context,
    mut solve: impl FnMut(&Leg, &mut Context) -> Result<Vec<Cell>, PlanError>,
) -> Result<Route, PlanError> {
    query.validate()?;
    let lattice = query.world.lattice(query.radius());
    let mut route = Route { cells: Vec::new(), points: vec![query.start], length: 0.0 };
    for pair in query.stops().windows(2) {
        let (Some(start), Some(goal)) = (anchor(query, &lattice, pair[0]), anchor(query, &lattice, pair[1])) else {
            return Err(no_path(query, false, Some("no free cell centre of the lattice is in reach of the start or the goal".into())));
        };
        let leg = Leg { query, lattice: &lattice, start, goal, ends: [pair[0], pair[1]], before: route.length };
        let found = solve(&leg, ctx)?;
        route.add(&lattice, &found, pair[1]);
    }
    Ok(route)
}

impl Route {
    /// Appends a path found between two anchors and the stubs at its ends.
    fn add(&mut self, lattice: &Lattice, found: &[Cell], to: Point) {
        let from = self.points[self.points.len() - 1];
        self.points.reserve(found.len() + 1);
        self.points.extend(turns(found).into_iter().map(|c| lattice.center(c)));
        self.points.push(to);
        let cells = every_cell(found);
        let [straight, diagonal, _] = counts(&cells);
        let stubs = shape::distance(from, lattice.center(cells[0])) + shape::distance(lattice.center(cells[cells.len() - 1]), to);
        self.length += (f64::from(straight) + f64::from(diagonal) * SQRT_2) * lattice.resolution() + stubs;
        if self.cells.is_empty() {
            self.cells = cells;
        } else {
            let joint = usize::from(self.cells.last() == cells.first());
            self.cells.extend_from_slice(&cells[joint..]);
        }
    }
}

/// (iteration, cost of the whole route in m) at each improvement, had every leg been stopped at that iteration, from the (iteration, cost in cells) of each
/// leg and its final cost. The last is the cost of the route where the shortest path is what is asked for.
pub(super) fn joined(legs: &[(Vec<(u64, f64)>, f64)], cost: f64, resolution: f64) -> Vec<(u64, f64)> {
    let mut when: Vec<u64> = legs.iter().flat_map(|l| l.0.iter().map(|h| h.0)).collect();
    when.sort_unstable();
    when.dedup();
    // No leg has a path before its first one.
    let first = legs.iter().filter_map(|l| l.0.first()).map(|h| h.0).max().unwrap_or(0);
    let at = |l: &(Vec<(u64, f64)>, f64), i: u64| l.0.iter().rev().find(|h| h.0 <= i).map_or(0.0, |h| h.1);
    let last: f64 = legs.iter().map(|l| l.1).sum();
    let over = |i: u64| cost + (legs.iter().map(|l| at(l, i)).sum::<f64>() - last) * resolution;
    when.into_iter().filter(|&i| i >= first).map(|i| (i, over(i))).collect()
}
