//! Cost-to-go: what the cheapest way to the goal costs from every place, by fast marching on the cells of the world.
//!
//! The field solves `|grad T| = F` with the upwind scheme on four neighbours, the same at any thread count: a queue of buckets in which a value that falls
//! is looked at again, so the result is the fixed point of the scheme whatever the width of the buckets.
//! `F` is 1 in the open, grows linearly to `1 + weight` over the soft clearance, and on to [`DEAR`] more where the body fits in some headings only. Diagonal moves
//! through a gap of width zero are none of the scheme's, and [`CostToGo::way`] keeps to that.

mod march;
mod way;

use crate::Point;
use crate::query::Soft;
use crate::world::World;
use march::march;

/// What a metre costs more where the robot just fits in its best heading than where it fits in every one.
pub const DEAR: f64 = 4.0;
/// Around the goal the field is exact within so many cells, where that is in sight.
const NEAR: i64 = 4;

/// Least cost to the goal from every place, in metres of open ground.
#[derive(Debug, Clone)]
pub struct CostToGo {
    frame: Frame,
    goal: Point,
    /// Costs of the cells in a frame of one cell, cells of open ground; infinite where blocked or cut off.
    cost: Vec<f32>,
    /// Cost of a cell's width there, same layout; infinite where blocked.
    slow: Vec<f32>,
}

/// Where the padded cells lie.
#[derive(Debug, Clone, Copy)]
struct Frame {
    origin: Point,
    rotation: [f64; 2],
    resolution: f64,
    size: [usize; 2],
}

impl Frame {
    fn of(world: &World) -> Self {
        let (a, b) = (world.cell_to_map([0.0, 0.0]), world.cell_to_map([1.0, 0.0]));
        let resolution = world.resolution();
        let rotation = [(b[0] - a[0]) / resolution, (b[1] - a[1]) / resolution];
        Self { origin: a, rotation, resolution, size: world.cells().map(|n| n as usize) }
    }
    /// In cells, the lower-left corner of cell (0, 0) at the origin.
    #[inline]
    fn cells(&self, p: Point) -> Point {
        let ([c, s], [dx, dy]) = (self.rotation, [p[0] - self.origin[0], p[1] - self.origin[1]]);
        [(c * dx + s * dy) / self.resolution, (c * dy - s * dx) / self.resolution]
    }
    fn map(&self, q: Point) -> Point {
        let ([c, s], [dx, dy]) = (self.rotation, [q[0] * self.resolution, q[1] * self.resolution]);
        [self.origin[0] + c * dx - s * dy, self.origin[1] + s * dx + c * dy]
    }
    fn stride(&self) -> usize {
        self.size[0] + 2
    }
    /// Padded index of cell (x, y); -1 and the size are the frame.
    #[inline]
    fn index(&self, x: i64, y: i64) -> usize {
        (y + 1) as usize * self.stride() + (x + 1) as usize
    }
    /// Padded index of the cell that holds a place, if one does.
    fn at(&self, p: Point) -> Option<usize> {
        let [x, y] = self.cells(p);
        let [w, h] = self.size.map(|n| n as f64);
        (x >= 0.0 && y >= 0.0 && x <= w && y <= h)
            .then(|| self.index((x as i64).min(self.size[0] as i64 - 1), (y as i64).min(self.size[1] as i64 - 1)))
    }
    fn center(&self, index: usize) -> Point {
        let (x, y) = (index % self.stride(), index / self.stride());
        self.map([x as f64 - 0.5, y as f64 - 0.5])
    }
}

impl CostToGo {
    /// The costs to `goal` (m) for a body with this inscribed and circumscribed radius (m): less clearance than the inscribed one blocks, less than the circumscribed one
    /// is dear. The cell of the goal counts as free whatever it is. A goal outside the world is reached from nowhere.
    pub fn new(world: &World, goal: Point, body: [f64; 2], soft: Soft) -> Self {
        let frame = Frame::of(world);
        let mut slow = slowness(world, frame, body, soft);
        let mut cost = vec![f32::INFINITY; slow.len()];
        if let Some(at) = frame.at(goal) {
            if slow[at].is_infinite() {
                slow[at] = (1.0 + soft.weight + DEAR) as f32;
            }
            let seeds = seeds(frame, &slow, goal, at);
            march(&mut cost, &slow, frame.stride(), &seeds);
        }
        Self { frame, goal, cost, slow }
    }

    /// The goal, m.
    pub fn goal(&self) -> Point {
        self.goal
    }

    /// Cost from `p` (m), in metres of open ground: between cell centres bilinear over those from which the goal can be reached. Infinite where none of the
    /// four around can.
    #[inline]
    pub fn at(&self, p: Point) -> f64 {
        let q = self.frame.cells(p);
        let (u, v) = (q[0] - 0.5, q[1] - 0.5);
        let (x, y) = (u.floor(), v.floor());
        let [w, h] = self.frame.size.map(|n| n as f64);
        if !(x >= -1.0 && y >= -1.0 && x < w && y < h) {
            return f64::INFINITY;
        }
        let (i, fx, fy) = (self.frame.index(x as i64, y as i64), u - x, v - y);
        let s = self.frame.stride();
        let around = [(i, (1.0 - fx) * (1.0 - fy)), (i + 1, fx * (1.0 - fy)), (i + s, (1.0 - fx) * fy), (i + s + 1, fx * fy)];
        let (mut sum, mut weight) = (0.0, 0.0);
        for (i, share) in around {
            let c = self.cost[i];
            if c < f32::INFINITY {
                // A trace of weight even at distance one: beside a wall some value is better than none.
                let share = share + 1e-9;
                sum += share * f64::from(c);
                weight += share;
            }
        }
        if weight > 0.0 { sum / weight * self.frame.resolution } else { f64::INFINITY }
    }
}

/// What a cell's width costs; infinite in the frame and where the body does not fit.
fn slowness(world: &World, frame: Frame, [inscribed, covering]: [f64; 2], soft: Soft) -> Vec<f32> {
    let field = world.clearance_field();
    let stride = frame.stride();
    let mut slow = vec![f32::INFINITY; stride * (frame.size[1] + 2)];
    let tight = (covering - inscribed).max(1e-9);
    let cost = |c: f64| {
        if c < inscribed || c < 0.0 {
            return f32::INFINITY;
        }
        let narrow = ((covering - c) / tight).clamp(0.0, 1.0);
        (soft.price(c - covering) + DEAR * narrow) as f32
    };
    field.map(cost, |x, y, f| slow[(y as usize + 1) * stride + x as usize + 1] = f);
    slow
}

/// Cells around the goal with their exact costs in cells: those within [`NEAR`] that a straight line over open cells reaches.
fn seeds(frame: Frame, slow: &[f32], goal: Point, at: usize) -> Vec<(usize, f32)> {
    let q = frame.cells(goal);
    let (cx, cy) = ((at % frame.stride()) as i64 - 1, (at / frame.stride()) as i64 - 1);
    let mut seeds = Vec::new();
    for y in (cy - NEAR).max(0)..=(cy + NEAR).min(frame.size[1] as i64 - 1) {
        for x in (cx - NEAR).max(0)..=(cx + NEAR).min(frame.size[0] as i64 - 1) {
            let (dx, dy) = (x as f64 + 0.5 - q[0], y as f64 + 0.5 - q[1]);
            let length = dx.hypot(dy);
            // Straight and open all along, cell by cell: the box between both holds the line.
            let open = |x: i64, y: i64| (slow[frame.index(x, y)] - 1.0).abs() < 1e-6;
            let (xs, ys) = (x.min(cx)..=x.max(cx), y.min(cy)..=y.max(cy));
            let all = ys.clone().all(|y| xs.clone().all(|x| open(x, y)));
            if frame.index(x, y) == at || (all && length <= NEAR as f64) {
                seeds.push((frame.index(x, y), (length * f64::from(slow[at])) as f32));
            }
        }
    }
    seeds
}

#[cfg(test)]
mod tests;
