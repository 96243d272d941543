//! The graph of jump points, discovered as searches ask for it and kept for the next ones.
//!
//! What a jump point leads to depends on the map, the rule and the direction in which it was entered, not on start or goal. So the first search that
//! expands a jump point scans; later ones read a list. The goal, which is no jump point, is found from numbers: from how far each diagonal walk
//! got, and how far the goal sees along its row and column.

use super::super::open::Cost;
use super::scan::{CLEAR, Map, ahead, onward, open_to, plain};
use crate::world::Cell;

/// A jump point (or a start), with its state in the current search.
#[derive(Debug, Clone, Copy)]
pub(super) struct Node<C> {
    pub cell: Cell,
    /// Cost from the start.
    pub g: C,
    /// Node from which it was reached; itself for the start.
    pub parent: u32,
    /// Search that wrote the state, and below it `CLOSED` and the directions of entry.
    pub state: u32,
}

/// A way to another jump point.
#[derive(Debug, Clone, Copy)]
pub(super) struct Edge<C> {
    pub cost: C,
    /// Node and, in the lowest three bits, direction of entry.
    pub target: u32,
}

/// Where a jump point entered in one direction leads.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct List {
    first: u32,
    count: u32,
    /// Directions that were searched.
    pub ways: u8,
    /// Steps of the diagonal walks, in the order of their directions.
    walks: [u32; 4],
}

impl List {
    /// Edges of the list in the graph's store.
    #[inline(always)]
    pub(super) fn range(&self) -> std::ops::Range<usize> {
        self.first as usize..(self.first + self.count) as usize
    }

    /// Steps of the diagonal walk in direction `k`, if there was one.
    #[inline(always)]
    pub(super) fn walk(&self, k: usize) -> Option<u32> {
        let diagonals = self.ways & 0b1010_1010;
        (diagonals >> k & 1 != 0).then(|| self.walks[(diagonals & ((1 << k) - 1)).count_ones() as usize & 3])
    }
}

/// Jump points known so far and their lists.
pub(super) struct Graph<C, const RULE: u8> {
    width: u32,
    /// Node of each cell; 0 for none.
    of_cell: Vec<u32>,
    pub nodes: Vec<Node<C>>,
    /// For each node and direction of entry: index into `lists`; 0 for not searched yet.
    index: Vec<[u32; 8]>,
    pub lists: Vec<List>,
    pub edges: Vec<Edge<C>>,
}

impl<C: Cost, const RULE: u8> Default for Graph<C, RULE> {
    fn default() -> Self {
        Self { width: 0, of_cell: Vec::new(), nodes: Vec::new(), index: Vec::new(), lists: Vec::new(), edges: Vec::new() }
    }
}

impl<C: Cost, const RULE: u8> Graph<C, RULE> {
    /// Makes the graph fit a map, and forgets it when it has grown beyond about four bytes a cell.
    pub(super) fn prepare(&mut self, width: u32, height: u32) {
        let cells = width as usize * height as usize;
        if self.of_cell.len() != cells || self.width != width {
            *self = Self { width, of_cell: vec![0; cells], ..Self::default() };
        } else if self.edges.len() > cells / 2 + (1 << 16) {
            for node in &self.nodes[1..] {
                self.of_cell[(node.cell[1] * width + node.cell[0]) as usize] = 0;
            }
            self.nodes.clear();
            self.index.clear();
            self.lists.clear();
            self.edges.clear();
        }
        if self.nodes.is_empty() {
            self.nodes.push(Node { cell: [0, 0], g: C::default(), parent: 0, state: 0 });
            self.index.push([0; 8]);
            self.lists.push(List::default());
        }
    }

    /// The node of a cell, made if need be.
    #[inline(always)]
    pub(super) fn node(&mut self, cell: Cell) -> u32 {
        let slot = &mut self.of_cell[(cell[1] * self.width + cell[0]) as usize];
        if *slot == 0 {
            *slot = self.nodes.len() as u32;
            self.nodes.push(Node { cell, g: C::default(), parent: 0, state: 0 });
            self.index.push([0; 8]);
        }
        *slot
    }

    /// The list of a node entered in direction `k`.
    #[inline(always)]
    pub(super) fn list(&mut self, map: Map, node: u32, k: usize) -> List {
        let known = self.index[node as usize][k];
        if known != 0 {
            return self.lists[known as usize];
        }
        self.discover(map, node, k)
    }

    #[inline(never)]
    fn discover(&mut self, map: Map, node: u32, k: usize) -> List {
        let cell = self.nodes[node as usize].cell;
        let ways = onward::<RULE>(map.around(cell), k);
        let list = self.spokes(map, cell, ways);
        self.index[node as usize][k] = self.lists.len() as u32;
        self.lists.push(list);
        list
    }

    /// Searches from a cell in a set of directions and stores the edges found.
    pub(super) fn spokes(&mut self, map: Map, cell: Cell, ways: u8) -> List {
        let first = self.edges.len() as u32;
        let (zero, mut walks, mut walked) = (C::default(), [0; 4], 0);
        let has = |k: usize| ways >> k & 1 != 0;
        let mut note = |steps: u32| {
            walks[walked & 3] = steps;
            walked += 1;
        };
        if has(0) {
            self.straight::<0>(map, cell, zero);
        }
        if has(2) {
            self.straight::<2>(map, cell, zero);
        }
        if has(4) {
            self.straight::<4>(map, cell, zero);
        }
        if has(6) {
            self.straight::<6>(map, cell, zero);
        }
        if has(1) {
            note(self.diagonal::<1, 0, 2>(map, cell));
        }
        if has(3) {
            note(self.diagonal::<3, 2, 4>(map, cell));
        }
        if has(5) {
            note(self.diagonal::<5, 4, 6>(map, cell));
        }
        if has(7) {
            note(self.diagonal::<7, 6, 0>(map, cell));
        }
        List { first, count: self.edges.len() as u32 - first, ways, walks }
    }

    #[inline(always)]
    fn straight<const K: usize>(&mut self, map: Map, cell: Cell, cost: C) {
        let (steps, jump) = map.straight::<RULE, K>(cell);
        if jump {
            self.edge(ahead(cell, K, steps), cost + C::STRAIGHT.times(steps), K);
        }
    }

    /// Walks in diagonal direction `K`, scanning both straight parts at each cell after the first. Returns the steps walked.
    #[inline(always)]
    fn diagonal<const K: usize, const A: usize, const B: usize>(&mut self, map: Map, mut cell: Cell) -> u32 {
        let (mut steps, mut around) = (0, map.around(cell));
        while open_to::<RULE>(around, K) {
            cell = ahead(cell, K, 1);
            steps += 1;
            around = map.around(cell);
            let cost = C::DIAGONAL.times(steps);
            if RULE != CLEAR && onward::<RULE>(around, K) & !plain(K) != 0 {
                self.edge(cell, cost, K);
                break;
            }
            self.straight::<A>(map, cell, cost);
            self.straight::<B>(map, cell, cost);
        }
        steps
    }

    #[inline(always)]
    fn edge(&mut self, cell: Cell, cost: C, k: usize) {
        let target = self.node(cell) << 3 | k as u32;
        self.edges.push(Edge { cost, target });
    }
}
