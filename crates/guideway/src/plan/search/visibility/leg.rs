//! One leg of a query: picks the engine, sizes the search by a lower bound, and turns the result into points.

use super::circles::Inflated;
use super::rows::{Found, Rows};
use super::tangent::{Outcome, Tangents, polyline};
use crate::Point;
use crate::context::Context;
use crate::query::Query;
use crate::world::shape::distance;
use crate::world::{Bits, Corners, Lattice};
use std::f64::consts::FRAC_1_SQRT_2;
use std::sync::Arc;

/// Bounds that are tried in turn, relative to the lower bound.
const GROWTH: [f64; 4] = [1.02, 1.1, 1.4, f64::INFINITY];
/// Relative excess of the polyline over the exact length.
const EXCESS: f64 = 5e-7;

/// What one leg gave; lengths in m.
pub(in crate::plan) enum Route {
    /// The optimum as a polyline, and its exact length.
    Path { points: Vec<Point>, length: f64 },
    /// Proved: there is none.
    Nothing,
    /// Stopped; every path is at least that long.
    Stopped { bound: f64 },
}

/// Free cells of a relaxed map.
enum Relaxed {
    Own(Bits),
    Lattice(Arc<Lattice>),
}

/// Searches between pairs of points for the robot of one query.
pub(in crate::plan) struct Leg<'a> {
    query: &'a Query,
    /// Cells that the reference point may enter, exactly or at most: free in a relaxed map.
    relaxed: Option<Relaxed>,
    /// The relaxed map is the exact one.
    point: bool,
    /// Expansions of the last search.
    pub expansions: u64,
    /// Circles that the last search looked at.
    pub circles: u64,
}

impl<'a> Leg<'a> {
    pub fn new(query: &'a Query) -> Self {
        let (world, radius) = (&query.world, query.radius());
        // A point at distance `radius` from everything lies in a cell whose centre is nearer by half a diagonal at most.
        let inner = radius - (FRAC_1_SQRT_2 + 1e-9) * world.resolution();
        let relaxed = if inner > 0.0 {
            Some(Relaxed::Own(world.clearance_field().at_least(inner)))
        } else if world.grid().is_some() && world.shapes().is_empty() {
            Some(Relaxed::Lattice(world.lattice(0.0)))
        } else {
            None
        };
        let point = radius == 0.0 && world.grid().is_some() && world.shapes().is_empty();
        Self { query, relaxed, point, expansions: 0, circles: 0 }
    }

    pub fn solve(&mut self, ends: [Point; 2], ctx: &mut Context) -> Route {
        (self.expansions, self.circles) = (0, 0);
        let mut bound = distance(ends[0], ends[1]);
        let scale = self.query.world.resolution();
        if let Some(found) = self.rows(ends, ctx) {
            match found {
                Found::Path(points) if self.point => return self.point_route(&points, ends),
                Found::Path(points) => bound = bound.max(cells_length(&points) * scale * (1.0 - 1e-12)),
                Found::Nothing => return Route::Nothing,
                Found::Stopped { bound: cells } => return Route::Stopped { bound: bound.max(cells * scale) },
            }
        }
        let inflated = Inflated { world: &self.query.world, robot: self.query.radius() };
        for growth in GROWTH {
            let mut search = Tangents::new(&inflated, ends, bound * growth + inflated.robot);
            let outcome = search.solve(&mut || ctx.poll().is_some());
            self.expansions += search.expansions;
            self.circles += search.count();
            match outcome {
                Outcome::Path(pieces, length) => {
                    let mut points = polyline(&pieces, &inflated, EXCESS);
                    points.insert(0, ends[0]);
                    points.push(ends[1]);
                    return Route::Path { points, length };
                }
                Outcome::Stopped(f) => return Route::Stopped { bound: bound.max(f) },
                Outcome::Nothing => {}
            }
        }
        Route::Nothing
    }

    /// Searches the relaxed map, if there is one.
    fn rows(&mut self, ends: [Point; 2], ctx: &mut Context) -> Option<Found> {
        let free = match self.relaxed.as_ref()? {
            Relaxed::Own(bits) => bits,
            Relaxed::Lattice(lattice) => lattice.free(),
        };
        let squeeze = self.point && self.query.corners == Corners::Squeeze;
        let [start, goal] = ends.map(|p| self.to_cells(p));
        let mut rows = Rows::new(free, squeeze, start, goal);
        let found = rows.solve(&mut || ctx.poll().is_some());
        self.expansions += rows.expansions;
        Some(found)
    }

    fn to_cells(&self, p: Point) -> Point {
        let world = &self.query.world;
        match world.grid() {
            Some(grid) => grid.to_cells(p),
            None => [0, 1].map(|k| (p[k] - world.bounds()[k]) / world.resolution()),
        }
    }

    fn point_route(&self, cells: &[Point], ends: [Point; 2]) -> Route {
        let mut points: Vec<Point> = cells.iter().map(|&q| self.query.world.cell_to_map(q)).collect();
        let last = points.len() - 1;
        (points[0], points[last]) = (ends[0], ends[1]);
        let length = points.windows(2).map(|w| distance(w[0], w[1])).sum();
        Route::Path { points, length }
    }
}

fn cells_length(points: &[Point]) -> f64 {
    points.windows(2).map(|w| distance(w[0], w[1])).sum()
}
