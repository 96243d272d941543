//! The one transition rule, in log space: weights of a node's exits are computed at the first visit of a round and shared by all ants and threads.

use super::paged::Paged;
use super::pheromone::Pheromone;
use super::roads::{Exit, Roads};
use rand::{Rng, RngExt};
use serde::{Deserialize, Serialize};
use std::sync::atomic::{AtomicU32, Ordering};

/// Visibility of a neighbour j of i, with g where the ant is heading.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Heuristic {
    /// 1 / (d(i,j) + d(j,g)).
    Detour,
    /// 1 / d(j,g); the goal itself counts as half a cell away.
    Goal,
    /// 1 / d(i,j).
    Step,
}

/// How an ant chooses.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::plan) struct Rule {
    /// Exponent of the pheromone.
    pub alpha: f64,
    /// Exponent of the heuristic.
    pub beta: f64,
    pub heuristic: Heuristic,
    /// Share of choices that take the best exit.
    pub greedy: f64,
    /// Share of choices that take any exit.
    pub uniform: f64,
}

/// Below this sum the weights of the open exits are too small to draw from: they are computed again among themselves.
const TINY: f32 = 1e-30;

/// Weights of exits under a rule, for one target, until the pheromone changes.
pub(in crate::plan) struct Choices {
    rule: Rule,
    target: u32,
    round: u32,
    /// Round in which the weights of a node were computed.
    rounds: Paged<AtomicU32>,
    /// Bits of a weight as `f32`, the largest of a node being 1.
    weights: Paged<AtomicU32>,
}

impl Choices {
    pub fn new(roads: &impl Roads, rule: Rule, target: u32) -> Self {
        Self { rule, target, round: 1, rounds: Paged::new(roads.nodes()), weights: Paged::new(roads.slots()) }
    }

    /// Forgets all weights: the pheromone, the rule or the target have changed.
    pub fn renew(&mut self, rule: Rule, target: u32) {
        self.round += 1;
        (self.rule, self.target) = (rule, target);
    }

    /// Where the ants are heading.
    pub fn target(&self) -> u32 {
        self.target
    }

    /// ln of an exit's weight, not normalised.
    fn ln(&self, roads: &impl Roads, tau: &Pheromone, exit: Exit) -> f64 {
        let rest = roads.distance(exit.to, self.target);
        let distance = match self.rule.heuristic {
            Heuristic::Detour => exit.length + rest,
            Heuristic::Goal => rest.max(0.5),
            Heuristic::Step => exit.length,
        };
        self.rule.alpha.mul_add(tau.ln(exit), -self.rule.beta * distance.ln())
    }

    /// Weights of a node's exits, computed if they are not there.
    fn fill(&self, roads: &impl Roads, tau: &Pheromone, node: u32, exits: &[Exit]) {
        let known = self.rounds.at(node as usize);
        if known.load(Ordering::Acquire) == self.round {
            return;
        }
        // Two threads may both come here; they store the same values.
        let most = exits.iter().map(|e| self.ln(roads, tau, *e)).fold(f64::NEG_INFINITY, f64::max);
        for exit in exits {
            let weight = (self.ln(roads, tau, *exit) - most).exp() as f32;
            self.weights.at(exit.slot as usize).store(weight.to_bits(), Ordering::Relaxed);
        }
        known.store(self.round, Ordering::Release);
    }

    /// Chooses among the exits of `node` that are `open`; the index of one of them. Keeps the heading `ahead` among equals.
    pub fn choose(&self, roads: &impl Roads, tau: &Pheromone, ask: &mut Ask, rng: &mut impl Rng) -> usize {
        if self.rule.uniform > 0.0 && rng.random_bool(self.rule.uniform) {
            return ask.open[rng.random_range(0..ask.open.len())].0;
        }
        self.fill(roads, tau, ask.node, ask.exits);
        let mut sum = 0.0;
        for (k, weight) in ask.open.iter_mut() {
            *weight = f32::from_bits(self.weights.at(ask.exits[*k].slot as usize).load(Ordering::Relaxed));
            sum += *weight;
        }
        if sum < TINY {
            sum = self.among(roads, tau, ask);
        }
        let drawn =
            if self.rule.greedy > 0.0 && rng.random_bool(self.rule.greedy) { best(ask.open) } else { spin(ask.open, rng.random::<f32>() * sum) };
        // Of equal choices, straight on (equal lengths are broken by turns).
        let straight =
            ask.open.iter().find(|(k, weight)| ask.exits[*k].heading == ask.ahead && *weight >= drawn.1 && *weight <= drawn.1 * (1.0 + 1e-6));
        straight.map_or(drawn.0, |s| s.0)
    }

    fn among(&self, roads: &impl Roads, tau: &Pheromone, ask: &mut Ask) -> f32 {
        let most = ask.open.iter().map(|(k, _)| self.ln(roads, tau, ask.exits[*k])).fold(f64::NEG_INFINITY, f64::max);
        let mut sum = 0.0;
        for (k, weight) in ask.open.iter_mut() {
            *weight = (self.ln(roads, tau, ask.exits[*k]) - most).exp() as f32;
            sum += *weight;
        }
        sum
    }

    /// Entropy of the choice at a node, 0 (decided) to 1 (all alike).
    pub fn entropy(&self, roads: &impl Roads, tau: &Pheromone, node: u32, exits: &[Exit]) -> f64 {
        if exits.len() < 2 {
            return 0.0;
        }
        self.fill(roads, tau, node, exits);
        let weights = exits.iter().map(|e| f64::from(f32::from_bits(self.weights.at(e.slot as usize).load(Ordering::Relaxed))));
        let sum: f64 = weights.clone().sum();
        weights.map(|w| w / sum).filter(|p| *p > 0.0).map(|p| -p * p.ln()).sum::<f64>() / (exits.len() as f64).ln()
    }
}

/// One choice to make.
pub(in crate::plan) struct Ask<'a> {
    pub node: u32,
    pub exits: &'a [Exit],
    /// Exits that may be taken: index into `exits`, and room for a weight.
    pub open: &'a mut [(usize, f32)],
    /// Heading of the last step.
    pub ahead: u8,
}

fn best(open: &[(usize, f32)]) -> (usize, f32) {
    open.iter().copied().fold((0, f32::NEG_INFINITY), |best, next| if next.1 > best.1 { next } else { best })
}

fn spin(open: &[(usize, f32)], mut left: f32) -> (usize, f32) {
    for &(k, weight) in open {
        left -= weight;
        if left < 0.0 {
            return (k, weight);
        }
    }
    best(open)
}
