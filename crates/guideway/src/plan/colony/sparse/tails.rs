//! The terminal distance index: the shortest rest to the goal, and to the start, that any ant found from a node.
//!
//! Source: \[li2023\]; (1) `TDI_i <- min(TDI_i, tail of a finished way)`, (2) `TDI_i <- min over the exits j of i of d_ij + TDI_j` at every node that an
//! ant visited. (2) is ours; both only ever store lengths of ways that exist.

use super::super::roads::{Exit, Roads};
use super::super::walk::Trail;
use super::corners::{Corners, GOAL, START};
use crate::plan::score::Aim;

/// Known rests: to the start and to the goal, cells; infinite where none is known.
pub(super) struct Tails {
    rests: Vec<[f64; 2]>,
}

impl Tails {
    pub fn new(roads: &Corners) -> Self {
        let mut rests = vec![[f64::INFINITY; 2]; roads.nodes()];
        (rests[START as usize][START as usize], rests[GOAL as usize][GOAL as usize]) = (0.0, 0.0);
        Self { rests }
    }

    /// The known rest of a node to an end.
    pub fn rest(&self, node: u32, end: u32) -> f64 {
        self.rests[node as usize][end as usize]
    }

    /// (1) for a finished way between the ends, either way.
    pub fn finished(&mut self, trail: &Trail) {
        for end in [START, GOAL] {
            let mut length = 0.0;
            let mut keep = |node: u32, step: f64| {
                length += step;
                let rest = &mut self.rests[node as usize][end as usize];
                *rest = rest.min(length);
            };
            if trail.nodes[0] == end {
                trail.exits.iter().for_each(|e| keep(e.to, e.length));
            } else {
                trail.nodes.iter().zip(&trail.exits).rev().for_each(|(from, e)| keep(*from, e.length));
            }
        }
    }

    /// (2) for the nodes that an ant visited, last first, and then again in order for those behind which it found nothing.
    pub fn visited(&mut self, roads: &Corners, nodes: &[u32]) {
        nodes.iter().rev().chain(nodes).for_each(|n| self.relax(roads, *n));
    }

    fn relax(&mut self, roads: &Corners, node: u32) {
        let [mut to_start, mut to_goal] = self.rests[node as usize];
        for exit in roads.of(node) {
            let [s, g] = self.rests[exit.to as usize];
            to_start = to_start.min(exit.length + s);
            to_goal = to_goal.min(exit.length + g);
        }
        self.rests[node as usize] = [to_start, to_goal];
    }

    /// The best way from start to goal that follows from the rests; `None` before one is known.
    pub fn best(&self, roads: &Corners) -> Option<Trail> {
        let (there, back) = (self.descend(roads, START, GOAL), self.descend(roads, GOAL, START).map(|t| t.reversed(roads)));
        match (there, back) {
            (Some(a), Some(b)) => Some(if b.score.beats(a.score) { b } else { a }),
            (a, b) => a.or(b),
        }
    }

    /// Rests fall along the exits that explain them, so this ends.
    fn descend(&self, roads: &Corners, from: u32, to: u32) -> Option<Trail> {
        if !self.rest(from, to).is_finite() {
            return None;
        }
        let (mut nodes, mut exits) = (vec![from], Vec::<Exit>::new());
        while nodes[nodes.len() - 1] != to {
            let here = nodes[nodes.len() - 1];
            let ahead = roads.of(here).filter(|e| self.rest(e.to, to) < self.rest(here, to));
            let next = ahead.min_by(|a, b| (a.length + self.rest(a.to, to)).total_cmp(&(b.length + self.rest(b.to, to))))?;
            exits.push(next);
            nodes.push(next.to);
        }
        Some(Trail::new(roads, nodes, exits, Aim::Shortest))
    }
}

/// The graph with known rests in place of straight distances.
pub(super) struct Learned<'a> {
    pub roads: &'a Corners<'a>,
    /// `None`: nothing is learned.
    pub tails: Option<&'a Tails>,
}

impl Roads for Learned<'_> {
    fn nodes(&self) -> usize {
        self.roads.nodes()
    }
    fn slots(&self) -> usize {
        self.roads.slots()
    }
    fn visit(&self, node: u32, see: impl FnMut(Exit)) {
        self.roads.visit(node, see);
    }
    fn back(&self, from: u32, exit: Exit) -> u32 {
        self.roads.back(from, exit)
    }
    fn distance(&self, a: u32, b: u32) -> f64 {
        let known = self.tails.filter(|_| b <= GOAL).map(|tails| tails.rest(a, b)).filter(|rest| rest.is_finite());
        known.unwrap_or_else(|| self.roads.distance(a, b))
    }
    fn position(&self, node: u32) -> [f64; 2] {
        self.roads.position(node)
    }
}
