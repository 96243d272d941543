//! The one ant walk: no node twice, rollback out of dead ends, loops cut where asked for.

use super::pheromone::Pheromone;
use super::roads::{ANY, Exit, Roads};
use super::rule::{Ask, Choices, Open};
use crate::plan::score::{Aim, Score};
use rand::Rng;

/// A finished walk.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::plan) struct Trail {
    /// Nodes from start to target.
    pub nodes: Vec<u32>,
    /// The exit taken out of each node but the last.
    pub exits: Vec<Exit>,
    /// Length, cells.
    pub length: f64,
    /// Worth under the aim of the colony.
    pub score: Score,
}

impl Trail {
    /// A trail along exits. Lengths are summed as whole counts of each kind of step, so that equal lattice lengths are equal numbers.
    pub fn new(roads: &impl Roads, nodes: Vec<u32>, exits: Vec<Exit>, aim: Aim) -> Self {
        let straight = exits.iter().filter(|e| e.length == 1.0).count() as f64;
        let diagonal = exits.iter().filter(|e| e.length == std::f64::consts::SQRT_2).count() as f64;
        let other: f64 = exits.iter().map(|e| e.length).filter(|l| *l != 1.0 && *l != std::f64::consts::SQRT_2).sum();
        let length = straight + diagonal * std::f64::consts::SQRT_2 + other;
        let turns = (1..exits.len()).filter(|&k| turns(roads, [nodes[k - 1], nodes[k], nodes[k + 1]], [exits[k - 1], exits[k]])).count();
        let score = aim.score(length, turns as u32);
        Self { nodes, exits, length, score }
    }

    /// The same way back.
    pub fn reversed(mut self, roads: &impl Roads) -> Self {
        for (exit, from) in self.exits.iter_mut().zip(&self.nodes) {
            *exit = Exit { to: *from, slot: roads.back(*from, *exit), length: exit.length, heading: opposite(exit.heading) };
        }
        self.exits.reverse();
        self.nodes.reverse();
        self
    }
}

fn opposite(heading: u8) -> u8 {
    if heading == ANY { ANY } else { 7 - heading }
}

/// Does the heading change at the middle node?
fn turns(roads: &impl Roads, nodes: [u32; 3], exits: [Exit; 2]) -> bool {
    if exits[0].heading != ANY && exits[1].heading != ANY {
        return exits[0].heading != exits[1].heading;
    }
    let [a, b, c] = nodes.map(|n| roads.position(n));
    let (u, v) = ([b[0] - a[0], b[1] - a[1]], [c[0] - b[0], c[1] - b[1]]);
    let (cross, dot) = (u[0] * v[1] - u[1] * v[0], u[0] * v[0] + u[1] * v[1]);
    cross.abs() > 1e-6 * dot.abs() || dot < 0.0
}

/// Place of a node that the ant left backwards.
const OFF: u32 = u32::MAX;

/// Working memory of one walking ant after the other.
pub(in crate::plan) struct Legs {
    /// Ant that was at a node last, and the node's place on its way.
    marks: Vec<[u32; 2]>,
    ant: u32,
    nodes: Vec<u32>,
    taken: Vec<Exit>,
    open: Vec<Open>,
}

impl Legs {
    pub fn new(roads: &impl Roads) -> Self {
        Self { marks: vec![[0; 2]; roads.nodes()], ant: 0, nodes: Vec::new(), taken: Vec::new(), open: Vec::new() }
    }

    /// A new ant at a node.
    pub fn set_out(&mut self, from: u32) {
        if self.ant == u32::MAX {
            self.marks.fill([0; 2]);
            self.ant = 0;
        }
        self.ant += 1;
        self.nodes.clear();
        self.taken.clear();
        self.nodes.push(from);
        self.marks[from as usize] = [self.ant, 0];
    }

    /// Where the ant is.
    pub fn here(&self) -> u32 {
        self.nodes[self.nodes.len() - 1]
    }

    /// Finds the exits that the ant may take: to nodes where it was not, and that `shut` does not close. Returns the number of all.
    fn look(&mut self, roads: &impl Roads, shut: impl Fn(u32) -> bool) -> usize {
        let (mut count, ant, marks, open) = (0, self.ant, &self.marks, &mut self.open);
        open.clear();
        roads.visit(self.nodes[self.nodes.len() - 1], |exit| {
            if marks[exit.to as usize][0] != ant && !shut(exit.to) {
                open.push(Open { exit, place: count, weight: 0.0 });
            }
            count += 1;
        });
        count
    }

    /// One step by the rule; false in a dead end. `shut` closes nodes.
    pub fn step(&mut self, roads: &impl Roads, tau: &Pheromone, choices: &Choices, shut: impl Fn(u32) -> bool, rng: &mut impl Rng) -> bool {
        let count = self.look(roads, shut);
        let exit = match self.open[..] {
            [] => return false,
            [only] => only.exit,
            _ => {
                let ahead = self.taken.last().map_or(ANY - 1, |e| e.heading);
                choices.choose(roads, tau, &mut Ask { node: self.here(), count, open: &mut self.open, ahead }, rng)
            }
        };
        self.marks[exit.to as usize] = [self.ant, 0];
        self.taken.push(exit);
        self.nodes.push(exit.to);
        true
    }

    /// One step back; the node stays forbidden for this ant. False at the start.
    pub fn roll_back(&mut self) -> bool {
        if let Some(node) = self.nodes.pop() {
            self.marks[node as usize][1] = OFF;
        }
        self.taken.pop().is_some()
    }

    /// Forbids a node to this ant.
    pub fn forbid(&mut self, node: u32) {
        self.marks[node as usize] = [self.ant, OFF];
    }

    /// Is a node forbidden to this ant, or did it leave it backwards?
    pub fn forbidden(&self, node: u32) -> bool {
        self.marks[node as usize] == [self.ant, OFF]
    }

    /// The node that the ant came from.
    pub fn before(&self) -> Option<u32> {
        self.nodes.len().checked_sub(2).map(|k| self.nodes[k])
    }

    /// From every node of the way, jumps to the latest one that is next to it.
    fn cut_loops(&mut self, roads: &impl Roads) {
        for (k, node) in self.nodes.iter().enumerate() {
            self.marks[*node as usize][1] = k as u32;
        }
        let (mut kept, mut at) = (0, 0);
        while at + 1 < self.nodes.len() {
            let (mut next, mut taken) = (at + 1, self.taken[at]);
            roads.visit(self.nodes[at], |exit| {
                let [ant, place] = self.marks[exit.to as usize];
                if ant == self.ant && place != OFF && place as usize > next {
                    (next, taken) = (place as usize, exit);
                }
            });
            kept += 1;
            (self.nodes[kept], self.taken[kept - 1]) = (self.nodes[next], taken);
            at = next;
        }
        self.nodes.truncate(kept + 1);
        self.taken.truncate(kept);
    }

    /// The way that the ant went.
    pub fn trail(&mut self, roads: &impl Roads, cut: bool, aim: Aim) -> Trail {
        if cut {
            self.cut_loops(roads);
        }
        Trail::new(roads, self.nodes.clone(), self.taken.clone(), aim)
    }
}
