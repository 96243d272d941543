//! Ants walk from the start to the goal and back, with a heuristic of its own in each direction.
//!
//! Source: \[han2024\]: (1) `eta = 1 / (d_ij + d_jg)` with g where the ant is heading, (2) `tau <- (1 - rho) tau + sum_k Q / L_k` after each half of an
//! iteration, the same in both directions, within bounds.
//!
//! | symbol | field |
//! |---|---|
//! | M | `ants` |
//! | alpha, beta, rho, Q | `alpha`, `beta`, `evaporation`, `deposit` |
//! | `tau_0`, bounds | `initial`, `least`, `most` |
//!
//! Departures: `loop_cutting`, `leash` (ants that wander are given up), `horizon` (far from the target ants tell directions apart as well as near it), `elitist` (the best so far deposits as well), `polish` (local search on the best of a half when the colony stands still) and `restart` (back to the
//! initial pheromone, with the best kept, when the choices along the best trail are decided) are ours; `preset=paper` switches them off.

use super::crew::{Crew, March, best_of, better};
use super::pheromone::Pheromone;
use super::rule::{Choices, Heuristic, Rule};
use super::walk::Trail;
use super::{Found, Graph, Seeding, Task, aim, check, memory, plan, polish, seed, sparse};
use crate::context::{Context, Stop};
use crate::error::PlanError;
use crate::plan::{Planner, Preset, Solution};
use crate::query::Query;
use serde::{Deserialize, Serialize};
use serde_json::json;

/// Bidirectional ant colony on the lattice.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct BidirectionalAco {
    /// Settings of the product or of the source.
    pub preset: Preset,
    /// Ants of half an iteration.
    pub ants: usize,
    /// Iterations (there and back), if the budget names none.
    pub iterations: u64,
    /// Iterations without improvement after which it stops.
    pub patience: u64,
    /// Exponent of the pheromone.
    pub alpha: f64,
    /// Exponent of the heuristic.
    pub beta: f64,
    /// Share of the pheromone that evaporates in half an iteration.
    pub evaporation: f64,
    /// Pheromone that an ant spreads over its way, times its length in cells.
    pub deposit: f64,
    /// Initial pheromone.
    pub initial: f64,
    /// Least pheromone.
    pub least: f64,
    /// Largest pheromone.
    pub most: f64,
    /// A trail of another search to begin with.
    pub seeding: Seeding,
    /// Cut loops out of the ways of ants?
    pub loop_cutting: bool,
    /// Steps that an ant may take, in steps of the best trail so far; 0: no limit but that of the source.
    pub leash: f64,
    /// Distance to the target, cells, beyond which ants tell directions apart as well as there; 0: none.
    pub horizon: f64,
    /// Does the best so far deposit in every half?
    pub elitist: bool,
    /// Iterations without improvement after which local search works on the best trails; 0: never. (From the first on it would take the colony's
    /// variety away.)
    pub polish: u64,
    /// Entropy of the choices along the best trail, 0 to 1, below which the pheromone starts anew; 0: never.
    pub restart: f64,
    /// What the ants walk on. Seeding, polish and memory are of the lattice.
    pub graph: Graph,
    /// Do nodes of a sparse graph keep the shortest rest that ants found?
    pub learning: bool,
}

impl Default for BidirectionalAco {
    fn default() -> Self {
        Self {
            preset: Preset::Default,
            seeding: Seeding::AnyAngle,
            loop_cutting: true,
            leash: 20.0,
            horizon: 15.0,
            elitist: true,
            polish: 5,
            restart: 0.02,
            learning: true,
            ..Self::paper()
        }
    }
}

impl BidirectionalAco {
    /// The settings of the source.
    pub fn paper() -> Self {
        Self {
            preset: Preset::Paper,
            ants: 50,
            iterations: 50,
            patience: 15,
            alpha: 1.0,
            beta: 12.0,
            evaporation: 0.2,
            deposit: 1.0,
            initial: 1.0,
            least: 0.01,
            most: 10.0,
            seeding: Seeding::Off,
            loop_cutting: false,
            leash: 0.0,
            horizon: 0.0,
            elitist: false,
            polish: 0,
            restart: 0.0,
            graph: Graph::Lattice,
            learning: false,
        }
    }

    pub(super) fn validate(&self) -> Result<(), PlanError> {
        check::count("ants", self.ants)?;
        check::exponents(self.alpha, self.beta)?;
        check::share("evaporation", self.evaporation)?;
        check::share("restart", self.restart)?;
        check::leash(self.leash)?;
        check::horizon(self.horizon)?;
        for (name, value) in [("deposit", self.deposit), ("initial", self.initial), ("least", self.least), ("most", self.most)] {
            check::positive(name, value)?;
        }
        if self.least > self.most {
            return Err(PlanError::bad("least", self.least, format!("at most `most` = {}", self.most)));
        }
        Ok(())
    }

    /// A short run from what is remembered.
    pub(super) fn repair(&self, task: &Task, known: &memory::Leg, ctx: &mut Context) -> Result<Found, PlanError> {
        let (ants, iterations) = memory::REPAIR;
        let begin = known.begin(task, self.seeding, ctx)?;
        Ok(Self { ants, iterations, ..*self }.colony(task, begin, Some(known), ctx))
    }

    /// Runs the colony, beginning with a trail that it may have, and with what it remembers.
    pub(super) fn colony(&self, task: &Task, begin: Option<Trail>, known: Option<&memory::Leg>, ctx: &mut Context) -> Found {
        let mut run = Run::new(self, task, begin, ctx);
        if let Some(known) = known {
            known.spread(task, &mut run.tau, self.least);
        }
        let mut stop = Stop::Converged;
        let first = ctx.iterations();
        let rounds = ctx.budget().iterations.map_or(self.iterations, |n| n.saturating_sub(first)).max(1);
        for number in 0..rounds {
            let before = run.score();
            if let Err(why) = run.half(false, 2 * (first + number), ctx).and_then(|()| run.half(true, 2 * (first + number) + 1, ctx)) {
                stop = why;
                break;
            }
            run.still = if run.score() == before { run.still + 1 } else { 0 };
            if let Some(why) = ctx.tick(task.cost(run.best.as_ref())) {
                stop = why;
                break;
            }
            if run.still >= self.patience {
                break;
            }
            run.restart();
        }
        run.choices.forget();
        let mut found = Found::new(task, run.best, stop, &run.tau, ctx);
        found.trace["restarts"] = json!(run.restarts);
        found
    }
}

/// A colony at work.
struct Run<'a> {
    method: &'a BidirectionalAco,
    task: &'a Task<'a>,
    crew: Crew<'a, super::Streets<'a>>,
    tau: Pheromone<'a>,
    choices: Choices,
    best: Option<Trail>,
    /// Iterations since the last improvement.
    still: u64,
    restarts: u32,
}

impl<'a> Run<'a> {
    fn new(method: &'a BidirectionalAco, task: &'a Task<'a>, begin: Option<Trail>, ctx: &Context) -> Self {
        let crew = Crew::new(task.roads, task.aim, method.loop_cutting, task.steps(), ctx);
        let tau = Pheromone::new(task.roads, |_| method.initial, method.evaporation, [method.least, method.most]);
        let choices = Choices::new(task.roads, method.rule(), task.goal).with_horizon(method.horizon);
        let mut run = Self { method, task, crew, tau, choices, best: begin, still: 0, restarts: 0 };
        run.raise();
        run
    }

    fn score(&self) -> Option<crate::plan::score::Score> {
        self.best.as_ref().map(|t| t.score)
    }

    /// Raises the pheromone along the best trail: `tau_0 (1 + 2 L_lb / L)`.
    fn raise(&mut self) {
        let Some(best) = &self.best else { return };
        let [a, b] = [self.task.leg.start, self.task.leg.goal];
        let (dx, dy) = (f64::from(a[0].abs_diff(b[0])), f64::from(a[1].abs_diff(b[1])));
        let octile = dx.max(dy) + (std::f64::consts::SQRT_2 - 1.0) * dx.min(dy);
        let value = self.method.initial * (1.0 + 2.0 * octile / best.length.max(f64::MIN_POSITIVE));
        for (exit, from) in best.exits.iter().zip(&best.nodes) {
            self.tau.assign(self.task.roads, *from, *exit, value);
        }
    }

    /// Half an iteration: there, or back.
    fn half(&mut self, back: bool, number: u64, ctx: &mut Context) -> Result<(), Stop> {
        let (from, to) = if back { (self.task.goal, self.task.start) } else { (self.task.start, self.task.goal) };
        self.choices.renew(self.method.rule(), to);
        self.crew.keep_on_leash(self.best.as_ref(), self.method.leash);
        let trails = self.crew.generation(&March { ants: self.method.ants, from, number }, &self.tau, &self.choices, ctx)?;
        let found = best_of(&trails).cloned().map(|t| if back { t.reversed(self.task.roads) } else { t });
        let found = found.map(|t| if self.method.polish > 0 && self.still >= self.method.polish { polish::polish(self.task, t) } else { t });
        self.best = better(self.best.take(), found.as_ref());
        self.tau.evaporate();
        let elite = self.best.iter().filter(|_| self.method.elitist);
        for trail in trails.iter().chain(elite) {
            self.crew.mark(&mut self.tau, trail, self.method.deposit / trail.length.max(1.0)); // (2)
        }
        Ok(())
    }

    /// Begins anew when the choices along the best trail are decided.
    fn restart(&mut self) {
        let Some(best) = self.best.as_ref().filter(|_| self.method.restart > 0.0) else { return };
        self.choices.renew(self.method.rule(), self.task.goal);
        let entropies = best.nodes.iter().map(|node| self.choices.entropy(self.task.roads, &self.tau, *node));
        let mean = entropies.sum::<f64>() / best.nodes.len() as f64;
        if mean < self.method.restart {
            self.tau.restart();
            self.restarts += 1;
        }
    }
}

impl BidirectionalAco {
    fn rule(&self) -> Rule {
        Rule { alpha: self.alpha, beta: self.beta, heuristic: Heuristic::Detour, greedy: 0.0, uniform: 0.0 }
    }
}

impl BidirectionalAco {
    /// The same colony on the sparse graph.
    fn sparse(&self) -> sparse::Settings {
        sparse::Settings {
            ants: self.ants,
            iterations: self.iterations,
            patience: self.patience,
            alpha: [self.alpha; 2],
            beta: [self.beta; 2],
            labour: None,
            evaporation: self.evaporation,
            deposit: self.deposit,
            initial: self.initial,
            cone: None,
            bounds: [self.least, self.most],
            elitist: self.elitist,
            restart: self.restart,
            learning: self.learning,
            focus: if self.learning { sparse::FOCUS } else { 1.0 },
        }
    }

    fn on_lattice(&self, task: &Task, ctx: &mut Context) -> Result<Found, PlanError> {
        let begin = seed::trail(task, self.seeding, ctx)?;
        Ok(self.colony(task, begin, None, ctx))
    }
}

impl Planner for BidirectionalAco {
    fn plan(&self, query: &Query, ctx: &mut Context) -> Result<Solution, PlanError> {
        self.validate()?;
        let aim = aim(self.preset, query);
        match self.graph {
            Graph::Lattice => plan(aim, query, ctx, |task, ctx| self.on_lattice(task, ctx)),
            Graph::Corners => sparse::plan(aim, self.sparse(), query, ctx, |task, ctx| self.on_lattice(task, ctx)),
        }
    }

    fn replan(&self, previous: &Solution, query: &Query, ctx: &mut Context) -> Result<Solution, PlanError> {
        self.validate()?;
        if self.graph != Graph::Lattice {
            return self.plan(query, ctx);
        }
        plan(aim(self.preset, query), query, ctx, |task, ctx| match memory::Memory::recall(previous, task) {
            Some(known) => self.repair(task, known, ctx),
            None => self.on_lattice(task, ctx),
        })
    }
}
