//! Every trade of length against turns between two cells: a bi-objective A* over cells and headings.
//!
//! Source: \[hernandez2023\], BOA*: labels leave the open list in the order of (length, turns) under exact remaining costs of either kind; one is worth expanding only with
//! fewer turns than every earlier one of its state, and than every solution. Ours: it also needs no more turns than the best label of its cell has, because
//! from there a turn makes up for the heading.

use super::tree::{beside, price};
use crate::world::{Cell, Lattice};
use std::cmp::Reverse;
use std::collections::BinaryHeap;

const UNSEEN: u32 = u32::MAX;
const FAR: u64 = u64::MAX;

/// One path of a trade: exact cost of its length, turns and cells.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Trade {
    pub length: u64,
    pub turns: u32,
    pub cells: Vec<Cell>,
}

/// A lattice reduced to the steps of interest.
pub(super) struct Maze<'a> {
    pub lattice: &'a Lattice,
    /// Steps allowed from each cell, a bit each; a step can be undone.
    pub ways: Vec<u8>,
    pub start: Cell,
    pub goal: Cell,
}

/// What one search found; `whole` says that it ran to its end.
pub(super) struct Trades {
    pub found: Vec<Trade>,
    pub labels: u64,
    pub whole: bool,
}

impl Maze<'_> {
    fn place(&self, cell: Cell) -> usize {
        cell[1] as usize * self.lattice.width() as usize + cell[0] as usize
    }

    fn cell(&self, place: usize) -> Cell {
        let width = self.lattice.width() as usize;
        [(place % width) as u32, (place / width) as u32]
    }

    /// All trades, shortest first, with at most `most` labels. `stop` is asked now and then.
    pub fn solve(&self, most: u64, stop: &mut dyn FnMut() -> bool) -> Trades {
        let none = |whole| Trades { found: Vec::new(), labels: 0, whole };
        let Some(length) = self.lengths(stop) else { return none(false) };
        if length[self.place(self.start)] == FAR {
            return none(true);
        }
        let Some(turns) = self.turns(stop) else { return none(false) };
        let count = self.ways.len();
        let search = Search {
            maze: self,
            length,
            turns,
            least: vec![UNSEEN; 8 * count],
            cell_least: vec![UNSEEN; count],
            goal_least: UNSEEN,
            heap: BinaryHeap::new(),
        };
        search.run(most, stop)
    }

    /// Exact remaining length of every cell; `None`: stopped.
    fn lengths(&self, stop: &mut dyn FnMut() -> bool) -> Option<Vec<u64>> {
        let mut best = vec![FAR; self.ways.len()];
        let mut heap = BinaryHeap::from([Reverse((0u64, self.place(self.goal)))]);
        best[self.place(self.goal)] = 0;
        let mut count = 0u64;
        while let Some(Reverse((g, place))) = heap.pop() {
            if g > best[place] {
                continue;
            }
            count += 1;
            if count.is_multiple_of(4096) && stop() {
                return None;
            }
            for k in (0..8).filter(|k| self.ways[place] >> k & 1 != 0) {
                let (next, g) = (self.place(beside(self.cell(place), k)), g + price::<u64>(k));
                if g < best[next] {
                    best[next] = g;
                    heap.push(Reverse((g, next)));
                }
            }
        }
        Some(best)
    }

    /// Fewest remaining turns of every cell and heading, breadth first; `None`: stopped.
    fn turns(&self, stop: &mut dyn FnMut() -> bool) -> Option<Vec<u32>> {
        let mut best = vec![UNSEEN; 8 * self.ways.len()];
        let mut reached = vec![false; self.ways.len()];
        let goal = self.place(self.goal);
        best[8 * goal..8 * goal + 8].fill(0);
        reached[goal] = true;
        let (mut now, mut next, mut turns) = ((8 * goal..8 * goal + 8).collect::<Vec<_>>(), Vec::new(), 0);
        while !now.is_empty() {
            if stop() {
                return None;
            }
            while let Some(state) = now.pop() {
                let (place, k) = (state / 8, state % 8);
                if best[state] != turns || self.ways[place] >> (k ^ 4) & 1 == 0 {
                    continue;
                }
                let before = self.place(beside(self.cell(place), k ^ 4));
                if best[8 * before + k] > turns {
                    best[8 * before + k] = turns;
                    now.push(8 * before + k);
                }
                if !std::mem::replace(&mut reached[before], true) {
                    for state in (8 * before..8 * before + 8).filter(|s| s % 8 != k) {
                        best[state] = best[state].min(turns + 1);
                        next.push(state);
                    }
                }
            }
            turns += 1;
            std::mem::swap(&mut now, &mut next);
        }
        Some(best)
    }
}

/// Estimated length and turns, state (8 times the place of the cell plus the heading), label before.
type Key = (u64, u32, u32, u32);

struct Search<'a> {
    maze: &'a Maze<'a>,
    length: Vec<u64>,
    turns: Vec<u32>,
    /// Fewest turns of an expanded label of each state, each cell, and the goal.
    least: Vec<u32>,
    cell_least: Vec<u32>,
    goal_least: u32,
    heap: BinaryHeap<Reverse<Key>>,
}

impl Search<'_> {
    fn run(mut self, most: u64, stop: &mut dyn FnMut() -> bool) -> Trades {
        let goal = self.maze.place(self.maze.goal);
        let mut labels: Vec<[u32; 2]> = Vec::new();
        let mut found = Vec::new();
        self.expand(self.maze.place(self.maze.start), (0, 0), None, UNSEEN);
        while let Some(Reverse((length, estimate, state, before))) = self.heap.pop() {
            let (place, turns) = (state as usize / 8, estimate - self.turns[state as usize]);
            if !self.worthy(state as usize, turns) {
                continue;
            }
            labels.push([state, before]);
            if place == goal {
                self.goal_least = turns;
                found.push(Trade { length, turns, cells: self.trail(&labels) });
                continue;
            }
            let count = labels.len() as u64;
            if count >= most || count.is_multiple_of(4096) && stop() {
                return Trades { found, labels: count, whole: false };
            }
            self.least[state as usize] = turns;
            self.cell_least[place] = self.cell_least[place].min(turns);
            self.expand(place, (length - self.length[place], turns), Some(state as usize % 8), count as u32 - 1);
        }
        Trades { found, labels: labels.len() as u64, whole: true }
    }

    /// Can a label lead to something new?
    fn worthy(&self, state: usize, turns: u32) -> bool {
        let ahead = self.turns[state];
        turns < self.least[state] && turns <= self.cell_least[state / 8] && ahead < UNSEEN && turns + ahead < self.goal_least
    }

    fn expand(&mut self, place: usize, (length, turns): (u64, u32), heading: Option<usize>, label: u32) {
        let ways = self.maze.ways[place];
        for k in (0..8).filter(|k| ways >> k & 1 != 0) {
            let next = self.maze.place(beside(self.maze.cell(place), k));
            let (state, turns) = (8 * next + k, turns + u32::from(heading.is_some_and(|h| h != k)));
            if self.worthy(state, turns) {
                let estimate = length + price::<u64>(k) + self.length[next];
                self.heap.push(Reverse((estimate, turns + self.turns[state], state as u32, label)));
            }
        }
    }

    /// Cells up to the newest label.
    fn trail(&self, labels: &[[u32; 2]]) -> Vec<Cell> {
        let (mut cells, mut at) = (Vec::new(), labels.len() as u32 - 1);
        while let Some([state, before]) = labels.get(at as usize) {
            cells.push(self.maze.cell(*state as usize / 8));
            at = *before;
        }
        cells.push(self.maze.start);
        cells.reverse();
        cells
    }
}
