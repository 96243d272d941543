//! Jump point search, bit-parallel.
//!
//! Source: [`harabor2011`] (jump points, forced neighbours), [`harabor2014`] (block-wise scans and pruning of intermediate jump points, "JPS (B+P)").
//!
//! A path is canonical if it turns from diagonal to straight wherever it can without growing longer; every shortest path can be made so. From a cell entered
//! in direction `d`, only those neighbours matter that a canonical path can reach through it: `d` itself, the two straight parts of a diagonal `d`, and
//! *forced* neighbours, next to an obstacle that stopped the path from turning earlier. A cell with a forced neighbour is a jump point.
//! Rows (and, transposed, columns) are scanned 57 or more cells at a time for the next wall or jump point. A diagonal walk scans both straight directions at
//! each cell and hands the jump points found there straight to its own start, so cells where a path only turns are never nodes. What a jump point leads to
//! is remembered between searches (see [`graph`]).
//!
//! The rules differ with the corner rule. Entering `x` by a straight step, with `a` the cell beside the one before, `b` beside `x`, `c` beside the next, `e` the next:
//!
//! | rule | forced when | new directions |
//! |---|---|---|
//! | clear | `a` blocked, `b` free | towards `b`, and the diagonal between |
//! | touch | `b` blocked, `c` and `e` free | the diagonal to `c` |
//! | squeeze | `b` blocked, `c` free | the diagonal to `c` |
//!
//! Entering diagonally, nothing is forced under `clear`; otherwise the diagonal back to a side is forced when the cell beside the one before is blocked and the step is allowed.

#![expect(clippy::inline_always, reason = "the loops are specialised by direction and rule; calls between them cost a third of the time")]

mod graph;
mod scan;

use super::open::{Cost, octile};
use super::{Ask, End, Steps};
use crate::world::{Cell, Corners};
use graph::{Graph, List};
use scan::{CLEAR, Map, SQUEEZE, TOUCH};
use std::collections::BinaryHeap;

/// Bit of [`graph::Node::state`]: expanded already. Directions of entry are below, the number of the search above.
const CLOSED: u32 = 1 << 8;
/// Number of the first search, and the step to the next.
const SEARCH: u32 = 1 << 9;

/// What one thread keeps between searches on a lattice.
struct Scratch<C: Cost, const RULE: u8> {
    graph: Graph<C, RULE>,
    heap: BinaryHeap<C::Key>,
    /// Nodes in the order in which they were pushed: ties go by age, never by what earlier searches have seen.
    pushed: Vec<u32>,
    /// Number of the current search, in units of [`SEARCH`].
    search: u32,
}

impl<C: Cost, const RULE: u8> Default for Scratch<C, RULE> {
    fn default() -> Self {
        Self { graph: Graph::default(), heap: BinaryHeap::new(), pushed: Vec::new(), search: 0 }
    }
}

impl<C: Cost, const RULE: u8> Scratch<C, RULE> {
    /// Forgets the last search, whatever its size, by counting up.
    fn begin(&mut self, width: u32, height: u32) {
        self.graph.prepare(width, height);
        self.heap.clear();
        self.pushed.clear();
        self.search = self.search.wrapping_add(SEARCH);
        if self.search == 0 {
            self.graph.nodes.iter_mut().for_each(|n| n.state = 0);
            self.search = SEARCH;
        }
    }

    /// The open node with the smallest estimate, now closed; among equals the youngest entry.
    #[inline(always)]
    fn pop(&mut self) -> Option<(C, u32)> {
        while let Some(key) = self.heap.pop() {
            let (f, entry) = C::split(key);
            let id = self.pushed[entry as usize];
            let state = &mut self.graph.nodes[id as usize].state;
            if *state & CLOSED == 0 {
                *state |= CLOSED;
                return Some((f, id));
            }
        }
        None
    }
}

/// The goal, and the best way to it so far.
struct Goal<C> {
    cell: Cell,
    /// Free cells from the goal to the wall in the four straight directions.
    sees: [u32; 4],
    best: C,
    parent: u32,
    /// A cost reached [`Cost::LIMIT`] and was dropped.
    overflow: bool,
}

impl<C: Cost> Goal<C> {
    /// Takes the goal if it can be reached from a node at `cell` by the searched directions: first diagonal, then straight.
    #[inline(always)]
    fn seen(&mut self, cell: Cell, g: C, list: &List, node: u32) {
        let (dx, dy) = (i64::from(self.cell[0]) - i64::from(cell[0]), i64::from(self.cell[1]) - i64::from(cell[1]));
        let (wide, high) = (dx.unsigned_abs() as u32, dy.unsigned_abs() as u32);
        let short = wide.min(high);
        // The straight part arrives at the goal from the side that the goal looks back to.
        let look = if wide > high {
            if dx > 0 { 2 } else { 0 }
        } else if dy > 0 {
            3
        } else {
            1
        };
        if wide.abs_diff(high) > self.sees[look] {
            return;
        }
        let arrives = if short == 0 {
            (wide | high) == 0 || list.ways >> ((look * 2 + 4) % 8) & 1 != 0
        } else {
            let k = [[5, 3], [7, 1]][usize::from(dx > 0)][usize::from(dy > 0)];
            list.walk(k).is_some_and(|steps| short <= steps)
        };
        if arrives {
            let total = g + octile(wide, high);
            if total < self.best {
                (self.best, self.parent) = (total, node);
            }
        }
    }
}

/// Searches by jump points. Leaves the turning points in `out`.
pub(super) fn search<C: Cost>(ask: &mut Ask, out: &mut Vec<Cell>) -> End {
    match ask.corners {
        Corners::Touch => run::<C, TOUCH>(ask, out),
        Corners::Clear => run::<C, CLEAR>(ask, out),
        Corners::Squeeze => run::<C, SQUEEZE>(ask, out),
    }
}

fn run<C: Cost, const RULE: u8>(ask: &mut Ask, out: &mut Vec<Cell>) -> End {
    let mut scratch = ask.lattice.pool().take::<Scratch<C, RULE>>();
    let map = Map::of(ask.lattice);
    let mut goal = Goal { cell: ask.goal, sees: map.reach(ask.goal), best: C::LIMIT, parent: 0, overflow: false };
    let expansions = explore(&mut scratch, map, ask, &mut goal);
    let end = match expansions {
        None => End::Stopped,
        Some(n) if goal.best < C::LIMIT => {
            retrace(&scratch.graph, &goal, out);
            End::Found(Steps::of(out, n))
        }
        Some(_) if goal.overflow => End::Overflow,
        Some(_) => End::Exhausted,
    };
    ask.lattice.pool().give(scratch);
    end
}

/// Expands nodes until no better way to the goal is left; returns how many, or `None` if stopped.
fn explore<C: Cost, const RULE: u8>(scratch: &mut Scratch<C, RULE>, map: Map, ask: &mut Ask, goal: &mut Goal<C>) -> Option<u64> {
    scratch.begin(ask.lattice.width(), ask.lattice.height());
    let start = scratch.graph.node(ask.start);
    let node = &mut scratch.graph.nodes[start as usize];
    (node.g, node.parent, node.state) = (C::default(), start, scratch.search | CLOSED);
    let first = scratch.graph.edges.len();
    let list = scratch.graph.spokes(map, ask.start, 0xff);
    follow(scratch, &list, start, goal);
    scratch.graph.edges.truncate(first);
    let mut expansions = 1;
    while let Some((f, id)) = scratch.pop() {
        if f >= goal.best {
            break;
        }
        expansions += 1;
        if ask.pause(expansions) {
            return None;
        }
        let mut entered = scratch.graph.nodes[id as usize].state & 0xff;
        while entered != 0 {
            let list = scratch.graph.list(map, id, entered.trailing_zeros() as usize);
            entered &= entered - 1;
            follow(scratch, &list, id, goal);
        }
    }
    Some(expansions)
}

/// Offers everything a node leads to.
#[inline(always)]
fn follow<C: Cost, const RULE: u8>(scratch: &mut Scratch<C, RULE>, list: &List, id: u32, goal: &mut Goal<C>) {
    let Scratch { graph: Graph { nodes, edges, .. }, heap, pushed, search } = scratch;
    let (cell, base) = (nodes[id as usize].cell, nodes[id as usize].g);
    goal.seen(cell, base, list, id);
    for edge in &edges[list.range()] {
        let (g, entered) = (base + edge.cost, 1 << (edge.target & 7));
        let node = &mut nodes[(edge.target >> 3) as usize];
        if node.state >= *search && node.g <= g {
            if node.g == g && node.state & CLOSED == 0 {
                node.state |= entered;
            }
            continue;
        }
        let f = g + octile(node.cell[0].abs_diff(goal.cell[0]), node.cell[1].abs_diff(goal.cell[1]));
        goal.overflow |= f >= C::LIMIT;
        if f < goal.best {
            (node.g, node.parent, node.state) = (g, id, *search | entered);
            heap.push(C::key(f, pushed.len() as u32));
            pushed.push(edge.target >> 3);
        }
    }
}

/// Turning points of the best way to the goal: between two jump points first diagonal, then straight.
fn retrace<C: Cost, const RULE: u8>(graph: &Graph<C, RULE>, goal: &Goal<C>, out: &mut Vec<Cell>) {
    // From the goal back, so each leg is walked from its far end: straight first, then diagonal.
    let (mut to, mut id) = (goal.cell, goal.parent);
    out.push(to);
    loop {
        let node = &graph.nodes[id as usize];
        let from = node.cell;
        let way = |k: usize| (i64::from(to[k]) - i64::from(from[k])).signum() as i32;
        let short = from[0].abs_diff(to[0]).min(from[1].abs_diff(to[1])) as i32;
        push(out, [from[0].wrapping_add_signed(way(0) * short), from[1].wrapping_add_signed(way(1) * short)]);
        push(out, from);
        if node.parent == id {
            break;
        }
        (to, id) = (from, node.parent);
    }
    out.reverse();
}

/// Adds a point unless it repeats the last one; the last one goes if it lies on the straight line through both neighbours.
fn push(out: &mut Vec<Cell>, to: Cell) {
    if out.last() == Some(&to) {
        return;
    }
    if let [.., a, b] = out[..] {
        let way = |p: Cell, q: Cell| [0, 1].map(|k| (i64::from(q[k]) - i64::from(p[k])).signum());
        if way(a, b) == way(b, to) {
            out.pop();
        }
    }
    out.push(to);
}
