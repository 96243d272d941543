//! What a robot without a map has seen: hits and misses along the rays, cell by cell.

use crate::Point;
use crate::drive::rays::walk;
use crate::error::PlanError;
use crate::world::{Bits, Grid, MAX_CELLS, World};
use std::sync::Arc;

/// Side of the cells where the world has none of its own, m.
const CELL: f64 = 0.05;
/// Never seen.
const UNKNOWN: i8 = i8::MIN;
/// Weight of a ray that ends in a cell against one that passes: a cell is blocked where more than one ray of five ends.
const HIT: i8 = 4;
/// Bounds of the evidence: free, blocked.
const LEAST: i8 = -20;
const MOST: i8 = 40;
/// Evidence of the first hit: blocked at once.
const FIRST: i8 = 8;
/// At most this evidence makes a cell certainly free.
const CERTAIN: i8 = -6;
/// A ray frees cells up to this far before its end, cells: the end is known no better.
const SHORT: f64 = 1.0;

/// Evidence per cell and the cells that follow from it. Row 0 at the bottom.
pub(super) struct LocalMap {
    frame: Grid,
    evidence: Vec<i8>,
    blocked: Bits,
    unknown: Bits,
    changed: bool,
    published: Arc<World>,
}

impl LocalMap {
    /// Nothing seen yet, over the bounds of a world (its own cells where it has a grid).
    /// # Errors
    /// [`PlanError::BadParameter`] for a world of too many cells.
    pub fn new(world: &World) -> Result<Self, PlanError> {
        let (size, resolution, origin) = if let Some(grid) = world.grid() {
            ([grid.width(), grid.height()], grid.resolution(), grid.origin())
        } else {
            let [x0, y0, x1, y1] = world.bounds();
            let cells = |a: f64, b: f64, side: f64| ((b - a) / side - 1e-9).ceil().max(1.0);
            let mut side = world.resolution().min(CELL);
            while cells(x0, x1, side) * cells(y0, y1, side) > MAX_CELLS as f64 / 16.0 {
                side *= 2.0;
            }
            ([cells(x0, x1, side) as u32, cells(y0, y1, side) as u32], side, [x0, y0, 0.0])
        };
        let (blocked, mut unknown) = (Bits::new(size[0], size[1]), Bits::new(size[0], size[1]));
        for y in 0..size[1] {
            (0..size[0]).for_each(|x| unknown.set(x, y, true));
        }
        let frame = Grid::new(blocked.clone(), Some(unknown.clone()), resolution, origin)?;
        let published = Arc::new(World::from_grid(frame.clone()));
        Ok(Self { frame, evidence: vec![UNKNOWN; size[0] as usize * size[1] as usize], blocked, unknown, changed: false, published })
    }

    fn index(&self, x: u32, y: u32) -> usize {
        y as usize * self.frame.width() as usize + x as usize
    }

    /// A ray from `from` in the unit direction `along` that met nothing before `length` (m).
    pub fn miss(&mut self, from: Point, along: Point, length: f64) {
        let scale = self.frame.resolution();
        let (p, q) = (self.frame.to_cells(from), self.frame.to_cells([from[0] + along[0], from[1] + along[1]]));
        let dir = [(q[0] - p[0]) * scale, (q[1] - p[1]) * scale];
        let (width, size) = (self.frame.width() as usize, [self.frame.width(), self.frame.height()]);
        let Self { evidence, blocked, unknown, changed, .. } = self;
        walk(p, dir, length / scale - SHORT, size, |[x, y], _| {
            let e = &mut evidence[y as usize * width + x as usize];
            if *e == UNKNOWN {
                (*e, *changed) = (0, true);
                unknown.set(x, y, false);
            }
            if *e > LEAST {
                *e -= 1;
                if *e == 0 {
                    blocked.set(x, y, false);
                    *changed = true;
                }
            }
            true
        });
    }

    /// A ray that ended at `p`.
    pub fn hit(&mut self, p: Point) {
        let Some([x, y]) = self.frame.cell_at(p) else { return };
        let i = self.index(x, y);
        let before = self.evidence[i];
        self.evidence[i] = if before == UNKNOWN { FIRST } else { (before + HIT).min(MOST) };
        if before == UNKNOWN {
            self.unknown.set(x, y, false);
        }
        if before <= 0 && self.evidence[i] > 0 {
            self.blocked.set(x, y, true);
            self.changed = true;
        }
    }

    /// Something that rests at `p` for good.
    pub fn settle(&mut self, p: Point) {
        self.hit(p);
        if let Some([x, y]) = self.frame.cell_at(p) {
            let i = self.index(x, y);
            self.evidence[i] = self.evidence[i].max(FIRST);
            self.blocked.set(x, y, true);
            self.changed = true;
        }
    }

    /// Is `p` in a cell that is certainly free, amid cells that are free?
    pub fn certainly_free(&self, p: Point) -> bool {
        let Some([x, y]) = self.frame.cell_at(p) else { return false };
        if self.evidence[self.index(x, y)] > CERTAIN || self.evidence[self.index(x, y)] == UNKNOWN {
            return false;
        }
        let (x1, y1) = ((x + 1).min(self.frame.width() - 1), (y + 1).min(self.frame.height() - 1));
        (y.saturating_sub(1)..=y1).all(|j| (x.saturating_sub(1)..=x1).all(|i| (UNKNOWN + 1..0).contains(&self.evidence[self.index(i, j)])))
    }

    /// The world as far as it was seen: blocked and never seen cells. Made anew only if a cell changed.
    pub fn world(&mut self) -> &Arc<World> {
        if std::mem::take(&mut self.changed)
            && let Ok(grid) = Grid::new(self.blocked.clone(), Some(self.unknown.clone()), self.frame.resolution(), self.frame.origin())
        {
            self.published = Arc::new(World::from_grid(grid));
        }
        &self.published
    }
}
