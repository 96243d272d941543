//! A grouped particle swarm finds a good way, which raises the pheromone that a bidirectional ant colony begins with.
//!
//! Source: \[han2024\]: swarm of `swarm_iterations`, then `tau = tau_0 (1 + 2 L_lb / L_pso)` along its way with `L_lb` the octile distance, then
//! the colony of [`BidirectionalAco`]; the best way of both is the answer.
//!
//! | symbol | field |
//! |---|---|
//! | NP, D, `m_g`, `t_max` | `particles`, `keys`, `groups`, `swarm_iterations` |
//! | M, alpha, beta, rho, Q, `it_max` | those of the colony |
//!
//! Departures: those of the colony and of the guided walk, switched off by `preset=paper`. Of a budget of iterations the swarm takes at most half.

use super::bidirectional::BidirectionalAco;
use super::crew::better;
use super::{Found, Task, aim, memory, plan, seed};
use crate::context::Context;
use crate::error::PlanError;
use crate::optimize::GroupedPso;
use crate::plan::swarm::{self, Decoding};
use crate::plan::{Planner, Preset, Solution};
use crate::query::Query;
use serde::{Deserialize, Serialize};
use serde_json::json;

/// Grouped particle swarm and bidirectional ant colony on the lattice.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct PsoAco {
    /// The colony.
    #[serde(flatten)]
    pub colony: BidirectionalAco,
    /// Particles of the swarm.
    pub particles: usize,
    /// Subgroups of the swarm.
    pub groups: usize,
    /// Iterations of the swarm; 0: no swarm.
    pub swarm_iterations: u64,
    /// Iterations without improvement after which the swarm stops.
    pub swarm_patience: u64,
    /// Keys of a guided walk.
    pub keys: usize,
    /// Has the swarm an elite group?
    pub elite: bool,
    /// Has the swarm a second, adaptive stage?
    pub second_stage: bool,
}

impl Default for PsoAco {
    fn default() -> Self {
        Self {
            colony: BidirectionalAco::default(),
            particles: 50,
            groups: 5,
            swarm_iterations: 50,
            swarm_patience: 20,
            keys: 40,
            elite: true,
            second_stage: true,
        }
    }
}

impl PsoAco {
    /// The settings of the source.
    pub fn paper() -> Self {
        Self { colony: BidirectionalAco::paper(), ..Self::default() }
    }

    fn decoding(&self) -> Decoding {
        let decoding = if self.colony.preset == Preset::Paper { Decoding::paper() } else { Decoding::default() };
        // The ants go on where walks of six sides do not arrive.
        Decoding { keys: self.keys, walk_limit: Decoding::paper().walk_limit, ..decoding }
    }

    fn swarm(&self, task: &Task, ctx: &mut Context) -> Result<Option<swarm::Found>, PlanError> {
        if self.swarm_iterations == 0 {
            return Ok(None);
        }
        let most = ctx.budget().iterations.map_or(u64::MAX, |n| n.div_ceil(2));
        let swarm = GroupedPso {
            particles: self.particles,
            groups: self.groups,
            iterations: self.swarm_iterations.min(most),
            patience: self.swarm_patience,
            elite: self.elite,
            second_stage: self.second_stage,
            ..GroupedPso::default()
        };
        match swarm::search(task.leg, &swarm, &self.decoding(), task.aim, ctx) {
            Ok(found) => Ok(Some(found)),
            // The ants may do better.
            Err(PlanError::NoPath(no)) if !no.proved => Ok(None),
            Err(other) => Err(other),
        }
    }

    fn leg(&self, task: &Task, ctx: &mut Context) -> Result<Found, PlanError> {
        let first = ctx.iterations();
        let swarm = self.swarm(task, ctx)?;
        ctx.take_history();
        let walked = swarm.as_ref().and_then(|s| seed::along(task.roads, &s.cells, task.aim));
        let seeded = seed::trail(task, self.colony.seeding, ctx)?;
        let mut found = self.colony.colony(task, better(walked, seeded.as_ref()), None, ctx);
        if let Some(swarm) = swarm {
            found.precede(swarm.history.iter().map(|h| (first + h.0, h.1)));
            found.trace["swarm"] = swarm.trace;
            found.trace["swarm"]["iterations"] = json!(swarm.iterations);
        }
        Ok(found)
    }
}

impl Planner for PsoAco {
    fn plan(&self, query: &Query, ctx: &mut Context) -> Result<Solution, PlanError> {
        self.colony.validate()?;
        plan(aim(self.colony.preset, query), query, ctx, |task, ctx| self.leg(task, ctx))
    }

    fn replan(&self, previous: &Solution, query: &Query, ctx: &mut Context) -> Result<Solution, PlanError> {
        self.colony.validate()?;
        plan(aim(self.colony.preset, query), query, ctx, |task, ctx| match memory::Memory::recall(previous, task) {
            Some(known) => self.colony.repair(task, known, ctx),
            None => self.leg(task, ctx),
        })
    }
}
