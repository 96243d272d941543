//! O4: dead ends. Cells that lead nowhere go into a table that all ants share, and an ant that runs into it twice is given up.

use super::super::crew::Crew;
use super::super::pheromone::Pheromone;
use super::super::roads::{Exit, Roads};
use super::super::rule::Choices;
use super::super::walk::{Legs, Trail};
use rand_chacha::ChaCha8Rng;
use std::collections::BTreeSet;

/// Dead ends caused by the tables after which an ant is given up.
const PATIENCE: u32 = 2;

/// What came of an ant.
pub(super) struct Outcome {
    /// Its way; `None` if it was given up.
    pub trail: Option<Trail>,
    /// Nodes that it found to lead nowhere.
    pub tabu: BTreeSet<u32>,
    /// Times it was placed again.
    pub again: u32,
}

/// What the walks of a generation share.
pub(super) struct Maze<'a, R> {
    pub crew: &'a Crew<'a, R>,
    pub tau: &'a Pheromone<'a>,
    /// The table of the generations before; empty: dead ends are only backed out of.
    pub tabu: &'a [bool],
    pub start: u32,
    /// Times that an ant which was given up may start again.
    pub retries: u32,
    /// Cut loops out of this ant's way?
    pub cut: bool,
}

impl<R: Roads> Maze<'_, R> {
    /// An ant's walk, from the start again if it is given up.
    pub fn walk(&self, choices: &Choices, legs: &mut Legs, rng: &mut ChaCha8Rng) -> Outcome {
        let (mut found, mut again) = (BTreeSet::new(), 0);
        loop {
            let trail = self.once(choices, legs, &mut found, rng);
            if trail.is_some() || again == self.retries {
                return Outcome { trail, tabu: found, again };
            }
            again += 1;
            legs.set_out(self.start);
            for node in &found {
                legs.forbid(*node);
            }
        }
    }

    fn once(&self, choices: &Choices, legs: &mut Legs, found: &mut BTreeSet<u32>, rng: &mut ChaCha8Rng) -> Option<Trail> {
        let (mut backing, mut caused) = (false, 0);
        for _ in 0..self.crew.steps {
            if legs.here() == choices.target() {
                return Some(legs.trail(self.crew.roads, self.cut, self.crew.aim));
            }
            if legs.step(self.crew.roads, self.tau, choices, |node| self.tabu.get(node as usize) == Some(&true), rng) {
                backing = false;
                continue;
            }
            if !backing && !self.tabu.is_empty() {
                backing = true;
                caused += u32::from(self.by_tables(legs, found));
                self.dead_end(choices.target(), legs, found);
            }
            if caused == PATIENCE || !legs.roll_back() {
                return None;
            }
        }
        None
    }

    /// Is this dead end there only because of cells that are tabu or forbidden? (Every exit but the way back leads to one.)
    fn by_tables(&self, legs: &Legs, found: &BTreeSet<u32>) -> bool {
        let (mut exits, from) = (Vec::with_capacity(8), legs.before());
        self.crew.roads.exits(legs.here(), &mut exits);
        exits.retain(|exit| Some(exit.to) != from);
        !exits.is_empty() && exits.iter().all(|e| legs.forbidden(e.to) || self.closed(e.to, found))
    }

    fn closed(&self, node: u32, found: &BTreeSet<u32>) -> bool {
        self.tabu[node as usize] || found.contains(&node)
    }

    /// Marks what leads nowhere around the ant.
    fn dead_end(&self, goal: u32, legs: &mut Legs, found: &mut BTreeSet<u32>) {
        let mut window = Vec::with_capacity(25);
        self.crew.roads.around(legs.here(), &mut window);
        for node in sweep(self.crew.roads, &window, [self.start, goal], |node| self.tabu[node as usize], found) {
            legs.forbid(node);
        }
    }
}

/// Adds to `found`, again and again, and returns, every node of the window but the two ends that has at most one exit to a node that is not closed. No simple way
/// between the ends passes such a node: it would need two.
pub(super) fn sweep(roads: &impl Roads, window: &[u32], ends: [u32; 2], tabu: impl Fn(u32) -> bool, found: &mut BTreeSet<u32>) -> Vec<u32> {
    let (mut exits, mut new): (Vec<Exit>, _) = (Vec::with_capacity(8), Vec::new());
    loop {
        let before = new.len();
        for &node in window.iter().filter(|node| !ends.contains(node)) {
            if tabu(node) || found.contains(&node) {
                continue;
            }
            roads.exits(node, &mut exits);
            if exits.iter().filter(|e| !tabu(e.to) && !found.contains(&e.to)).count() <= 1 {
                found.insert(node);
                new.push(node);
            }
        }
        if new.len() == before {
            return new;
        }
    }
}
