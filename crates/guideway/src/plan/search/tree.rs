//! Exact costs from one cell to every cell that a path to the other end may use.

use super::open::{Cost, Node, Open, octile};
use super::step::{DIRECTIONS, ways};
use super::{Ask, Stopped};
use crate::world::Cell;

/// What a search grew: the costs of the cells that matter are those of closed nodes.
pub(super) struct Tree<'a, C: Cost> {
    pub open: &'a mut Open<C>,
    width: u32,
    /// Cost of a shortest path.
    pub best: C,
    pub expansions: u64,
}

/// How growing ended.
pub(super) enum Grown<'a, C: Cost> {
    Tree(Tree<'a, C>),
    /// No path joins the ends.
    Exhausted,
    /// Costs got too large for the integers in use.
    Overflow,
}

/// A* from the start of `ask` that goes on until every cell is closed through which a path of at most the least cost + `slack` runs.
pub(super) fn grow<'a, C: Cost>(ask: &mut Ask, slack: C, open: &'a mut Open<C>) -> Result<Grown<'a, C>, Stopped> {
    let width = ask.lattice.width();
    let place = |c: Cell| c[1] * width + c[0];
    let ([gx, gy], goal) = (ask.goal, place(ask.goal));
    open.begin(width as usize * ask.lattice.height() as usize, place(ask.start));
    let (mut best, mut expansions) = (None, 0);
    while let Some((f, id)) = open.pop() {
        if best.is_some_and(|least: C| f > least + slack) {
            break;
        }
        let node = open.nodes[id as usize];
        if node.place == goal && best.is_none() {
            best = Some(f);
        }
        expansions += 1;
        if ask.pause(expansions) {
            return Err(Stopped);
        }
        let cell = [node.place % width, node.place / width];
        let mut ways = ways(ask.lattice, ask.corners, cell);
        while ways != 0 {
            let k = ways.trailing_zeros() as usize;
            ways &= ways - 1;
            let [x, y] = beside(cell, k);
            let g = node.g + price(k);
            open.relax(y * width + x, g, g + octile(x.abs_diff(gx), y.abs_diff(gy)), id, 1 << k);
        }
    }
    Ok(match best {
        _ if open.overflow => Grown::Overflow,
        Some(best) => Grown::Tree(Tree { open, width, best, expansions }),
        None => Grown::Exhausted,
    })
}

/// Cost of a step in direction `k`.
#[inline]
pub(super) fn price<C: Cost>(k: usize) -> C {
    if k.is_multiple_of(2) { C::STRAIGHT } else { C::DIAGONAL }
}

/// The cell next to `cell` in direction `k`; it must be inside.
#[inline]
pub(super) fn beside(cell: Cell, k: usize) -> Cell {
    [cell[0].wrapping_add_signed(DIRECTIONS[k][0]), cell[1].wrapping_add_signed(DIRECTIONS[k][1])]
}

impl<C: Cost> Tree<'_, C> {
    /// Number of a closed node at that cell and what it knows.
    #[inline]
    pub fn at(&self, cell: Cell) -> Option<(u32, &Node<C>)> {
        self.open.find(cell[1] * self.width + cell[0]).filter(|(_, node)| node.closed)
    }

    /// The cell of a node.
    #[inline]
    pub fn cell(&self, id: u32) -> Cell {
        let place = self.open.nodes[id as usize].place;
        [place % self.width, place / self.width]
    }
}
