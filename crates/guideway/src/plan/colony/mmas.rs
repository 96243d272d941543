//! Max-min ant system: only the best ant deposits, and the pheromone stays between bounds.
//!
//! Source: \[stutzle2000\]; (1) `tau <- (1 - rho) tau + 1 / f(best)`, (2) `tau_max = 1 / (rho f(best so far))`,
//! (3) `tau_min = tau_max (1 - p) / ((avg - 1) p)` with `p = p_best^(1/l)`, (4) smoothing `tau <- tau + 0.5 (tau_max - tau)`.
//!
//! | symbol | field |
//! |---|---|
//! | alpha, beta, rho, m | `alpha`, `beta`, `evaporation`, `ants` |
//! | `p_best` | `best_probability` |
//! | eta | `heuristic` |
//!
//! Departures: the best of the iteration deposits, every `elite_every`-th iteration the best so far; `avg` is half the mean number of exits along the
//! best trail, `l` its number of steps; smoothing when all ants took the same trail for `stagnation` iterations.

use super::crew::{Crew, March, best_of, better};
use super::pheromone::Pheromone;
use super::roads::Roads;
use super::rule::{Choices, Heuristic, Rule};
use super::walk::Trail;
use super::{Found, Task, aim, check, plan};
use crate::context::{Context, Stop};
use crate::error::PlanError;
use crate::plan::{Planner, Preset, Solution};
use crate::query::Query;
use serde::{Deserialize, Serialize};

/// Max-min ant system on the lattice.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Mmas {
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
    /// Probability of drawing the best trail when the search has converged; sets the lower bound.
    pub best_probability: f64,
    /// Every so many generations the best so far deposits instead of the best of the generation.
    pub elite_every: u64,
    /// Generations of equal trails after which the pheromone is smoothed.
    pub stagnation: u32,
    /// Cut loops out of the ways of ants?
    pub loop_cutting: bool,
}

impl Default for Mmas {
    fn default() -> Self {
        Self {
            preset: Preset::Default,
            ants: 50,
            iterations: 100,
            alpha: 1.0,
            beta: 5.0,
            heuristic: Heuristic::Goal,
            evaporation: 0.15,
            best_probability: 0.05,
            elite_every: 5,
            stagnation: 10,
            loop_cutting: true,
        }
    }
}

/// Bounds of the pheromone, (2) and (3), for a best trail.
pub(super) fn bounds(roads: &impl Roads, best: &Trail, rho: f64, best_probability: f64) -> [f64; 2] {
    let most = 1.0 / (rho.max(1e-9) * best.score.cost.max(1.0)); // (2)
    let mut exits = Vec::new();
    let count = |node: &u32| {
        roads.exits(*node, &mut exits);
        exits.len()
    };
    let steps = best.exits.len().max(1) as f64;
    let average = best.nodes.iter().map(count).sum::<usize>() as f64 / best.nodes.len() as f64 / 2.0;
    let p = best_probability.powf(1.0 / steps);
    let least = most * (1.0 - p) / ((average - 1.0).max(0.1) * p); // (3)
    [least.min(most).max(f64::MIN_POSITIVE), most]
}

impl Mmas {
    /// As in the comparisons of the sources: loops are not cut.
    pub fn paper() -> Self {
        Self { preset: Preset::Paper, loop_cutting: false, ..Self::default() }
    }

    fn validate(&self) -> Result<(), PlanError> {
        check::count("ants", self.ants)?;
        check::exponents(self.alpha, self.beta)?;
        check::share("evaporation", self.evaporation)?;
        if !(1e-9..1.0).contains(&self.best_probability) {
            return Err(PlanError::bad("best_probability", self.best_probability, "1e-9 to 1, 1 excluded"));
        }
        if self.elite_every == 0 {
            return Err(PlanError::bad("elite_every", 0, "1 or more"));
        }
        Ok(())
    }

    fn colony(&self, task: &Task, ctx: &mut Context) -> Found {
        let roads = task.roads;
        let rule = Rule { alpha: self.alpha, beta: self.beta, heuristic: self.heuristic, greedy: 0.0, uniform: 0.0 };
        let mut tau = Pheromone::new(roads, |_| 1.0, self.evaporation, [f64::MIN_POSITIVE, 1.0]);
        let mut choices = Choices::new(roads, rule, task.goal);
        let crew = Crew::new(roads, task.aim, self.loop_cutting, task.steps(), ctx);
        let (mut best, mut equal) = (None, 0);
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
                if let (Some(best), Some(now)) = (&best, best_of(&trails)) {
                    tau.bound(bounds(roads, best, self.evaporation, self.best_probability));
                    let chosen = if (number + 1).is_multiple_of(self.elite_every) { best } else { now };
                    crew.mark(&mut tau, chosen, 1.0 / chosen.score.cost.max(1.0)); // (1)
                    equal = if trails.iter().all(|t| t.nodes == now.nodes) { equal + 1 } else { 0 };
                    if equal >= self.stagnation {
                        tau.smooth(bounds(roads, best, self.evaporation, self.best_probability)[1]); // (4)
                        equal = 0;
                    }
                }
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

impl Planner for Mmas {
    fn plan(&self, query: &Query, ctx: &mut Context) -> Result<Solution, PlanError> {
        self.validate()?;
        plan(aim(self.preset, query), query, ctx, |task, ctx| Ok(self.colony(task, ctx)))
    }
}
