//! Scans of rows and columns, 57 cells or more at a time.

use super::super::step::{DIRECTIONS, allowed, neighbours};
use crate::world::{Cell, Corners, Lattice, Padded};

pub(super) const TOUCH: u8 = Corners::Touch as u8;
pub(super) const CLEAR: u8 = Corners::Clear as u8;
pub(super) const SQUEEZE: u8 = Corners::Squeeze as u8;
/// No corner rule: scans stop at walls alone.
const WALLS: u8 = 255;

/// Bits of a window at which a straight scan meets a jump point; the scan starts at bit 0 and moves to higher bits.
#[inline(always)]
fn forced_up<const RULE: u8>(side: u64, line: u64) -> u64 {
    match RULE {
        CLEAR => (side << 1) & !side,
        TOUCH => side & !(side >> 1) & !(line >> 1),
        SQUEEZE => side & !(side >> 1),
        _ => 0,
    }
}

/// The same for scans to lower bits.
#[inline(always)]
fn forced_down<const RULE: u8>(side: u64, line: u64) -> u64 {
    match RULE {
        CLEAR => (side >> 1) & !side,
        TOUCH => side & !(side << 1) & !(line << 1),
        SQUEEZE => side & !(side << 1),
        _ => 0,
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

/// The map as the scans see it.
#[derive(Clone, Copy)]
pub(super) struct Map<'a> {
    rows: &'a Padded,
    columns: &'a Padded,
}

impl<'a> Map<'a> {
    pub(super) fn of(lattice: &'a Lattice) -> Self {
        Self { rows: lattice.rows(), columns: lattice.columns() }
    }

    /// Scans from a cell in straight direction `K`.
    #[inline(always)]
    pub(super) fn straight<const RULE: u8, const K: usize>(&self, cell: Cell) -> (u32, bool) {
        let (bits, at) = if K % 4 == 2 { (self.columns, self.columns.at(cell[1], cell[0])) } else { (self.rows, self.rows.at(cell[0], cell[1])) };
        if K < 4 { scan::<RULE, true>(bits, at) } else { scan::<RULE, false>(bits, at) }
    }

    /// Free cells from a cell to the wall in each of the four straight directions.
    pub(super) fn reach(&self, cell: Cell) -> [u32; 4] {
        [self.straight::<WALLS, 0>(cell).0, self.straight::<WALLS, 2>(cell).0, self.straight::<WALLS, 4>(cell).0, self.straight::<WALLS, 6>(cell).0]
    }

    /// Blocked neighbours of a cell, a bit each.
    #[inline(always)]
    pub(super) fn around(&self, cell: Cell) -> u8 {
        neighbours(self.rows, self.rows.at(cell[0], cell[1]))
    }
}

/// May the robot step in direction `k` from a cell with these blocked neighbours?
#[inline(always)]
pub(super) fn open_to<const RULE: u8>(around: u8, k: usize) -> bool {
    allowed(rule::<RULE>(), around) >> k & 1 != 0
}

/// Directions to search from a cell with these blocked neighbours that was entered in direction `k`.
#[inline(always)]
pub(super) fn onward<const RULE: u8>(around: u8, k: usize) -> u8 {
    let turn = |by: usize| 1u8 << ((k + by) % 8);
    let forced = |hit: usize, ways: u8| if around & turn(hit) == 0 { 0 } else { ways };
    let wanted = plain(k)
        | if k % 2 == 1 {
            // The cell beside the one before is three eighths of a turn back, the forced diagonal one eighth less.
            if RULE == CLEAR { 0 } else { forced(3, turn(2)) | forced(5, turn(6)) }
        } else if RULE == CLEAR {
            forced(3, turn(1) | turn(2)) | forced(5, turn(7) | turn(6))
        } else {
            forced(2, turn(1)) | forced(6, turn(7))
        };
    wanted & allowed(rule::<RULE>(), around)
}

/// Natural directions of a cell entered in direction `k`.
pub(super) const fn plain(k: usize) -> u8 {
    if k.is_multiple_of(2) { 1 << k } else { 1 << k | 1 << (k - 1) | 1 << ((k + 1) % 8) }
}

const fn rule<const RULE: u8>() -> Corners {
    match RULE {
        TOUCH => Corners::Touch,
        CLEAR => Corners::Clear,
        _ => Corners::Squeeze,
    }
}

/// The cell `steps` ahead in direction `k`.
#[inline(always)]
pub(super) fn ahead(cell: Cell, k: usize, steps: u32) -> Cell {
    let [dx, dy] = DIRECTIONS[k];
    [cell[0].wrapping_add_signed(dx * steps as i32), cell[1].wrapping_add_signed(dy * steps as i32)]
}
