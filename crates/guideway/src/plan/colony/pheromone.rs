//! The one pheromone store: concentrations on slots, evaporated when they are read.
//!
//! Evaporation multiplies every trail, so it is a count of rounds here; a slot knows the round of its last change. Only slots that ants marked take
//! memory. The bounds hold at every reading.

use super::paged::Paged;
use super::roads::{Exit, Roads};

/// What lies on a slot. Small: there are eight slots to a cell.
#[derive(Debug, Clone, Copy, Default)]
struct Deposit {
    /// Concentration after the round before `next`.
    value: f32,
    /// What is going to be added to the road; kept on one of its two slots.
    sum: f32,
    /// The round after the last change; 0: never marked.
    next: u32,
}

/// Initial concentration of the road to a node.
pub(in crate::plan) type Initial<'a> = dyn Fn(u32) -> f64 + Sync + 'a;

/// Concentrations on the roads of a graph, the same in both directions.
pub(in crate::plan) struct Pheromone<'a> {
    slots: Paged<Deposit>,
    initial: Box<Initial<'a>>,
    /// What one evaporation leaves.
    keep: f64,
    /// Least and largest concentration.
    bounds: [f64; 2],
    round: u32,
    /// Rounds in which all trails were drawn towards a concentration, and that concentration.
    smoothed: Vec<(u32, f64)>,
    /// Roads to which something is going to be added.
    gathered: Vec<(u32, Exit)>,
}

impl<'a> Pheromone<'a> {
    /// Concentrations from `initial`, kept within `bounds`; an evaporation takes the share `rho`.
    pub fn new(roads: &impl Roads, initial: impl Fn(u32) -> f64 + Sync + 'a, rho: f64, bounds: [f64; 2]) -> Self {
        let slots = Paged::new(roads.slots());
        Self { slots, initial: Box::new(initial), keep: 1.0 - rho, bounds, round: 0, smoothed: Vec::new(), gathered: Vec::new() }
    }

    /// Concentration on an exit.
    pub fn at(&self, exit: Exit) -> f64 {
        match self.slots.find(exit.slot as usize) {
            Some(deposit) if deposit.next > 0 => self.aged(f64::from(deposit.value), deposit.next - 1),
            _ => self.aged((self.initial)(exit.to), 0),
        }
    }

    /// ln of the concentration on an exit.
    pub fn ln(&self, exit: Exit) -> f64 {
        self.at(exit).ln()
    }

    /// A concentration of round `round` as it is now.
    fn aged(&self, mut value: f64, mut round: u32) -> f64 {
        let since = round;
        for &(when, goal) in self.smoothed.iter().filter(|s| s.0 >= since) {
            value = self.within(value * self.left(when - round));
            (value, round) = (value + 0.5 * (goal - value), when);
        }
        self.within(value * self.left(self.round - round))
    }

    /// What some evaporations leave.
    #[inline]
    fn left(&self, rounds: u32) -> f64 {
        match rounds {
            0 => 1.0,
            1 => self.keep,
            n => self.keep.powi(n as i32),
        }
    }

    fn within(&self, value: f64) -> f64 {
        value.clamp(self.bounds[0], self.bounds[1])
    }

    /// One evaporation.
    pub fn evaporate(&mut self) {
        self.round += 1;
    }

    /// Adds to a road, in both directions. `from` is where the exit leaves.
    pub fn deposit(&mut self, roads: &impl Roads, from: u32, exit: Exit, amount: f64) {
        let back = Exit { to: from, slot: roads.back(from, exit), ..exit };
        for exit in [exit, back] {
            let value = self.within(self.at(exit) + amount);
            self.set(exit.slot, value);
        }
    }

    /// Adds to a road at the next [`Pheromone::settle`]: many ants that went the same way cost little more than one.
    pub fn gather(&mut self, roads: &impl Roads, from: u32, exit: Exit, amount: f64) {
        let slot = exit.slot.min(roads.back(from, exit));
        if let Some(deposit) = self.slots.at_mut(slot as usize) {
            if deposit.sum == 0.0 {
                self.gathered.push((from, exit));
            }
            deposit.sum += amount as f32;
        }
    }

    /// Adds what was gathered, in both directions.
    pub fn settle(&mut self, roads: &impl Roads) {
        let mut gathered = std::mem::take(&mut self.gathered);
        for (from, exit) in gathered.drain(..) {
            let slot = exit.slot.min(roads.back(from, exit));
            let amount = self.slots.at_mut(slot as usize).map_or(0.0, |deposit| std::mem::take(&mut deposit.sum));
            self.deposit(roads, from, exit, f64::from(amount));
        }
        self.gathered = gathered;
    }

    /// Sets the concentration of a road, in both directions.
    pub fn assign(&mut self, roads: &impl Roads, from: u32, exit: Exit, value: f64) {
        let value = self.within(value);
        self.set(exit.slot, value);
        self.set(roads.back(from, exit), value);
    }

    /// Sets the concentration on one slot.
    pub fn lay(&mut self, slot: u32, value: f64) {
        let value = self.within(value);
        self.set(slot, value);
    }

    fn set(&mut self, slot: u32, value: f64) {
        let next = self.round + 1;
        if let Some(deposit) = self.slots.at_mut(slot as usize) {
            *deposit = Deposit { value: value as f32, next, ..*deposit };
        }
    }

    /// Changes the least and largest concentration.
    pub fn bound(&mut self, bounds: [f64; 2]) {
        self.bounds = bounds;
    }

    /// Draws every concentration half the way to `goal`.
    pub fn smooth(&mut self, goal: f64) {
        self.smoothed.push((self.round, goal));
    }

    /// Back to the initial concentrations.
    pub fn restart(&mut self) {
        self.slots.clear();
        self.smoothed.clear();
        self.round = 0;
    }

    /// Slots that were ever marked and their concentrations, in order of slots: for pictures and memories.
    pub fn marked(&self) -> impl Iterator<Item = (u32, f64)> {
        let marked = self.slots.entries().filter(|(_, deposit)| deposit.next > 0);
        marked.map(|(slot, deposit)| (slot as u32, self.aged(f64::from(deposit.value), deposit.next - 1)))
    }
}

#[cfg(test)]
mod tests {
    use super::super::roads::Streets;
    use super::*;
    use crate::world::{Bits, Corners, Grid, World};

    #[test]
    fn lazy_evaporation_equals_the_plain_rule_to_single_precision() {
        let world = World::from_grid(Grid::new(Bits::new(4, 4), None, 1.0, [0.0; 3]).unwrap());
        let lattice = world.lattice(0.0);
        let roads = Streets::new(&lattice, Corners::Touch);
        let mut tau = Pheromone::new(&roads, |_| 1.0, 0.2, [0.05, 3.0]);
        let mut exits = Vec::new();
        roads.exits(5, &mut exits);
        let mut plain: Vec<f64> = vec![1.0; exits.len()];
        for round in 0..60 {
            tau.evaporate();
            plain = plain.iter().map(|t| (t * 0.8).max(0.05)).collect();
            let k = round * 7 % exits.len();
            if round % 3 != 0 {
                tau.deposit(&roads, 5, exits[k], 0.4);
                plain[k] = (plain[k] + 0.4).min(3.0);
            }
            if round % 5 == 4 {
                // Gathered from both ends, added at once.
                tau.gather(&roads, 5, exits[k], 0.3);
                tau.gather(&roads, exits[k].to, Exit { to: 5, slot: roads.back(5, exits[k]), ..exits[k] }, 0.2);
                tau.settle(&roads);
                plain[k] = (plain[k] + 0.5).min(3.0);
            }
            if round == 31 {
                tau.smooth(3.0);
                plain = plain.iter().map(|t| t + 0.5 * (3.0 - t)).collect();
            }
            for (exit, expected) in exits.iter().zip(&plain) {
                assert!((tau.at(*exit) - expected).abs() < 1e-5 * expected, "round {round}");
                let back = Exit { to: 5, slot: roads.back(5, *exit), ..*exit };
                assert!((tau.at(back) - tau.at(*exit)).abs() < 1e-12, "the same in both directions");
            }
        }
    }
}
