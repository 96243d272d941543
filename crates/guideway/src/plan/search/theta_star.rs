//! Theta*: A* on the lattice whose parents may be any cell in sight.
//!
//! Source: \[daniel2010\]. No parameters. Departures: exact lines of sight for discs; cells are taken from buckets of
//! estimates a sixteenth of a cell wide, the last one first. The path is near the any-angle optimum, never below it.

use super::sight::{Sight, Tree, plan, span};
use crate::context::Context;
use crate::error::PlanError;
use crate::plan::{Planner, Solution};
use crate::query::Query;
use crate::world::Cell;
use serde::{Deserialize, Serialize};

/// Any-angle path by Theta*.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ThetaStar {}

impl Planner for ThetaStar {
    fn plan(&self, query: &Query, ctx: &mut Context) -> Result<Solution, PlanError> {
        plan(query, ctx, expand)
    }
}

fn expand(sight: &Sight, tree: &mut Tree, cell: Cell, goal: Cell) {
    let (parent, here) = (tree.parent(cell), tree.g(cell));
    for next in sight.neighbours(cell) {
        if tree.is_closed(next) {
            continue;
        }
        let straight = tree.g(parent) + span(parent, next);
        let known = tree.g(next);
        // The straight way is never longer than the way over the cell, so it is looked at first.
        if straight >= known {
            continue;
        }
        if !tree.is_hidden(next, parent) {
            if sight.see(parent, next) {
                tree.offer(next, straight, parent, goal);
                continue;
            }
            tree.hide(next, parent);
        }
        if here + span(cell, next) < known {
            tree.offer(next, here + span(cell, next), cell, goal);
        }
    }
}
