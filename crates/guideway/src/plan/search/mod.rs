//! Exact and any-angle searches: planners themselves, and the references every other result is measured against.

mod astar;
mod bottleneck;
mod clearances;
mod dijkstra;
mod explain;
mod jump;
mod jump_point;
mod lazy_theta_star;
mod least_energy;
mod leg;
mod lexicographic;
mod open;
mod pareto;
mod reference;
mod sight;
mod soft;
mod step;
mod theta_star;
mod tree;
mod two_costs;
mod visibility;

pub use astar::AStar;
pub use dijkstra::Dijkstra;
pub use explain::explain;
pub use jump_point::JumpPoint;
pub use lazy_theta_star::LazyThetaStar;
pub use leg::{Engine, grid_optimum};
pub(super) use leg::{anchor, no_path, search};
pub use lexicographic::{Lexicographic, Optimum, Stopped, exact_instead, grid_best, lexicographic};
pub use pareto::{Effort, Pareto, pareto};
pub use reference::{Reference, gap, reference};
pub use theta_star::ThetaStar;
pub use visibility::Visibility;
pub(super) use visibility::{Classes, Inflated, Leg as ExactLeg, Route, Taut, runs};

use crate::world::{Cell, Corners, Lattice};
use std::f64::consts::SQRT_2;

/// Number of steps of a lattice path, from which its exact cost follows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Steps {
    /// Steps along rows and columns.
    pub straight: u64,
    /// Diagonal steps.
    pub diagonal: u64,
    /// Nodes expanded by the search.
    pub expansions: u64,
}

impl Steps {
    /// Length in cells.
    pub fn length(&self) -> f64 {
        self.straight as f64 + self.diagonal as f64 * SQRT_2
    }

    /// Counts the steps of a path given by its turning points (or all its cells).
    fn of(points: &[Cell], expansions: u64) -> Self {
        let mut steps = Self { expansions, ..Self::default() };
        for pair in points.windows(2) {
            let (dx, dy) = (pair[0][0].abs_diff(pair[1][0]), pair[0][1].abs_diff(pair[1][1]));
            steps.diagonal += u64::from(dx.min(dy));
            steps.straight += u64::from(dx.abs_diff(dy));
        }
        steps
    }
}

/// One search on a lattice.
struct Ask<'a, 'b> {
    lattice: &'a Lattice,
    start: Cell,
    goal: Cell,
    corners: Corners,
    /// Asked every few thousand expansions; true stops the search.
    stop: &'b mut dyn FnMut() -> bool,
}

impl Ask<'_, '_> {
    /// Should the search stop? Asks the caller now and then.
    #[inline]
    fn pause(&mut self, expansions: u64) -> bool {
        expansions.is_multiple_of(4096) && (self.stop)()
    }
}

/// How a search ended.
enum End {
    Found(Steps),
    /// No path exists.
    Exhausted,
    /// The caller stopped it.
    Stopped,
    /// Costs got too large for the integers in use.
    Overflow,
}

/// Shortest path between two cells by jump point search (A* where its rules do not hold). Leaves the turning points in `out`, start and goal included;
/// `None` if a cell is blocked or outside, or there is no path. Allocates nothing but what `out` needs (after the first calls on a lattice).
pub fn shortest_cells(lattice: &Lattice, start: Cell, goal: Cell, corners: Corners, out: &mut Vec<Cell>) -> Option<Steps> {
    out.clear();
    let inside = |c: Cell| c[0] < lattice.width() && c[1] < lattice.height() && lattice.free().at(c[0], c[1]);
    if !(inside(start) && inside(goal)) {
        return None;
    }
    let mut ask = Ask { lattice, start, goal, corners, stop: &mut || false };
    match leg::run(Engine::JumpPoint, &mut ask, out) {
        End::Found(steps) => Some(steps),
        _ => None,
    }
}

/// All cells of a path given by its turning points: every step to one of the eight neighbours.
pub fn every_cell(turns: &[Cell]) -> Vec<Cell> {
    let steps = |p: &[Cell]| p[0][0].abs_diff(p[1][0]).max(p[0][1].abs_diff(p[1][1])) as usize;
    let mut cells = Vec::with_capacity(1 + turns.windows(2).map(steps).sum::<usize>());
    cells.extend(turns.first());
    for pair in turns.windows(2) {
        let ([mut x, mut y], [tx, ty]) = (pair[0], pair[1]);
        while [x, y] != [tx, ty] {
            x = x.wrapping_add_signed((i64::from(tx) - i64::from(x)).signum() as i32);
            y = y.wrapping_add_signed((i64::from(ty) - i64::from(y)).signum() as i32);
            cells.push([x, y]);
        }
    }
    cells
}

/// The turning points of a path along the eight directions: cells where the direction changes, and both ends.
pub(super) fn turns(cells: &[Cell]) -> Vec<Cell> {
    let way = |a: Cell, b: Cell| [0, 1].map(|k| (i64::from(b[k]) - i64::from(a[k])).signum());
    let mut out = Vec::with_capacity(cells.len().min(64));
    for (k, &cell) in cells.iter().enumerate() {
        if k == 0 || k + 1 == cells.len() || way(cells[k - 1], cell) != way(cell, cells[k + 1]) {
            out.push(cell);
        }
    }
    out
}

#[cfg(test)]
mod tests;
