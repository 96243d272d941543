//! Incremental replanning: the pheromone of the last plan is kept, roads that are shut now fall to the lower bound, and the last way is repaired.
//!
//! Source: \[lu2025\]. Departures: the last way is bridged where it is blocked by shortest lattice paths and is what the ants have to beat.

use super::Task;
use super::crew::better;
use super::pheromone::Pheromone;
use super::roads::{Exit, Roads};
use super::seed::{self, Seeding, along};
use super::walk::Trail;
use crate::context::Context;
use crate::error::PlanError;
use crate::plan::Solution;
use crate::plan::search::shortest_cells;
use crate::world::Cell;
use std::sync::Arc;

/// Ants and iterations of a repair.
pub(super) const REPAIR: (usize, u64) = (20, 10);

/// What a colony remembers of a plan, leg by leg.
#[derive(Debug, Default)]
pub(super) struct Memory {
    legs: Vec<Leg>,
}

/// What it remembers of a leg.
#[derive(Debug, Clone)]
pub(in crate::plan) struct Leg {
    /// Columns and rows of the lattice.
    size: [u32; 2],
    goal: u32,
    /// Concentrations on the slots that ants marked.
    slots: Vec<(u32, f32)>,
    /// The best way, node by node.
    way: Vec<u32>,
}

impl Memory {
    pub fn push(&mut self, leg: Leg) {
        self.legs.push(leg);
    }

    pub fn into_solution(self) -> Arc<dyn std::any::Any + Send + Sync> {
        Arc::new(self)
    }

    /// What a solution remembers of the leg to this task's goal.
    pub fn recall<'a>(previous: &'a Solution, task: &Task) -> Option<&'a Leg> {
        let memory = previous.memory.as_ref()?.downcast_ref::<Self>()?;
        memory.legs.iter().find(|leg| leg.goal == task.goal && leg.size == task.size())
    }
}

impl Leg {
    pub fn new(task: &Task, tau: &Pheromone, best: Option<&Trail>) -> Self {
        Self {
            size: task.size(),
            goal: task.goal,
            slots: tau.marked().map(|(slot, value)| (slot, value as f32)).collect(),
            way: best.map(|t| t.nodes.clone()).unwrap_or_default(),
        }
    }

    /// Lays the remembered concentrations on the roads that are still open; on the others lies the least.
    pub fn spread(&self, task: &Task, tau: &mut Pheromone, least: f64) {
        let mut exits: Vec<Exit> = Vec::with_capacity(8);
        let mut at = None;
        for &(slot, value) in &self.slots {
            if at != Some(slot / 8) {
                at = Some(slot / 8);
                task.roads.exits(slot / 8, &mut exits);
            }
            tau.lay(slot, if exits.iter().any(|e| e.slot == slot) { f64::from(value) } else { least });
        }
    }

    /// The trail that a repair begins with: the remembered way, or the one of the seeding if that is better.
    pub fn begin(&self, task: &Task, seeding: Seeding, ctx: &mut Context) -> Result<Option<Trail>, PlanError> {
        Ok(better(self.repaired(task), seed::trail(task, seeding, ctx)?.as_ref()))
    }

    /// The remembered way from the task's start on: from its first cell that is nearest to the start, bridged where it is blocked.
    fn repaired(&self, task: &Task) -> Option<Trail> {
        let (roads, lattice) = (task.roads, task.leg.lattice);
        let apart = |node: &u32| roads.distance(*node, task.start);
        let nearest = (0..self.way.len()).min_by(|a, b| apart(&self.way[*a]).total_cmp(&apart(&self.way[*b])))?;
        let free = |node: &u32| lattice.free().at(roads.cell(*node)[0], roads.cell(*node)[1]);
        let mut cells: Vec<Cell> = vec![task.leg.start];
        let mut bridge = Vec::new();
        for node in self.way[nearest..].iter().filter(|node| free(node)) {
            let (from, to) = (cells[cells.len() - 1], roads.cell(*node));
            if from == to {
                continue;
            }
            let step = [0, 1].map(|k| i64::from(to[k]) - i64::from(from[k]));
            if step.iter().all(|d| d.abs() <= 1) && lattice.step_free(from, step[0], step[1], task.leg.query.corners) {
                cells.push(to);
            } else {
                shortest_cells(lattice, from, to, task.leg.query.corners, &mut bridge)?;
                cells.extend(crate::plan::search::every_cell(&bridge).into_iter().skip(1));
            }
        }
        along(roads, &without_loops(&cells), task.aim)
    }
}

/// A way without the rounds that bridges may have made: each cell once.
fn without_loops(cells: &[Cell]) -> Vec<Cell> {
    let last: std::collections::HashMap<Cell, usize> = cells.iter().enumerate().map(|(k, c)| (*c, k)).collect();
    let (mut way, mut at) = (Vec::with_capacity(cells.len()), 0);
    while at < cells.len() {
        way.push(cells[at]);
        at = last[&cells[at]] + 1;
    }
    way
}
