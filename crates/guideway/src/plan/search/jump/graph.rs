//! The graph of jump points, discovered as searches ask for it and kept for the next ones.
//!
//! What a jump point leads to depends on the map, the rule and the direction in which it was entered, not on start or goal. So the first search that
//! expands a jump point scans; later ones read a list. The cost of a way is the octile distance of its ends, so a list is bare node numbers. The goal,
//! which is no jump point, is found from numbers: from how far each diagonal walk got, and how far the goal sees along its row and column.

use super::super::open::Cost;
use super::scan::{CLEAR, Map, ahead, onward, open_to, plain};
use crate::world::Cell;

/// Where a node is; sides are at most 30 000 cells.
pub(super) type Spot = [u16; 2];

/// A jump point (or a start), with its state in the current search. `WAYS` is the number of directions in which it may be entered: the four straight ones
/// under the rule `clear`, else eight.
#[derive(Debug, Clone, Copy)]
pub(super) struct Node<C, const WAYS: usize> {
    /// Cost from the start.
    pub g: C,
    pub spot: Spot,
    /// Node from which it was reached; itself for the start.
    pub parent: u32,
    /// Search that wrote the state, and below it `CLOSED` and the directions of entry.
    pub state: u32,
    /// For each direction of entry, where in `Graph::words` its list starts; 0 while unknown.
    lists: [u32; WAYS],
}

/// Where a jump point entered in one direction leads.
#[derive(Clone, Copy)]
pub(super) struct List<'a> {
    /// Directions that were searched.
    pub ways: u8,
    /// Steps of the diagonal walks, in the order of their directions.
    walks: &'a [u32],
    /// Node and, in the lowest three bits, direction of entry.
    pub targets: &'a [u32],
}

impl<'a> List<'a> {
    /// Reads the list that starts at word `at`.
    #[inline(always)]
    pub(super) fn read(words: &'a [u32], at: u32) -> Self {
        let at = at as usize;
        let (ways, count) = (words[at] as u8, (words[at] >> 8) as usize);
        let (walks, targets) = words[at + 1..].split_at((ways & DIAGONALS).count_ones() as usize);
        Self { ways, walks, targets: &targets[..count] }
    }

    /// Steps of the diagonal walk in direction `k`, if there was one.
    #[inline(always)]
    pub(super) fn walk(&self, k: usize) -> Option<u32> {
        let diagonals = self.ways & DIAGONALS;
        if diagonals >> k & 1 == 0 {
            return None;
        }
        self.walks.get((diagonals & ((1 << k) - 1)).count_ones() as usize).copied()
    }
}

/// Set of the diagonal directions.
const DIAGONALS: u8 = 0b1010_1010;

/// Jump points known so far and their lists.
pub(super) struct Graph<C, const RULE: u8, const WAYS: usize> {
    width: u32,
    /// Node of each cell; 0 for none.
    of_cell: Vec<u32>,
    pub nodes: Vec<Node<C, WAYS>>,
    /// Lists end to end: ways and number of targets, walks, targets.
    pub words: Vec<u32>,
}

impl<C: Cost, const RULE: u8, const WAYS: usize> Default for Graph<C, RULE, WAYS> {
    fn default() -> Self {
        Self { width: 0, of_cell: Vec::new(), nodes: Vec::new(), words: Vec::new() }
    }
}

impl<C: Cost, const RULE: u8, const WAYS: usize> Graph<C, RULE, WAYS> {
    /// Makes the graph fit a map, and forgets it when it has grown beyond about ten bytes a cell.
    pub(super) fn prepare(&mut self, width: u32, height: u32) {
        let cells = width as usize * height as usize;
        if self.of_cell.len() != cells || self.width != width {
            *self = Self { width, of_cell: vec![0; cells], ..Self::default() };
        } else if self.words.len() + self.nodes.len() * 4 > cells * 2 + (1 << 16) {
            for node in &self.nodes[1..] {
                self.of_cell[usize::from(node.spot[1]) * width as usize + usize::from(node.spot[0])] = 0;
            }
            self.nodes.clear();
            self.words.clear();
        }
        if self.nodes.is_empty() {
            self.words.push(0);
            self.nodes.push(Self::fresh([0, 0]));
        }
    }

    fn fresh(spot: Spot) -> Node<C, WAYS> {
        Node { g: C::default(), spot, parent: 0, state: 0, lists: [0; WAYS] }
    }

    /// The node of a cell, made if need be.
    #[inline(always)]
    pub(super) fn node(&mut self, cell: Cell) -> u32 {
        let slot = &mut self.of_cell[(cell[1] * self.width + cell[0]) as usize];
        if *slot == 0 {
            *slot = self.nodes.len() as u32;
            self.nodes.push(Self::fresh(cell.map(|v| v as u16)));
        }
        *slot
    }

    /// Where the list of a node entered in direction `k` starts.
    #[inline(always)]
    pub(super) fn list(&mut self, map: Map, node: u32, k: usize) -> u32 {
        let known = self.nodes[node as usize].lists[k * WAYS / 8];
        if known == 0 { self.discover(map, node, k) } else { known }
    }

    #[inline(never)]
    fn discover(&mut self, map: Map, node: u32, k: usize) -> u32 {
        let cell = self.nodes[node as usize].spot.map(u32::from);
        let ways = onward::<RULE>(map.around(cell), k);
        let at = self.spokes(map, cell, ways);
        self.nodes[node as usize].lists[k * WAYS / 8] = at;
        at
    }

    /// Searches from a cell in a set of directions and appends the list found; returns where it starts.
    pub(super) fn spokes(&mut self, map: Map, cell: Cell, ways: u8) -> u32 {
        let at = self.words.len();
        let first = at + 1 + (ways & DIAGONALS).count_ones() as usize;
        self.words.resize(first, 0);
        let mut walks = at;
        let has = |k: usize| ways >> k & 1 != 0;
        let mut note = |words: &mut [u32], steps: u32| {
            walks += 1;
            words[walks] = steps;
        };
        if has(0) {
            self.straight::<0>(map, cell);
        }
        if has(2) {
            self.straight::<2>(map, cell);
        }
        if has(4) {
            self.straight::<4>(map, cell);
        }
        if has(6) {
            self.straight::<6>(map, cell);
        }
        if has(1) {
            let steps = self.diagonal::<1, 0, 2>(map, cell);
            note(&mut self.words, steps);
        }
        if has(3) {
            let steps = self.diagonal::<3, 2, 4>(map, cell);
            note(&mut self.words, steps);
        }
        if has(5) {
            let steps = self.diagonal::<5, 4, 6>(map, cell);
            note(&mut self.words, steps);
        }
        if has(7) {
            let steps = self.diagonal::<7, 6, 0>(map, cell);
            note(&mut self.words, steps);
        }
        self.words[at] = u32::from(ways) | ((self.words.len() - first) as u32) << 8;
        at as u32
    }

    #[inline(always)]
    fn straight<const K: usize>(&mut self, map: Map, cell: Cell) {
        let (steps, jump) = map.straight::<RULE, K>(cell);
        if jump {
            self.target(ahead(cell, K, steps), K);
        }
    }

    /// Walks from a cell in diagonal direction `K`, scanning both straight parts at each cell after the first. Returns the steps walked.
    #[inline(always)]
    fn diagonal<const K: usize, const A: usize, const B: usize>(&mut self, map: Map, mut cell: Cell) -> u32 {
        let (mut steps, mut around) = (0, map.around(cell));
        while open_to::<RULE>(around, K) {
            cell = ahead(cell, K, 1);
            steps += 1;
            around = map.around(cell);
            if RULE != CLEAR && onward::<RULE>(around, K) & !plain(K) != 0 {
                self.target(cell, K);
                break;
            }
            self.straight::<A>(map, cell);
            self.straight::<B>(map, cell);
        }
        steps
    }

    #[inline(always)]
    fn target(&mut self, cell: Cell, k: usize) {
        let target = self.node(cell) << 3 | k as u32;
        self.words.push(target);
    }
}
