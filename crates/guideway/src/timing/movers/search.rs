//! The earliest arrival: A* over (node, time).

use super::bound::{Bound, STEP, bin};
use super::motions::{Motions, Node};
use super::safety::{Brake, Safety};
use super::table::{Passage, Table};
use crate::context::{Context, Stop};
use crate::error::PlanError;
use crate::timing::{Piece, Trajectory};
use std::cmp::Ordering;
use std::collections::BinaryHeap;

/// What a search found.
pub(super) struct Found {
    pub trajectory: Trajectory,
    /// s.
    pub waiting: f64,
}

/// A state that can be reached.
struct Reached {
    node: usize,
    t: f64,
    /// The state before, and the number of the motion from there; none for waiting.
    before: Option<(usize, Option<usize>)>,
}

/// States in the order of the earliest arrival they may lead to; the farther one of equals first.
#[derive(PartialEq)]
struct Open {
    least: f64,
    node: usize,
    state: usize,
}

impl Eq for Open {}

impl PartialOrd for Open {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Open {
    fn cmp(&self, other: &Self) -> Ordering {
        other.least.total_cmp(&self.least).then(self.node.cmp(&other.node)).then(other.state.cmp(&self.state))
    }
}

/// What is known of a motion before it is tested at a time.
#[derive(Clone, Default)]
struct Known {
    passage: Option<Passage>,
    brakes: Option<Vec<Brake>>,
}

/// A search among movers.
pub(super) struct Search<'a, 'b> {
    motions: &'a mut Motions<'b>,
    safety: &'a Safety<'b>,
    table: &'a Table,
    bound: Bound,
    known: Vec<Known>,
    states: Vec<Reached>,
    open: BinaryHeap<Open>,
    /// Earliest time (s) by node and step of time.
    earliest: Vec<Vec<f64>>,
}

impl<'a, 'b> Search<'a, 'b> {
    pub fn new(motions: &'a mut Motions<'b>, safety: &'a Safety<'b>, table: &'a Table) -> Self {
        let bins = bin(table.horizon) + 2;
        let bound = Bound::new(motions, table);
        let known = vec![Known::default(); motions.made.len()];
        let earliest = vec![vec![f64::INFINITY; bins]; motions.nodes.len()];
        Self { motions, safety, table, bound, known, states: Vec::new(), open: BinaryHeap::new(), earliest }
    }

    /// The earliest arrival, `None` if there is none within the horizon or until so many motions have been tested (`most`).
    pub fn run(mut self, ctx: &mut Context, tested: &mut u64, most: u64) -> Result<Option<Found>, PlanError> {
        let goal = self.motions.nodes.len() - 1;
        self.reach(Reached { node: 0, t: 0.0, before: None });
        while let Some(Open { node, state, .. }) = self.open.pop() {
            if node == goal {
                return Ok(Some(self.trace(state)));
            }
            match ctx.poll() {
                Some(Stop::Cancelled) => return Err(PlanError::Cancelled),
                Some(_) => return Ok(None),
                None if *tested >= most => return Ok(None),
                None => {}
            }
            let t = self.states[state].t;
            if self.earliest[node][bin(t)] >= t {
                self.leave(node, state, t, tested);
            }
        }
        Ok(None)
    }

    /// Whatever can follow a state.
    fn leave(&mut self, node: usize, state: usize, t: f64, tested: &mut u64) {
        let Node { s, speed, .. } = self.motions.nodes[node];
        let next = (bin(t) + 1) as f64 * STEP;
        // Rounding may leave a moment in the same step.
        let next = if next > t { next } else { next + STEP };
        if speed == 0.0 && self.wants(node, next) && self.table.free(self.table.cell(s), t, next) {
            self.reach(Reached { node, t: next, before: Some((state, None)) });
        }
        for k in 0..self.motions.nodes[node].next.len() {
            let (to, motion) = self.motions.nodes[node].next[k];
            self.motions.make(motion);
            let arrival = t + self.motions.made[motion].duration;
            if self.wants(to, arrival) {
                *tested += 1;
                if self.possible(motion, t) {
                    self.reach(Reached { node: to, t: arrival, before: Some((state, Some(motion))) });
                }
            }
        }
    }

    /// Whether an arrival is of use.
    fn wants(&self, node: usize, t: f64) -> bool {
        t < self.table.horizon && t < self.earliest[node][bin(t)] && self.bound.arrival(self.motions.nodes[node].station, t).is_finite()
    }

    fn reach(&mut self, reached: Reached) {
        let Reached { node, t, .. } = reached;
        let here = &self.motions.nodes[node];
        self.earliest[node][bin(t)] = t;
        let least = (t + here.remaining).max(self.bound.arrival(here.station, t));
        if least.is_finite() {
            self.open.push(Open { least, node, state: self.states.len() });
            self.states.push(reached);
        }
    }

    fn possible(&mut self, motion: usize, t: f64) -> bool {
        let (made, known) = (&self.motions.made[motion], &mut self.known[motion]);
        let passage = known.passage.get_or_insert_with(|| made.passage(self.table));
        if !self.table.lets(passage, t) {
            return false;
        }
        !self.safety.around.passive || known.brakes.get_or_insert_with(|| self.safety.brakes(made)).iter().all(|b| self.safety.ends_well(b, t))
    }

    /// The motion that leads to a state. Steps of waiting in a row become one piece: a turn by nothing.
    fn trace(&self, mut state: usize) -> Found {
        let mut parts = Vec::new();
        while let Some((before, motion)) = self.states[state].before {
            parts.push((before, motion, state));
            state = before;
        }
        let (mut pieces, mut t, mut waiting) = (Vec::<Piece>::new(), 0.0, 0.0);
        for (before, motion, after) in parts.into_iter().rev() {
            if let Some(motion) = motion {
                for piece in &self.motions.made[motion].pieces {
                    pieces.push(piece.shifted(t - piece.start()));
                    t += piece.duration();
                }
                continue;
            }
            let (node, pause) = (&self.motions.nodes[self.states[after].node], self.states[after].t - self.states[before].t);
            match pieces.last_mut() {
                Some(Piece::Turn { turn, duration, .. }) if *turn == 0.0 => *duration += pause,
                _ => pieces.push(Piece::Turn { turn: 0.0, t, duration: pause, s: node.s, from: node.heading }),
            }
            t += pause;
            waiting += pause;
        }
        let plain = self.motions.plain;
        Found { trajectory: Trajectory { path: plain.path.clone(), pieces, limits: plain.limits }, waiting }
    }
}
