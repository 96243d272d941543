//! The loop of the improved ant colony, on any graph.

use super::super::crew::{Crew, March, best_of, better};
use super::super::mmas;
use super::super::pheromone::Pheromone;
use super::super::rule::Choices;
use super::cone::Cone;
use super::deadlock::{Maze, Outcome};
use super::labour::{self, Role, Signs};
use super::{Bounds, ImprovedAco, Roads, Trail};
use crate::context::{Context, Stop};
use crate::plan::score::{Aim, Score};

/// Generations between two changes of the exponents.
const REFRESH: u64 = 5;
/// Times that an ant may be placed again in an iteration.
const AGAIN: u32 = 2;

/// Where a colony works.
pub(super) struct Ground<'a, R> {
    pub roads: &'a R,
    /// Start and goal.
    pub ends: [u32; 2],
    pub aim: Aim,
    /// Side of the map, cells.
    pub side: f64,
    /// Largest number of steps of an ant, those back included.
    pub steps: usize,
    /// Local search on a trail.
    pub polish: &'a (dyn Fn(Trail) -> Trail + Sync + 'a),
    /// What the whole way costs so far with the best trail, m.
    pub cost: &'a (dyn Fn(Option<&Trail>) -> f64 + Sync + 'a),
}

/// A colony at work.
pub(super) struct Run<'a, R> {
    method: &'a ImprovedAco,
    ground: &'a Ground<'a, R>,
    crew: Crew<'a, R>,
    pub tau: Pheromone<'a>,
    /// What plain ants and soldiers choose by.
    choices: Choices,
    /// What kings choose by; only with O3.
    royal: Option<Choices>,
    roles: Vec<Role>,
    /// Nodes that lead nowhere.
    pub tabu: Vec<bool>,
    pub best: Option<Trail>,
    /// Iterations since the last improvement.
    still: u64,
    pub restarts: u32,
    /// Ants that were placed again.
    pub again: u64,
}

impl<'a, R: Roads> Run<'a, R> {
    pub fn new(method: &'a ImprovedAco, ground: &'a Ground<'a, R>, begin: Option<Trail>, ctx: &Context) -> Self {
        let roads = ground.roads;
        let crew = Crew::new(roads, ground.aim, method.loop_cutting, ground.steps, ctx);
        let bounds = if method.o6 || method.bounds == Bounds::MaxMin { [method.least, method.most] } else { [1e-12, 1e12] };
        let cone = Cone::new(roads, method.o1_reading, ground.ends, ground.side);
        let scale = if method.o1 { method.cone / cone.mean(roads) } else { 0.0 };
        let plain = (!method.o1).then_some(method.initial);
        let initial = move |node| plain.unwrap_or_else(|| scale * cone.strength(roads.position(node)));
        let tau = Pheromone::new(roads, initial, method.evaporation, bounds);
        let (rule, goal) = (method.rule(0.0), ground.ends[1]);
        let mut run = Self {
            method,
            ground,
            crew,
            tau,
            choices: Choices::new(roads, rule, goal).with_horizon(method.horizon),
            royal: method.o3.then(|| Choices::new(roads, rule, goal).with_horizon(method.horizon)),
            roles: if method.o3 { labour::roles(method.ants) } else { Vec::new() },
            tabu: if method.o4 { vec![false; roads.nodes()] } else { Vec::new() },
            best: begin,
            still: 0,
            restarts: 0,
            again: 0,
        };
        run.raise();
        run
    }

    /// Makes the trail to begin with a little stronger than what is around it.
    fn raise(&mut self) {
        let Some(best) = &self.best else { return };
        for (exit, from) in best.exits.iter().zip(&best.nodes) {
            let now = self.tau.at(*exit);
            self.tau.assign(self.ground.roads, *from, *exit, 3.0 * now);
        }
    }

    /// All iterations.
    pub fn finish(mut self, ctx: &mut Context) -> (Self, Stop) {
        let first = ctx.iterations();
        let rounds = ctx.budget().iterations.map_or(self.method.iterations, |n| n.saturating_sub(first)).max(1);
        for number in 0..rounds {
            let progress = (number + 1) as f64 / rounds as f64;
            if number.is_multiple_of(REFRESH) {
                self.renew(progress);
            } else {
                self.keep();
            }
            if let Err(stop) = self.iteration(first + number, progress, ctx) {
                return (self, stop);
            }
            if let Some(stop) = ctx.tick((self.ground.cost)(self.best.as_ref())) {
                return (self, stop);
            }
        }
        (self, Stop::Converged)
    }

    /// New exponents for all ants.
    fn renew(&mut self, progress: f64) {
        let (rule, goal) = (self.method.rule(progress), self.ground.ends[1]);
        if let Some(royal) = &mut self.royal {
            self.choices.renew(Role::Soldier.rule(rule), goal);
            royal.renew(Role::King.rule(rule), goal);
        } else {
            self.choices.renew(rule, goal);
        }
    }

    /// The pheromone has changed, the exponents have not.
    fn keep(&mut self) {
        for choices in std::iter::once(&mut self.choices).chain(&mut self.royal) {
            choices.renew(choices.rule(), choices.target());
        }
    }

    fn role(&self, ant: usize) -> Role {
        self.roles.get(ant).copied().unwrap_or(Role::Soldier)
    }

    fn iteration(&mut self, number: u64, progress: f64, ctx: &mut Context) -> Result<(), Stop> {
        self.crew.keep_on_leash(self.best.as_ref(), self.method.leash);
        let outcomes = self.walks(number, ctx)?;
        let again: u64 = outcomes.iter().map(|o| u64::from(o.again)).sum();
        ctx.count_evaluations(again);
        self.again += again;
        for node in outcomes.iter().flat_map(|o| &o.tabu) {
            self.tabu[*node as usize] = true;
        }
        let (weights, trails): (Vec<f64>, Vec<Trail>) = outcomes
            .into_iter()
            .enumerate()
            .filter_map(|(ant, outcome)| outcome.trail.map(|trail| (if self.royal.is_some() { self.role(ant).weight() } else { 1.0 }, trail)))
            .unzip();
        self.remember(best_of(&trails));
        self.mark(&trails, &weights);
        let entropy = self.entropy();
        if self.royal.is_some() {
            let lengths: Vec<f64> = trails.iter().map(|t| t.length).collect();
            let [mean, deviation] = labour::statistics(&lengths, self.method.ants);
            let signs = Signs { progress, mean, deviation, entropy };
            labour::convert(&mut self.roles, self.method.conversion, &signs, &mut ctx.rng);
        }
        if entropy < self.method.restart && self.best.is_some() {
            self.tau.restart();
            self.restarts += 1;
        }
        Ok(())
    }

    /// Sends the ants out.
    fn walks(&self, number: u64, ctx: &mut Context) -> Result<Vec<Outcome>, Stop> {
        let method = self.method;
        let march = March { ants: method.ants, from: self.ground.ends[0], number };
        let retries = if method.o6 { AGAIN } else { 0 };
        self.crew.march(&march, ctx, |ant, legs, rng| {
            let king = self.royal.as_ref().filter(|_| self.role(ant) == Role::King);
            let choices = king.unwrap_or(&self.choices);
            let cut = method.loop_cutting || king.is_some() && method.king_cutting;
            let maze = Maze { crew: &self.crew, tau: &self.tau, tabu: &self.tabu, start: self.ground.ends[0], retries, cut };
            maze.walk(choices, legs, rng)
        })
    }

    fn remember(&mut self, found: Option<&Trail>) {
        // Not in every iteration: on winding ways local search is dearer than the ants.
        let standing = self.method.polish > 0 && self.still > 0 && self.still.is_multiple_of(self.method.polish);
        let found = found.map(|t| if standing { (self.ground.polish)(t.clone()) } else { t.clone() });
        let before = self.best.as_ref().map_or(Score::WORST, |t| t.score);
        self.best = better(self.best.take(), found.as_ref());
        let improved = self.best.as_ref().is_some_and(|t| t.score.beats(before));
        self.still = if improved { 0 } else { self.still + 1 };
    }

    /// Evaporation and deposits.
    fn mark(&mut self, trails: &[Trail], weights: &[f64]) {
        let method = self.method;
        self.tau.evaporate();
        let amount = |trail: &Trail| method.deposit / trail.length.max(1.0);
        if method.bounds == Bounds::MaxMin {
            if let Some(best) = &self.best {
                self.tau.bound(mmas::bounds(self.ground.roads, best, method.evaporation, method.best_probability));
            }
            if let Some(trail) = best_of(trails) {
                self.crew.mark(&mut self.tau, trail, amount(trail));
            }
        } else {
            self.crew.mark_all(&mut self.tau, trails.iter().zip(weights).map(|(trail, weight)| (trail, weight * amount(trail)))); // (5)
        }
        for best in self.best.iter().filter(|_| method.o6) {
            self.crew.mark(&mut self.tau, best, amount(best)); // (5)
        }
    }

    /// Mean entropy of the choices of a plain ant along the best trail; 1 without one, or where nothing asks for it.
    fn entropy(&mut self) -> f64 {
        let asked = self.method.restart > 0.0 || self.royal.is_some() && self.method.conversion == super::Conversion::Entropy;
        let Some(best) = self.best.as_ref().filter(|_| asked) else { return 1.0 };
        self.choices.renew(self.choices.rule(), self.ground.ends[1]);
        let inner = &best.nodes[..best.nodes.len() - 1];
        let sum: f64 = inner.iter().map(|node| self.choices.entropy(self.ground.roads, &self.tau, *node)).sum();
        sum / inner.len().max(1) as f64
    }

    /// Gives the memory of the ants' choices back.
    pub fn forget(&mut self) {
        std::iter::once(&mut self.choices).chain(&mut self.royal).for_each(Choices::forget);
    }

    /// Number of kings.
    pub fn kings(&self) -> usize {
        self.roles.iter().filter(|r| **r == Role::King).count()
    }
}
