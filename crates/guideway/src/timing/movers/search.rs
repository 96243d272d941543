//! The earliest arrival: A* over (station, time).

use super::motions::{Motion, Motions};
use super::safety::{Safety, duration};
use crate::context::{Context, Stop};
use crate::error::PlanError;
use crate::timing::{Piece, Trajectory};
use std::cmp::Ordering;
use std::collections::{BinaryHeap, HashMap};

/// Step of waiting, s.
const STEP: f64 = 0.1;
/// Most motions that are tested.
const MOST: u64 = 1_000_000;

/// Until when a search looks, s, if the plain motion takes `plain` s.
pub(super) fn horizon(plain: f64) -> f64 {
    4.0 * plain + 60.0
}

/// What a search found.
pub(super) struct Found {
    pub trajectory: Trajectory,
    /// s.
    pub waiting: f64,
}

/// A state at rest that can be reached.
struct Node {
    station: usize,
    t: f64,
    /// The state before, and the motion from there; none for waiting.
    before: Option<(usize, Option<Motion>)>,
}

/// Nodes in the order of the earliest arrival they may lead to; the farther one of equals first.
#[derive(PartialEq)]
struct Open {
    least: f64,
    station: usize,
    node: usize,
}

impl Eq for Open {}

impl PartialOrd for Open {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Open {
    fn cmp(&self, other: &Self) -> Ordering {
        other.least.total_cmp(&self.least).then(self.station.cmp(&other.station)).then(other.node.cmp(&self.node))
    }
}

/// The tree of a search.
struct Tree {
    nodes: Vec<Node>,
    open: BinaryHeap<Open>,
    /// Earliest time (s) by station and step of time.
    reached: HashMap<(usize, u64), f64>,
    horizon: f64,
}

fn bin(t: f64) -> u64 {
    (t / STEP) as u64
}

impl Tree {
    /// Whether an arrival is of use.
    fn wants(&self, station: usize, t: f64) -> bool {
        t <= self.horizon && self.reached.get(&(station, bin(t))).is_none_or(|known| t < *known)
    }

    fn add(&mut self, node: Node, remaining: f64) {
        self.reached.insert((node.station, bin(node.t)), node.t);
        self.open.push(Open { least: node.t + remaining, station: node.station, node: self.nodes.len() });
        self.nodes.push(node);
    }
}

/// The earliest arrival, `None` if there is none within the horizon (or the bound on tests).
pub(super) fn earliest(motions: &mut Motions, safety: &Safety, ctx: &mut Context, tested: &mut u64) -> Result<Option<Found>, PlanError> {
    let (Some(first), goal) = (motions.stations.first().copied(), motions.stations.len().saturating_sub(1)) else { return Ok(None) };
    let mut tree = Tree { nodes: Vec::new(), open: BinaryHeap::new(), reached: HashMap::new(), horizon: horizon(motions.plain.duration()) };
    tree.add(Node { station: 0, t: 0.0, before: None }, first.remaining);
    let most = *tested + MOST;
    while let Some(Open { node, station, .. }) = tree.open.pop() {
        if station == goal {
            return Ok(Some(trace(&tree, node, motions)));
        }
        match ctx.poll() {
            Some(Stop::Cancelled) => return Err(PlanError::Cancelled),
            Some(_) => return Ok(None),
            None if *tested > most => return Ok(None),
            None => {}
        }
        let t = tree.nodes[node].t;
        if tree.reached.get(&(station, bin(t))).is_some_and(|known| *known < t) {
            continue;
        }
        let (here, next) = (motions.stations[station], (bin(t) + 1) as f64 * STEP);
        if tree.wants(station, next) && safety.rests(here.s, (t, next)) {
            tree.add(Node { station, t: next, before: Some((node, None)) }, here.remaining);
        }
        for (to, motion) in motions.from(station) {
            let arrival = t + duration(&motion);
            if !tree.wants(to, arrival) {
                continue;
            }
            *tested += 1;
            if safety.meeting(&motion, t).is_none() {
                tree.add(Node { station: to, t: arrival, before: Some((node, Some(motion))) }, motions.stations[to].remaining);
            }
        }
    }
    Ok(None)
}

/// The motion that leads to a node. Steps of waiting in a row become one piece: a turn by nothing.
fn trace(tree: &Tree, mut node: usize, motions: &Motions) -> Found {
    let mut parts = Vec::new();
    while let Some((before, motion)) = &tree.nodes[node].before {
        parts.push((*before, motion, node));
        node = *before;
    }
    let (mut pieces, mut t, mut waiting) = (Vec::<Piece>::new(), 0.0, 0.0);
    for (before, motion, after) in parts.into_iter().rev() {
        if let Some(motion) = motion {
            for piece in motion.iter() {
                pieces.push(piece.shifted(t - piece.start()));
                t += piece.duration();
            }
            continue;
        }
        let (station, pause) = (motions.stations[tree.nodes[after].station], tree.nodes[after].t - tree.nodes[before].t);
        match pieces.last_mut() {
            Some(Piece::Turn { turn, duration, .. }) if *turn == 0.0 => *duration += pause,
            _ => pieces.push(Piece::Turn { turn: 0.0, t, duration: pause, s: station.s, from: station.heading }),
        }
        t += pause;
        waiting += pause;
    }
    let plain = motions.plain;
    Found { trajectory: Trajectory { path: plain.path.clone(), pieces, limits: plain.limits }, waiting }
}
