//! Jump point search, bit-parallel.
//!
//! Source: \[harabor2011\] (jump points, forced neighbours), \[harabor2014\] (block-wise scans and pruning of intermediate jump points, "JPS (B+P)").
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

mod agenda;
mod graph;
mod scan;

use super::open::{Cost, octile};
use super::{Ask, End, Steps};
use crate::world::{Cell, Corners};
pub(super) use agenda::{Agenda, Buckets, Heap};
use graph::{Graph, List, Spot};
use scan::{CLEAR, Map, SQUEEZE, TOUCH};

/// Bit of [`graph::Node::state`]: expanded already. Directions of entry are below, the number of the search above.
const CLOSED: u32 = 1 << 8;
/// Number of the first search, and the step to the next.
const SEARCH: u32 = 1 << 9;

/// What one thread keeps between searches on a lattice.
struct Scratch<C: Cost, const RULE: u8, const WAYS: usize> {
    graph: Graph<C, RULE, WAYS>,
    agenda: C::Agenda,
    /// Number of the current search, in units of [`SEARCH`].
    search: u32,
}

impl<C: Cost, const RULE: u8, const WAYS: usize> Default for Scratch<C, RULE, WAYS> {
    fn default() -> Self {
        Self { graph: Graph::default(), agenda: C::Agenda::default(), search: 0 }
    }
}

impl<C: Cost, const RULE: u8, const WAYS: usize> Scratch<C, RULE, WAYS> {
    /// Forgets the last search, whatever its size, by counting up.
    fn begin(&mut self, ask: &Ask) {
        self.graph.prepare(ask.lattice.width(), ask.lattice.height());
        self.agenda.begin(octile(ask.start[0].abs_diff(ask.goal[0]), ask.start[1].abs_diff(ask.goal[1])));
        self.search = self.search.wrapping_add(SEARCH);
        if self.search == 0 {
            self.graph.nodes.iter_mut().for_each(|n| n.state = 0);
            self.search = SEARCH;
        }
    }
}

/// Octile distance of two spots.
#[inline(always)]
fn between<C: Cost>(a: Spot, b: Spot) -> C {
    octile(a[0].abs_diff(b[0]).into(), a[1].abs_diff(b[1]).into())
}

/// The goal, and the best way to it so far.
struct Goal<C> {
    spot: Spot,
    /// Free cells from the goal to the wall in the four straight directions.
    sees: [u32; 4],
    best: C,
    parent: u32,
    /// A cost reached [`Cost::LIMIT`] and was dropped.
    overflow: bool,
}

impl<C: Cost> Goal<C> {
    /// Takes the goal if it can be reached from a node at `from` by the searched directions: first diagonal, then straight.
    #[inline(always)]
    fn seen(&mut self, from: Spot, g: C, list: &List, node: u32) {
        let (dx, dy) = (i32::from(self.spot[0]) - i32::from(from[0]), i32::from(self.spot[1]) - i32::from(from[1]));
        let (wide, high) = (dx.unsigned_abs(), dy.unsigned_abs());
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
        Corners::Touch => run::<C, TOUCH, 8>(ask, out),
        Corners::Clear => run::<C, CLEAR, 4>(ask, out),
        Corners::Squeeze => run::<C, SQUEEZE, 8>(ask, out),
    }
}

fn run<C: Cost, const RULE: u8, const WAYS: usize>(ask: &mut Ask, out: &mut Vec<Cell>) -> End {
    let mut scratch = ask.lattice.pool().take::<Scratch<C, RULE, WAYS>>();
    let map = Map::of(ask.lattice);
    let spot = ask.goal.map(|v| v as u16);
    let mut goal = Goal { spot, sees: map.reach(ask.goal), best: C::LIMIT, parent: 0, overflow: false };
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
fn explore<C: Cost, const RULE: u8, const WAYS: usize>(
    scratch: &mut Scratch<C, RULE, WAYS>,
    map: Map,
    ask: &mut Ask,
    goal: &mut Goal<C>,
) -> Option<u64> {
    scratch.begin(ask);
    let start = scratch.graph.node(ask.start);
    let node = &mut scratch.graph.nodes[start as usize];
    (node.g, node.parent, node.state) = (C::default(), start, scratch.search | CLOSED);
    let list = scratch.graph.spokes(map, ask.start, 0xff);
    follow(scratch, list, start, goal);
    scratch.graph.words.truncate(list as usize);
    let mut expansions = 1;
    while let Some((bound, id)) = scratch.agenda.pop() {
        if bound >= goal.best {
            break;
        }
        let node = &mut scratch.graph.nodes[id as usize];
        if node.state & CLOSED != 0 || node.g + between(node.spot, goal.spot) >= goal.best {
            continue;
        }
        let mut entered = node.state & 0xff;
        node.state |= CLOSED;
        expansions += 1;
        if ask.pause(expansions) {
            return None;
        }
        while entered != 0 {
            let list = scratch.graph.list(map, id, entered.trailing_zeros() as usize);
            entered &= entered - 1;
            follow(scratch, list, id, goal);
        }
    }
    Some(expansions)
}

/// Offers everything a list of a node leads to.
#[inline(always)]
fn follow<C: Cost, const RULE: u8, const WAYS: usize>(scratch: &mut Scratch<C, RULE, WAYS>, list: u32, id: u32, goal: &mut Goal<C>) {
    let Scratch { graph: Graph { nodes, words, .. }, agenda, search } = scratch;
    let list = List::read(words, list);
    let (spot, base) = (nodes[id as usize].spot, nodes[id as usize].g);
    goal.seen(spot, base, &list, id);
    for target in list.targets {
        let entered = 1 << (target & 7);
        let node = &mut nodes[(target >> 3) as usize];
        let g = base + between(spot, node.spot);
        if node.state >= *search && node.g <= g {
            if node.g == g && node.state & CLOSED == 0 {
                node.state |= entered;
            }
            continue;
        }
        let f = g + between(node.spot, goal.spot);
        goal.overflow |= f >= C::LIMIT;
        if f < goal.best {
            (node.g, node.parent, node.state) = (g, id, *search | entered);
            agenda.push(f, target >> 3);
        }
    }
}

/// Turning points of the best way to the goal: between two jump points first diagonal, then straight.
fn retrace<C: Cost, const RULE: u8, const WAYS: usize>(graph: &Graph<C, RULE, WAYS>, goal: &Goal<C>, out: &mut Vec<Cell>) {
    // From the goal back, so each leg is walked from its far end: straight first, then diagonal.
    let (mut to, mut id) = (goal.spot.map(u32::from), goal.parent);
    out.push(to);
    loop {
        let node = &graph.nodes[id as usize];
        let from = node.spot.map(u32::from);
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

#[cfg(test)]
mod tests;
