//! Improved ant colony: six improvements of the ant system, each of them a switch.
//!
//! Source: \[lu2025\], global layer. O1 cone of initial pheromone (1), O2 growing exponents (2), O3 division of labour (3) (4), O4 dead ends, O5 smoothing
//! under a curvature limit, O6 combined flow: (5) `tau <- (1 - rho) tau + sum_k w_k Q / D_k + Q / D_best` within bounds, ants that were given up are placed
//! again.
//!
//! | symbol | field |
//! |---|---|
//! | m, N | `ants`, `iterations` |
//! | alpha, beta without O2 | `alpha`, `beta` |
//! | alpha, beta at n = 0 and n = N | `alpha_range`, `beta_range` |
//! | `tau_0` without O1, `tau_init` of O1 | `initial`, `cone` |
//! | rho, Q | `evaporation`, `deposit` |
//!
//! Departures: as printed, (1) is infinite at the goal and zero along the line that it should favour, and (4) is imaginary; `o1_reading` and `conversion` choose
//! among what can be computed. O6 has no operator of its own in the source; here it is the deposit of the best so far, the bounds and the second placing.
//! With all six off this is the ant system. O5 leaves the lattice path alone and puts the smoothed one into the trace: the path of a plan is smoothed
//! by a refiner. `heuristic`, `bounds=max-min`, `conversion=entropy`, `polish`, `restart`, `seeding` and the cutting of loops are ours.

pub(super) mod cone;
mod deadlock;
pub(super) mod labour;
mod run;
#[cfg(test)]
mod tests;

use super::roads::Roads;
use super::rule::{Heuristic, Rule};
use super::walk::Trail;
use super::{Found, Graph, Seeding, Task, aim, check, memory, plan, polish, seed, sparse};
use crate::context::Context;
use crate::error::PlanError;
use crate::path::{Path, measure};
use crate::plan::{Planner, Preset, Solution};
use crate::query::Query;
use crate::refine::{Refiner, Smooth};
use run::{Ground, Run};
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

/// Which form of an equation is used.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Reading {
    /// As printed, made finite.
    Literal,
    /// Such that it does what the text says.
    Corrected,
}

/// When soldiers become kings.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Conversion {
    /// By the stimulus (3), at most 18 % of them in an iteration.
    Stimulus,
    /// 18 % of them in every iteration.
    Rate,
    /// The share of soldiers is larger where the choices along the best trail are decided, and falls again.
    Entropy,
}

/// What keeps the pheromone within bounds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Bounds {
    /// `least` and `most`, as a part of O6.
    Fixed,
    /// Those of the max-min ant system for the best so far, and only the best of the iteration and the best so far deposit.
    MaxMin,
}

/// Improved ant colony on the lattice.
#[expect(clippy::struct_excessive_bools, reason = "every improvement is a switch")]
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ImprovedAco {
    /// Settings of the product or of the source.
    pub preset: Preset,
    /// Ants of a generation.
    pub ants: usize,
    /// Generations, if the budget names none.
    pub iterations: u64,
    /// Initial pheromone in a cone around the straight line?
    pub o1: bool,
    /// Exponents that grow?
    pub o2: bool,
    /// Division of labour?
    pub o3: bool,
    /// Tabu table of dead ends?
    pub o4: bool,
    /// Smoothed path in the trace?
    pub o5: bool,
    /// Best so far deposits, bounds, ants placed again?
    pub o6: bool,
    /// The form of the cone (1).
    pub o1_reading: Reading,
    /// When soldiers become kings (3).
    pub conversion: Conversion,
    /// Exponent of the pheromone without O2.
    pub alpha: f64,
    /// Exponent of the heuristic without O2.
    pub beta: f64,
    /// Exponent of the pheromone with O2, first and last.
    pub alpha_range: [f64; 2],
    /// Exponent of the heuristic with O2, first and last.
    pub beta_range: [f64; 2],
    /// Visibility of a neighbour.
    pub heuristic: Heuristic,
    /// Share of the pheromone that evaporates in a generation.
    pub evaporation: f64,
    /// Pheromone that an ant spreads over its way, times its length in cells.
    pub deposit: f64,
    /// Initial pheromone without O1.
    pub initial: f64,
    /// Mean initial pheromone with O1.
    pub cone: f64,
    /// What keeps the pheromone within bounds.
    pub bounds: Bounds,
    /// Least pheromone (fixed bounds).
    pub least: f64,
    /// Largest pheromone (fixed bounds).
    pub most: f64,
    /// Probability of drawing the best trail when the search has converged; sets the lower of the max-min bounds.
    pub best_probability: f64,
    /// Largest curvature of the smoothed path of O5, 1/m.
    pub max_curvature: f64,
    /// A trail of another search to begin with.
    pub seeding: Seeding,
    /// Cut loops out of the ways of ants?
    pub loop_cutting: bool,
    /// Steps that an ant may take, in steps of the best trail so far; 0: no limit but that of the source.
    pub leash: f64,
    /// Distance to the target, cells, beyond which ants tell directions apart as well as there; 0: none.
    pub horizon: f64,
    /// Cut loops out of the ways of kings?
    pub king_cutting: bool,
    /// After every so many iterations without improvement local search works on the best trail of the iteration; 0: never.
    pub polish: u64,
    /// Entropy of the choices along the best trail, 0 to 1, below which the pheromone starts anew; 0: never.
    pub restart: f64,
    /// What the ants walk on. On corners O4 is the rollback that all ants have, and O5, seeding, polish and memory are left out.
    pub graph: Graph,
    /// Do nodes of a sparse graph keep the shortest rest that ants found?
    pub learning: bool,
}

impl Default for ImprovedAco {
    fn default() -> Self {
        Self {
            preset: Preset::Default,
            o2: false,
            o3: false,
            o4: false,
            o5: false,
            conversion: Conversion::Entropy,
            beta: 12.0,
            alpha_range: [1.0, 1.5],
            beta_range: [8.0, 12.0],
            heuristic: Heuristic::Detour,
            cone: 1.0,
            least: 0.01,
            seeding: Seeding::AnyAngle,
            loop_cutting: true,
            leash: 20.0,
            horizon: 15.0,
            polish: 5,
            restart: 0.02,
            learning: true,
            ..Self::paper()
        }
    }
}

impl ImprovedAco {
    /// The settings of the source.
    pub fn paper() -> Self {
        Self {
            preset: Preset::Paper,
            ants: 50,
            iterations: 100,
            o1: true,
            o2: true,
            o3: true,
            o4: true,
            o5: true,
            o6: true,
            o1_reading: Reading::Corrected,
            conversion: Conversion::Stimulus,
            alpha: 1.0,
            beta: 5.0,
            alpha_range: [1.2, 3.8],
            beta_range: [2.5, 5.2],
            heuristic: Heuristic::Goal,
            evaporation: 0.15,
            deposit: 1.0,
            initial: 1.0,
            cone: 1e-4,
            bounds: Bounds::Fixed,
            least: 1e-6,
            most: 10.0,
            best_probability: 0.05,
            max_curvature: 0.28,
            seeding: Seeding::Off,
            loop_cutting: false,
            leash: 0.0,
            horizon: 0.0,
            king_cutting: false,
            polish: 0,
            restart: 0.0,
            graph: Graph::Lattice,
            learning: false,
        }
    }

    fn validate(&self) -> Result<(), PlanError> {
        check::count("ants", self.ants)?;
        check::exponents(self.alpha, self.beta)?;
        check::exponents(self.alpha_range[0], self.beta_range[0])?;
        check::exponents(self.alpha_range[1], self.beta_range[1])?;
        check::share("evaporation", self.evaporation)?;
        check::share("restart", self.restart)?;
        check::probability("best_probability", self.best_probability)?;
        for (name, value) in [("deposit", self.deposit), ("initial", self.initial), ("cone", self.cone), ("least", self.least), ("most", self.most)] {
            check::positive(name, value)?;
        }
        check::positive("max_curvature", self.max_curvature)?;
        check::leash(self.leash)?;
        check::horizon(self.horizon)?;
        check::order("least", self.least, "most", self.most)
    }

    /// Rule of a plain ant when the share `progress` of the iterations is over.
    fn rule(&self, progress: f64) -> Rule {
        let grown = |range: [f64; 2]| range[0] + (range[1] - range[0]) * progress * progress; // (2), in closed form
        let (alpha, beta) = if self.o2 { (grown(self.alpha_range), grown(self.beta_range)) } else { (self.alpha, self.beta) };
        Rule { alpha, beta, heuristic: self.heuristic, greedy: 0.0, uniform: 0.0 }
    }

    /// The same colony on the sparse graph.
    fn sparse(&self) -> sparse::Settings {
        let [first, last] = [self.rule(0.0), self.rule(1.0)];
        sparse::Settings {
            ants: self.ants,
            iterations: self.iterations,
            patience: sparse::PATIENCE,
            alpha: [first.alpha, last.alpha],
            beta: [first.beta, last.beta],
            labour: self.o3.then_some(self.conversion),
            evaporation: self.evaporation,
            deposit: self.deposit,
            initial: self.initial,
            cone: self.o1.then_some((self.o1_reading, self.cone)),
            bounds: [self.least, self.most],
            elitist: self.o6,
            restart: self.restart,
            learning: self.learning,
            focus: if self.learning { sparse::FOCUS } else { 1.0 },
        }
    }

    fn on_lattice(&self, task: &Task, ctx: &mut Context) -> Result<Found, PlanError> {
        let begin = seed::trail(task, self.seeding, ctx)?;
        Ok(self.colony(task, begin, None, ctx))
    }

    /// Runs the colony on the lattice, beginning with a trail that it may have, and with what it remembers.
    fn colony(&self, task: &Task, begin: Option<Trail>, known: Option<&memory::Leg>, ctx: &mut Context) -> Found {
        let lattice = task.leg.lattice;
        let ground = Ground {
            roads: task.roads,
            ends: [task.start, task.goal],
            aim: task.aim,
            side: f64::from(lattice.width().max(lattice.height())),
            steps: task.steps(),
            polish: &|trail| polish::polish(task, trail),
            cost: &|best| task.cost(best),
        };
        let mut run = Run::new(self, &ground, begin, ctx);
        if let Some(known) = known {
            known.spread(task, &mut run.tau, self.least);
        }
        let (mut run, stop) = run.finish(ctx);
        run.forget();
        let mut found = Found::new(task, run.best.take(), stop, &run.tau, ctx);
        let trace = &mut found.trace;
        trace["restarts"] = json!(run.restarts);
        trace["again"] = json!(run.again);
        trace["kings"] = json!(run.kings());
        trace["tabu"] = run.tabu.iter().enumerate().filter(|(_, tabu)| **tabu).map(|(node, _)| json!(task.roads.cell(node as u32))).collect();
        if self.o5 {
            trace["smoothed"] = self.smoothed(task, found.best.as_ref(), ctx);
        }
        found
    }

    /// O5: the path of this leg smoothed, as a record: its length (m), its largest curvature (1/m) and what could not be met.
    fn smoothed(&self, task: &Task, best: Option<&Trail>, ctx: &mut Context) -> Value {
        let Some(best) = best else { return Value::Null };
        let lattice = task.leg.lattice;
        let points: Vec<_> = best.nodes.iter().map(|node| lattice.center(task.roads.cell(*node))).collect();
        let query = Query { start: points[0], goal: points[points.len() - 1], via: Vec::new(), ..task.leg.query.clone() };
        let smooth = Smooth { max_curvature: Some(self.max_curvature), ..Smooth::default() };
        match smooth.refine(&Path::polyline(&points), &query, ctx) {
            Ok(refined) => json!({
                "length": refined.path.length(),
                "max_curvature": measure(&refined.path, &query.world, query.radius()).max_curvature,
                "unmet": refined.unmet,
            }),
            Err(error) => json!({ "error": error.to_string() }),
        }
    }
}

impl Planner for ImprovedAco {
    fn plan(&self, query: &Query, ctx: &mut Context) -> Result<Solution, PlanError> {
        self.validate()?;
        let aim = aim(self.preset, query);
        match self.graph {
            Graph::Lattice => plan(aim, query, ctx, |task, ctx| self.on_lattice(task, ctx)),
            Graph::Corners => sparse::plan(aim, self.sparse(), query, ctx, |task, ctx| self.on_lattice(task, ctx)),
        }
    }

    /// Repairs the last way with fewer ants and iterations, with the pheromone that was there.
    fn replan(&self, previous: &Solution, query: &Query, ctx: &mut Context) -> Result<Solution, PlanError> {
        self.validate()?;
        if self.graph != Graph::Lattice {
            return self.plan(query, ctx);
        }
        let (ants, iterations) = memory::REPAIR;
        let quick = Self { ants, iterations, ..*self };
        plan(aim(self.preset, query), query, ctx, |task, ctx| match memory::Memory::recall(previous, task) {
            Some(known) => Ok(quick.colony(task, known.begin(task, self.seeding, ctx)?, Some(known), ctx)),
            None => Ok(self.colony(task, seed::trail(task, self.seeding, ctx)?, None, ctx)),
        })
    }
}
