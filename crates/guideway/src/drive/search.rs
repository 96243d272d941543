//! The best sequence of manoeuvres over the next seconds: a beam in (place, time).
//!
//! Each level appends one manoeuvre to each plan kept so far; of plans that end in the same place the best is kept, of places the best `beam`.
//! Plans that meet something end there and rank below all others.

use super::crowd::Crowd;
use super::field::Met;
use super::ways::{Forecast, Predictor, Sim, Way};
use crate::Point;
use crate::world::shape::wrap;

/// Plans whose ends are nearer than this (m), in heading (rad) and in speed (m/s) are alike; after the first level and later.
const ALIKE: [[f64; 3]; 2] = [[0.04, 0.15, 0.12], [0.25, 0.6, 0.3]];
/// So many times as many plans are kept after the first level.
const WIDER: usize = 2;
/// Room for so many plans is made at first.
const MOST: usize = 512;
/// Rank of plans that meet something, and what each second until then is worth.
const LOST: f64 = -1e3;
const SECOND: f64 = 10.0;

/// A plan up to one of its levels.
#[derive(Debug, Clone, Copy)]
pub(super) struct Node {
    pub sim: Sim,
    /// s from now.
    pub t: f64,
    /// Integrals so far, as in the forecast.
    pub aside: f64,
    pub near: f64,
    /// Integrals of the exposure (0 to 1) to movers that go on and that turn around, where it would stand if it stopped at the ends of its levels, s.
    pub exposed: [f64; 2],
    /// Distance that is left, m, and the integral of it, m s.
    pub rest: f64,
    pub left: f64,
    /// Index of its first manoeuvre.
    pub first: usize,
    parent: usize,
    pub met: Option<Met>,
    /// It meets something, or may not be able to stop.
    pub lost: bool,
    pub score: f64,
}

impl Node {
    /// Where a search begins.
    fn at(sim: Sim) -> Self {
        Self { sim, t: 0.0, aside: 0.0, near: 0.0, exposed: [0.0; 2], rest: 0.0, left: 0.0, first: 0, parent: 0, met: None, lost: false, score: 0.0 }
    }

    /// It, and then what was found up to a time, s.
    fn then(&self, found: &Forecast, until: f64) -> Self {
        let mut next = Self { sim: found.end, t: until, aside: self.aside + found.aside, near: self.near + found.near, ..*self };
        if let Some((t, met)) = found.contact {
            (next.t, next.met, next.lost) = (if found.parked { t } else { t - 0.5 }, Some(met), true);
        } else if let Some(t) = found.late {
            (next.t, next.lost) = (t - 0.25, true);
        }
        next
    }
}

/// What a search is asked.
pub(super) struct Search<'a> {
    pub predictor: &'a Predictor<'a>,
    /// Ends of the levels, s.
    pub levels: &'a [f64],
    pub beam: usize,
    /// Time that the place where a plan ends counts for, s.
    pub park: f64,
}

/// All plans of one search.
pub(super) struct Plans {
    nodes: Vec<Node>,
    /// Index of the best plan of each first manoeuvre, best first.
    pub best: Vec<usize>,
}

impl Plans {
    pub fn node(&self, i: usize) -> &Node {
        &self.nodes[i]
    }

    /// Ends of the levels of a plan, from the start.
    pub fn line(&self, mut i: usize) -> Vec<Point> {
        let mut line = Vec::new();
        loop {
            let node = &self.nodes[i];
            line.push([node.sim.pose[0], node.sim.pose[1]]);
            if node.parent == i {
                line.reverse();
                return line;
            }
            i = node.parent;
        }
    }
}

impl<'a> Search<'a> {
    /// Searches from `start`. `ways(node, level)` lists what may follow, `score` judges a node.
    pub fn run(
        &self,
        start: Sim,
        ways: &mut dyn FnMut(&Node, usize, &mut Vec<Way>),
        left: &dyn Fn(&Sim) -> f64,
        score: &dyn Fn(&Node) -> f64,
    ) -> Plans {
        let (mut nodes, mut open, mut ended) = (Vec::with_capacity(MOST), vec![0], Vec::new());
        nodes.push(Node::at(start));
        let (mut list, mut found, mut part) = (Vec::new(), Vec::new(), [const { Vec::new() }; 2].map(Crowd::<'a>::new));
        for (level, until) in self.levels.iter().enumerate() {
            let from = nodes.len();
            for &i in &open {
                let node = nodes[i];
                list.clear();
                ways(&node, level, &mut list);
                self.predictor.part(&node.sim, [node.t, *until], &mut part);
                let pace = self.predictor.pace(&node.sim, [node.t, *until]);
                self.predictor.run(&list, &node.sim, &pace, [&part[0], &part[1]], &mut found);
                for (k, found) in found.iter().enumerate() {
                    let first = if level == 0 { k } else { node.first };
                    let mut next = node.then(found, *until);
                    (next.first, next.parent) = (first, i);
                    if next.lost {
                        next.score = LOST + SECOND * next.t - next.near;
                    } else {
                        let last = if level + 1 == self.levels.len() { self.park } else { 0.0 };
                        let exposure = self.predictor.exposure(&next.sim, next.t);
                        next.exposed = [0, 1].map(|k| next.exposed[k] + exposure[k] * (until - node.t + last));
                        next.rest = left(&next.sim);
                        next.left += (until - node.t) * next.rest;
                        next.score = score(&next);
                    }
                    nodes.push(next);
                }
            }
            ended.extend((from..nodes.len()).filter(|i| nodes[*i].lost));
            open = self.keep(&nodes, from, level);
            if open.is_empty() {
                break;
            }
        }
        ended.extend(open);
        let before = |i: usize, j: usize| nodes[j].score.total_cmp(&nodes[i].score).then(i.cmp(&j));
        let mut best: Vec<Option<usize>> = Vec::new();
        for i in ended {
            let first = nodes[i].first;
            if best.len() <= first {
                best.resize(first + 1, None);
            }
            if best[first].is_none_or(|j| before(i, j).is_lt()) {
                best[first] = Some(i);
            }
        }
        let mut best: Vec<usize> = best.into_iter().flatten().collect();
        best.sort_unstable_by(|i, j| before(*i, *j));
        Plans { nodes, best }
    }

    /// The best plans whose ends are not alike; after the last level all, in any order.
    fn keep(&self, nodes: &[Node], from: usize, level: usize) -> Vec<usize> {
        let open = (from..nodes.len()).filter(|i| !nodes[*i].lost);
        if level + 1 == self.levels.len() {
            return open.collect();
        }
        let mut open: Vec<(f64, usize)> = open.map(|i| (nodes[i].score, i)).collect();
        open.sort_unstable_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        let ([place, turn, speed], most) = if level == 0 { (ALIKE[0], WIDER * self.beam) } else { (ALIKE[1], self.beam) };
        let mut kept: Vec<usize> = Vec::with_capacity(most);
        for (_, i) in open {
            let like = |j: &usize| {
                let (a, b) = (&nodes[i].sim, &nodes[*j].sim);
                let near = (a.pose[0] - b.pose[0]).abs() < place && (a.pose[1] - b.pose[1]).abs() < place;
                near && (a.v - b.v).abs() < speed && wrap(a.pose[2] - b.pose[2]).abs() < turn
            };
            if !kept.iter().any(like) {
                kept.push(i);
                if kept.len() == most {
                    break;
                }
            }
        }
        kept
    }
}
