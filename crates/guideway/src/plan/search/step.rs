//! Best-first search step by step: A* and Dijkstra on the lattice.

use super::open::{Cost, Open, octile};
use super::{Ask, End, Steps};
use crate::world::{Cell, Corners, Lattice};

/// The eight directions, counter-clockwise from +x; odd ones are diagonal. A direction set has bit `k` for `DIRECTIONS[k]`.
pub(super) const DIRECTIONS: [[i32; 2]; 8] = [[1, 0], [1, 1], [0, 1], [-1, 1], [-1, 0], [-1, -1], [0, -1], [1, -1]];

/// Allowed directions for each set of blocked neighbours (same bits) and corner rule.
static ALLOWED: [[u8; 256]; 3] = [table(Corners::Touch), table(Corners::Clear), table(Corners::Squeeze)];

const fn table(corners: Corners) -> [u8; 256] {
    let mut out = [0; 256];
    let mut blocked = 0;
    while blocked < 256 {
        let mut k = 0;
        while k < 8 {
            let target = blocked >> k & 1 == 0;
            let (left, right) = (blocked >> ((k + 1) % 8) & 1 == 0, blocked >> ((k + 7) % 8) & 1 == 0);
            let sides = match corners {
                Corners::Touch => left || right,
                Corners::Clear => left && right,
                Corners::Squeeze => true,
            };
            if target && (k % 2 == 0 || sides) {
                out[blocked] |= 1 << k;
            }
            k += 1;
        }
        blocked += 1;
    }
    out
}

/// Blocked neighbours of the cell at bit `at`, one bit for each direction.
#[inline]
pub(super) fn neighbours(rows: &crate::world::Padded, at: usize) -> u8 {
    let pitch = rows.pitch();
    let look = |b: usize| rows.ahead(b) as u8 & 7;
    let (below, here, above) = (look(at - pitch - 1), look(at - 1), look(at + pitch - 1));
    here >> 2
        | (above >> 2) << 1
        | (above >> 1 & 1) << 2
        | (above & 1) << 3
        | (here & 1) << 4
        | (below & 1) << 5
        | (below >> 1 & 1) << 6
        | (below >> 2) << 7
}

/// Directions in which the robot may step from the cell with these blocked neighbours.
#[inline]
pub(super) fn allowed(corners: Corners, blocked: u8) -> u8 {
    ALLOWED[corners as usize][blocked as usize]
}

/// Directions that the corner bits of an inflated lattice forbid at `cell`.
fn tight(lattice: &Lattice, cell: Cell) -> u8 {
    let Some(corner) = lattice.corner_free() else { return 0 };
    let [x, y] = cell;
    let forbid = |k: u8, dx: u32, dy: u32| if corner.at(x + dx, y + dy) { 0 } else { 1 << k };
    forbid(1, 1, 1) | forbid(3, 0, 1) | forbid(5, 0, 0) | forbid(7, 1, 0)
}

/// Directions in which the robot may step from a free cell. Steps can be undone: the way back is allowed too.
#[inline]
pub(super) fn ways(lattice: &Lattice, corners: Corners, cell: Cell) -> u8 {
    let rows = lattice.rows();
    allowed(corners, neighbours(rows, rows.at(cell[0], cell[1]))) & !tight(lattice, cell)
}

/// Searches with the octile heuristic (`INFORMED`: A*) or none (Dijkstra). Leaves the path's cells in `out`.
pub(super) fn search<C: Cost, const INFORMED: bool>(ask: &mut Ask, out: &mut Vec<Cell>) -> End {
    let lattice = ask.lattice;
    let mut open = lattice.pool().take::<Open<C>>();
    let end = run::<C, INFORMED>(ask, &mut open, out);
    lattice.pool().give(open);
    end
}

fn run<C: Cost, const INFORMED: bool>(ask: &mut Ask, open: &mut Open<C>, out: &mut Vec<Cell>) -> End {
    let (lattice, width) = (ask.lattice, ask.lattice.width());
    let place = |c: Cell| c[1] * width + c[0];
    let [gx, gy] = ask.goal;
    let goal = place(ask.goal);
    open.begin(width as usize * lattice.height() as usize, place(ask.start));
    let mut expansions = 0;
    while let Some((_, id)) = open.pop() {
        let node = open.nodes[id as usize];
        if node.place == goal {
            out.extend(open.trail(id).into_iter().map(|p| [p % width, p / width]));
            return End::Found(Steps::of(out, expansions));
        }
        expansions += 1;
        if ask.pause(expansions) {
            return End::Stopped;
        }
        let cell = [node.place % width, node.place / width];
        let mut ways = ways(lattice, ask.corners, cell);
        while ways != 0 {
            let k = ways.trailing_zeros() as usize;
            ways &= ways - 1;
            let [x, y] = [cell[0].wrapping_add_signed(DIRECTIONS[k][0]), cell[1].wrapping_add_signed(DIRECTIONS[k][1])];
            let g = node.g + if k.is_multiple_of(2) { C::STRAIGHT } else { C::DIAGONAL };
            let h = if INFORMED { octile(x.abs_diff(gx), y.abs_diff(gy)) } else { C::default() };
            open.relax(y * width + x, g, g + h, id, 1 << k);
        }
    }
    if open.overflow { End::Overflow } else { End::Exhausted }
}
