//! The one transition rule, in log space: weights of a node's exits are computed at the first visit of a round and shared by all ants and threads.

use super::paged::Paged;
use super::pheromone::Pheromone;
use super::roads::{Exit, Roads};
use rand::{Rng, RngExt};
use serde::{Deserialize, Serialize};
use std::sync::OnceLock;
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

/// Exits whose weights lie beside each other; most nodes have no more.
const FEW: usize = 8;

/// The weights of a node's exits: bits of `f32`, the largest being 1.
#[derive(Default)]
struct Desk {
    /// Round in which they were computed.
    round: AtomicU32,
    few: [AtomicU32; FEW],
}

/// An exit that an ant may take.
#[derive(Debug, Clone, Copy)]
pub(in crate::plan) struct Open {
    pub exit: Exit,
    /// Its place among all exits of the node.
    pub place: usize,
    /// Room for its weight.
    pub weight: f32,
}

/// Weights of exits under a rule, for one target, until the pheromone changes.
pub(in crate::plan) struct Choices {
    rule: Rule,
    target: u32,
    round: u32,
    desks: Paged<Desk, 8>,
    /// Weights of nodes with more than [`FEW`] exits.
    many: Paged<OnceLock<Box<[AtomicU32]>>, 8>,
    /// What is left of the shortest way of a node in the distances of its exits; 1: all.
    focus: f64,
    /// Distances differ as they do that far from the target, cells, or nearer.
    horizon: f64,
}

impl Choices {
    pub fn new(roads: &impl Roads, rule: Rule, target: u32) -> Self {
        Self { rule, target, round: 1, desks: Paged::new(roads.nodes()), many: Paged::new(roads.nodes()), focus: 1.0, horizon: f64::INFINITY }
    }

    /// Distances count from `1 - focus` of the shortest one of the node on: on long ways all are nearly alike otherwise.
    pub fn with_focus(mut self, focus: f64) -> Self {
        self.focus = focus;
        self
    }

    /// Beyond that many cells (0: never) the directions are told apart as well as there: from far away all are nearly alike otherwise.
    pub fn with_horizon(mut self, cells: f64) -> Self {
        self.horizon = if cells > 0.0 { cells } else { f64::INFINITY };
        self
    }

    /// Forgets all weights: the pheromone, the rule or the target have changed.
    pub fn renew(&mut self, rule: Rule, target: u32) {
        self.round += 1;
        (self.rule, self.target) = (rule, target);
    }

    /// Gives the memory of all weights back.
    pub fn forget(&mut self) {
        self.desks.clear();
        self.many.clear();
    }

    /// How the ants choose.
    pub fn rule(&self) -> Rule {
        self.rule
    }

    /// Where the ants are heading.
    pub fn target(&self) -> u32 {
        self.target
    }

    fn distance(&self, roads: &impl Roads, exit: Exit) -> f64 {
        let rest = roads.distance(exit.to, self.target);
        match self.rule.heuristic {
            Heuristic::Detour => exit.length + rest,
            Heuristic::Goal => rest.max(0.5),
            Heuristic::Step => exit.length,
        }
    }

    /// What is taken off all distances of a node whose shortest is `least`.
    fn less(&self, least: f64) -> f64 {
        ((1.0 - self.focus) * least).max(least - self.horizon).max(0.0)
    }

    /// ln of an exit's weight, not normalised.
    fn ln(&self, tau: &Pheromone, exit: Exit, distance: f64) -> f64 {
        self.rule.alpha.mul_add(tau.ln(exit), -self.rule.beta * distance.ln())
    }

    /// Weights of all `count` exits of a node, computed if they are not there.
    fn weights(&self, roads: &impl Roads, tau: &Pheromone, node: u32, count: usize) -> &[AtomicU32] {
        let desk = self.desks.at(node as usize);
        let fresh = || std::iter::repeat_with(AtomicU32::default).take(count).collect();
        let weights = if count <= FEW { &desk.few } else { &**self.many.at(node as usize).get_or_init(fresh) };
        if desk.round.load(Ordering::Acquire) != self.round {
            // Two threads may both come here; they store the same values.
            let (mut few, mut many) = ([0.0; FEW], Vec::new());
            let logs = if count <= FEW {
                &mut few[..count]
            } else {
                many.resize(count, 0.0);
                &mut many[..]
            };
            let mut next = logs.iter_mut();
            roads.visit(node, |exit| next.next().into_iter().for_each(|log| *log = self.distance(roads, exit)));
            let less = self.less(logs.iter().copied().fold(f64::INFINITY, f64::min));
            let mut next = logs.iter_mut();
            roads.visit(node, |exit| next.next().into_iter().for_each(|log| *log = self.ln(tau, exit, *log - less)));
            let most = logs.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            for (weight, ln) in weights.iter().zip(logs) {
                weight.store(((*ln - most).exp() as f32).to_bits(), Ordering::Relaxed);
            }
            desk.round.store(self.round, Ordering::Release);
        }
        weights
    }

    /// Chooses among the exits of a node that are open. Keeps the heading `ahead` among equals.
    pub fn choose(&self, roads: &impl Roads, tau: &Pheromone, ask: &mut Ask, rng: &mut impl Rng) -> Exit {
        if self.rule.uniform > 0.0 && rng.random_bool(self.rule.uniform) {
            return ask.open[rng.random_range(0..ask.open.len())].exit;
        }
        let weights = self.weights(roads, tau, ask.node, ask.count);
        let mut sum = 0.0;
        for open in ask.open.iter_mut() {
            open.weight = f32::from_bits(weights[open.place].load(Ordering::Relaxed));
            sum += open.weight;
        }
        if sum < TINY {
            sum = self.among(roads, tau, ask);
        }
        let drawn =
            if self.rule.greedy > 0.0 && rng.random_bool(self.rule.greedy) { best(ask.open) } else { spin(ask.open, rng.random::<f32>() * sum) };
        // Of equal choices, straight on (equal lengths are broken by turns).
        let ahead = ask.open.iter().find(|open| open.exit.heading == ask.ahead);
        ahead.filter(|open| (open.weight - drawn.weight).abs() <= 1e-6 * drawn.weight).unwrap_or(drawn).exit
    }

    /// Weighs the open exits among themselves.
    fn among(&self, roads: &impl Roads, tau: &Pheromone, ask: &mut Ask) -> f32 {
        let mut logs: Vec<f64> = ask.open.iter().map(|open| self.distance(roads, open.exit)).collect();
        let less = self.less(logs.iter().copied().fold(f64::INFINITY, f64::min));
        for (log, open) in logs.iter_mut().zip(ask.open.iter()) {
            *log = self.ln(tau, open.exit, *log - less);
        }
        let most = logs.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let mut sum = 0.0;
        for (open, log) in ask.open.iter_mut().zip(logs) {
            open.weight = (log - most).exp() as f32;
            sum += open.weight;
        }
        sum
    }

    /// Entropy of the choice at a node, 0 (decided) to 1 (all alike).
    pub fn entropy(&self, roads: &impl Roads, tau: &Pheromone, node: u32) -> f64 {
        let mut count = 0;
        roads.visit(node, |_| count += 1);
        if count < 2 {
            return 0.0;
        }
        let weights = self.weights(roads, tau, node, count)[..count].iter().map(|w| f64::from(f32::from_bits(w.load(Ordering::Relaxed))));
        let sum: f64 = weights.clone().sum();
        weights.map(|w| w / sum).filter(|p| *p > 0.0).map(|p| -p * p.ln()).sum::<f64>() / (count as f64).ln()
    }
}

/// One choice to make.
pub(in crate::plan) struct Ask<'a> {
    pub node: u32,
    /// Exits of the node, open or not.
    pub count: usize,
    pub open: &'a mut [Open],
    /// Heading of the last step.
    pub ahead: u8,
}

fn best(open: &[Open]) -> &Open {
    open.iter().reduce(|best, next| if next.weight > best.weight { next } else { best }).unwrap_or(&open[0])
}

fn spin(open: &[Open], mut left: f32) -> &Open {
    for next in open {
        left -= next.weight;
        if left < 0.0 {
            return next;
        }
    }
    best(open)
}
