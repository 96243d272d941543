//! How near each step of the lattice comes to an obstacle, as ranks of exact distances.
//!
//! Among square cells the distance along a step is least at its ends or, on a diagonal, at the corner that it passes (proof in `world/lattice/build.rs`); among
//! shapes the distance of the whole step is looked up.

use super::Stopped;
use super::step::{DIRECTIONS, ways};
use super::tree::beside;
use crate::Point;
use crate::query::Query;
use crate::world::{Cell, Lattice};

/// Distances that differ by less are one, in cells: far below the least difference of two distances among squares.
const SAME: f64 = 1e-9;

/// Rank of every step's distance among all distances that occur.
pub(super) struct Clearances {
    width: u32,
    /// Ranks of the steps to the right, up right, up and up left of each cell; anything where there is no step.
    steps: Vec<[u32; 4]>,
    /// The distances, m, increasing.
    values: Vec<f64>,
}

impl Clearances {
    /// Those of all allowed steps, none above `most` (m): what is farther counts as that.
    pub fn of(query: &Query, lattice: &Lattice, most: f64, stop: &mut dyn FnMut() -> bool) -> Result<Self, Stopped> {
        let (world, width, height) = (&query.world, lattice.width(), lattice.height());
        let field = world.clearance_field();
        let (plain, same) = (world.shapes().is_empty(), SAME * world.resolution());
        let near = |cell: Cell, k: usize| {
            let to = beside(cell, k);
            if !plain {
                return world.segment_clearance(lattice.center(cell), lattice.center(to));
            }
            let ends = field.at(cell).min(field.at(to));
            if k.is_multiple_of(2) { ends } else { ends.min(world.clearance_within(corner(query, cell, k), ends)) }
        };
        let mut distances = vec![[f64::INFINITY; 4]; width as usize * height as usize];
        let mut all = Vec::new();
        for y in 0..height {
            if stop() {
                return Err(Stopped);
            }
            for x in (0..width).filter(|&x| lattice.free().at(x, y)) {
                let ways = ways(lattice, query.corners, [x, y]);
                for k in (0..4).filter(|k| ways >> k & 1 != 0) {
                    let distance = near([x, y], k).clamp(0.0, most);
                    distances[(y * width + x) as usize][k] = distance;
                    all.push(distance);
                }
            }
            thin(&mut all, same);
        }
        let rank = |d: f64| all.partition_point(|v| *v < d - same) as u32;
        let steps = distances.iter().map(|d| d.map(rank)).collect();
        Ok(Self { width, steps, values: all })
    }

    /// The distances, m, increasing.
    pub fn values(&self) -> &[f64] {
        &self.values
    }

    /// Directions of steps from `cell` that keep at least the distance of that rank, out of `ways`.
    #[inline]
    pub fn wide(&self, cell: Cell, ways: u8, rank: u32) -> u8 {
        (0..8).filter(|&k| ways >> k & 1 != 0 && self.rank(cell, k) >= rank).fold(0, |set, k| set | 1 << k)
    }

    /// Least distance along a path, m; `None` for a single cell.
    pub fn along(&self, cells: &[Cell]) -> Option<f64> {
        let rank = |pair: &[Cell]| {
            let step = [0, 1].map(|i| pair[1][i].wrapping_sub(pair[0][i]) as i32);
            DIRECTIONS.iter().position(|d| *d == step).map(|k| self.rank(pair[0], k))
        };
        let least = cells.windows(2).filter_map(rank).min()?;
        self.values.get(least as usize).copied()
    }

    #[inline]
    fn rank(&self, cell: Cell, k: usize) -> u32 {
        let (cell, k) = if k < 4 { (cell, k) } else { (beside(cell, k), k ^ 4) };
        self.steps[(cell[1] * self.width + cell[0]) as usize][k]
    }
}

/// Sorts and keeps one of those that differ by no more than `same`.
fn thin(all: &mut Vec<f64>, same: f64) {
    all.sort_unstable_by(f64::total_cmp);
    all.dedup_by(|b, a| b == a || *b - *a <= same);
}

/// The corner that a diagonal step passes, m.
fn corner(query: &Query, cell: Cell, k: usize) -> Point {
    let [dx, dy] = DIRECTIONS[k].map(|d| f64::from(d.max(0)));
    query.world.cell_to_map([f64::from(cell[0]) + dx, f64::from(cell[1]) + dy])
}
