//! Exact first hits of a fan of rays from one point: discs and edges touch only the rays in their angle, cells are walked ray by ray.

use super::Outline;
use crate::Point;
use crate::world::{Grid, Shape};
use std::f64::consts::{PI, TAU};

/// Angles are padded by this against rounding, rad.
const PAD: f64 = 1e-9;

/// A fan of rays and how far each one got.
pub(super) struct Rays {
    origin: Point,
    /// Direction of the first ray, map frame, and from ray to ray, rad.
    first: f64,
    step: f64,
    /// Unit vectors, map frame.
    along: Vec<Point>,
    /// m.
    hits: Vec<f64>,
    range: f64,
}

impl Rays {
    /// `count` rays from the direction `first` against the heading of `pose` on; hits beyond `range` (m) are none.
    pub fn new(pose: [f64; 3], (first, step, count): (f64, f64, usize), range: f64) -> Self {
        let start = pose[2] + first;
        let along = (0..count).map(|i| (start + step * i as f64).sin_cos()).map(|(s, c)| [c, s]).collect();
        Self { origin: [pose[0], pose[1]], first: start, step, along, hits: vec![f64::INFINITY; count], range }
    }

    /// Ranges, m; infinite where nothing was hit within range.
    pub fn into_ranges(mut self) -> Vec<f64> {
        for r in &mut self.hits {
            if *r > self.range {
                *r = f64::INFINITY;
            }
        }
        self.hits
    }

    /// All shapes.
    pub fn shapes(&mut self, shapes: &[Shape]) {
        for shape in shapes {
            match shape {
                Shape::Disc { center, radius } => self.disc(*center, *radius),
                Shape::Polygon { points } => self.polygon(points, ([0.0; 2], 0.0)),
            }
        }
    }

    /// A mover's outline at a position.
    pub fn outline(&mut self, outline: &Outline, at: Point) {
        match outline.points[..] {
            [p] => self.disc([p[0] + at[0], p[1] + at[1]], outline.radius),
            _ => self.polygon(&outline.points, (at, outline.radius)),
        }
    }

    fn disc(&mut self, center: Point, radius: f64) {
        let m = [center[0] - self.origin[0], center[1] - self.origin[1]];
        let d = m[0].hypot(m[1]);
        if d <= radius {
            self.hits.fill(0.0);
            return;
        }
        if d - radius > self.range {
            return;
        }
        let square = d * d - radius * radius;
        self.within(m[1].atan2(m[0]), (radius / d).asin(), |u| {
            let b = u[0] * m[0] + u[1] * m[1];
            let c = u[0] * m[1] - u[1] * m[0];
            let root = radius * radius - c * c;
            // The nearer of the two crossings, in the form that does not cancel.
            (root >= 0.0 && b > 0.0).then(|| square / (b + root.sqrt()))
        });
    }

    /// A convex polygon (counter-clockwise), moved and grown by a radius.
    fn polygon(&mut self, points: &[Point], (at, radius): (Point, f64)) {
        let n = points.len();
        let place = |i: usize| [points[i % n][0] + at[0], points[i % n][1] + at[1]];
        let (mut inside, mut near) = (n > 2, false);
        for i in 0..n {
            let (a, b) = (place(i), place(i + 1));
            let e = [b[0] - a[0], b[1] - a[1]];
            let length = e[0].hypot(e[1]);
            let side = e[0] * (self.origin[1] - a[1]) - e[1] * (self.origin[0] - a[0]);
            inside &= side >= 0.0;
            near |= crate::world::shape::point_segment(self.origin, a, b) <= radius;
            if length > 0.0 && side < 0.0 {
                let out = [e[1] / length * radius, -e[0] / length * radius];
                self.edge([a[0] + out[0], a[1] + out[1]], [b[0] + out[0], b[1] + out[1]]);
            }
            if radius > 0.0 {
                self.disc(a, radius);
            }
        }
        if inside || near {
            self.hits.fill(0.0);
        }
    }

    fn edge(&mut self, a: Point, b: Point) {
        let (p, q) = ([a[0] - self.origin[0], a[1] - self.origin[1]], [b[0] - self.origin[0], b[1] - self.origin[1]]);
        let (from, to) = (p[1].atan2(p[0]), q[1].atan2(q[0]));
        let half = 0.5 * (to - from + PI).rem_euclid(TAU) - 0.5 * PI;
        let e = [q[0] - p[0], q[1] - p[1]];
        let area = p[0] * e[1] - p[1] * e[0];
        self.within(from + half, half.abs(), |u| {
            let det = u[0] * e[1] - u[1] * e[0];
            let t = area / det;
            (t >= 0.0).then_some(t)
        });
    }

    /// Lowers the hits of the rays within `half` rad of the direction `middle`.
    fn within(&mut self, middle: f64, half: f64, hit: impl Fn(Point) -> Option<f64>) {
        let n = self.hits.len() as i64;
        let low = (middle - half - PAD - self.first).rem_euclid(TAU);
        let width = 2.0 * (half + PAD);
        // The fan may cover the interval twice: at its beginning and at its end.
        for start in [low - TAU, low] {
            let i0 = ((start / self.step).ceil() as i64).max(0);
            let i1 = (((start + width) / self.step).floor() as i64).min(n - 1);
            for i in i0..=i1 {
                if let Some(t) = hit(self.along[i as usize])
                    && t < self.hits[i as usize]
                {
                    self.hits[i as usize] = t;
                }
            }
        }
    }

    /// The blocked cells.
    pub fn grid(&mut self, grid: &Grid) {
        let scale = grid.resolution();
        let from = grid.to_cells(self.origin);
        for (u, hit) in self.along.iter().zip(&mut self.hits) {
            let reach = hit.min(self.range) / scale;
            let ahead = grid.to_cells([self.origin[0] + u[0], self.origin[1] + u[1]]);
            let dir = [(ahead[0] - from[0]) * scale, (ahead[1] - from[1]) * scale];
            let mut found = f64::INFINITY;
            walk(from, dir, reach, [grid.width(), grid.height()], |[x, y], t| {
                let on = grid.blocked().at(x, y);
                if on {
                    found = t;
                }
                !on
            });
            *hit = hit.min(found * scale);
        }
    }
}

/// Visits the cells of a grid of `size` along a ray from `from` (cells) in the unit direction `dir` up to the length `reach` (cells), in order, with the
/// length at which each is entered; ends when `visit` says no. A ray that starts outside enters the grid where it meets it.
pub(super) fn walk(from: Point, dir: Point, reach: f64, size: [u32; 2], mut visit: impl FnMut([u32; 2], f64) -> bool) {
    let Some([enter, leave]) = span(from, dir, reach, size) else { return };
    let (mut cell, mut step, mut next, mut delta) = ([0_i64; 2], [0_i64; 2], [f64::INFINITY; 2], [f64::INFINITY; 2]);
    for k in 0..2 {
        let at = from[k] + enter * dir[k];
        cell[k] = (at.floor() as i64).clamp(0, i64::from(size[k]) - 1);
        if dir[k] != 0.0 {
            step[k] = if dir[k] > 0.0 { 1 } else { -1 };
            delta[k] = 1.0 / dir[k].abs();
            next[k] = ((cell[k] + i64::from(dir[k] > 0.0)) as f64 - from[k]) / dir[k];
        }
    }
    // Scalars: the loop is short, and every ray of every scan runs through it.
    let ([mut x, mut y], [mut across, mut up], mut t) = (cell, next, enter);
    let [w, h] = size.map(i64::from);
    while visit([x as u32, y as u32], t) {
        // Without a branch, which nobody could foretell.
        let rises = up < across;
        t = if rises { up } else { across };
        up += if rises { delta[1] } else { 0.0 };
        across += if rises { 0.0 } else { delta[0] };
        y += if rises { step[1] } else { 0 };
        x += if rises { 0 } else { step[0] };
        if t > leave || x < 0 || y < 0 || x >= w || y >= h {
            return;
        }
    }
}

/// The lengths at which a ray of at most the length `reach` enters and leaves a grid of `size`, all in cells, if it meets it.
pub(super) fn span(from: Point, dir: Point, reach: f64, size: [u32; 2]) -> Option<[f64; 2]> {
    let (mut enter, mut leave) = (0.0_f64, reach);
    for k in 0..2 {
        let (a, b) = (-from[k] / dir[k], (f64::from(size[k]) - from[k]) / dir[k]);
        if dir[k] == 0.0 {
            if !(0.0..=f64::from(size[k])).contains(&from[k]) {
                return None;
            }
            continue;
        }
        (enter, leave) = (enter.max(a.min(b)), leave.min(a.max(b)));
    }
    (enter <= leave && dir[0].is_finite() && dir[1].is_finite()).then_some([enter, leave])
}
