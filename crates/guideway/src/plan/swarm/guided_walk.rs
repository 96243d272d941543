//! The guided walk: how a row of keys becomes a lattice path.
//!
//! Source: our reconstruction for \[han2024\], which leaves its encoding open. Key `x_k` in -1 to 1 turns the direction to the goal by `x_k` quarter turns;
//! the walk takes the free, unvisited neighbour nearest to that direction, and steps back where there is none. Loops are cut: from each cell the path
//! goes on at the latest of its cells that is one step away. Departures: none, but for switches (see [`super::Decoding`]).
//!
//! Directions are compared without angles: the direction asked for lies in one of 16 sectors of 22.5 degrees, and inside a sector the order of the eight
//! steps by angle is always the same, so a table gives the best of the open ones.

use crate::world::{Cell, Corners, Lattice};
use std::f64::consts::FRAC_PI_2;
use std::sync::atomic::{AtomicU8, Ordering};

/// The eight steps, counter-clockwise from +x.
const STEPS: [[i32; 2]; 8] = [[1, 0], [1, 1], [0, 1], [-1, 1], [-1, 0], [-1, -1], [0, -1], [1, -1]];
/// Tangent of 22.5 degrees.
const TAN: f64 = std::f64::consts::SQRT_2 - 1.0;

/// The best of a set of steps (bit `k`: step `k`) for a direction in each sector.
static BEST: [[u8; 256]; 16] = table();

const fn table() -> [[u8; 256]; 16] {
    let mut out = [[0; 256]; 16];
    let mut sector = 0;
    while sector < 16 {
        let mut set = 1;
        while set < 256 {
            let (mut best, mut least, mut k) = (0, i32::MAX, 0);
            while k < 8 {
                // Twice the angle between the middle of the sector and step k, in sectors, round the circle.
                let apart = (2 * sector as i32 + 1 - 4 * k).rem_euclid(32);
                let apart = if apart > 16 { 32 - apart } else { apart };
                if set >> k & 1 != 0 && apart < least {
                    (best, least) = (k, apart);
                }
                k += 1;
            }
            out[sector][set] = best as u8;
            set += 1;
        }
        sector += 1;
    }
    out
}

/// Where walks go: the open steps of every cell, looked up at the first visit.
pub(in crate::plan) struct Ground<'a> {
    pub lattice: &'a Lattice,
    corners: Corners,
    /// Open steps of a cell; 0: not looked at.
    open: Vec<AtomicU8>,
}

impl<'a> Ground<'a> {
    pub fn new(lattice: &'a Lattice, corners: Corners) -> Self {
        let mut open = Vec::new();
        open.resize_with(lattice.width() as usize * lattice.height() as usize, AtomicU8::default);
        Self { lattice, corners, open }
    }
    #[inline]
    fn place(&self, [x, y]: Cell) -> usize {
        y as usize * self.lattice.width() as usize + x as usize
    }
    #[inline]
    fn open(&self, cell: Cell) -> u8 {
        let known = self.open[self.place(cell)].load(Ordering::Relaxed);
        if known != 0 { known } else { self.look(cell) }
    }
    #[cold]
    fn look(&self, cell: Cell) -> u8 {
        let free = |k: usize| self.lattice.step_free(cell, i64::from(STEPS[k][0]), i64::from(STEPS[k][1]), self.corners);
        let open = (0..8).fold(0, |set, k| set | u8::from(free(k)) << k);
        self.open[self.place(cell)].store(open, Ordering::Relaxed);
        open
    }
    /// May the robot step from a cell to this neighbour?
    pub fn allows(&self, from: Cell, to: Cell) -> bool {
        let step = [0, 1].map(|i| to[i].wrapping_sub(from[i]) as i32);
        STEPS.iter().position(|s| *s == step).is_some_and(|k| self.open(from) >> k & 1 != 0)
    }
}

/// How walks go.
#[derive(Debug, Clone, Copy)]
pub(in crate::plan) struct Gait {
    /// Steps, forth and back, after which a walk gives up.
    pub limit: u64,
    /// Steps that one key steers.
    pub stride: u32,
    /// Cut loops.
    pub cut: bool,
}

/// Working memory of walks on one lattice; used again and again.
#[derive(Default)]
pub(in crate::plan) struct Scratch {
    /// The path.
    pub cells: Vec<Cell>,
    /// Number of the walk that visited the cell (high half), its place on the path plus one (low half).
    marks: Vec<u64>,
    walk: u64,
    turns: Vec<[f64; 2]>,
}

impl Scratch {
    fn begin(&mut self, cells: usize) {
        self.walk += 1;
        if self.marks.len() != cells || self.walk > u64::from(u32::MAX) {
            self.marks.clear();
            self.marks.resize(cells, 0);
            self.walk = 1;
        }
        self.cells.clear();
        self.turns.clear();
    }
    /// Cosine and sine of the turn by a key.
    #[inline]
    fn turn(&mut self, keys: &[f64], k: usize) -> [f64; 2] {
        while self.turns.len() <= k {
            self.turns.push(quarters(keys[self.turns.len()]));
        }
        self.turns[k]
    }
}

/// Cosine and sine of that many quarter turns, -1 to 1: series that are right to 1e-9, exact at the ends and in the middle.
fn quarters(key: f64) -> [f64; 2] {
    if key.abs() >= 1.0 {
        return [0.0, key.signum()];
    }
    let a = key * FRAC_PI_2;
    let b = a * a;
    let sine = a * (1.0 - b / 6.0 * (1.0 - b / 20.0 * (1.0 - b / 42.0 * (1.0 - b / 72.0 * (1.0 - b / 110.0 * (1.0 - b / 156.0))))));
    let cosine = 1.0 - b / 2.0 * (1.0 - b / 12.0 * (1.0 - b / 30.0 * (1.0 - b / 56.0 * (1.0 - b / 90.0 * (1.0 - b / 132.0 * (1.0 - b / 182.0))))));
    [cosine, sine]
}

/// The sector of a direction, 16 counter-clockwise from +x; on a border the lower one.
#[inline]
fn sector(x: f64, y: f64) -> usize {
    let (base, a, b) = if x >= 0.0 && y > 0.0 {
        (0, x, y)
    } else if x < 0.0 && y >= 0.0 {
        (4, y, -x)
    } else if y < 0.0 && x <= 0.0 {
        (8, -x, -y)
    } else {
        (12, -y, x)
    };
    base + usize::from(b > TAN * a) + usize::from(b > a) + usize::from(b * TAN > a)
}

impl Ground<'_> {
    /// Walks from a free cell to another under some keys (at least one) and leaves the path in the scratch. False if it did not arrive.
    pub fn walk(&self, [from, to]: [Cell; 2], keys: &[f64], gait: Gait, scratch: &mut Scratch) -> bool {
        scratch.begin(self.open.len());
        let stamp = scratch.walk << 32;
        let (mut cell, mut steps, mut key, mut steered) = (from, 0, 0, 0);
        scratch.cells.push(from);
        scratch.marks[self.place(from)] = stamp | 1;
        while cell != to {
            if steps == gait.limit {
                return false;
            }
            steps += 1;
            let at = aim(cell, to, keys[key], scratch.turn(keys, key));
            steered += 1;
            if steered == gait.stride {
                (steered, key) = (0, (key + 1) % keys.len());
            }
            if let Some(next) = self.next(cell, at, scratch) {
                scratch.cells.push(next);
                scratch.marks[self.place(next)] = stamp | scratch.cells.len() as u64;
                cell = next;
            } else {
                scratch.marks[self.place(cell)] = stamp;
                scratch.cells.pop();
                let Some(&back) = scratch.cells.last() else { return false };
                cell = back;
            }
        }
        if gait.cut {
            self.cut(scratch);
        }
        true
    }

    /// The best open step to a cell that this walk has not visited.
    #[inline]
    fn next(&self, cell: Cell, sector: usize, scratch: &Scratch) -> Option<Cell> {
        let mut open = self.open(cell);
        while open != 0 {
            let k = BEST[sector][open as usize];
            let next = stepped(cell, k);
            if scratch.marks[self.place(next)] >> 32 != scratch.walk {
                return Some(next);
            }
            open &= !(1 << k);
        }
        None
    }

    /// Cuts loops of the path in the scratch.
    fn cut(&self, scratch: &mut Scratch) {
        let (mut kept, mut at) = (0, 0);
        while at + 1 < scratch.cells.len() {
            let (mut open, mut latest) = (self.open(scratch.cells[at]), at + 1);
            while open != 0 {
                let mark = scratch.marks[self.place(stepped(scratch.cells[at], open.trailing_zeros() as u8))];
                if mark >> 32 == scratch.walk {
                    latest = latest.max((mark as u32 as usize).saturating_sub(1));
                }
                open &= open - 1;
            }
            kept += 1;
            scratch.cells[kept] = scratch.cells[latest];
            at = latest;
        }
        scratch.cells.truncate(kept + 1);
    }

    /// Cuts loops of any path of neighbouring cells; a cell that comes again counts as met by itself.
    pub fn cut_path(&self, path: &[Cell], scratch: &mut Scratch) {
        scratch.begin(self.open.len());
        scratch.cells.extend_from_slice(path);
        for (i, &cell) in path.iter().enumerate() {
            scratch.marks[self.place(cell)] = scratch.walk << 32 | (i as u64 + 1);
        }
        self.cut(scratch);
    }
}

/// The sector that a key asks for. A key to the right is looked at in the mirror, so that of two steps as near the one nearer to the goal wins.
#[inline]
fn aim(cell: Cell, to: Cell, key: f64, [cos, sin]: [f64; 2]) -> usize {
    let [gx, gy] = [0, 1].map(|i| f64::from(to[i]) - f64::from(cell[i]));
    let (x, y) = (cos * gx - sin * gy, sin * gx + cos * gy);
    if key < 0.0 { 15 - sector(x, -y) } else { sector(x, y) }
}

#[inline]
fn stepped(cell: Cell, k: u8) -> Cell {
    let [dx, dy] = STEPS[k as usize];
    [cell[0].wrapping_add_signed(dx), cell[1].wrapping_add_signed(dy)]
}

#[cfg(test)]
mod tests;
