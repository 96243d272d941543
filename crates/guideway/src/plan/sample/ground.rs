//! What sampling planners ask of the world: free points, free straight ways, steps towards a point.

use crate::Point;
use crate::query::Query;
use crate::world::{World, shape};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

/// Draws until one is free, at most; then the iteration goes by without a sample.
const DRAWS: u32 = 100;
/// Step where none is given, share of the diagonal of the world.
const STEP: f64 = 0.1;

/// One leg as samplers see it.
pub(super) struct Ground<'a> {
    world: &'a World,
    radius: f64,
    /// Longest edge, m.
    pub step: f64,
    halvings: u32,
    /// Straight ways looked at.
    pub checks: u64,
}

impl<'a> Ground<'a> {
    pub fn new(query: &'a Query, step: Option<f64>, halvings: u32) -> Self {
        let [x0, y0, x1, y1] = query.world.bounds();
        let step = step.unwrap_or(STEP * (x1 - x0).hypot(y1 - y0));
        Self { world: &query.world, radius: query.radius(), step, halvings, checks: 0 }
    }

    /// Area of the rectangle that samples are drawn from, m2.
    pub fn area(&self) -> f64 {
        let [x0, y0, x1, y1] = self.world.bounds();
        (x1 - x0) * (y1 - y0)
    }

    /// Is the straight way free? Exact.
    pub fn free(&mut self, a: Point, b: Point) -> bool {
        self.checks += 1;
        self.world.segment_free(a, b, self.radius)
    }

    /// Does the robot fit at `p`?
    pub fn fits(&self, p: Point) -> bool {
        self.world.fits(p, self.radius)
    }

    /// A random point where the robot fits.
    pub fn random(&self, rng: &mut ChaCha8Rng) -> Option<Point> {
        self.drawn(|| self.anywhere(rng))
    }

    /// A point of `draw` where the robot fits.
    pub fn drawn(&self, mut draw: impl FnMut() -> Point) -> Option<Point> {
        (0..DRAWS).map(|_| draw()).find(|p| self.fits(*p))
    }

    /// A random point of the bounds.
    pub fn anywhere(&self, rng: &mut ChaCha8Rng) -> Point {
        let [x0, y0, x1, y1] = self.world.bounds();
        [rng.random_range(x0..=x1), rng.random_range(y0..=y1)]
    }

    /// The end of a free step from `from` towards `to`, and is that `to`? Where the way is not free, halves of it are tried.
    pub fn steer(&mut self, from: Point, to: Point) -> Option<(Point, bool)> {
        let d = shape::distance(from, to);
        if d == 0.0 {
            return None;
        }
        let near = d <= self.step;
        (0..=self.halvings).find_map(|k| {
            let t = d.min(self.step) / d * 0.5f64.powi(k as i32);
            let (whole, p) = (near && k == 0, [from[0] + t * (to[0] - from[0]), from[1] + t * (to[1] - from[1])]);
            let p = if whole { to } else { p };
            (p != from && self.free(from, p)).then_some((p, whole))
        })
    }
}
