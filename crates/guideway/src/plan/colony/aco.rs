//! The ant system in its ant-cycle form: every ant that arrives deposits.
//!
//! Source: \[dorigo1996\]; (1) transition `P_ij ~ tau_ij^alpha eta_ij^beta`, (2) `tau <- (1 - rho) tau + sum_k Q / L_k`.
//!
//! | symbol | field |
//! |---|---|
//! | alpha, beta | `alpha`, `beta` |
//! | eta | `heuristic` |
//! | rho, Q, `tau_0` | `evaporation`, `deposit`, `initial` |
//! | m | `ants` |
//!
//! Departures: the source plans tours; here ants walk from start to goal, back out of dead ends, and visit no cell twice.

use super::crew::{Crew, March, best_of, better};
use super::pheromone::Pheromone;
use super::rule::{Choices, Heuristic, Rule};
use super::{Found, Task, aim, plan};
use crate::context::{Context, Stop};
use crate::error::PlanError;
use crate::plan::{Planner, Preset, Solution};
use crate::query::Query;
use serde::{Deserialize, Serialize};

/// Ant system on the lattice.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Aco {
    /// Settings of the product or of the source.
    pub preset: Preset,
    /// Ants of a generation.
    pub ants: usize,
    /// Generations, if the budget names none.
    pub iterations: u64,
    /// Exponent of the pheromone.
    pub alpha: f64,
    /// Exponent of the heuristic.
    pub beta: f64,
    /// Visibility of a neighbour.
    pub heuristic: Heuristic,
    /// Share of the pheromone that evaporates in a generation.
    pub evaporation: f64,
    /// Pheromone that an ant spreads over its way, times its length in cells.
    pub deposit: f64,
    /// Initial pheromone.
    pub initial: f64,
    /// Cut loops out of the ways of ants?
    pub loop_cutting: bool,
}

impl Default for Aco {
    fn default() -> Self {
        Self {
            preset: Preset::Default,
            ants: 50,
            iterations: 100,
            alpha: 1.0,
            beta: 5.0,
            heuristic: Heuristic::Goal,
            evaporation: 0.15,
            deposit: 1.0,
            initial: 1.0,
            loop_cutting: true,
        }
    }
}

impl Aco {
    /// As in the comparisons of the sources: loops are not cut.
    pub fn paper() -> Self {
        Self { preset: Preset::Paper, loop_cutting: false, ..Self::default() }
    }

    fn validate(&self) -> Result<(), PlanError> {
        use super::check;
        check::count("ants", self.ants)?;
        check::exponents(self.alpha, self.beta)?;
        check::share("evaporation", self.evaporation)?;
        check::positive("deposit", self.deposit)?;
        check::positive("initial", self.initial)
    }

    fn colony(&self, task: &Task, ctx: &mut Context) -> Found {
        let roads = task.roads;
        let rule = Rule { alpha: self.alpha, beta: self.beta, heuristic: self.heuristic, greedy: 0.0, uniform: 0.0 };
        let mut tau = Pheromone::new(roads, |_| self.initial, self.evaporation, [1e-12, 1e12]);
        let mut choices = Choices::new(roads, rule, task.goal);
        let crew = Crew::new(roads, task.aim, self.loop_cutting, task.steps(), ctx);
        let mut best = None;
        let rounds = ctx.budget().iterations.unwrap_or(self.iterations).max(1);
        let stop = 'colony: {
            for number in 0..rounds {
                let march = March { ants: self.ants, from: task.start, number };
                let trails = match crew.generation(&march, &tau, &choices, ctx) {
                    Ok(trails) => trails,
                    Err(stop) => break 'colony stop,
                };
                best = better(best, best_of(&trails));
                tau.evaporate();
                crew.mark_all(&mut tau, trails.iter().map(|trail| (trail, self.deposit / trail.length.max(1.0)))); // (2)
                choices.renew(rule, task.goal);
                if let Some(stop) = ctx.tick(task.cost(best.as_ref())) {
                    break 'colony stop;
                }
            }
            Stop::Converged
        };
        Found::new(task, best, stop, &tau, ctx)
    }
}

impl Planner for Aco {
    fn plan(&self, query: &Query, ctx: &mut Context) -> Result<Solution, PlanError> {
        self.validate()?;
        plan(aim(self.preset, query), query, ctx, |task, ctx| Ok(self.colony(task, ctx)))
    }
}
