//! The colony on the corner graph: generations there and back, with what they learn on the way.

use super::super::crew::{Crew, March, best_of, better};
use super::super::pheromone::Pheromone;
use super::super::rule::{Choices, Heuristic, Rule};
use super::super::walk::{Legs, Trail};
use super::Settings;
use super::corners::{Corners, GOAL, START};
use super::tails::{Learned, Tails};
use crate::context::{Context, Stop};
use crate::plan::score::Aim;
use rand_chacha::ChaCha8Rng;

/// Nodes that an ant of the first generation may visit; twice as many in each further one until one arrives.
const FIRST: usize = 512;

/// A walk: every node in the order of the visits, and the way if the ant arrived.
struct Walk {
    been: Vec<u32>,
    trail: Option<Trail>,
}

/// A colony at work.
pub(super) struct Run<'a> {
    settings: &'a Settings,
    pub roads: &'a Corners<'a>,
    crew: Crew<'a, Corners<'a>>,
    pub tau: Pheromone<'a>,
    choices: Choices,
    tails: Option<Tails>,
    pub best: Option<Trail>,
    /// Nodes that an ant may visit.
    patience: usize,
    rounds: u64,
    pub restarts: u32,
}

impl<'a> Run<'a> {
    pub fn new(settings: &'a Settings, roads: &'a Corners<'a>, ctx: &Context) -> Self {
        let crew = Crew::new(roads, Aim::Shortest, true, 0, ctx);
        let tau = Pheromone::new(roads, |_| settings.initial, settings.evaporation, settings.bounds);
        let choices = Choices::new(roads, settings.rule(0.0), GOAL).with_focus(settings.focus);
        let tails = settings.learning.then(|| Tails::new(roads));
        Self { settings, roads, crew, tau, choices, tails, best: None, patience: FIRST, rounds: 1, restarts: 0 }
    }

    /// Runs to the end; `cost` is what the best way so far is worth to the caller, m.
    pub fn run(&mut self, ctx: &mut Context, cost: impl Fn(Option<&Trail>) -> f64) -> Stop {
        let first = ctx.iterations();
        self.rounds = ctx.budget().iterations.map_or(self.settings.iterations, |n| n.saturating_sub(first)).max(1);
        let mut still = 0;
        for number in 0..self.rounds {
            let before = self.length();
            for back in [false, true] {
                if let Err(stop) = self.half(back, number, 2 * (first + number) + u64::from(back), ctx) {
                    return stop;
                }
            }
            still = if self.length() < before || self.best.is_none() { 0 } else { still + 1 };
            if let Some(stop) = ctx.tick(cost(self.best.as_ref())) {
                return stop;
            }
            if still >= self.settings.patience {
                break;
            }
            self.restart();
        }
        Stop::Converged
    }

    fn length(&self) -> f64 {
        self.best.as_ref().map_or(f64::INFINITY, |t| t.length)
    }

    /// Half an iteration: there, or back.
    fn half(&mut self, back: bool, round: u64, number: u64, ctx: &mut Context) -> Result<(), Stop> {
        let (from, to) = if back { (GOAL, START) } else { (START, GOAL) };
        self.choices.renew(self.settings.rule(round as f64 / self.rounds as f64), to);
        let march = March { ants: self.settings.ants, from, number };
        let walks = self.crew.march(&march, ctx, |_, legs, rng| self.walk(legs, rng))?;
        self.learn(&walks);
        let trails: Vec<Trail> = walks.into_iter().filter_map(|w| w.trail).collect();
        let found = best_of(&trails).cloned().map(|t| if back { t.reversed(self.roads) } else { t });
        self.best = better(self.best.take(), found.as_ref());
        if let Some(tails) = self.tails.as_ref().filter(|t| t.rest(START, GOAL).min(t.rest(GOAL, START)) < self.length()) {
            self.best = better(self.best.take(), tails.best(self.roads).as_ref());
        }
        if self.best.is_none() {
            self.patience = (2 * self.patience).min(8 * self.roads.count().max(FIRST));
        }
        self.tau.evaporate();
        let elite = self.best.iter().filter(|_| self.settings.elitist);
        for trail in trails.iter().chain(elite) {
            self.crew.mark(&mut self.tau, trail, self.settings.deposit / trail.length.max(1.0));
        }
        Ok(())
    }

    /// One ant: by the rule, back out of dead ends that nobody knows a way out of, past no node that only longer ways than the best lead over.
    fn walk(&self, legs: &mut Legs, rng: &mut ChaCha8Rng) -> Walk {
        let (target, most) = (self.choices.target(), self.length() * (1.0 + 1e-12));
        let learned = Learned { roads: self.roads, tails: self.tails.as_ref() };
        let shut = |node: u32| {
            use super::super::roads::Roads;
            self.roads.distance(START, node) + self.roads.distance(node, GOAL) > most
        };
        let mut been = vec![legs.here()];
        for _ in 0..self.patience {
            if legs.here() == target {
                return Walk { been, trail: Some(legs.trail(self.roads, true, Aim::Shortest)) };
            }
            if legs.step(&learned, &self.tau, &self.choices, shut, rng) {
                been.push(legs.here());
            } else if self.tails.as_ref().is_some_and(|t| t.rest(legs.here(), target).is_finite()) || !legs.roll_back() {
                break;
            }
        }
        Walk { been, trail: None }
    }

    /// In the order of the ants, so that threads change nothing.
    fn learn(&mut self, walks: &[Walk]) {
        let Some(tails) = &mut self.tails else { return };
        for walk in walks {
            if let Some(trail) = &walk.trail {
                tails.finished(trail);
            }
            tails.visited(self.roads, &walk.been);
        }
    }

    /// Begins anew when the choices along the best way are decided.
    fn restart(&mut self) {
        let Some(best) = self.best.as_ref().filter(|_| self.settings.restart > 0.0) else { return };
        self.choices.renew(self.settings.rule(0.0), GOAL);
        let learned = Learned { roads: self.roads, tails: self.tails.as_ref() };
        let entropies = best.nodes.iter().map(|node| self.choices.entropy(&learned, &self.tau, *node));
        if entropies.sum::<f64>() / (best.nodes.len() as f64) < self.settings.restart {
            self.tau.restart();
            self.restarts += 1;
        }
    }
}

impl Settings {
    /// The rule after a share of the iterations.
    fn rule(&self, share: f64) -> Rule {
        let at = |[a, b]: [f64; 2]| a + (b - a) * share * share;
        Rule { alpha: at(self.alpha), beta: at(self.beta), heuristic: Heuristic::Detour, greedy: self.greedy, uniform: 0.0 }
    }
}
