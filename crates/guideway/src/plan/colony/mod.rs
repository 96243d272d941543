//! Ant colonies: one walk, one pheromone store and one transition rule in log space, shared by every method.
//!
//! `roads` is what ants walk on, `pheromone` what they leave there, `rule` how they choose, `walk` how they go, `crew` a generation of them. The methods
//! own their loops.

mod aco;
mod bidirectional;
mod check;
mod crew;
mod improved;
mod memory;
mod mmas;
mod paged;
mod pheromone;
mod polish;
mod pso_aco;
mod roads;
mod rule;
mod seed;
mod sparse;
mod walk;
mod workers;

pub use aco::Aco;
pub use bidirectional::BidirectionalAco;
pub use improved::{Bounds, Conversion, ImprovedAco, Reading};
pub use mmas::Mmas;
pub use pso_aco::PsoAco;
pub use rule::Heuristic;
pub use seed::Seeding;
pub use sparse::Graph;

use super::legs::{self, Leg};
use super::score::Aim;
use super::search::{self, Engine};
use super::{Preset, Solution};
use crate::context::{Context, Stop};
use crate::error::PlanError;
use crate::query::Query;
use crate::world::Cell;
use pheromone::Pheromone;
use roads::Streets;
use serde_json::{Value, json};
use walk::Trail;

/// One leg on the lattice, as a colony sees it.
pub(super) struct Task<'a> {
    pub leg: &'a Leg<'a>,
    pub roads: &'a Streets<'a>,
    pub aim: Aim,
    pub start: u32,
    pub goal: u32,
}

/// What a colony found on a leg.
pub(super) struct Found {
    /// Best trail, if an ant arrived.
    pub best: Option<Trail>,
    pub stop: Stop,
    /// (iteration, best cost in cells) at each improvement.
    pub history: Vec<(u64, f64)>,
    /// For pictures.
    pub trace: Value,
    /// For replanning.
    pub memory: memory::Leg,
}

impl Found {
    /// With the improvements since the leg began.
    pub fn new(task: &Task, best: Option<Trail>, stop: Stop, tau: &Pheromone, ctx: &mut Context) -> Self {
        let cells = |m: f64| (m - task.leg.before) / task.leg.lattice.resolution();
        let mut history: Vec<_> = ctx.take_history().into_iter().map(|(i, m)| (i, cells(m))).collect();
        if let Some(best) = &best {
            let when = history.pop().map_or(ctx.iterations(), |last| last.0);
            history.push((when, best.score.cost));
        }
        let trace = json!({ "pheromone": picture(task.roads, tau), "convergence": history });
        Self { trace, memory: memory::Leg::new(task, tau, best.as_ref()), history, best, stop }
    }

    /// Puts the improvements of a method that went ahead before its own.
    pub fn precede(&mut self, earlier: impl Iterator<Item = (u64, f64)>) {
        let mut history: Vec<_> = earlier.collect();
        let least = history.last().map_or(f64::INFINITY, |h| h.1);
        history.extend(self.history.iter().filter(|h| h.1 < least));
        self.history = history;
        self.trace["convergence"] = json!(self.history);
    }
}

impl Task<'_> {
    /// Largest number of steps of an ant: enough to visit every cell and to go back.
    pub fn steps(&self) -> usize {
        let side = self.leg.lattice.width().max(self.leg.lattice.height()) as usize;
        6 * side * side
    }

    /// Columns and rows of the lattice.
    pub fn size(&self) -> [u32; 2] {
        [self.leg.lattice.width(), self.leg.lattice.height()]
    }

    /// Cost of the route so far if this leg takes a trail, m; infinite without one.
    pub fn cost(&self, best: Option<&Trail>) -> f64 {
        best.map_or(f64::INFINITY, |trail| self.leg.before + trail.score.cost * self.leg.lattice.resolution())
    }
}

/// What is minimised. In the sources always length, then turns.
fn aim(preset: Preset, query: &Query) -> Aim {
    if preset == Preset::Paper { Aim::Shortest } else { Aim::of(query.material) }
}

/// Plans a query on the lattice, leg by leg: first the proof that there is a way, then the colony.
fn plan(
    aim: Aim,
    query: &Query,
    ctx: &mut Context,
    mut colony: impl FnMut(&Task, &mut Context) -> Result<Found, PlanError>,
) -> Result<Solution, PlanError> {
    let (mut stop, mut legs, mut traces, mut memory) = (Stop::Converged, Vec::new(), Vec::new(), memory::Memory::default());
    let route = legs::plan(query, ctx, |leg, ctx| {
        // Ants would walk for ever in a closed room. The path of this search is not looked at.
        search::search(Engine::JumpPoint, leg, ctx)?;
        let roads = Streets::new(leg.lattice, query.corners);
        let task = Task { leg, roads: &roads, aim, start: roads.node(leg.start), goal: roads.node(leg.goal) };
        let first = ctx.iterations();
        let mut found = colony(&task, ctx)?;
        found.history.iter_mut().for_each(|h| h.0 = h.0.saturating_sub(first));
        found.trace["convergence"] = json!(found.history);
        if found.stop != Stop::Converged {
            stop = found.stop;
        }
        let worth = found.best.as_ref().map_or(f64::INFINITY, |t| t.score.cost);
        legs.push((found.history, worth));
        traces.push(found.trace);
        memory.push(found.memory);
        match found.best {
            Some(trail) => Ok(roads.cells(&trail.nodes)),
            None if found.stop == Stop::Cancelled => Err(PlanError::Cancelled),
            None => Err(search::no_path(query, false, Some(lost(found.stop).into()))),
        }
    })?;
    Ok(Solution {
        path: route.path(),
        cost: route.length,
        cells: Some(route.cells),
        trajectory: None,
        stop,
        iterations: ctx.iterations(),
        evaluations: ctx.evaluations(),
        seconds: ctx.seconds(),
        history: legs::joined(&legs, route.length, query.world.resolution()),
        trace: json!({ "legs": traces }),
        memory: Some(memory.into_solution()),
    })
}

fn lost(stop: Stop) -> &'static str {
    match stop {
        Stop::Converged => "no ant arrived, though there is a way: try more iterations, preset=default or another planner",
        _ => "the budget was spent before an ant arrived, though there is a way: allow more, or try another planner",
    }
}

/// Most cells that a picture of the pheromone holds.
const PICTURE: usize = 5_000;

/// The strongest concentration out of each cell that ants marked, `[x, y, value]` with row 0 at the bottom, as a trace.
fn picture(roads: &Streets, tau: &Pheromone) -> Value {
    let mut cells: Vec<(Cell, f64)> = Vec::new();
    for (slot, value) in tau.marked() {
        let cell = roads.cell(slot / 8);
        match cells.last_mut() {
            Some((last, most)) if *last == cell => *most = most.max(value),
            _ => cells.push((cell, value)),
        }
    }
    if cells.len() > PICTURE {
        cells.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
        cells.truncate(PICTURE);
    }
    let rows: Vec<_> = cells.into_iter().map(|([x, y], value)| json!([x, y, value])).collect();
    Value::Array(rows)
}

#[cfg(test)]
mod tests;
