//! Lower bounds of the clearance that are quick to look up: most places of a prediction are far from everything, and need no exact distance.

use crate::Point;
use crate::world::{Bits, ClearanceField, Grid, Shape, World};
use std::cell::Cell;
use std::f64::consts::FRAC_1_SQRT_2;
use std::sync::Arc;

/// Side of the tiles, m, and how many there may be; there are fewer and larger ones in larger worlds.
const SIDE: f64 = 0.1;
const MOST: f64 = 65_536.0;
/// Half the side of the part of a map that is looked at, tiles.
const HALF: f64 = 160.0;
/// So many tiles may have become free before the distances are made anew; until then they are lower than they need be.
const FREED: u32 = 8;
/// So many tiles may have become blocked; until then each is looked at by itself.
const MORE: usize = 8;
/// Bounds are so much lower than they need be, m: rounding is far below.
const SURE: f64 = 1e-5;

/// Bounds in the world that a controller sees, kept from step to step as long as they hold.
#[derive(Default)]
pub(super) struct Rooms {
    world: Option<Arc<World>>,
    shapes: Option<Tiles>,
    cells: Option<Cells>,
}

impl Rooms {
    /// Brings everything up to date for a robot at `p` that looks up to `far` m.
    pub fn look(&mut self, world: &Arc<World>, p: Point, far: f64) {
        let before = self.world.replace(Arc::clone(world));
        let same = before.as_ref().is_some_and(|old| Arc::ptr_eq(old, world));
        if !before.as_ref().is_some_and(|old| same || (old.bounds() == world.bounds() && old.shapes() == world.shapes())) {
            self.shapes = (!world.shapes().is_empty()).then(|| Tiles::new(world.bounds()));
        }
        let Some(grid) = world.grid() else {
            self.cells = None;
            return;
        };
        let placed = before.as_ref().and_then(|old| old.grid()).is_some_and(|old| same || in_place(old, grid));
        if !(placed && self.cells.as_mut().is_some_and(|cells| cells.cover(grid, p, far) && (same || cells.hold(grid.blocked())))) {
            self.cells = Cells::new(grid, p, far);
        }
    }

    /// At most the clearance at `p`, m, if that is known.
    #[inline]
    pub fn at(&self, p: Point) -> Option<f64> {
        let world = self.world.as_deref()?;
        let grid = match world.grid() {
            Some(grid) => self.cells.as_ref()?.at(grid, p)?,
            None => f64::INFINITY,
        };
        match &self.shapes {
            Some(tiles) => Some(grid.min(tiles.at(world.shapes(), p)?)),
            None => Some(grid),
        }
    }
}

/// Cells of the same size in the same place?
fn in_place(a: &Grid, b: &Grid) -> bool {
    a.resolution() == b.resolution() && a.origin() == b.origin() && [a.width(), a.height()] == [b.width(), b.height()]
}

/// Distances from shapes, tile by tile, each when it is first asked for.
struct Tiles {
    low: Point,
    side: f64,
    size: [usize; 2],
    /// Not a number where nobody has asked.
    known: Vec<Cell<f64>>,
}

impl Tiles {
    fn new([x0, y0, x1, y1]: [f64; 4]) -> Self {
        let side = SIDE.max(((x1 - x0) * (y1 - y0) / MOST).sqrt()).max((x1 - x0).max(y1 - y0) / MOST);
        let size = [x1 - x0, y1 - y0].map(|d| (d / side) as usize + 1);
        Self { low: [x0, y0], side, size, known: vec![Cell::new(f64::NAN); size[0] * size[1]] }
    }

    #[inline]
    fn at(&self, shapes: &[Shape], p: Point) -> Option<f64> {
        let [x, y] = [0, 1].map(|k| (p[k] - self.low[k]) / self.side);
        let (i, j) = (x as usize, y as usize);
        if !(x >= 0.0 && y >= 0.0 && i < self.size[0] && j < self.size[1]) {
            return None;
        }
        let known = &self.known[j * self.size[0] + i];
        if known.get().is_nan() {
            let middle = [self.low[0] + (i as f64 + 0.5) * self.side, self.low[1] + (j as f64 + 0.5) * self.side];
            known.set(shapes.iter().map(|s| s.distance(middle)).fold(f64::INFINITY, f64::min) - SURE);
        }
        Some(known.get() - self.side * off_middle([x, y]))
    }
}

/// Distances from the blocked cells of a part of a map, for tiles of several cells each: a tile is blocked if one of its cells is.
struct Cells {
    /// Cells along the side of a tile.
    by: u32,
    /// First tile, and how many.
    low: [u32; 2],
    size: [u32; 2],
    /// Does the part end where the map ends? Low and high, columns and rows.
    ends: [[bool; 2]; 2],
    tiles: Bits,
    field: Arc<ClearanceField>,
    /// Blocked tiles that the field does not know.
    more: Vec<[u32; 2]>,
}

impl Cells {
    fn new(grid: &Grid, p: Point, far: f64) -> Option<Self> {
        let side = grid.resolution();
        let by = (SIDE / side).round().clamp(1.0, 64.0) as u32;
        let half = (2.0 * far / (side * f64::from(by))).clamp(1.0, HALF);
        let (q, whole) = (grid.to_cells(p), [grid.width().div_ceil(by), grid.height().div_ceil(by)]);
        let ends = [0, 1].map(|k| {
            let middle = q[k] / f64::from(by);
            let top = f64::from(whole[k]);
            [(middle - half).floor().clamp(0.0, top) as u32, (middle + half).ceil().clamp(0.0, top) as u32]
        });
        let (low, size) = ([ends[0][0], ends[1][0]], [ends[0][1] - ends[0][0], ends[1][1] - ends[1][0]]);
        if size.contains(&0) {
            return None;
        }
        let tiles = coarse(grid.blocked(), by, (low, size));
        let coarse = Grid::new(tiles.clone(), None, side * f64::from(by), [0.0; 3]).ok()?;
        let ends = [0, 1].map(|k| [low[k] == 0, low[k] + size[k] == whole[k]]);
        Some(Self { by, low, size, ends, tiles, field: World::from_grid(coarse).clearance_field(), more: Vec::new() })
    }

    /// Do the distances still hold, but for a few tiles, and are they nearly what they could be?
    fn hold(&mut self, blocked: &Bits) -> bool {
        let (new, mut freed) = (coarse(blocked, self.by, (self.low, self.size)), 0);
        self.more.clear();
        for y in 0..self.size[1] {
            for (k, (new, old)) in new.row(y).iter().zip(self.tiles.row(y)).enumerate() {
                freed += (old & !new).count_ones();
                let mut more = new & !old;
                while more != 0 {
                    self.more.push([64 * k as u32 + more.trailing_zeros(), y]);
                    more &= more - 1;
                }
            }
        }
        freed <= FREED && self.more.len() <= MORE
    }

    /// Is all that is within `far` m of `p` known?
    fn cover(&self, grid: &Grid, p: Point, far: f64) -> bool {
        let scale = grid.resolution() * f64::from(self.by);
        let q = grid.to_cells(p);
        (0..2).all(|k| {
            let at = q[k] / f64::from(self.by) - f64::from(self.low[k]);
            let room = (far / scale).min(0.5 * HALF);
            (self.ends[k][0] || at >= room) && (self.ends[k][1] || f64::from(self.size[k]) - at >= room)
        })
    }

    #[inline]
    fn at(&self, grid: &Grid, p: Point) -> Option<f64> {
        let q = grid.to_cells(p);
        let (scale, side) = (f64::from(self.by), grid.resolution() * f64::from(self.by));
        let at = [0, 1].map(|k| q[k] / scale - f64::from(self.low[k]));
        let tile = at.map(|v| v as u32);
        if !(at[0] >= 0.0 && at[1] >= 0.0 && tile[0] < self.size[0] && tile[1] < self.size[1]) {
            return None;
        }
        let away = |k: usize, other: &[u32; 2]| (f64::from(tile[k].abs_diff(other[k])) - 0.5).max(0.0);
        let more = self.more.iter().map(|other| away(0, other).powi(2) + away(1, other).powi(2)).fold(f64::INFINITY, f64::min);
        let mut least = self.field.at(tile).min(more.sqrt() * side);
        for ((tile, size), ends) in tile.into_iter().zip(self.size).zip(self.ends) {
            // Beyond the part there may be anything.
            let beyond = [f64::from(tile), f64::from(size - 1 - tile)];
            for (_, tiles) in ends.into_iter().zip(beyond).filter(|(end, _)| !end) {
                least = least.min(tiles * side);
            }
        }
        // Within a blocked tile nothing is known of how deep a place is.
        let off = if least > 0.0 { off_middle(at) } else { FRAC_1_SQRT_2 };
        Some(least - side * off - SURE)
    }
}

/// Distance of a place from the middle of its square of side 1.
#[inline]
fn off_middle([x, y]: Point) -> f64 {
    let [u, v] = [x, y].map(|q| q - f64::from(q as u32) - 0.5);
    (u * u + v * v).sqrt()
}

/// The tiles of `by` x `by` bits in which one is set, `size` of them from tile `low` on.
fn coarse(set: &Bits, by: u32, (low, size): ([u32; 2], [u32; 2])) -> Bits {
    let mut tiles = Bits::new(size[0], size[1]);
    let (first, last) = (low[0] * by, ((low[0] + size[0]) * by).min(set.width()) - 1);
    for y in low[1] * by..((low[1] + size[1]) * by).min(set.height()) {
        let mut x = first;
        while let Some(next) = set.first(y, x, last, true) {
            let tile = next / by;
            tiles.set(tile - low[0], y / by - low[1], true);
            x = (tile + 1) * by;
            if x > last {
                break;
            }
        }
    }
    tiles
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use rand::RngExt;
    use rand_chacha::ChaCha8Rng;
    use rand_chacha::rand_core::SeedableRng;

    proptest! {
        #[test]
        fn bounds_are_never_above_the_clearance_and_seldom_far_below(
            [w, h] in [20_u32..300, 20_u32..300], share in 0..30_u32, seed in 0..u64::MAX, side in 0.01..0.3_f64, shapes in 0..4_u32
        ) {
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            let mut blocked = Bits::new(w, h);
            let mut rooms = Rooms::default();
            for _ in 0..3 {
                for _ in 0..share {
                    blocked.set(rng.random_range(0..w), rng.random_range(0..h), true);
                }
                let grid = Grid::new(blocked.clone(), None, side, [1.0, -2.0, 0.7]).unwrap();
                let place = |rng: &mut ChaCha8Rng| grid.to_map([rng.random_range(0.0..f64::from(w)), rng.random_range(0.0..f64::from(h))]);
                let discs = (0..shapes).map(|k| Shape::disc(grid.to_map([20.0 * f64::from(k), 15.0]), 0.2).unwrap()).collect();
                let world = Arc::new(World::from_grid(grid.clone()).with_shapes(discs));
                let p = place(&mut rng);
                rooms.look(&world, p, 2.0);
                for _ in 0..200 {
                    let q = place(&mut rng);
                    let (exact, bound) = (world.clearance(q), rooms.at(q));
                    if let Some(bound) = bound {
                        prop_assert!(bound <= exact, "{bound} {exact}");
                    }
                    let near = (p[0] - q[0]).hypot(p[1] - q[1]) < 0.5 && share + shapes > 0;
                    let tile = side * (SIDE / side).round().max(1.0);
                    prop_assert!(!near || bound.is_some_and(|b| b >= exact.min(1.0) - 4.0 * tile.max(SIDE)), "{bound:?} {exact}");
                }
            }
        }
    }
}
