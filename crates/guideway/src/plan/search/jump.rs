//! Jump point search, bit-parallel.
//!
//! Source: [`harabor2011`] (jump points, forced neighbours), [`harabor2014`] (block-wise scans and pruning of intermediate jump points, "JPS (B+P)").
//!
//! A path is canonical if it turns from diagonal to straight wherever it can without growing longer; every shortest path can be made so. From a cell entered
//! in direction `d`, only those neighbours matter that a canonical path can reach through it: `d` itself, the two straight parts of a diagonal `d`, and
//! *forced* neighbours, next to an obstacle that stopped the path from turning earlier. A cell with a forced neighbour is a jump point.
//! Rows (and, transposed, columns) are scanned 57 or more cells at a time for the next wall or jump point. A diagonal walk scans both straight directions at
//! each cell and hands the jump points found there straight to its own start, so cells where a path only turns are never nodes.
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

use super::open::{Cost, Node, Open, octile};
use super::step::{DIRECTIONS, allowed, neighbours};
use super::{Ask, End, Steps};
use crate::world::{Cell, Corners, Padded};

const TOUCH: u8 = Corners::Touch as u8;
const CLEAR: u8 = Corners::Clear as u8;
const SQUEEZE: u8 = Corners::Squeeze as u8;

/// Bits of a window at which a straight scan meets a jump point; the scan starts at bit 0 and moves to higher bits.
#[inline(always)]
fn forced_up<const RULE: u8>(side: u64, line: u64) -> u64 {
    match RULE {
        CLEAR => (side << 1) & !side,
        TOUCH => side & !(side >> 1) & !(line >> 1),
        _ => side & !(side >> 1),
    }
}

/// The same for scans to lower bits.
#[inline(always)]
fn forced_down<const RULE: u8>(side: u64, line: u64) -> u64 {
    match RULE {
        CLEAR => (side >> 1) & !side,
        TOUCH => side & !(side << 1) & !(line << 1),
        _ => side & !(side << 1),
    }
}

/// How far a straight scan from bit `at` goes: (cells, true) to the next jump point, or (free cells, false) before a wall.
#[inline(always)]
fn scan<const RULE: u8, const UP: bool>(bits: &Padded, at: usize) -> (u32, bool) {
    let pitch = bits.pitch();
    let mut done = 0;
    loop {
        let (here, stops, count) = if UP {
            let from = at + done as usize;
            let (here, left, right) = (bits.ahead(from), bits.ahead(from + pitch), bits.ahead(from - pitch));
            (here, (here | forced_up::<RULE>(left, here) | forced_up::<RULE>(right, here)) & !1, 64 - (from & 7) as u32)
        } else {
            let from = at - done as usize;
            let (here, left, right) = (bits.behind(from), bits.behind(from + pitch), bits.behind(from - pitch));
            let stops = (here | forced_down::<RULE>(left, here) | forced_down::<RULE>(right, here)) & !(1 << 63);
            (here, stops, 57 + (from & 7) as u32)
        };
        let step = if UP { stops.trailing_zeros() } else { stops.leading_zeros() };
        // The last valid bit cannot be judged by the rules that look one cell ahead.
        if step < count - 1 {
            let wall = if UP { here >> step & 1 } else { here << step >> 63 } != 0;
            return if wall { (done + step - 1, false) } else { (done + step, true) };
        }
        done += count - 2;
    }
}

/// One search in progress.
struct Search<'a, C: Cost, const RULE: u8> {
    rows: &'a Padded,
    columns: &'a Padded,
    width: u32,
    goal: Cell,
    /// Best cost of the goal so far.
    best: C,
    open: &'a mut Open<C>,
}

/// Where a scan starts and what it belongs to.
#[derive(Clone, Copy)]
struct From<C> {
    cell: Cell,
    g: C,
    parent: u32,
}

impl<C: Cost, const RULE: u8> Search<'_, C, RULE> {
    /// Can a path of this cost not improve on the best one? Notes if that is for want of bits.
    #[inline(always)]
    fn hopeless(&mut self, f: C) -> bool {
        self.open.overflow |= f >= C::LIMIT;
        f >= self.best
    }

    #[inline(always)]
    fn relax(&mut self, cell: Cell, g: C, parent: u32, entered: u8) {
        let f = g + octile(cell[0].abs_diff(self.goal[0]), cell[1].abs_diff(self.goal[1]));
        if self.hopeless(f) {
            return;
        }
        if cell == self.goal {
            self.best = g;
        }
        self.open.relax(cell[1] * self.width + cell[0], g, f, parent, entered);
    }

    /// Scans from a cell in straight direction `K`; offers the goal or the jump point found.
    #[inline(always)]
    fn straight<const K: usize>(&mut self, from: From<C>) {
        let [x, y] = from.cell;
        let along = K % 4 == 2;
        let (at, line, goal_at, goal_line) = if along { (y, x, self.goal[1], self.goal[0]) } else { (x, y, self.goal[0], self.goal[1]) };
        let bits = if along { self.columns } else { self.rows };
        let start = bits.at(at, line);
        let (mut steps, mut jump) = if K < 4 { scan::<RULE, true>(bits, start) } else { scan::<RULE, false>(bits, start) };
        if line == goal_line {
            let ahead = if K < 4 { goal_at.wrapping_sub(at) } else { at.wrapping_sub(goal_at) };
            if ahead.wrapping_sub(1) < steps {
                (steps, jump) = (ahead, true);
            }
        }
        if jump {
            self.relax(ahead::<K>(from.cell, steps), from.g + C::STRAIGHT.times(steps), from.parent, 1 << K);
        }
    }

    /// Walks from a cell in diagonal direction `K`, scanning both straight parts at each cell after the first.
    #[inline(always)]
    fn diagonal<const K: usize, const A: usize, const B: usize>(&mut self, mut from: From<C>) {
        loop {
            let around = neighbours(self.rows, self.rows.at(from.cell[0], from.cell[1]));
            if allowed(rule::<RULE>(), around) >> K & 1 == 0 {
                return;
            }
            from.cell = ahead::<K>(from.cell, 1);
            from.g = from.g + C::DIAGONAL;
            if self.hopeless(from.g) {
                return;
            }
            if from.cell == self.goal || (RULE != CLEAR && self.onward(from.cell, K) & !plain(K) != 0) {
                self.relax(from.cell, from.g, from.parent, 1 << K);
                return;
            }
            self.straight::<A>(from);
            self.straight::<B>(from);
        }
    }

    /// Directions to search from a cell that was entered in direction `k`.
    #[inline(always)]
    fn onward(&self, cell: Cell, k: usize) -> u8 {
        let blocked = neighbours(self.rows, self.rows.at(cell[0], cell[1]));
        let ways = allowed(rule::<RULE>(), blocked);
        let turn = |by: usize| 1u8 << ((k + by) % 8);
        let hit = |by: usize| blocked & turn(by) != 0;
        let mut wanted = plain(k);
        if k % 2 == 1 {
            // Beside the cell before: three eighths of a turn back. The forced way is the diagonal next to it.
            if RULE != CLEAR {
                wanted |= if hit(3) { turn(2) } else { 0 } | if hit(5) { turn(6) } else { 0 };
            }
        } else if RULE == CLEAR {
            wanted |= if hit(3) { turn(1) | turn(2) } else { 0 } | if hit(5) { turn(7) | turn(6) } else { 0 };
        } else {
            wanted |= if hit(2) { turn(1) } else { 0 } | if hit(6) { turn(7) } else { 0 };
        }
        wanted & ways
    }

    fn expand(&mut self, id: u32) {
        let Node { g, place, entered, .. } = self.open.nodes[id as usize];
        let cell = [place % self.width, place / self.width];
        let mut ways = 0;
        if entered == 0 {
            ways = 0xff;
        }
        for k in 0..8 {
            if entered >> k & 1 != 0 {
                ways |= self.onward(cell, k);
            }
        }
        let from = From { cell, g, parent: id };
        if ways & 1 != 0 {
            self.straight::<0>(from);
        }
        if ways & 4 != 0 {
            self.straight::<2>(from);
        }
        if ways & 16 != 0 {
            self.straight::<4>(from);
        }
        if ways & 64 != 0 {
            self.straight::<6>(from);
        }
        if ways & 2 != 0 {
            self.diagonal::<1, 0, 2>(from);
        }
        if ways & 8 != 0 {
            self.diagonal::<3, 2, 4>(from);
        }
        if ways & 32 != 0 {
            self.diagonal::<5, 4, 6>(from);
        }
        if ways & 128 != 0 {
            self.diagonal::<7, 6, 0>(from);
        }
    }
}

/// Natural directions of a cell entered in direction `k`.
const fn plain(k: usize) -> u8 {
    if k.is_multiple_of(2) { 1 << k } else { 1 << k | 1 << (k - 1) | 1 << ((k + 1) % 8) }
}

const fn rule<const RULE: u8>() -> Corners {
    match RULE {
        TOUCH => Corners::Touch,
        CLEAR => Corners::Clear,
        _ => Corners::Squeeze,
    }
}

/// The cell `steps` ahead in direction `K`.
#[inline(always)]
fn ahead<const K: usize>(cell: Cell, steps: u32) -> Cell {
    let [dx, dy] = DIRECTIONS[K];
    [cell[0].wrapping_add_signed(dx * steps as i32), cell[1].wrapping_add_signed(dy * steps as i32)]
}

/// Searches by jump points. Leaves the turning points in `out`.
pub(super) fn search<C: Cost>(ask: &mut Ask, out: &mut Vec<Cell>) -> End {
    let mut open = ask.lattice.pool().take::<Open<C>>();
    let end = match ask.corners {
        Corners::Touch => run::<C, TOUCH>(ask, &mut open, out),
        Corners::Clear => run::<C, CLEAR>(ask, &mut open, out),
        Corners::Squeeze => run::<C, SQUEEZE>(ask, &mut open, out),
    };
    ask.lattice.pool().give(open);
    end
}

fn run<C: Cost, const RULE: u8>(ask: &mut Ask, open: &mut Open<C>, out: &mut Vec<Cell>) -> End {
    let width = ask.lattice.width();
    let place = |c: Cell| c[1] * width + c[0];
    open.begin(width as usize * ask.lattice.height() as usize, place(ask.start));
    let goal = place(ask.goal);
    let mut search = Search::<C, RULE> { rows: ask.lattice.rows(), columns: ask.lattice.columns(), width, goal: ask.goal, best: C::LIMIT, open };
    let mut expansions = 0;
    while let Some((_, id)) = search.open.pop() {
        if search.open.nodes[id as usize].place == goal {
            retrace(&search.open.trail(id), width, out);
            return End::Found(Steps::of(out, expansions));
        }
        expansions += 1;
        if ask.pause(expansions) {
            return End::Stopped;
        }
        search.expand(id);
    }
    if search.open.overflow { End::Overflow } else { End::Exhausted }
}

/// Turning points of the way along jump points: between two of them first diagonal, then straight.
fn retrace(places: &[u32], width: u32, out: &mut Vec<Cell>) {
    for &place in places {
        let to = [place % width, place / width];
        if let Some(&from) = out.last() {
            let way = |k: usize| (i64::from(to[k]) - i64::from(from[k])).signum() as i32;
            let short = from[0].abs_diff(to[0]).min(from[1].abs_diff(to[1])) as i32;
            let bend = [from[0].wrapping_add_signed(way(0) * short), from[1].wrapping_add_signed(way(1) * short)];
            if bend != from && bend != to {
                push(out, bend);
            }
        }
        push(out, to);
    }
}

/// Adds a point; the last one goes if it lies on the straight line through both neighbours.
fn push(out: &mut Vec<Cell>, to: Cell) {
    if let [.., a, b] = out[..] {
        let way = |p: Cell, q: Cell| [0, 1].map(|k| (i64::from(q[k]) - i64::from(p[k])).signum());
        if way(a, b) == way(b, to) {
            out.pop();
        }
    }
    out.push(to);
}
