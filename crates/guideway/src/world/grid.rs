//! Occupancy grid: which square cells are blocked, and where the grid lies in the map frame.

use super::bits::Bits;
use crate::Point;
use crate::error::PlanError;

/// Largest number of cells accepted (16384 x 16384).
pub const MAX_CELLS: u64 = 1 << 28;

/// Largest number of cells along a side: squared distances then fit 32 bits.
pub const MAX_SIDE: u32 = 65_000;

/// A cell: column from the left, row from the *bottom* (the map frame has y up).
pub type Cell = [u32; 2];

/// An occupancy grid. Blocked cells are closed squares; the robot may touch them but not enter.
#[derive(Debug, Clone, PartialEq)]
pub struct Grid {
    blocked: Bits,
    unknown: Option<Bits>,
    resolution: f64,
    origin: [f64; 3],
    rotation: [f64; 2],
}

impl Grid {
    /// A grid from its blocked cells (row 0 at the bottom), cell side `resolution` in m, and `origin`: x, y in m and yaw
    /// in rad of the lower-left corner of the lower-left cell. `unknown` marks those of the blocked (or free) cells that nobody has seen; it is
    /// for pictures and reports only.
    /// # Errors
    /// [`PlanError::BadParameter`] for an empty or huge grid, or a resolution or origin that is not finite and positive.
    pub fn new(blocked: Bits, unknown: Option<Bits>, resolution: f64, origin: [f64; 3]) -> Result<Self, PlanError> {
        let cells = u64::from(blocked.width()) * u64::from(blocked.height());
        if cells == 0 || cells > MAX_CELLS || blocked.width() > MAX_SIDE || blocked.height() > MAX_SIDE {
            let shown = format!("{} x {} cells", blocked.width(), blocked.height());
            return Err(PlanError::bad("map size", shown, format!("1 to {MAX_CELLS} cells, sides up to {MAX_SIDE} cells")));
        }
        if let Some(unknown) = &unknown
            && (unknown.width(), unknown.height()) != (blocked.width(), blocked.height())
        {
            return Err(PlanError::bad("unknown cells", format!("{} x {} cells", unknown.width(), unknown.height()), "the size of the map"));
        }
        if !(resolution.is_finite() && (1e-6..=1e6).contains(&resolution)) {
            return Err(PlanError::bad("resolution", resolution, "1e-6 to 1e6 m per cell"));
        }
        if !origin.iter().all(|v| v.is_finite() && v.abs() <= 1e9) {
            return Err(PlanError::bad("origin", format!("{origin:?}"), "three finite numbers: x, y in m and yaw in rad"));
        }
        let rotation = if origin[2] == 0.0 { [1.0, 0.0] } else { [origin[2].cos(), origin[2].sin()] };
        Ok(Self { blocked, unknown, resolution, origin, rotation })
    }

    /// Columns.
    pub fn width(&self) -> u32 {
        self.blocked.width()
    }
    /// Rows.
    pub fn height(&self) -> u32 {
        self.blocked.height()
    }
    /// Side of a cell, m.
    pub fn resolution(&self) -> f64 {
        self.resolution
    }
    /// x, y (m) and yaw (rad) of the lower-left corner.
    pub fn origin(&self) -> [f64; 3] {
        self.origin
    }
    /// Blocked cells.
    pub fn blocked(&self) -> &Bits {
        &self.blocked
    }
    /// Cells that nobody has seen, if the map tells.
    pub fn unknown(&self) -> Option<&Bits> {
        self.unknown.as_ref()
    }
    /// The same grid with these cells blocked or free, which nobody need wonder about any more. They must be inside.
    pub(super) fn with(&self, changes: &[(Cell, bool)]) -> Self {
        let mut grid = self.clone();
        for &([x, y], on) in changes {
            grid.blocked.set(x, y, on);
            if let Some(unknown) = &mut grid.unknown {
                unknown.set(x, y, false);
            }
        }
        grid
    }
    /// Blocks more cells, those of bits of the same size.
    pub(super) fn block(&mut self, more: &Bits) {
        for y in 0..self.height().min(more.height()) {
            self.blocked.row_mut(y).iter_mut().zip(more.row(y)).for_each(|(a, b)| *a |= b);
        }
    }
    /// Map frame (m) to grid frame (cells, real-valued; cell `(i, j)` covers `[i, i+1] x [j, j+1]`).
    #[inline]
    pub fn to_cells(&self, p: Point) -> Point {
        let [c, s] = self.rotation;
        let (dx, dy) = (p[0] - self.origin[0], p[1] - self.origin[1]);
        [(c * dx + s * dy) / self.resolution, (c * dy - s * dx) / self.resolution]
    }
    /// Grid frame (cells) to map frame (m).
    #[inline]
    pub fn to_map(&self, q: Point) -> Point {
        let [c, s] = self.rotation;
        let (dx, dy) = (q[0] * self.resolution, q[1] * self.resolution);
        [self.origin[0] + c * dx - s * dy, self.origin[1] + s * dx + c * dy]
    }
    /// Centre of a cell in the map frame, m.
    #[inline]
    pub fn center(&self, cell: Cell) -> Point {
        self.to_map([f64::from(cell[0]) + 0.5, f64::from(cell[1]) + 0.5])
    }
    /// The cell that holds `p` (m, map frame); `None` outside. The upper and right border belong to the last cell.
    #[inline]
    pub fn cell_at(&self, p: Point) -> Option<Cell> {
        self.cell_of(self.to_cells(p))
    }
    /// As [`Grid::cell_at`] for a point in the grid frame (cells).
    #[inline]
    pub fn cell_of(&self, [x, y]: Point) -> Option<Cell> {
        let (w, h) = (f64::from(self.width()), f64::from(self.height()));
        (x >= 0.0 && y >= 0.0 && x <= w && y <= h).then(|| [(x as u32).min(self.width() - 1), (y as u32).min(self.height() - 1)])
    }
}
