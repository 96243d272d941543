//! Trails of other searches that ants may begin with.

use super::Task;
use super::roads::{Exit, Roads, Streets};
use super::walk::Trail;
use crate::context::Context;
use crate::error::PlanError;
use crate::plan::score::Aim;
use crate::plan::search::{self, Engine, LazyThetaStar, every_cell, shortest_cells};
use crate::plan::{Planner, legs};
use crate::query::Query;
use crate::world::Cell;
use serde::{Deserialize, Serialize};

/// What raises the initial pheromone and is the best trail to begin with.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Seeding {
    /// Nothing: the ants find everything themselves.
    #[default]
    Off,
    /// The lattice path along the turning points of Lazy Theta*.
    AnyAngle,
    /// The exact shortest lattice path.
    Exact,
}

/// The trail to begin with.
pub(super) fn trail(task: &Task, seeding: Seeding, ctx: &mut Context) -> Result<Option<Trail>, PlanError> {
    let turns = match seeding {
        Seeding::Off => return Ok(None),
        Seeding::Exact => search::search(Engine::JumpPoint, task.leg, ctx)?.0,
        Seeding::AnyAngle => match any_angle(task.leg, ctx) {
            Ok(turns) => turns,
            Err(PlanError::NoPath(_)) => return Ok(None),
            Err(other) => return Err(other),
        },
    };
    Ok(along(task.roads, &every_cell(&turns), task.aim))
}

/// Turning points of the lattice path along those of Lazy Theta*.
fn any_angle(leg: &legs::Leg, ctx: &mut Context) -> Result<Vec<Cell>, PlanError> {
    let (lattice, mut query) = (leg.lattice, Query { via: Vec::new(), ..leg.query.clone() });
    (query.start, query.goal) = (lattice.center(leg.start), lattice.center(leg.goal));
    let path = LazyThetaStar::default().plan(&query, ctx)?.path;
    let (mut all, mut part) = (vec![leg.start], Vec::new());
    let corners = (1..path.count()).filter_map(|k| lattice.cell_at([path.point(k)[0], path.point(k)[1]]));
    for cell in corners {
        let from = all[all.len() - 1];
        if shortest_cells(lattice, from, cell, query.corners, &mut part).is_none() {
            return Err(search::no_path(&query, false, None));
        }
        all.extend_from_slice(&part[1..]);
    }
    Ok(all)
}

/// The trail along neighbouring cells; `None` if a step is not allowed.
pub(super) fn along(roads: &Streets, cells: &[Cell], aim: Aim) -> Option<Trail> {
    let nodes: Vec<u32> = cells.iter().map(|c| roads.node(*c)).collect();
    let mut out = Vec::with_capacity(8);
    let exits: Option<Vec<Exit>> = nodes
        .windows(2)
        .map(|pair| {
            roads.exits(pair[0], &mut out);
            out.iter().find(|e| e.to == pair[1]).copied()
        })
        .collect();
    exits.map(|exits| Trail::new(roads, nodes, exits, aim))
}
