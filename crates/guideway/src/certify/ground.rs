//! Distances by looking at every obstacle in a window: nothing here is shared with the world's own queries.

use crate::Point;
use crate::world::shape::{cross, distance, dot, norm, sub};
use crate::world::{Bits, Grid, Shape, World};

/// The static obstacles of a world.
pub(super) struct Ground<'a> {
    pub world: &'a World,
    pub grid: Option<&'a Grid>,
    /// Is no cell blocked? Then no window needs to be looked at, however large.
    bare: bool,
}

impl<'a> Ground<'a> {
    pub fn new(world: &'a World) -> Self {
        let grid = world.grid();
        Self { world, grid, bare: grid.is_some_and(|g| g.blocked().count() == 0) }
    }

    /// Is `p` on the map, up to `slack` m?
    pub fn holds(&self, p: Point, slack: f64) -> bool {
        let (q, [x0, y0, x1, y1], slack) = match self.grid {
            Some(grid) => (grid.to_cells(p), [0.0, 0.0, f64::from(grid.width()), f64::from(grid.height())], slack / grid.resolution()),
            None => (p, self.world.bounds(), slack),
        };
        (x0 - slack..=x1 + slack).contains(&q[0]) && (y0 - slack..=y1 + slack).contains(&q[1])
    }

    /// Distance (m) between the convex body with corners `body` (one point, two, or a polygon counter-clockwise) and the nearest obstacle, if it is
    /// below `cap`, else `cap`. Not above zero when they overlap.
    pub fn gap(&self, body: &[Point], cap: f64) -> f64 {
        let shapes = self.shapes_gap(body, cap);
        let Some(grid) = self.grid else { return shapes };
        if self.bare && body.iter().flatten().all(|v| v.is_finite()) {
            return shapes;
        }
        let mut corners = [[0.0; 2]; 2];
        let scale = grid.resolution();
        if let Some(few) = corners.get_mut(..body.len()) {
            few.iter_mut().zip(body).for_each(|(c, p)| *c = grid.to_cells(*p));
            return shapes.min(scale * cells_gap(grid.blocked(), few, shapes / scale));
        }
        let corners: Vec<Point> = body.iter().map(|p| grid.to_cells(*p)).collect();
        shapes.min(scale * cells_gap(grid.blocked(), &corners, shapes / scale))
    }

    /// The same to the shapes alone.
    pub fn shapes_gap(&self, body: &[Point], cap: f64) -> f64 {
        self.world.shapes().iter().map(|s| shape_gap(s, body)).fold(cap, f64::min)
    }

    /// Is every cell that `p` touches (within `eps` m) blocked or outside the map?
    pub fn engulfs(&self, p: Point, eps: f64) -> bool {
        self.grid.is_some_and(|grid| {
            let (q, eps) = (grid.to_cells(p), eps / grid.resolution());
            let span = |v: f64| (v - eps).floor() as i64..=(v + eps).floor() as i64;
            let outside = |x: i64, y: i64| x.min(y) < 0 || x >= i64::from(grid.width()) || y >= i64::from(grid.height());
            span(q[1]).all(|y| span(q[0]).all(|x| outside(x, y) || set(grid.blocked(), x, y)))
        })
    }

    /// Distance from `p` to the nearest point outside the blocked cells, on the map or not, m.
    pub fn depth(&self, p: Point) -> f64 {
        let Some(grid) = self.grid else { return 0.0 };
        let q = grid.to_cells(p);
        let (x, y) = (q[0].floor() as i64, q[1].floor() as i64);
        let mut best = f64::INFINITY;
        for k in 0i64.. {
            if best <= k as f64 - 1.0 {
                break;
            }
            for j in -k..=k {
                let step = if j.abs() == k { 1 } else { 2 * k };
                for i in (-k..=k).step_by(step.max(1) as usize).filter(|i| !set(grid.blocked(), x + i, y + j)) {
                    best = best.min(point_square(q, (x + i) as f64, (y + j) as f64));
                }
            }
        }
        best * grid.resolution()
    }
}

/// Is the cell blocked? Not outside the map.
pub(super) fn set(blocked: &Bits, x: i64, y: i64) -> bool {
    x >= 0 && y >= 0 && x < i64::from(blocked.width()) && y < i64::from(blocked.height()) && blocked.at(x as u32, y as u32)
}

/// Least distance from the body to a set square, if below `best`; all in cells.
fn cells_gap(blocked: &Bits, body: &[Point], mut best: f64) -> f64 {
    let fold = |k: usize, f: fn(f64, f64) -> f64, start: f64| body.iter().map(|p| p[k]).fold(start, f);
    let low = [0, 1].map(|k| fold(k, f64::min, f64::INFINITY));
    let high = [0, 1].map(|k| fold(k, f64::max, f64::NEG_INFINITY));
    if !(low.iter().chain(&high).all(|v| v.is_finite())) {
        return f64::NEG_INFINITY;
    }
    let last = i64::from(blocked.height()) - 1;
    let middle = ((0.5 * (low[1] + high[1])).floor() as i64).clamp(0, last);
    for k in 0..=last {
        let rows = [middle + k, middle - k];
        let mut near = false;
        for &j in &rows[..if k == 0 { 1 } else { 2 }] {
            let away = (j as f64 - high[1]).max(low[1] - j as f64 - 1.0);
            near |= away < best;
            if away < best && (0..=last).contains(&j) {
                best = row_gap(blocked, j as u32, body, [low[0], high[0]], best);
            }
        }
        if !near {
            break;
        }
    }
    best
}

/// Least distance from the body to a set square of row `j`, if below `best`.
fn row_gap(blocked: &Bits, j: u32, body: &[Point], [low, high]: [f64; 2], mut best: f64) -> f64 {
    let last = i64::from(blocked.width()) - 1;
    let (first, end) = (((low - best - 1.0).floor().max(0.0) as i64), ((high + best).floor() as i64).min(last));
    if first > end {
        return best;
    }
    let words = blocked.row(j);
    for w in (first / 64)..=(end / 64) {
        let mut word = words[w as usize];
        while word != 0 {
            let i = 64 * w + i64::from(word.trailing_zeros());
            word &= word - 1;
            if i >= first && i <= end {
                best = best.min(square_gap(body, i as f64, f64::from(j), best));
            }
        }
    }
    best
}

/// Distance from a point to the square with lower left corner `(x, y)`.
fn point_square(q: Point, x: f64, y: f64) -> f64 {
    let (dx, dy) = ((x - q[0]).max(q[0] - x - 1.0).max(0.0), (y - q[1]).max(q[1] - y - 1.0).max(0.0));
    (dx * dx + dy * dy).sqrt()
}

/// Distance from a body to a square, if below `cap`.
fn square_gap(body: &[Point], x: f64, y: f64, cap: f64) -> f64 {
    if let [q] = body {
        return point_square(*q, x, y);
    }
    // Boxes around both tell most pairs apart.
    let away = |k: usize, v: f64| {
        let (low, high) = body.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), p| (l.min(p[k]), h.max(p[k])));
        (low - v - 1.0).max(v - high).max(0.0)
    };
    if away(0, x).hypot(away(1, y)) >= cap {
        return cap;
    }
    convex_gap(body, &[[x, y], [x + 1.0, y], [x + 1.0, y + 1.0], [x, y + 1.0]])
}

fn shape_gap(shape: &Shape, body: &[Point]) -> f64 {
    match shape {
        Shape::Disc { center, radius } => convex_gap(body, std::slice::from_ref(center)) - radius,
        Shape::Polygon { points } => convex_gap(body, points),
    }
}

/// Distance of two convex bodies; when they overlap, minus the least overlap seen along a normal of an edge.
fn convex_gap(a: &[Point], b: &[Point]) -> f64 {
    if let ([p], [q]) = (a, b) {
        return distance(*p, *q);
    }
    let apart = separation(a, b).max(separation(b, a));
    if apart <= 0.0 && (a.len() > 2 || b.len() > 2) {
        return apart;
    }
    corner_gap(a, b).min(corner_gap(b, a))
}

/// Largest distance between the two along an outward normal of an edge of `a`.
fn separation(a: &[Point], b: &[Point]) -> f64 {
    let n = a.len();
    let mut best = f64::NEG_INFINITY;
    for i in 0..n {
        let e = sub(a[(i + 1) % n], a[i]);
        let length = norm(e);
        if length > 0.0 {
            best = best.max(b.iter().map(|p| cross(sub(*p, a[i]), e)).fold(f64::INFINITY, f64::min) / length);
        }
    }
    best
}

/// Least distance from a corner of `a` to an edge of `b`.
fn corner_gap(a: &[Point], b: &[Point]) -> f64 {
    let n = b.len();
    let mut best = f64::INFINITY;
    for (i, &s) in b.iter().enumerate() {
        let e = sub(b[(i + 1) % n], s);
        let square = dot(e, e);
        for &p in a {
            let v = sub(p, s);
            let t = if square > 0.0 { (dot(v, e) / square).clamp(0.0, 1.0) } else { 0.0 };
            best = best.min(norm([v[0] - t * e[0], v[1] - t * e[1]]));
        }
    }
    best
}

/// Convex hull, counter-clockwise.
pub(super) fn hull(mut points: Vec<Point>) -> Vec<Point> {
    points.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
    points.dedup();
    if points.len() < 3 {
        return points;
    }
    let mut out: Vec<Point> = Vec::with_capacity(points.len() + 1);
    let half = |out: &mut Vec<Point>, p: Point, base: usize| {
        while out.len() >= base + 2 && cross(sub(out[out.len() - 1], out[out.len() - 2]), sub(p, out[out.len() - 1])) <= 0.0 {
            out.pop();
        }
        out.push(p);
    };
    for &p in &points {
        half(&mut out, p, 0);
    }
    let base = out.len() - 1;
    for &p in points.iter().rev().skip(1) {
        half(&mut out, p, base);
    }
    out.pop();
    out
}
