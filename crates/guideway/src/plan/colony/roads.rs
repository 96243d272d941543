//! What ants walk on: nodes, and the exits of each.

use crate::world::{Cell, Corners, Lattice};
use std::f64::consts::SQRT_2;
use std::sync::atomic::{AtomicU8, Ordering};

/// A way out of a node.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::plan) struct Exit {
    /// Where it leads.
    pub to: u32,
    /// Its number among all exits of all nodes: pheromone lies on slots.
    pub slot: u32,
    /// Length, cells.
    pub length: f64,
    /// Exits of equal heading continue each other straight on; [`ANY`] never does.
    pub heading: u8,
}

/// No particular heading.
pub(in crate::plan) const ANY: u8 = u8::MAX;

/// A symmetric graph in the plane.
pub(in crate::plan) trait Roads: Sync {
    /// Nodes are numbered from 0 to this.
    fn nodes(&self) -> usize;
    /// Slots are numbered from 0 to this.
    fn slots(&self) -> usize;
    /// Puts the exits of a node into `out`, always in the same order; their slots follow one another.
    fn exits(&self, node: u32, out: &mut Vec<Exit>);
    /// The slot of the same road in the other direction: back to `from` out of `exit.to`.
    fn back(&self, from: u32, exit: Exit) -> u32;
    /// Straight distance between two nodes, cells.
    fn distance(&self, a: u32, b: u32) -> f64;
    /// Position of a node, cells.
    fn position(&self, node: u32) -> [f64; 2];
}

/// The eight directions; direction `7 - k` is opposite to direction `k`.
const WAYS: [(i64, i64); 8] = [(-1, -1), (0, -1), (1, -1), (-1, 0), (1, 0), (-1, 1), (0, 1), (1, 1)];

/// The 8-connected lattice under a corner rule. Slot `8 node + k` leaves in direction `k`.
pub(in crate::plan) struct Streets<'a> {
    pub lattice: &'a Lattice,
    corners: Corners,
    /// Open directions of a cell, found at the first visit; 0: not looked at.
    open: Vec<AtomicU8>,
}

impl<'a> Streets<'a> {
    pub fn new(lattice: &'a Lattice, corners: Corners) -> Self {
        let cells = lattice.width() as usize * lattice.height() as usize;
        let mut open = Vec::new();
        open.resize_with(cells, AtomicU8::default);
        Self { lattice, corners, open }
    }
    pub fn node(&self, [x, y]: Cell) -> u32 {
        y * self.lattice.width() + x
    }
    pub fn cell(&self, node: u32) -> Cell {
        [node % self.lattice.width(), node / self.lattice.width()]
    }
    pub fn cells(&self, nodes: &[u32]) -> Vec<Cell> {
        nodes.iter().map(|&n| self.cell(n)).collect()
    }
    fn ways(&self, node: u32) -> u8 {
        let known = self.open[node as usize].load(Ordering::Relaxed);
        if known != 0 {
            return known;
        }
        let cell = self.cell(node);
        let mask = WAYS.iter().enumerate().fold(0, |mask, (k, &(dx, dy))| mask | u8::from(self.lattice.step_free(cell, dx, dy, self.corners)) << k);
        self.open[node as usize].store(mask, Ordering::Relaxed);
        mask
    }
    fn neighbour(&self, node: u32, k: usize) -> u32 {
        (i64::from(node) + WAYS[k].0 + WAYS[k].1 * i64::from(self.lattice.width())) as u32
    }
}

impl Roads for Streets<'_> {
    fn nodes(&self) -> usize {
        self.open.len()
    }
    fn slots(&self) -> usize {
        8 * self.open.len()
    }
    fn exits(&self, node: u32, out: &mut Vec<Exit>) {
        out.clear();
        let mut mask = self.ways(node);
        while mask != 0 {
            let k = mask.trailing_zeros() as usize;
            mask &= mask - 1;
            let length = if WAYS[k].0 == 0 || WAYS[k].1 == 0 { 1.0 } else { SQRT_2 };
            out.push(Exit { to: self.neighbour(node, k), slot: 8 * node + k as u32, length, heading: k as u8 });
        }
    }
    fn back(&self, _: u32, exit: Exit) -> u32 {
        8 * exit.to + 7 - exit.slot % 8
    }
    fn distance(&self, a: u32, b: u32) -> f64 {
        let ([ax, ay], [bx, by]) = (self.cell(a), self.cell(b));
        let (dx, dy) = (f64::from(ax.abs_diff(bx)), f64::from(ay.abs_diff(by)));
        (dx * dx + dy * dy).sqrt()
    }
    fn position(&self, node: u32) -> [f64; 2] {
        self.cell(node).map(|v| f64::from(v) + 0.5)
    }
}
