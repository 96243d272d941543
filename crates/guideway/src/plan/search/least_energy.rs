//! The lattice path of the least energy: A* over cells and headings under the exact remaining length.

use super::open::{Cost, Open};
use super::step::ways;
use super::tree::{Grown, Tree, beside, grow, price};
use super::{Ask, Stopped};
use crate::plan::score::Aim;
use crate::world::Cell;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// Energy in exact integers and turns, in this order. A straight step counts `2 q`, a diagonal one `2 p`, a turn `q`: half of a straight step, as the
/// energy has it ([`Aim::LeastEnergy`]). Exact below `q / 2` diagonal steps, more than any map has cells.
type Label = (u64, u32);

const TURN: u64 = <u64 as Cost>::STRAIGHT;
const UNSEEN: Label = (u64::MAX, u32::MAX);

/// The path of the least energy, fewest turns first among equals, and the states expanded. `shortest` is a shortest path with `turns` turns: a bound.
pub(super) fn search(ask: &mut Ask, shortest: Vec<Cell>, turns: u32) -> Result<(Vec<Cell>, u64), Stopped> {
    debug_assert_eq!(Aim::LeastEnergy.score(1.0, 0).cost, 2.0 * Aim::LeastEnergy.score(0.0, 1).cost);
    let mut open = ask.lattice.pool().take::<Open<u64>>();
    let mut back = Ask { lattice: ask.lattice, start: ask.goal, goal: ask.start, corners: ask.corners, stop: &mut *ask.stop };
    // All turns saved are worth so much length at most.
    let found = grow(&mut back, u64::from(turns) * TURN.div_ceil(2), &mut open).and_then(|grown| match grown {
        Grown::Tree(tree) => {
            let more = tree.expansions;
            States::new(&tree, turns).run(ask).map(|(cells, expansions)| (cells.unwrap_or(shortest), more + expansions))
        }
        // Neither can be: the path is there, and no map is so long.
        Grown::Exhausted | Grown::Overflow => Ok((shortest, 0)),
    });
    ask.lattice.pool().give(open);
    found
}

/// Labels of cells and headings; state `8 n + k` is node `n` of the tree entered in direction `k`.
struct States<'a, 'b> {
    tree: &'a Tree<'b, u64>,
    labels: Vec<Label>,
    /// Heading before the last step, 8 where there is none.
    from: Vec<u8>,
    heap: BinaryHeap<Reverse<(u64, u32, u32)>>,
    /// No better path has more estimated energy than that.
    most: u64,
}

impl<'a, 'b> States<'a, 'b> {
    fn new(tree: &'a Tree<'b, u64>, turns: u32) -> Self {
        let count = 8 * tree.open.nodes.len();
        let most = 2 * tree.best + u64::from(turns) * TURN;
        Self { tree, labels: vec![UNSEEN; count], from: vec![8; count], heap: BinaryHeap::new(), most }
    }

    fn run(mut self, ask: &mut Ask) -> Result<(Option<Vec<Cell>>, u64), Stopped> {
        self.expand(ask, ask.start, (0, 0), None);
        let mut expansions = 1;
        while let Some(Reverse((f, turns, state))) = self.heap.pop() {
            let (cell, label) = (self.tree.cell(state / 8), self.labels[state as usize]);
            if (self.estimate(state / 8, label), label.1) != (f, turns) {
                continue;
            }
            if cell == ask.goal {
                return Ok((Some(self.trail(ask.start, state)), expansions));
            }
            expansions += 1;
            if ask.pause(expansions) {
                return Err(Stopped);
            }
            self.expand(ask, cell, label, Some(state as usize % 8));
        }
        Ok((None, expansions))
    }

    /// Energy of a path with that label through a node at least.
    fn estimate(&self, node: u32, label: Label) -> u64 {
        label.0 + 2 * self.tree.open.nodes[node as usize].g
    }

    fn expand(&mut self, ask: &Ask, cell: Cell, (g, turns): Label, heading: Option<usize>) {
        let ways = ways(ask.lattice, ask.corners, cell);
        for k in (0..8).filter(|k| ways >> k & 1 != 0) {
            let turn = heading.is_some_and(|h| h != k);
            let label = (g + 2 * price::<u64>(k) + if turn { TURN } else { 0 }, turns + u32::from(turn));
            let Some((node, _)) = self.tree.at(beside(cell, k)) else { continue };
            let (state, f) = (8 * node + k as u32, self.estimate(node, label));
            if f <= self.most && label < self.labels[state as usize] {
                self.labels[state as usize] = label;
                self.from[state as usize] = heading.unwrap_or(8) as u8;
                self.heap.push(Reverse((f, label.1, state)));
            }
        }
    }

    fn trail(&self, start: Cell, state: u32) -> Vec<Cell> {
        let (mut cell, mut k) = (self.tree.cell(state / 8), state as usize % 8);
        let mut cells = vec![cell];
        while k < 8 && cell != start {
            let Some((node, _)) = self.tree.at(cell) else { break };
            let before = self.from[8 * node as usize + k];
            cell = beside(cell, k ^ 4);
            cells.push(cell);
            k = before.into();
        }
        cells.reverse();
        cells
    }
}
