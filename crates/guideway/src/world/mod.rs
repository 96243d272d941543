//! The world: what is blocked, where the robot may be, and exactly how far away everything is.
//!
//! A world is an occupancy [`Grid`], analytic [`Shape`]s, or both, inside bounds. The border of the world stops the robot's reference
//! point but is no obstacle: it costs no clearance. Places may be [forbidden](World::forbidding) without an obstacle. Worlds are immutable; moving obstacles overlay them in time.

mod bits;
mod clearance;
mod distance;
mod envelope;
mod footprint;
mod grid;
mod lattice;
mod mover;
mod pose;
mod rules;
mod segment;
pub mod shape;
mod speed_map;
#[cfg(test)]
mod tests;
mod update;

pub use bits::Bits;
pub use distance::{ClearanceField, DistanceField, distance_transform, distances};
pub use footprint::Footprint;
pub use grid::{Cell, Grid, MAX_CELLS, MAX_SIDE};
pub use lattice::{Corners, Lattice, Padded, Pool};
pub use mover::{Appears, Loop, Mover};
pub use shape::Shape;
pub use speed_map::SpeedMap;

use crate::Point;
use crate::error::PlanError;
use std::sync::{Arc, Mutex, OnceLock};

/// Obstacles may be touched; contact is told from penetration up to this distance, m. Half of what certificates allow, so that rounding in what is
/// made of free segments never costs a certificate.
const TOUCH: f64 = 5e-10;

/// Side of the tiles in which shapes are sorted out, cells.
const TILE: u32 = 16;

/// A static world with the movers that overlay it.
#[derive(Debug)]
pub struct World {
    grid: Option<Grid>,
    shapes: Vec<Shape>,
    bounds: [f64; 4],
    resolution: f64,
    movers: Vec<Mover>,
    /// What is only forbidden, if anything is; it is among the blocked cells and the shapes.
    rules: Option<rules::Rules>,
    lattices: Mutex<Vec<(u64, Arc<Lattice>)>>,
    /// Distances to blocked cells, and clearances, which hold them.
    squares: OnceLock<Arc<distance::SquareField>>,
    field: OnceLock<Arc<ClearanceField>>,
}

impl World {
    /// A world from an occupancy grid alone.
    pub fn from_grid(grid: Grid) -> Self {
        let (w, h) = (f64::from(grid.width()), f64::from(grid.height()));
        let corners = [[0.0, 0.0], [w, 0.0], [w, h], [0.0, h]].map(|q| grid.to_map(q));
        let fold = |k: usize, f: fn(f64, f64) -> f64, start: f64| corners.iter().map(|p| p[k]).fold(start, f);
        let bounds = [
            fold(0, f64::min, f64::INFINITY),
            fold(1, f64::min, f64::INFINITY),
            fold(0, f64::max, f64::NEG_INFINITY),
            fold(1, f64::max, f64::NEG_INFINITY),
        ];
        let resolution = grid.resolution();
        Self::bare(Some(grid), Vec::new(), bounds, resolution)
    }

    /// A continuous world: `bounds` = [x0, y0, x1, y1] in m, shapes, and the `resolution` (m) of the lattice that grid planners see.
    /// # Errors
    /// [`PlanError::BadParameter`] for bounds or a resolution that make no sense.
    pub fn from_shapes(bounds: [f64; 4], shapes: Vec<Shape>, resolution: f64) -> Result<Self, PlanError> {
        let [x0, y0, x1, y1] = bounds;
        if !(bounds.iter().all(|v| v.is_finite() && v.abs() <= 1e9) && x0 < x1 && y0 < y1) {
            return Err(PlanError::bad("world.bounds", format!("{bounds:?}"), "[x0, y0, x1, y1] in m with x0 < x1 and y0 < y1"));
        }
        let [w, h] = cells_of(bounds, resolution);
        if !(resolution.is_finite() && resolution > 0.0 && w * h <= MAX_CELLS as f64 && w.max(h) <= f64::from(MAX_SIDE)) {
            let allowed = format!("a positive cell side in m that gives at most {MAX_CELLS} cells, sides up to {MAX_SIDE} cells");
            return Err(PlanError::bad("world.resolution", resolution, allowed));
        }
        Ok(Self::bare(None, shapes, bounds, resolution))
    }

    /// A static world of which nothing is computed yet.
    fn bare(grid: Option<Grid>, shapes: Vec<Shape>, bounds: [f64; 4], resolution: f64) -> Self {
        let (lattices, squares, field) = (Mutex::default(), OnceLock::new(), OnceLock::new());
        Self { grid, shapes, bounds, resolution, movers: Vec::new(), rules: None, lattices, squares, field }
    }

    /// Adds analytic shapes to the static world.
    #[must_use]
    pub fn with_shapes(mut self, shapes: Vec<Shape>) -> Self {
        if let Some(rules) = &mut self.rules {
            rules.solid = Arc::new(rules.solid.extended(shapes.iter().cloned()));
        }
        self.shapes.extend(shapes);
        self.lattices = Mutex::default();
        self.field = OnceLock::new();
        self
    }

    /// Share of the map's cells that nobody has seen, 0 to 1; 0 without a map.
    pub fn unknown_share(&self) -> f64 {
        let cells = |g: &Grid| f64::from(g.width()) * f64::from(g.height());
        self.grid.as_ref().map_or(0.0, |g| g.unknown().map_or(0.0, |u| u.count() as f64 / cells(g)))
    }

    /// Checks every shape and mover, also those that were read from a file, and normalises the sense of polygons.
    /// # Errors
    /// [`PlanError::BadParameter`] of the first that makes no sense.
    pub fn validated(mut self) -> Result<Self, PlanError> {
        self.shapes = std::mem::take(&mut self.shapes).into_iter().map(Shape::validated).collect::<Result<_, _>>()?;
        self.movers = std::mem::take(&mut self.movers).into_iter().map(Mover::validated).collect::<Result<_, _>>()?;
        Ok(self)
    }

    /// Sets the moving obstacles.
    #[must_use]
    pub fn with_movers(mut self, movers: Vec<Mover>) -> Self {
        self.movers = movers;
        self
    }

    /// The same static world under other movers; what was computed from it is shared.
    #[must_use]
    pub fn overlaid(&self, movers: Vec<Mover>) -> Self {
        let lattices = self.lattices.lock().unwrap_or_else(std::sync::PoisonError::into_inner).clone();
        Self {
            grid: self.grid.clone(),
            shapes: self.shapes.clone(),
            bounds: self.bounds,
            resolution: self.resolution,
            movers,
            rules: self.rules.clone(),
            lattices: Mutex::new(lattices),
            squares: self.squares.clone(),
            field: self.field.clone(),
        }
    }

    /// The occupancy grid, if there is one.
    pub fn grid(&self) -> Option<&Grid> {
        self.grid.as_ref()
    }
    /// Analytic obstacles.
    pub fn shapes(&self) -> &[Shape] {
        &self.shapes
    }
    /// Moving obstacles.
    pub fn movers(&self) -> &[Mover] {
        &self.movers
    }
    /// [x0, y0, x1, y1], m.
    pub fn bounds(&self) -> [f64; 4] {
        self.bounds
    }
    /// Side of the cells that grid planners see, m.
    pub fn resolution(&self) -> f64 {
        self.resolution
    }

    /// Columns and rows of the cells that grid planners see.
    pub fn cells(&self) -> [u32; 2] {
        match &self.grid {
            Some(grid) => [grid.width(), grid.height()],
            None => cells_of(self.bounds, self.resolution).map(|n| n as u32),
        }
    }

    /// A real-valued cell position (cell `(i, j)` covers `[i, i+1] x [j, j+1]`, row 0 at the bottom) in the map frame, m.
    pub fn cell_to_map(&self, q: Point) -> Point {
        match &self.grid {
            Some(grid) => grid.to_map(q),
            None => [0, 1].map(|k| self.bounds[k] + q[k] * self.resolution),
        }
    }

    /// Columns and rows of the cells that grid planners see (the same as [`World::cells`]).
    pub fn size(&self) -> [u32; 2] {
        self.cells()
    }

    /// Centre of a cell that grid planners see, map frame, m.
    pub fn cell_center(&self, [x, y]: Cell) -> Point {
        self.cell_to_map([f64::from(x) + 0.5, f64::from(y) + 0.5])
    }

    /// May the reference point be here, obstacles aside?
    pub fn contains(&self, p: Point) -> bool {
        match &self.grid {
            Some(grid) => grid.cell_at(p).is_some(),
            None => p[0] >= self.bounds[0] && p[1] >= self.bounds[1] && p[0] <= self.bounds[2] && p[1] <= self.bounds[3],
        }
    }

    /// Exact distance from `p` (m) to the nearest static obstacle, m; infinite if there is none, not a number if `p` is not finite.
    ///
    /// Blocked cells are closed squares and count as one obstacle. Inside it the value is minus the distance to the nearest point outside (also on an
    /// edge shared by two blocked cells), inside a shape minus the distance to its border; inside several obstacles the deepest counts.
    pub fn clearance(&self, p: Point) -> f64 {
        self.clearance_within(p, f64::INFINITY)
    }

    /// As [`World::clearance`] where that is below `reach` (m); anything from `reach` up elsewhere. The cost grows with `reach`, not with the map.
    pub fn clearance_within(&self, p: Point, reach: f64) -> f64 {
        if !(p[0].is_finite() && p[1].is_finite()) {
            return f64::NAN;
        }
        let shapes = self.shapes.iter().map(|s| s.distance(p)).fold(f64::INFINITY, f64::min);
        let grid = self.grid.as_ref().map_or(f64::INFINITY, |g| {
            let q = g.to_cells(p);
            // A query never builds the field, but it uses it.
            let known = || self.field.get().and_then(|field| field.near(g.cell_of(q)?));
            clearance::signed(g.blocked(), q, reach / g.resolution(), known) * g.resolution()
        });
        shapes.min(grid)
    }

    /// Does a disc of radius `radius` (m) fit at `p`, with its centre inside the world? Touching (to 1e-9 m) is fitting. A point robot on a grid needs a
    /// free cell.
    pub fn fits(&self, p: Point, radius: f64) -> bool {
        if radius == 0.0
            && self.shapes.is_empty()
            && let Some(grid) = &self.grid
        {
            return grid.cell_at(p).is_some_and(|[x, y]| !grid.blocked().at(x, y));
        }
        let seam = |grid: &Grid| !segment::point_free(grid.blocked(), grid.to_cells(p), grid.to_cells(p), TOUCH / grid.resolution());
        self.nearly_contains(p)
            && self.clearance_within(p, radius) >= radius - TOUCH
            && !(radius <= 2.0 * TOUCH && self.grid.as_ref().is_some_and(seam))
    }

    /// Does a disc of radius `radius` (m) swept along the segment `a b` stay inside the world and out of the interior of every static obstacle?
    ///
    /// Exact up to 1e-9 m: touching is allowed. Radius 0 is a point: it may slide along walls and touch corners, but not pass along the shared edge of
    /// two blocked cells, nor between a blocked cell and the border of the map, nor through the gap of width zero where two blocked cells meet at a
    /// corner (it may end there).
    pub fn segment_free(&self, a: Point, b: Point, radius: f64) -> bool {
        if !self.segment_inside(a, b) {
            return false;
        }
        if let Some(grid) = &self.grid {
            let (p, q, scale) = (grid.to_cells(a), grid.to_cells(b), grid.resolution());
            let eps = TOUCH / scale;
            let free = if radius > 2.0 * TOUCH {
                segment::capsule_free(grid.blocked(), p, q, radius / scale - eps)
            } else {
                segment::point_free(grid.blocked(), p, q, eps)
            };
            if !free {
                return false;
            }
        }
        self.shapes.iter().all(|s| s.segment_distance(a, b) >= radius - TOUCH)
    }

    /// Smallest clearance along the segment `a b`, m: exact, and not above 0 where it meets an obstacle.
    pub fn segment_clearance(&self, a: Point, b: Point) -> f64 {
        let ends = if [a, b].iter().flatten().all(|v| v.is_finite()) { self.clearance(a).min(self.clearance(b)) } else { f64::NAN };
        let shapes = self.shapes.iter().map(|s| s.segment_distance(a, b)).fold(ends, |m, d| if d < m { d } else { m });
        if !(shapes > 0.0 && shapes.is_finite()) {
            return shapes;
        }
        self.grid.as_ref().map_or(shapes, |g| {
            let scale = g.resolution();
            segment::distance(g.blocked(), g.to_cells(a), g.to_cells(b), (shapes / scale).min(f64::from(g.width()).hypot(f64::from(g.height()))))
                * scale
        })
    }

    /// As [`World::segment_clearance`] where that is below `reach` (m), 0 where the segment meets blocked cells; anything from `reach` up elsewhere.
    /// The cost grows with `reach`, not with the map.
    pub fn segment_clearance_within(&self, a: Point, b: Point, reach: f64) -> f64 {
        let shapes = self.shapes.iter().map(|s| s.segment_distance(a, b)).fold(reach, |m, d| if d < m { d } else { m });
        if !(shapes > 0.0 && shapes.is_finite() && [a, b].iter().flatten().all(|v| v.is_finite())) {
            return if reach.is_finite() { shapes } else { self.segment_clearance(a, b) };
        }
        self.grid.as_ref().map_or(shapes, |g| {
            let scale = g.resolution();
            let within = (shapes / scale).min(f64::from(g.width()).hypot(f64::from(g.height())));
            let found = segment::distance(g.blocked(), g.to_cells(a), g.to_cells(b), within);
            if found < within { found * scale } else { shapes }
        })
    }

    /// Are both ends, and so all of the segment, inside the world (up to 1e-9 m)?
    fn segment_inside(&self, a: Point, b: Point) -> bool {
        self.nearly_contains(a) && self.nearly_contains(b)
    }

    /// As [`World::contains`], 1e-9 m more on every side; false for points that are not finite.
    fn nearly_contains(&self, p: Point) -> bool {
        let (q, [x0, y0, x1, y1], slack) = match &self.grid {
            Some(grid) => (grid.to_cells(p), [0.0, 0.0, f64::from(grid.width()), f64::from(grid.height())], TOUCH / grid.resolution()),
            None => (p, self.bounds, TOUCH),
        };
        q[0] >= x0 - slack && q[1] >= y0 - slack && q[0] <= x1 + slack && q[1] <= y1 + slack
    }

    /// Clearance of every cell centre of the lattice that grid planners see; computed at the first call and kept.
    pub fn clearance_field(&self) -> Arc<ClearanceField> {
        Arc::clone(self.field.get_or_init(|| {
            let of_grid = || Arc::new(self.grid.as_ref().map_or(distance::SquareField::Empty, |g| distance::SquareField::new(g.blocked())));
            let squares = Arc::clone(self.squares.get_or_init(of_grid));
            let shapes = self.shape_distances(&squares);
            Arc::new(ClearanceField::new(self.cells(), self.resolution, squares, shapes))
        }))
    }

    /// Distance from every cell centre to the nearest shape, m; infinite all over tiles in which blocked cells are nearer everywhere. Empty without shapes.
    fn shape_distances(&self, squares: &distance::SquareField) -> Vec<f64> {
        if self.shapes.is_empty() {
            return Vec::new();
        }
        let [w, h] = self.cells();
        let mut out = vec![f64::INFINITY; w as usize * h as usize];
        let mut near = Vec::new();
        for (y0, x0) in (0..h).step_by(TILE as usize).flat_map(|y| (0..w).step_by(TILE as usize).map(move |x| (y, x))) {
            // Distances change by no more than the way from the middle of the tile: shapes that stay behind the nearest one all over it are left out.
            let (x1, y1) = ((x0 + TILE).min(w), (y0 + TILE).min(h));
            let middle = self.cell_to_map([f64::from(x0 + TILE / 2), f64::from(y0 + TILE / 2)]);
            let reach = f64::from(TILE) * self.resolution;
            near.clear();
            near.extend(self.shapes.iter().map(|s| (s.distance(middle), s)));
            let nearest = near.iter().map(|n| n.0).fold(f64::INFINITY, f64::min);
            let cell = [(x0 + TILE / 2).min(w - 1), (y0 + TILE / 2).min(h - 1)];
            let cells = squares.at(cell[1] as usize * w as usize + cell[0] as usize).map_or(f64::INFINITY, |d| d * self.resolution);
            // No centre in the tile is farther than 0.75 sides from its middle, or 1.5 from that cell at the border of the map.
            if nearest - 0.75 * reach > cells + 1.5 * reach {
                continue;
            }
            near.retain(|n| n.0 <= nearest + 2.0 * reach);
            for (y, x) in (y0..y1).flat_map(|y| (x0..x1).map(move |x| (y, x))) {
                let p = self.cell_to_map([f64::from(x) + 0.5, f64::from(y) + 0.5]);
                out[y as usize * w as usize + x as usize] = near.iter().map(|n| n.1.distance(p)).fold(f64::INFINITY, f64::min);
            }
        }
        out
    }

    /// The lattice that grid planners see for a disc of radius `radius` (m); built once per radius and kept.
    pub fn lattice(&self, radius: f64) -> Arc<Lattice> {
        let key = radius.to_bits();
        let mut kept = self.lattices.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        if let Some((_, lattice)) = kept.iter().find(|(k, _)| *k == key) {
            return Arc::clone(lattice);
        }
        let lattice = Arc::new(Lattice::build(self, radius));
        if kept.len() >= 4 {
            kept.remove(0);
        }
        kept.push((key, Arc::clone(&lattice)));
        lattice
    }
}

/// Columns and rows that cover `bounds`.
fn cells_of([x0, y0, x1, y1]: [f64; 4], resolution: f64) -> [f64; 2] {
    [((x1 - x0) / resolution).ceil(), ((y1 - y0) / resolution).ceil()]
}
