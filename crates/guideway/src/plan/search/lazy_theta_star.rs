//! Lazy Theta*: assumes that a cell sees its grandparent and looks only when the cell is expanded.
//!
//! Source: \[nash2010\]. No parameters. Departures: as Theta*.

use super::sight::{Sight, Tree, plan, span};
use crate::context::Context;
use crate::error::PlanError;
use crate::plan::{Planner, Solution};
use crate::query::Query;
use crate::world::Cell;
use serde::{Deserialize, Serialize};

/// Any-angle path by Lazy Theta*: far fewer lines of sight than Theta*, paths about as long.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct LazyThetaStar {}

impl Planner for LazyThetaStar {
    fn plan(&self, query: &Query, ctx: &mut Context) -> Result<Solution, PlanError> {
        plan(query, ctx, expand)
    }
}

fn expand(sight: &Sight, tree: &mut Tree, cell: Cell, goal: Cell) {
    let mut parent = tree.parent(cell);
    if parent != cell && !sight.see(parent, cell) {
        // The assumption failed: the best closed neighbour becomes the parent. One exists, the cell was reached through it.
        let mut best = f64::INFINITY;
        for next in sight.neighbours(cell).filter(|&n| n != cell && tree.is_closed(n)) {
            let g = tree.g(next) + span(next, cell);
            if g < best {
                (best, parent) = (g, next);
            }
        }
        tree.assign(cell, best, parent);
    }
    let g = tree.g(parent);
    for next in sight.neighbours(cell) {
        let straight = g + span(parent, next);
        if !tree.is_closed(next) && straight < tree.g(next) {
            tree.offer(next, straight, parent, goal);
        }
    }
}
