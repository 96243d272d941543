//! What a robot has seen of the static world: hits and misses along the rays, cell by cell. Without a map that is all it knows; with one it is what stands there besides.

use super::tiles::Tiles;
use crate::Point;
use crate::error::PlanError;
use crate::world::{Bits, Cell, Grid, World};
use std::collections::BTreeMap;
use std::sync::Arc;

/// Side of the cells where the world has none of its own, m.
const CELL: f64 = 0.05;
/// Never seen.
const UNKNOWN: i8 = i8::MIN;
/// Weight of a ray that ends in a cell against one that passes: a cell is blocked where more than one ray of five ends.
const HIT: i8 = 4;
/// Something unexplained that is seen in a cell for so long, s, becomes part of the map; it may be missed for so long.
const STAYS: f64 = 0.8;
const BLINKS: f64 = 0.3;
/// Bounds of the evidence: free, blocked.
const LEAST: i8 = -20;
const MOST: i8 = 20;
/// Evidence of the first hit: blocked at once.
const FIRST: i8 = 8;
/// At most this evidence makes a cell certainly free.
const CERTAIN: i8 = -6;
/// Cells of one map at most.
const CELLS: f64 = (1 << 26) as f64;
/// A ray frees cells up to this far before its end, cells: the end is known no better.
const SHORT: f64 = 1.0;

/// Evidence per cell and the cells that follow from it. Row 0 at the bottom.
pub(super) struct LocalMap {
    frame: Grid,
    evidence: Vec<i8>,
    blocked: Bits,
    unknown: Bits,
    changed: bool,
    /// Known cells that are not as free as can be, and where those and the unknown ones are.
    open: usize,
    tiles: Tiles,
    /// Cells in which something unexplained is seen: since when and when last, s.
    lingering: BTreeMap<usize, [f64; 2]>,
    /// The static world where it is given, as it is.
    base: Option<Arc<World>>,
    /// The world whose rules hold.
    site: Arc<World>,
    published: Option<Arc<World>>,
}

impl LocalMap {
    /// Nothing seen yet, over the bounds of a world (its own cells where it has a grid). Where the map is `given` all that it does not show is free.
    /// # Errors
    /// [`PlanError::BadParameter`] for a map of too many cells.
    pub fn new(world: &Arc<World>, given: bool) -> Result<Self, PlanError> {
        let (size, resolution, origin) = if let Some(grid) = world.grid() {
            ([grid.width(), grid.height()], grid.resolution(), grid.origin())
        } else {
            let [x0, y0, x1, y1] = world.bounds();
            let cells = |a: f64, b: f64, side: f64| ((b - a) / side - 1e-9).ceil().max(1.0);
            let mut side = world.resolution().min(CELL);
            while cells(x0, x1, side) * cells(y0, y1, side) > CELLS / 4.0 {
                side *= 2.0;
            }
            ([cells(x0, x1, side) as u32, cells(y0, y1, side) as u32], side, [x0, y0, 0.0])
        };
        let count = f64::from(size[0]) * f64::from(size[1]);
        if count > CELLS {
            return Err(PlanError::bad("map", format!("{count} cells"), format!("at most {CELLS} cells for a robot that looks around")));
        }
        let blocked = Bits::new(size[0], size[1]);
        let mut unknown = blocked.clone();
        if !given {
            (0..size[1]).for_each(|y| (0..size[0]).for_each(|x| unknown.set(x, y, true)));
        }
        let frame = Grid::new(blocked.clone(), None, resolution, origin)?;
        let (base, start) = if given { (Some(Arc::new(world.solid().overlaid(Vec::new()))), LEAST) } else { (None, UNKNOWN) };
        let evidence = vec![start; size[0] as usize * size[1] as usize];
        Ok(Self {
            frame,
            evidence,
            blocked,
            unknown,
            changed: !given,
            open: 0,
            tiles: Tiles::new(size, !given),
            lingering: BTreeMap::new(),
            base,
            site: Arc::clone(world),
            published: None,
        })
    }

    fn index(&self, x: u32, y: u32) -> usize {
        y as usize * self.frame.width() as usize + x as usize
    }

    /// A ray from `from` in the unit direction `along` that met nothing before `length` (m).
    pub fn miss(&mut self, from: Point, along: Point, length: f64) {
        let scale = self.frame.resolution();
        let (p, q) = (self.frame.to_cells(from), self.frame.to_cells([from[0] + along[0], from[1] + along[1]]));
        let dir = [(q[0] - p[0]) * scale, (q[1] - p[1]) * scale];
        let width = self.frame.width() as usize;
        let Self { evidence, blocked, unknown, changed, open, tiles, .. } = self;
        tiles.walk((p, dir), length / scale - SHORT, |[x, y]| {
            let e = &mut evidence[y as usize * width + x as usize];
            if *e == UNKNOWN {
                (*e, *changed) = (0, true);
                *open += 1;
                unknown.set(x, y, false);
            }
            // Those that are as free as can be do not wait.
            *e -= 1;
            if *e == 0 {
                blocked.set(x, y, false);
                *changed = true;
            }
            *open -= usize::from(*e == LEAST);
            *e == LEAST
        });
    }

    /// Something that nothing explains is seen at `p` at time `t`, s: if it stays it becomes part of the map.
    pub fn linger(&mut self, p: Point, t: f64) {
        let Some([x, y]) = self.frame.cell_at(p) else { return };
        let seen = self.lingering.entry(self.index(x, y)).or_insert([t, t]);
        seen[1] = t;
        if t - seen[0] >= STAYS {
            self.raise([x, y], |_| FIRST);
        }
    }

    /// Forgets what lingers no longer at time `t`, s; all of it after a leap of time.
    pub fn fade(&mut self, t: f64) {
        self.lingering.retain(|_, seen| (0.0..=BLINKS).contains(&(t - seen[1])));
    }

    /// A ray that ended at `p`.
    pub fn hit(&mut self, p: Point) {
        if let Some(cell) = self.frame.cell_at(p) {
            self.raise(cell, |before| if before == UNKNOWN { FIRST } else { (before + HIT).min(MOST) });
        }
    }

    fn raise(&mut self, [x, y]: Cell, to: impl Fn(i8) -> i8) {
        let i = self.index(x, y);
        let before = self.evidence[i];
        self.evidence[i] = to(before);
        self.open += usize::from(before <= LEAST);
        if before == LEAST {
            self.tiles.wait([x, y]);
        }
        if before == UNKNOWN {
            self.unknown.set(x, y, false);
        }
        if before <= 0 && self.evidence[i] > 0 {
            self.blocked.set(x, y, true);
            self.changed = true;
        }
    }

    /// Is everything as free as can be, so that rays that pass change nothing?
    pub fn idle(&self) -> bool {
        self.open == 0 && self.base.is_some()
    }

    /// Is something blocked in the cell of `p` or beside it?
    pub fn shows(&self, p: Point) -> bool {
        let Some([x, y]) = self.frame.cell_at(p) else { return false };
        let (low, high) = (i64::from(x) - 1, i64::from(x) + 1);
        (y.saturating_sub(1)..=(y + 1).min(self.frame.height() - 1)).any(|j| self.blocked.any(j, low, high))
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

    /// The world as far as it is known: blocked and never seen cells, the shapes of the given map, what is forbidden. Made anew only if a cell changed; `None` while it is
    /// the given one.
    pub fn world(&mut self) -> Option<&Arc<World>> {
        if std::mem::take(&mut self.changed) {
            self.published = self.merged().ok().map(Arc::new);
        }
        self.published.as_ref()
    }

    fn merged(&self) -> Result<World, PlanError> {
        let mut blocked = self.blocked.clone();
        let below = self.base.as_ref().and_then(|w| w.grid()).map(Grid::blocked);
        if let Some(below) = below {
            for y in 0..blocked.height() {
                blocked.row_mut(y).iter_mut().zip(below.row(y)).for_each(|(a, b)| *a |= b);
            }
        }
        let unknown = self.base.is_none().then(|| self.unknown.clone());
        let grid = Grid::new(blocked, unknown, self.frame.resolution(), self.frame.origin())?;
        let shapes = self.base.as_ref().map_or(Vec::new(), |w| w.shapes().to_vec());
        Ok(World::from_grid(grid).with_shapes(shapes).ruled_as(&self.site))
    }
}
