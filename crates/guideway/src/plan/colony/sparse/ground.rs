//! Squares that the robot's reference point may enter: the free cells for a point on a grid, small squares that are clear all over otherwise.

use crate::Point;
use crate::plan::search::runs::{is_free, run_at, runs_over};
use crate::query::Query;
use crate::world::{Bits, Corners, Lattice, World};
use std::f64::consts::FRAC_1_SQRT_2;

/// Squares per side of a cell where the free space is approximated: so many to the radius, within these bounds.
const PER_RADIUS: f64 = 8.0;
const FINE: [f64; 2] = [2.0, 8.0];
/// Most squares of a map; larger maps are not divided.
const MOST: u64 = 1 << 27;
/// How far from an end a free square is looked for, cells.
const REACH: i32 = 3;

/// Free squares of a world for one robot.
pub(super) struct Ground {
    free: Bits,
    fine: u32,
    exact: bool,
    pub squeeze: bool,
}

impl Ground {
    pub fn new(query: &Query, lattice: &Lattice) -> Self {
        let (world, radius) = (&query.world, query.radius());
        if radius == 0.0 && world.grid().is_some() && world.shapes().is_empty() {
            return Self { free: lattice.free().clone(), fine: 1, exact: true, squeeze: query.corners == Corners::Squeeze };
        }
        let [w, h] = world.cells();
        let wished = (PER_RADIUS * world.resolution() / radius).clamp(FINE[0], FINE[1]) as u32;
        let fits = |fine: &u32| u64::from(w) * u64::from(h) * u64::from(fine * fine) <= MOST;
        let fine = (1..=wished).rev().find(fits).unwrap_or(1);
        let mut free = Bits::new(w * fine, h * fine);
        for y in 0..h * fine {
            fill(&mut free, y, [0, i64::from(w * fine) - 1], true);
        }
        keep_off_cells(&mut free, world, radius, fine);
        keep_off_shapes(&mut free, world, radius, fine);
        Self { free, fine, exact: false, squeeze: false }
    }

    pub fn free(&self) -> &Bits {
        &self.free
    }
    /// Squares per side of a cell.
    pub fn fine(&self) -> f64 {
        f64::from(self.fine)
    }
    /// Are the squares exactly the free space?
    pub fn exact(&self) -> bool {
        self.exact
    }
    pub fn to_map(&self, query: &Query, q: Point) -> Point {
        query.world.cell_to_map(q.map(|v| v / self.fine()))
    }
    fn ground_at(&self, query: &Query, p: Point) -> Point {
        let q = match query.world.grid() {
            Some(grid) => grid.to_cells(p),
            None => [0, 1].map(|k| (p[k] - query.world.bounds()[k]) / query.world.resolution()),
        };
        q.map(|v| v * self.fine())
    }
    /// Is the straight way free? Exact.
    pub fn sees(&self, query: &Query, a: Point, b: Point) -> bool {
        query.world.segment_free(self.to_map(query, a), self.to_map(query, b), query.radius())
    }

    /// Where a point of the map stands: there, or on the nearest free square that it sees.
    pub fn foot(&self, query: &Query, p: Point) -> Option<Point> {
        let at = self.ground_at(query, p);
        let [x, y] = at.map(|v| v.floor() as i32);
        if self.own(at).is_some() {
            return Some(at);
        }
        let reach = REACH * self.fine as i32;
        let around = (y - reach..=y + reach).flat_map(|y| (x - reach..=x + reach).map(move |x| [x, y]));
        let mut near: Vec<(f64, Point)> = around
            .filter(|c| is_free(&self.free, c[0], c[1]))
            .map(|c| c.map(|v| f64::from(v) + 0.5))
            .map(|c| ((c[0] - at[0]).powi(2) + (c[1] - at[1]).powi(2), c))
            .collect();
        near.sort_by(|a, b| a.0.total_cmp(&b.0));
        near.into_iter().map(|n| n.1).find(|c| query.world.segment_free(p, self.to_map(query, *c), query.radius()))
    }

    /// A free square that holds a point, its rim included.
    fn own(&self, at: Point) -> Option<[i32; 2]> {
        let sides = |v: f64| if v.fract() == 0.0 { vec![v as i32, v as i32 - 1] } else { vec![v as i32] };
        sides(at[1]).into_iter().flat_map(|y| sides(at[0]).into_iter().map(move |x| [x, y])).find(|c| is_free(&self.free, c[0], c[1]))
    }

    /// Can one get from one point to another over free squares? For exact ground the lattice has proved it.
    pub fn joined(&self, ends: [Point; 2]) -> bool {
        let [Some(a), Some(b)] = ends.map(|p| self.own(p)) else { return false };
        if self.exact {
            return true;
        }
        let goal = run_at(&self.free, b[0], b[1]);
        let mut seen = Bits::new(self.free.width(), self.free.height());
        let mut queue = vec![(run_at(&self.free, a[0], a[1]), a[1])];
        while let Some((run, y)) = queue.pop() {
            if y == b[1] && run == goal {
                return true;
            }
            if seen.at(run.a as u32, y as u32) {
                continue;
            }
            seen.set(run.a as u32, y as u32, true);
            for next in [y - 1, y + 1] {
                queue.extend(runs_over(&self.free, next, f64::from(run.a), f64::from(run.b)).map(|r| (r, next)));
            }
        }
        false
    }
}

/// Sets the bits `x0..=x1` of a row, clipped to it.
fn fill(bits: &mut Bits, y: u32, [x0, x1]: [i64; 2], on: bool) {
    let (x0, x1) = (x0.max(0), x1.min(i64::from(bits.width()) - 1));
    if x0 > x1 {
        return;
    }
    let (first, last) = ((x0 >> 6) as usize, (x1 >> 6) as usize);
    let row = bits.row_mut(y);
    for (i, word) in row.iter_mut().enumerate().take(last + 1).skip(first) {
        let mut mask = !0u64;
        if i == first {
            mask &= !0 << (x0 & 63);
        }
        if i == last {
            mask &= !0 >> (63 - (x1 & 63));
        }
        if on { *word |= mask } else { *word &= !mask }
    }
}

/// Takes away the squares that are nearer to a blocked cell than the radius anywhere: distances between squares are exact.
fn keep_off_cells(free: &mut Bits, world: &World, radius: f64, fine: u32) {
    let Some(grid) = world.grid() else { return };
    let reach = (radius / grid.resolution() * f64::from(fine) - 1e-9).max(0.0);
    let (blocked, fine) = (grid.blocked(), i64::from(fine));
    let far = reach.ceil() as i64;
    for y in 0..grid.height() {
        let mut x = 0;
        while x < grid.width()
            && let Some(a) = blocked.first(y, x, grid.width() - 1, true)
        {
            let b = blocked.first(y, a, grid.width() - 1, false).unwrap_or(grid.width());
            x = b;
            let (bottom, top) = (i64::from(y) * fine, (i64::from(y) + 1) * fine);
            for row in (bottom - far).max(0)..(top + far).min(i64::from(free.height())) {
                let gap = (bottom - row - 1).max(row - top).max(0) as f64;
                if gap >= reach && !(bottom..top).contains(&row) {
                    continue;
                }
                let aside = ((reach * reach - gap * gap).max(0.0).sqrt().ceil()) as i64;
                fill(free, row as u32, [i64::from(a) * fine - aside, i64::from(b) * fine + aside - 1], false);
            }
        }
    }
}

/// Takes away the squares that are nearer to a shape than the radius anywhere, and a few that are not: the bound is the distance of the centre.
fn keep_off_shapes(free: &mut Bits, world: &World, radius: f64, fine: u32) {
    if world.shapes().is_empty() {
        return;
    }
    let (field, [w, h]) = (world.clearance_field(), world.cells());
    let (cell, half) = (world.resolution() * FRAC_1_SQRT_2, world.resolution() * FRAC_1_SQRT_2 / f64::from(fine));
    for (x, y) in (0..h).flat_map(|y| (0..w).map(move |x| (x, y))) {
        if field.at([x, y]) >= radius + cell {
            continue;
        }
        for (i, j) in (0..fine).flat_map(|j| (0..fine).map(move |i| (x * fine + i, y * fine + j))) {
            let center = world.cell_to_map([i, j].map(|v| (f64::from(v) + 0.5) / f64::from(fine)));
            if world.shapes().iter().any(|s| s.distance(center) < radius + half) {
                free.set(i, j, false);
            }
        }
    }
}
