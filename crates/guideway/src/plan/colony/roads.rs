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
    /// Shows the exits of a node, always in the same order.
    fn visit(&self, node: u32, see: impl FnMut(Exit));
    /// Puts the exits of a node into `out`, in the order of [`Roads::visit`].
    fn exits(&self, node: u32, out: &mut Vec<Exit>) {
        out.clear();
        self.visit(node, |exit| out.push(exit));
    }
    /// The slot of the same road in the other direction: back to `from` out of `exit.to`.
    fn back(&self, from: u32, exit: Exit) -> u32;
    /// Straight distance between two nodes, cells.
    fn distance(&self, a: u32, b: u32) -> f64;
    /// Position of a node, cells.
    fn position(&self, node: u32) -> [f64; 2];
    /// Puts the nodes near a node and itself into `out`, always in the same order: those within two exits of it.
    fn around(&self, node: u32, out: &mut Vec<u32>) {
        let mut near = vec![node];
        self.visit(node, |exit| near.push(exit.to));
        out.clone_from(&near);
        near[1..].iter().for_each(|next| self.visit(*next, |exit| out.push(exit.to)));
        out.sort_unstable();
        out.dedup();
    }
}

/// The eight directions; direction `7 - k` is opposite to direction `k`.
const WAYS: [(i64, i64); 8] = [(-1, -1), (0, -1), (1, -1), (-1, 0), (1, 0), (-1, 1), (0, 1), (1, 1)];

/// Length of a step in each direction, cells.
const LENGTH: [f64; 8] = [SQRT_2, 1.0, SQRT_2, 1.0, 1.0, SQRT_2, 1.0, SQRT_2];

/// The 8-connected lattice under a corner rule. Slot `8 node + k` leaves in direction `k`.
pub(in crate::plan) struct Streets<'a> {
    pub lattice: &'a Lattice,
    corners: Corners,
    /// What a direction adds to a node's number.
    offset: [i32; 8],
    /// Open directions of a cell, found at the first visit; 0: not looked at.
    open: Vec<AtomicU8>,
}

impl<'a> Streets<'a> {
    pub fn new(lattice: &'a Lattice, corners: Corners) -> Self {
        let cells = lattice.width() as usize * lattice.height() as usize;
        let mut open = Vec::new();
        open.resize_with(cells, AtomicU8::default);
        let offset = WAYS.map(|(dx, dy)| (dx + dy * i64::from(lattice.width())) as i32);
        Self { lattice, corners, offset, open }
    }
    /// Heading of a step, each part -1, 0 or 1 and not both 0.
    pub fn heading([dx, dy]: [i64; 2]) -> u8 {
        WAYS.iter().position(|way| *way == (dx, dy)).map_or(ANY, |k| k as u8)
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
    #[inline]
    fn ways(&self, node: u32) -> u8 {
        let known = self.open[node as usize].load(Ordering::Relaxed);
        if known == 0 { self.look(node) } else { known }
    }
    fn look(&self, node: u32) -> u8 {
        let cell = self.cell(node);
        let mask = WAYS.iter().enumerate().fold(0, |mask, (k, &(dx, dy))| mask | u8::from(self.lattice.step_free(cell, dx, dy, self.corners)) << k);
        self.open[node as usize].store(mask, Ordering::Relaxed);
        mask
    }
}

impl Roads for Streets<'_> {
    fn nodes(&self) -> usize {
        self.open.len()
    }
    fn slots(&self) -> usize {
        8 * self.open.len()
    }
    #[inline]
    fn visit(&self, node: u32, mut see: impl FnMut(Exit)) {
        let mut mask = self.ways(node);
        while mask != 0 {
            let k = mask.trailing_zeros();
            mask &= mask - 1;
            see(Exit { to: node.wrapping_add_signed(self.offset[k as usize]), slot: 8 * node + k, length: LENGTH[k as usize], heading: k as u8 });
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
    /// The free cells of the five by five around a cell.
    fn around(&self, node: u32, out: &mut Vec<u32>) {
        let [x, y] = self.cell(node);
        let [right, top] = [self.lattice.width() - 1, self.lattice.height() - 1];
        out.clear();
        for row in y.saturating_sub(2)..=(y + 2).min(top) {
            for column in x.saturating_sub(2)..=(x + 2).min(right) {
                if self.lattice.free().at(column, row) {
                    out.push(self.node([column, row]));
                }
            }
        }
    }
}
