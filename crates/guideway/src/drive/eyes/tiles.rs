//! Rays through cells most of which need no look: tiles of cells tell where one does.

use crate::Point;
use crate::drive::rays::span;

/// Cells along the side of a tile.
const SIDE: u32 = 8;

/// Which cells of each tile wait to be looked at.
pub(super) struct Tiles {
    /// Cells, and tiles, in each direction.
    size: [u32; 2],
    count: [u32; 2],
    /// A bit for each cell, row by row.
    waiting: Vec<u64>,
}

impl Tiles {
    /// Over so many columns and rows of cells, of which all wait or none.
    pub fn new(size: [u32; 2], wait: bool) -> Self {
        let count = size.map(|n| n.div_ceil(SIDE));
        let long = |k: usize, i: u32| SIDE.min(size[k] - SIDE * i);
        let row = |x: u32| (1 << long(0, x)) - 1;
        let cells = |y: u32, x: u32| if wait { (0..long(1, y)).fold(0, |all, k| all | row(x) << (SIDE * k)) } else { 0 };
        let waiting = (0..count[1]).flat_map(|y| (0..count[0]).map(move |x| cells(y, x))).collect();
        Self { size, count, waiting }
    }

    /// A cell waits that did not.
    pub fn wait(&mut self, [x, y]: [u32; 2]) {
        self.waiting[((y / SIDE) * self.count[0] + x / SIDE) as usize] |= bit([x, y]);
    }

    /// Visits those cells that wait, along a ray from `from` (cells) in the unit direction `dir` up to the length `reach` (cells), in order; `visit`
    /// says whether the cell that it is given need not wait any longer. A ray that starts outside enters where it meets the first cell.
    pub fn walk(&mut self, (from, dir): (Point, Point), reach: f64, mut visit: impl FnMut([u32; 2]) -> bool) {
        let Some([enter, leave]) = span(from, dir, reach, self.size) else { return };
        let ray = Ray { from, dir, inverse: dir.map(|d| 1.0 / d), leave };
        let last = self.count.map(|n| n - 1);
        let tile = ray.cell(enter, SIDE, [[0, last[0]], [0, last[1]]]);
        let (mut at, [width, height]) = (ray.start(tile, SIDE, enter), self.count);
        while at.x < width && at.y < height {
            let waiting = &mut self.waiting[(at.y * width + at.x) as usize];
            if *waiting != 0 {
                ray.visit(at.t, waiting, around(*waiting, [at.x, at.y]), &mut visit);
            }
            at.advance();
            if at.t > leave {
                return;
            }
        }
    }
}

/// The bit of a cell in its tile.
#[inline]
fn bit([x, y]: [u32; 2]) -> u64 {
    1 << (SIDE * (y % SIDE) + x % SIDE)
}

/// First and last column and row of the cells of a tile whose bits are set; at least one is.
#[inline]
fn around(set: u64, [x, y]: [u32; 2]) -> [[u32; 2]; 2] {
    let columns = [32, 16, 8].into_iter().fold(set, |all, half| all | all >> half) & 0xff;
    let rows = [set.trailing_zeros() / SIDE, SIDE - 1 - set.leading_zeros() / SIDE];
    [[columns.trailing_zeros(), columns.ilog2()].map(|k| SIDE * x + k), rows.map(|k| SIDE * y + k)]
}

/// A square of cells that a ray is in, and the lengths at which it came there and leaves the column and the row.
struct At {
    x: u32,
    y: u32,
    t: f64,
    across: f64,
    up: f64,
    delta: Point,
    /// To the next column and row; one before the first is beyond the last.
    step: [u32; 2],
}

impl At {
    #[expect(clippy::inline_always, reason = "the innermost loop of every scan: all of it stays in registers")]
    #[inline(always)]
    fn advance(&mut self) {
        // Without a branch, which nobody could foretell.
        let rises = self.up < self.across;
        self.t = if rises { self.up } else { self.across };
        self.up += if rises { self.delta[1] } else { 0.0 };
        self.across += if rises { 0.0 } else { self.delta[0] };
        self.y = self.y.wrapping_add(if rises { self.step[1] } else { 0 });
        self.x = self.x.wrapping_add(if rises { 0 } else { self.step[0] });
    }
}

/// A ray in the frame of the cells.
struct Ray {
    from: Point,
    dir: Point,
    inverse: Point,
    leave: f64,
}

impl Ray {
    /// The square of a side of `side` cells that it is in at length `t`, among those of a range.
    #[inline]
    fn cell(&self, t: f64, side: u32, within: [[u32; 2]; 2]) -> [u32; 2] {
        [0, 1].map(|k| (((self.from[k] + t * self.dir[k]) / f64::from(side)) as u32).clamp(within[k][0], within[k][1]))
    }

    /// In a square of a side of `side` cells from the length `t` on.
    #[inline]
    fn start(&self, [x, y]: [u32; 2], side: u32, t: f64) -> At {
        let end = |k: usize, square: u32| {
            let edge = f64::from(side * (square + u32::from(self.dir[k] > 0.0)));
            if self.dir[k] == 0.0 { f64::INFINITY } else { (edge - self.from[k]) * self.inverse[k] }
        };
        let delta = self.inverse.map(|d| f64::from(side) * d.abs());
        let step = self.dir.map(|d| if d > 0.0 { 1 } else { u32::MAX });
        At { x, y, t, across: end(0, x), up: end(1, y), delta, step }
    }

    /// The length at which it comes into a range of cells, from the length `t` on, if it does.
    #[inline]
    fn enters(&self, t: f64, within: [[u32; 2]; 2]) -> Option<f64> {
        let (mut enter, mut leave) = (t, self.leave);
        for (k, [first, last]) in within.into_iter().enumerate() {
            if self.dir[k] == 0.0 {
                if !(first..=last).contains(&(self.from[k] as u32)) {
                    return None;
                }
                continue;
            }
            let [a, b] = [first, last + 1].map(|edge| (f64::from(edge) - self.from[k]) * self.inverse[k]);
            (enter, leave) = (enter.max(a.min(b)), leave.min(a.max(b)));
        }
        (enter <= leave).then_some(enter)
    }

    /// Visits the cells of a range that wait from the length `t` on; those of which `visit` says so wait no longer.
    #[inline]
    fn visit(&self, t: f64, waiting: &mut u64, within: [[u32; 2]; 2], visit: &mut impl FnMut([u32; 2]) -> bool) {
        let Some(t) = self.enters(t, within) else { return };
        let mut at = self.start(self.cell(t, 1, within), 1, t);
        let [[low, right], [bottom, top]] = within;
        while at.x >= low && at.x <= right && at.y >= bottom && at.y <= top && at.t <= self.leave {
            let own = bit([at.x, at.y]);
            if *waiting & own != 0 && visit([at.x, at.y]) {
                *waiting &= !own;
            }
            at.advance();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::drive::rays::walk;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn every_cell_that_waits_is_visited_once_by_a_ray_that_passes_it(
            [w, h] in [1_u32..70, 1_u32..70], [x, y] in [-20.0..90.0_f64, -20.0..90.0_f64], angle in 0.0..6.2_f64, reach in 0.0..120.0_f64, axis in 0..8_u32
        ) {
            let (s, c) = if axis < 4 { (f64::from(axis) * std::f64::consts::FRAC_PI_2).sin_cos() } else { angle.sin_cos() };
            let mut cells = Vec::new();
            walk([x, y], [c, s], reach, [w, h], |cell, _| { cells.push(cell); true });
            let mut visited = Vec::new();
            let mut tiles = Tiles::new([w, h], true);
            tiles.walk(([x, y], [c, s]), reach, |cell| { visited.push(cell); false });
            prop_assert_eq!(&visited, &cells);
            // Once nothing waits, nothing is visited; then only the tile of a cell that waits again.
            let mut tiles = Tiles::new([w, h], false);
            tiles.walk(([x, y], [c, s]), reach, |_| panic!("nothing waits"));
            if let Some(&cell) = cells.get(cells.len() / 2) {
                tiles.wait(cell);
                let mut found = Vec::new();
                tiles.walk(([x, y], [c, s]), reach, |at| { found.push(at); at == cell });
                prop_assert_eq!(found, vec![cell]);
                tiles.walk(([x, y], [c, s]), reach, |_| panic!("nothing waits any more"));
            }
        }
    }
}
