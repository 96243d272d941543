//! The 8-connected lattice of cell centres that grid planners search.

mod build;
mod padded;
mod pool;

pub use padded::Padded;
pub use pool::Pool;

use super::World;
use super::bits::Bits;
use super::grid::Cell;
use crate::Point;
use serde::{Deserialize, Serialize};
use std::sync::OnceLock;

/// When a diagonal step is allowed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Corners {
    /// Target free and at least one of the two orthogonal neighbours free.
    #[default]
    Touch,
    /// Target and both orthogonal neighbours free.
    Clear,
    /// Target free: passes through the zero-width gap between two blocked cells.
    Squeeze,
}

/// Cells whose centre a disc of the given radius may occupy, and the cell corners that a diagonal step may pass: together exactly the safe steps of a
/// grid of square obstacles, and only safe ones among shapes (proof in `lattice/build.rs`).
#[derive(Debug)]
pub struct Lattice {
    free: Bits,
    corner_free: Option<Bits>,
    implied: bool,
    resolution: f64,
    radius: f64,
    place: Place,
    rows: OnceLock<Padded>,
    columns: OnceLock<Padded>,
    pool: Pool,
}

/// Where the lattice lies in the map frame.
#[derive(Debug, Clone, Copy)]
struct Place {
    origin: Point,
    rotation: [f64; 2],
}

impl Lattice {
    fn new(world: &World, radius: f64, free: Bits, corner_free: Option<Bits>, implied: bool) -> Self {
        let (resolution, place) = (world.resolution(), place(world));
        Self { free, corner_free, implied, resolution, radius, place, rows: OnceLock::new(), columns: OnceLock::new(), pool: Pool::default() }
    }

    /// Blocked cells row by row inside a blocked frame; built at first use.
    pub fn rows(&self) -> &Padded {
        self.rows.get_or_init(|| Padded::around(&self.free))
    }
    /// Blocked cells column by column inside a blocked frame; built at first use.
    pub fn columns(&self) -> &Padded {
        self.columns.get_or_init(|| Padded::around(&padded::transposed(&self.free)))
    }
    /// Corners that a diagonal step may pass; bit `(x, y)` is the lower-left corner of cell `(x, y)`. `None`: every one.
    pub fn corner_free(&self) -> Option<&Bits> {
        self.corner_free.as_ref()
    }
    /// Do the free cells alone tell which steps are allowed under this corner rule? Jump point search needs that.
    pub fn plain(&self, corners: Corners) -> bool {
        self.corner_free.is_none() || (self.implied && corners == Corners::Clear)
    }
    /// Working memory of searches on this lattice.
    pub fn pool(&self) -> &Pool {
        &self.pool
    }

    /// Columns.
    pub fn width(&self) -> u32 {
        self.free.width()
    }
    /// Rows.
    pub fn height(&self) -> u32 {
        self.free.height()
    }
    /// Side of a cell, m.
    pub fn resolution(&self) -> f64 {
        self.resolution
    }
    /// Radius of the disc that fits at every free centre, m.
    pub fn radius(&self) -> f64 {
        self.radius
    }
    /// Free cells.
    pub fn free(&self) -> &Bits {
        &self.free
    }
    /// Is the cell inside the lattice and free?
    #[inline]
    pub fn is_free(&self, x: i64, y: i64) -> bool {
        x >= 0 && y >= 0 && x < i64::from(self.width()) && y < i64::from(self.height()) && self.free.at(x as u32, y as u32)
    }
    /// May the robot step from free cell `from` by `(dx, dy)`, each -1, 0 or 1?
    #[inline]
    pub fn step_free(&self, from: Cell, dx: i64, dy: i64, corners: Corners) -> bool {
        let (x, y) = (i64::from(from[0]), i64::from(from[1]));
        if !self.is_free(x + dx, y + dy) {
            return false;
        }
        if dx == 0 || dy == 0 {
            return true;
        }
        if let Some(corner) = &self.corner_free
            && !corner.at((x + i64::from(dx > 0)) as u32, (y + i64::from(dy > 0)) as u32)
        {
            return false;
        }
        let (a, b) = (self.is_free(x + dx, y), self.is_free(x, y + dy));
        match corners {
            Corners::Squeeze => true,
            Corners::Touch => a || b,
            Corners::Clear => a && b,
        }
    }
    /// Centre of a cell in the map frame, m.
    pub fn center(&self, cell: Cell) -> Point {
        let [c, s] = self.place.rotation;
        let (dx, dy) = ((f64::from(cell[0]) + 0.5) * self.resolution, (f64::from(cell[1]) + 0.5) * self.resolution);
        [self.place.origin[0] + c * dx - s * dy, self.place.origin[1] + s * dx + c * dy]
    }
    /// The cell that holds `p` (map frame, m); `None` outside.
    pub fn cell_at(&self, p: Point) -> Option<Cell> {
        let [c, s] = self.place.rotation;
        let (dx, dy) = (p[0] - self.place.origin[0], p[1] - self.place.origin[1]);
        let (x, y) = ((c * dx + s * dy) / self.resolution, (c * dy - s * dx) / self.resolution);
        let (w, h) = (f64::from(self.width()), f64::from(self.height()));
        (x >= 0.0 && y >= 0.0 && x <= w && y <= h).then(|| [(x as u32).min(self.width() - 1), (y as u32).min(self.height() - 1)])
    }
}

fn place(world: &World) -> Place {
    match world.grid() {
        Some(g) => {
            let [x, y, yaw] = g.origin();
            Place { origin: [x, y], rotation: if yaw == 0.0 { [1.0, 0.0] } else { [yaw.cos(), yaw.sin()] } }
        }
        None => Place { origin: [world.bounds()[0], world.bounds()[1]], rotation: [1.0, 0.0] },
    }
}
