//! The circles a taut path bends around: inflated discs, and corners of blocked cells and polygons with the robot's radius, each with the arcs that
//! are exposed, that is, not covered by another inflated obstacle.

use crate::Point;
use crate::world::shape::{cross, distance, norm, sub};
use crate::world::{ClearanceField, Grid, Shape, World};
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// Distances that count as touching, m.
pub(super) const TOUCH: f64 = 1e-9;
/// Angles that count as equal, rad.
pub(super) const ANGLE: f64 = 1e-9;
/// Windows are not split below this angle, rad.
const WINDOW: f64 = 0.1;
/// Windows up to this angle are looked at with exact clearances, rad.
const CLOSE: f64 = 0.25;

/// Angles `from` to `from + extent`, counter-clockwise, seen from a circle's centre, rad.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Arc {
    pub from: f64,
    pub extent: f64,
    ends: [Point; 2],
}

impl Arc {
    pub fn new(from: f64, extent: f64) -> Self {
        let at = |t: f64| [t.cos(), t.sin()];
        Self { from, extent, ends: [at(from), at(from + extent)] }
    }

    pub fn is_full(&self) -> bool {
        self.extent >= TAU - ANGLE
    }

    /// Does the unit vector `v` point into the arc?
    #[inline]
    pub fn holds(&self, v: Point) -> bool {
        let [a, b] = self.ends;
        if self.extent <= PI {
            cross(a, v) >= -ANGLE && cross(v, b) >= -ANGLE && (self.extent > ANGLE || a[0] * v[0] + a[1] * v[1] > 0.0)
        } else {
            self.is_full() || !(cross(b, v) > ANGLE && cross(v, a) > ANGLE)
        }
    }

    /// Position of the angle within the arc, 0 to `extent`.
    pub fn position(&self, angle: f64) -> f64 {
        let r = (angle - self.from).rem_euclid(TAU);
        if self.is_full() || r <= self.extent {
            r
        } else if r - self.extent < TAU - r {
            self.extent
        } else {
            0.0
        }
    }
}

/// A circle with the arcs that may be exposed (a superset, cheap) or are (exact).
#[derive(Debug, Clone)]
pub(super) struct Circle {
    pub center: Point,
    pub radius: f64,
    pub arcs: Vec<Arc>,
    pub exact: bool,
}

/// Obstacles inflated by a robot's radius.
pub(in crate::plan) struct Inflated<'a> {
    pub world: &'a World,
    /// Radius of the robot, m.
    pub robot: f64,
}

impl Inflated<'_> {
    /// All circles that may be exposed and lie within `keep`.
    pub(super) fn circles(&self, keep: &dyn Fn(Point, f64) -> bool) -> Vec<Circle> {
        let field = self.world.clearance_field();
        let mut found = Vec::new();
        let mut add = |center: Point, radius: f64, from: f64, extent: f64| {
            if keep(center, radius) {
                let arcs = self.windows(&field, (center, radius), (from, extent));
                if !arcs.is_empty() {
                    found.push(Circle { center, radius, arcs, exact: false });
                }
            }
        };
        for shape in self.world.shapes() {
            match shape {
                Shape::Disc { center, radius } => add(*center, radius + self.robot, 0.0, TAU),
                Shape::Polygon { points } => {
                    for (corner, from, extent) in polygon_corners(points) {
                        add(corner, self.robot, from, extent);
                    }
                }
            }
        }
        if let Some(grid) = self.world.grid() {
            grid_corners(grid, &mut |corner, from| add(corner, self.robot, from, FRAC_PI_2));
        }
        found
    }

    /// Parts of the arc that are not proved covered: the clearance changes by no more than the way along the arc, or from the centre of a cell.
    fn windows(&self, field: &ClearanceField, (center, radius): (Point, f64), arc: (f64, f64)) -> Vec<Arc> {
        if radius == 0.0 {
            let free = self.world.clearance_within(center, self.robot + 2.0 * TOUCH) >= self.robot - TOUCH;
            return if free { vec![Arc::new(arc.0, arc.1)] } else { Vec::new() };
        }
        let mut kept: Vec<(f64, f64)> = Vec::new();
        let mut todo = vec![arc];
        while let Some((from, extent)) = todo.pop() {
            let p = on(center, radius, from + extent / 2.0);
            let needed = self.robot - radius * extent / 2.0 - TOUCH;
            let covered = self.at_most(field, p) < needed || extent <= CLOSE && self.world.clearance_within(p, self.robot) < needed;
            if covered {
                continue;
            }
            if extent > WINDOW {
                todo.push((from + extent / 2.0, extent / 2.0));
                todo.push((from, extent / 2.0));
                continue;
            }
            match kept.last_mut() {
                Some(last) if (last.0 + last.1 - from).abs() < ANGLE => last.1 += extent,
                _ => kept.push((from, extent)),
            }
        }
        kept.into_iter().map(|(from, extent)| Arc::new(from, extent)).collect()
    }

    /// Upper bound of the clearance at `p` from the centre of its cell, m.
    fn at_most(&self, field: &ClearanceField, p: Point) -> f64 {
        let q = match self.world.grid() {
            Some(grid) => grid.to_cells(p),
            None => [0, 1].map(|k| (p[k] - self.world.bounds()[k]) / self.world.resolution()),
        };
        if !(q[0] >= 0.0 && q[1] >= 0.0 && q[0] < f64::from(field.width()) && q[1] < f64::from(field.height())) {
            return f64::INFINITY;
        }
        let cell = q.map(|v| v as u32);
        let off = [0, 1].map(|k| q[k] - f64::from(cell[k]) - 0.5);
        field.at(cell) + ((off[0] * off[0] + off[1] * off[1]).sqrt() + 1e-9) * self.world.resolution()
    }

    /// Replaces a circle's windows by its exposed arcs: they end where the circle meets the border of another inflated obstacle or of the world.
    pub(super) fn settle(&self, circle: &mut Circle) {
        if circle.exact {
            return;
        }
        circle.exact = true;
        if circle.radius == 0.0 {
            return;
        }
        let cuts = self.cuts(circle);
        let mut exposed: Vec<(f64, f64)> = Vec::new();
        for window in &circle.arcs {
            let mut stops: Vec<f64> = cuts.iter().map(|c| (c - window.from).rem_euclid(TAU)).filter(|&r| r < window.extent).collect();
            stops.extend([0.0, window.extent]);
            stops.sort_by(f64::total_cmp);
            for w in stops.windows(2) {
                let p = on(circle.center, circle.radius, window.from + f64::midpoint(w[0], w[1]));
                if w[1] - w[0] < 1e-13 || !self.world.contains(p) || self.world.clearance_within(p, self.robot) < self.robot - TOUCH {
                    continue;
                }
                match exposed.last_mut() {
                    Some(last) if (last.0 + last.1 - window.from - w[0]).abs() < 1e-12 => last.1 += w[1] - w[0],
                    _ => exposed.push((window.from + w[0], w[1] - w[0])),
                }
            }
        }
        // A full circle was cut open at angle 0.
        if exposed.len() > 1 && exposed[0].0 == 0.0 && (exposed[exposed.len() - 1].0 + exposed[exposed.len() - 1].1 - TAU).abs() < 1e-12 {
            let first = exposed.remove(0);
            if let Some(last) = exposed.last_mut() {
                last.1 += first.1;
            }
        }
        circle.arcs = exposed.into_iter().map(|(from, extent)| Arc::new(from, extent)).collect();
    }

    /// Angles where the circle meets the border of an inflated obstacle or of the world (and some where it does not).
    fn cuts(&self, circle: &Circle) -> Vec<f64> {
        let (c, r, robot) = (circle.center, circle.radius, self.robot);
        let mut cuts = Vec::new();
        for shape in self.world.shapes() {
            match shape {
                Shape::Disc { center, radius } => meet_circle(c, r, *center, radius + robot, &mut cuts),
                Shape::Polygon { points } => {
                    for (i, &a) in points.iter().enumerate() {
                        meet_circle(c, r, a, robot, &mut cuts);
                        let b = points[(i + 1) % points.len()];
                        let l = distance(a, b).max(1e-300);
                        let normal = [(b[1] - a[1]) / l, (a[0] - b[0]) / l];
                        meet_line(c, r, normal, normal[0] * a[0] + normal[1] * a[1] + robot, &mut cuts);
                    }
                }
            }
        }
        let [x0, y0, x1, y1] = self.world.bounds();
        if let Some(grid) = self.world.grid() {
            grid_cuts(grid, circle, robot, &mut cuts);
        } else {
            for (normal, offset) in [([1.0, 0.0], x0), ([1.0, 0.0], x1), ([0.0, 1.0], y0), ([0.0, 1.0], y1)] {
                meet_line(c, r, normal, offset, &mut cuts);
            }
        }
        cuts
    }
}

/// The point of a circle at an angle.
pub(super) fn on(center: Point, radius: f64, angle: f64) -> Point {
    let (s, c) = angle.sin_cos();
    [center[0] + radius * c, center[1] + radius * s]
}

/// Corners of a convex polygon with their cone of outward normals: (corner, from, extent).
fn polygon_corners(points: &[Point]) -> impl Iterator<Item = (Point, f64, f64)> + '_ {
    let n = points.len();
    (0..n).filter_map(move |i| {
        let (e, f) = (sub(points[i], points[(i + n - 1) % n]), sub(points[(i + 1) % n], points[i]));
        let extent = cross(e, f).atan2(e[0] * f[0] + e[1] * f[1]);
        (extent > 1e-12 && norm(e) > 0.0).then(|| (points[i], (-e[0]).atan2(e[1]), extent))
    })
}

/// Convex corners of the blocked region inside the grid: `add(corner in the map frame, angle where its quarter arc begins)`.
fn grid_corners(grid: &Grid, add: &mut dyn FnMut(Point, f64)) {
    let (bits, yaw) = (grid.blocked(), grid.origin()[2]);
    for y in 1..grid.height() {
        let (below, above) = (bits.row(y - 1), bits.row(y));
        for k in 0..below.len() {
            let shifted = |row: &[u64]| row[k] << 1 | if k > 0 { row[k - 1] >> 63 } else { 0 };
            let cells = [shifted(below), below[k], shifted(above), above[k]];
            for (i, from) in [(0, 0.0), (1, FRAC_PI_2), (2, -FRAC_PI_2), (3, PI)] {
                let mut alone = cells[i] & !(0..4).filter(|&j| j != i).fold(0, |acc, j| acc | cells[j]);
                while alone != 0 {
                    let x = k as u32 * 64 + alone.trailing_zeros();
                    alone &= alone - 1;
                    if x > 0 && x < grid.width() {
                        add(grid.to_map([f64::from(x), f64::from(y)]), from + yaw);
                    }
                }
            }
        }
    }
}

/// Angles at which a circle meets another one.
fn meet_circle(c: Point, r: f64, other: Point, radius: f64, cuts: &mut Vec<f64>) {
    let (d, v) = (distance(c, other), sub(other, c));
    if d <= 0.0 || d > r + radius || d < (r - radius).abs() {
        return;
    }
    let half = ((d * d + r * r - radius * radius) / (2.0 * d * r)).clamp(-1.0, 1.0).acos();
    let middle = v[1].atan2(v[0]);
    cuts.extend([middle - half, middle + half]);
}

/// Angles at which a circle meets the line `normal . p = offset` (unit normal).
fn meet_line(c: Point, r: f64, normal: Point, offset: f64, cuts: &mut Vec<f64>) {
    let k = (offset - normal[0] * c[0] - normal[1] * c[1]) / r;
    if k.abs() <= 1.0 {
        let (middle, half) = (normal[1].atan2(normal[0]), k.acos());
        cuts.extend([middle - half, middle + half]);
    }
}

/// Meetings with inflated cells: circles around the corners of blocked cells, lines beside their edges, and the border of the grid.
fn grid_cuts(grid: &Grid, circle: &Circle, robot: f64, cuts: &mut Vec<f64>) {
    let (scale, yaw) = (grid.resolution(), grid.origin()[2]);
    let (c, r, robot) = (grid.to_cells(circle.center), circle.radius / scale, robot / scale);
    let size = [f64::from(grid.width()), f64::from(grid.height())];
    let range = |k: usize| {
        let reach = r + robot + 1.0;
        (((c[k] - reach).floor().max(0.0)) as i64, ((c[k] + reach).ceil().min(size[k])) as i64)
    };
    let first = cuts.len();
    let blocked =
        |x: i64, y: i64| x >= 0 && y >= 0 && x < i64::from(grid.width()) && y < i64::from(grid.height()) && grid.blocked().at(x as u32, y as u32);
    let ((x0, x1), (y0, y1)) = (range(0), range(1));
    for y in y0..=y1 {
        for x in x0..=x1 {
            let cells = [blocked(x - 1, y - 1), blocked(x, y - 1), blocked(x - 1, y), blocked(x, y)];
            if cells.iter().any(|&b| b) && !cells.iter().all(|&b| b) {
                meet_circle(c, r, [x as f64, y as f64], robot, cuts);
            }
        }
    }
    for (normal, lo, hi, end) in [([1.0, 0.0], x0, x1, size[0]), ([0.0, 1.0], y0, y1, size[1])] {
        for line in lo..=hi {
            meet_line(c, r, normal, line as f64 - robot, cuts);
            meet_line(c, r, normal, line as f64 + robot, cuts);
        }
        meet_line(c, r, normal, 0.0, cuts);
        meet_line(c, r, normal, end, cuts);
    }
    for angle in &mut cuts[first..] {
        *angle += yaw;
    }
}
