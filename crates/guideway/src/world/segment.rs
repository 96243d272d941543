//! Straight motions against the blocked squares of a grid: exact tests, a row of bits at a time.
//!
//! Everything here is in the grid frame (cells). Outside the grid there is no obstacle to keep a distance from, but for a point, which may slide along
//! walls, the outside is one: between a blocked cell and the border of the grid there is no way.

use super::bits::Bits;
use crate::Point;

/// Does the capsule of radius `r` > 0 around `a b` stay out of every set closed square?
///
/// The capsule is convex, so its part within one row of cells projects onto one interval of columns: a row is one look at its bits.
pub(super) fn capsule_free(set: &Bits, a: Point, b: Point, r: f64) -> bool {
    let (a, b) = if a[1] <= b[1] { (a, b) } else { (b, a) };
    let last = i64::from(set.height()) - 1;
    let first_row = (((a[1] - r).ceil() as i64) - 1).max(0);
    let last_row = ((b[1] + r).floor() as i64).min(last);
    let capsule = Capsule::new(a, b, r);
    (first_row..=last_row).all(|j| {
        let (y0, y1) = (j as f64, (j + 1) as f64);
        let (x0, x1) = capsule.extent(y0.max(a[1] - r), y1.min(b[1] + r));
        !set.any(j as u32, x0.ceil() as i64 - 1, x1.floor() as i64)
    })
}

/// A segment with rounded ends; `a` is not above `b`.
struct Capsule {
    a: Point,
    b: Point,
    r: f64,
    /// Unit direction from `a` to `b`.
    u: Point,
    /// Heights at which the leftmost and the rightmost point lie: one is `a`'s, the other is `b`'s.
    ends: [f64; 2],
}

impl Capsule {
    fn new(a: Point, b: Point, r: f64) -> Self {
        let d = [b[0] - a[0], b[1] - a[1]];
        let length = d[0].hypot(d[1]);
        let u = if length > 0.0 { [d[0] / length, d[1] / length] } else { [0.0, 1.0] };
        let ends = if u[0] >= 0.0 { [a[1], b[1]] } else { [b[1], a[1]] };
        Self { a, b, r, u, ends }
    }

    /// Smallest and largest x of the capsule within `y0 <= y <= y1` (which it reaches).
    fn extent(&self, y0: f64, y1: f64) -> (f64, f64) {
        // The left boundary is a convex and the right one a concave function of y: each is extreme where it is nearest to its own extreme point.
        let pick = |y: f64| y.max(y0).min(y1);
        (self.boundary(pick(self.ends[0]), -1.0), self.boundary(pick(self.ends[1]), 1.0))
    }

    /// x of the boundary at height `y`; `side` is -1 for the left one and 1 for the right one.
    fn boundary(&self, y: f64, side: f64) -> f64 {
        let ([xa, ya], [xb, yb], r) = (self.a, self.b, self.r);
        // The straight part starts beside `a` and ends beside `b`, moved by r along the normal (side * u_y, -side * u_x).
        let lift = -side * self.u[0] * r;
        if y <= ya + lift {
            xa + side * (r * r - (y - ya) * (y - ya)).max(0.0).sqrt()
        } else if y >= yb + lift {
            xb + side * (r * r - (y - yb) * (y - yb)).max(0.0).sqrt()
        } else {
            let t = ((y - ya - lift) / (yb - ya)).clamp(0.0, 1.0);
            xa + side * self.u[1] * r + t * (xb - xa)
        }
    }
}

/// Does the convex polygon with these corners, grown by `r` >= 0, stay out of every set square? Squares count as smaller by `eps` on all sides.
///
/// The border of the grown polygon is made of borders of the capsules around its sides, so a row of it is as wide as theirs together.
pub(super) fn polygon_free(set: &Bits, corners: &[Point], r: f64, eps: f64) -> bool {
    let sides = corners.iter().zip(corners.iter().cycle().skip(1));
    let sides: Vec<Capsule> = sides.map(|(&a, &b)| if a[1] <= b[1] { Capsule::new(a, b, r) } else { Capsule::new(b, a, r) }).collect();
    let low = sides.iter().map(|c| c.a[1]).fold(f64::INFINITY, f64::min) - r;
    let high = sides.iter().map(|c| c.b[1]).fold(f64::NEG_INFINITY, f64::max) + r;
    let last = i64::from(set.height()) - 1;
    let (first_row, last_row) = ((low.floor() as i64).max(0), (high.floor() as i64).min(last));
    (first_row..=last_row).all(|j| {
        let (y0, y1) = (j as f64 + eps, (j + 1) as f64 - eps);
        let (mut x0, mut x1) = (f64::INFINITY, f64::NEG_INFINITY);
        for side in &sides {
            let (bottom, top) = (side.a[1] - r, side.b[1] + r);
            if bottom < y1 && top > y0 {
                let (left, right) = side.extent(y0.max(bottom), y1.min(top));
                (x0, x1) = (x0.min(left), x1.max(right));
            }
        }
        x0 > x1 || !set.any(j as u32, (x0 - 1.0 + eps).floor() as i64 + 1, (x1 - eps).ceil() as i64 - 1)
    })
}

/// Least distance from the segment `a b` to a set closed square if that is below `best`, else `best`; 0 if they meet.
pub(super) fn distance(set: &Bits, a: Point, b: Point, mut best: f64) -> f64 {
    let (a, b) = if a[1] <= b[1] { (a, b) } else { (b, a) };
    let last = i64::from(set.height()) - 1;
    let middle = (f64::midpoint(a[1], b[1]).floor() as i64).clamp(0, last);
    // From the middle row outwards; the capsule shrinks with what is found.
    for j in (middle..=last).chain((0..middle).rev()) {
        loop {
            let (y0, y1) = ((j as f64).max(a[1] - best), ((j + 1) as f64).min(b[1] + best));
            if best <= 0.0 || y0 > y1 {
                break;
            }
            let (x0, x1) = Capsule::new(a, b, best).extent(y0, y1);
            let (i0, i1) = ((x0.ceil() as i64 - 1).max(0), (x1.floor() as i64).min(i64::from(set.width()) - 1));
            let Some(i) = (i0 <= i1).then(|| set.first(j as u32, i0 as u32, i1 as u32, true)).flatten() else { break };
            let found = to_square(a, b, [f64::from(i), j as f64]);
            if found >= best {
                // Rounding at the rim: step over it.
                best = rest_of_row(set, j as u32, [i + 1, i1 as u32], (a, b, best));
                break;
            }
            best = found;
        }
    }
    best
}

/// Least distance from the segment to the set squares `i0..=i1` of row `j`, if below `best`.
fn rest_of_row(set: &Bits, j: u32, [mut i0, i1]: [u32; 2], (a, b, mut best): (Point, Point, f64)) -> f64 {
    while i0 <= i1 {
        let Some(i) = set.first(j, i0, i1, true) else { break };
        best = best.min(to_square(a, b, [f64::from(i), f64::from(j)]));
        i0 = i + 1;
    }
    best
}

/// Distance from the segment to the square with lower left corner `s`.
fn to_square(a: Point, b: Point, s: Point) -> f64 {
    let c = [s, [s[0] + 1.0, s[1]], [s[0] + 1.0, s[1] + 1.0], [s[0], s[1] + 1.0]];
    super::shape::convex_distance(&[a, b], &c).max(0.0)
}

/// May a point slide along `a b`? Not through the inside of the union of the set squares and the outside of the grid, deeper than `eps`, and not
/// through the gap of width zero between two squares that meet at a corner. Touching is allowed.
pub(super) fn point_free(set: &Bits, a: Point, b: Point, eps: f64) -> bool {
    interiors_free(set, a, b, eps) && seams_free(set, a, b, 2.0 * eps)
}

/// No point of the segment is inside a single square, shrunk by `eps` on all sides.
fn interiors_free(set: &Bits, a: Point, b: Point, eps: f64) -> bool {
    let (a, b) = if a[1] <= b[1] { (a, b) } else { (b, a) };
    let last = i64::from(set.height()) - 1;
    let (first_row, last_row) = (((a[1] + eps).ceil() as i64 - 1).max(0), ((b[1] - eps).floor() as i64).min(last));
    (first_row..=last_row).all(|j| {
        let (y0, y1) = (j as f64 + eps, (j + 1) as f64 - eps);
        if b[1] <= y0 || a[1] >= y1 {
            return true;
        }
        let (p, q) = (x_at(a, b, y0.max(a[1])), x_at(a, b, y1.min(b[1])));
        let (p, q) = if a[1] == b[1] { (a[0], b[0]) } else { (p, q) };
        let (x0, x1) = (p.min(q), p.max(q));
        !set.any(j as u32, (x0 - 1.0 + eps).floor() as i64 + 1, (x1 - eps).ceil() as i64 - 1)
    })
}

/// x of the line through `a` and `b` at height `y`, kept between them.
#[inline]
fn x_at(a: Point, b: Point, y: f64) -> f64 {
    let t = if b[1] == a[1] { 0.0 } else { ((y - a[1]) / (b[1] - a[1])).clamp(0.0, 1.0) };
    a[0] + t * (b[0] - a[0])
}

/// The segment does not run within `eps` of an edge that two set squares share, nor through a corner where two set squares meet diagonally.
fn seams_free(set: &Bits, a: Point, b: Point, eps: f64) -> bool {
    let shallow = (b[0] - a[0]).abs() >= (b[1] - a[1]).abs();
    let point = |p: Point| seam_free_at(set, p, eps);
    if !(point(a) && point(b)) {
        return false;
    }
    // Grid lines nearly across the segment are met in points, and what lies beside those is found as an interior; the lines nearly along it need care.
    let k = usize::from(shallow);
    let (low, high) = (a[k].min(b[k]), a[k].max(b[k]));
    ((low - eps).ceil() as i64..=(high + eps).floor() as i64).all(|line| {
        let y = line as f64;
        let (p, q) = if shallow { (a, b) } else { ([a[1], a[0]], [b[1], b[0]]) };
        let (p, q) = if p[1] <= q[1] { (p, q) } else { (q, p) };
        let (s, e) = if q[1] - p[1] <= 2.0 * eps { (p[0], q[0]) } else { (x_at(p, q, y - eps), x_at(p, q, y + eps)) };
        let (s, e) = (s.min(e), s.max(e));
        let (first, last) = ((s - 1.0 + eps).floor() as i64 + 1, (e - eps).ceil() as i64 - 1);
        let shared =
            if shallow { any_pair(set, line - 1, first, last) } else { (first..=last).any(|j| shut(set, line - 1, j) && shut(set, line, j)) };
        !shared && pinches_free(set, [s, e], [line, i64::from(shallow)], (p, q, eps))
    })
}

/// Is the cell set or outside the grid?
#[inline]
fn shut(set: &Bits, x: i64, y: i64) -> bool {
    x < 0 || y < 0 || x >= i64::from(set.width()) || y >= i64::from(set.height()) || set.at(x as u32, y as u32)
}

/// Is any column `x0 <= x <= x1` of the grid shut in both rows `y` and `y + 1`?
fn any_pair(set: &Bits, y: i64, x0: i64, x1: i64) -> bool {
    match y {
        -1 => set.any(0, x0, x1),
        _ if y + 1 == i64::from(set.height()) => set.any(y as u32, x0, x1),
        _ => set.any_pair(y, x0, x1),
    }
}

/// No corner on grid line `line` within `span` joins two set squares diagonally while the segment goes on at both sides of it.
fn pinches_free(set: &Bits, span: [f64; 2], [line, shallow]: [i64; 2], (p, q, eps): (Point, Point, f64)) -> bool {
    ((span[0] - eps).ceil() as i64..=(span[1] + eps).floor() as i64).all(|i| {
        let (x, y) = if shallow == 1 { (i, line) } else { (line, i) };
        let near = |c: Point| (c[0] - i as f64).abs().max((c[1] - line as f64).abs()) <= 4.0 * eps;
        near(p) || near(q) || !pinched(set, x, y)
    })
}

/// Do exactly two set squares meet at corner `(x, y)`, diagonally? Never on the border: there two neighbours are outside, or three.
pub(super) fn pinched(set: &Bits, x: i64, y: i64) -> bool {
    let (sw, se, nw, ne) = (set.at_or_zero(x - 1, y - 1), set.at_or_zero(x, y - 1), set.at_or_zero(x - 1, y), set.at_or_zero(x, y));
    (sw && ne && !se && !nw) || (se && nw && !sw && !ne)
}

/// Is `p` neither on an edge that two shut squares share (within `eps`, and farther than that from its ends) nor at the middle of four shut squares?
fn seam_free_at(set: &Bits, p: Point, eps: f64) -> bool {
    let line = [p[0].round(), p[1].round()];
    let (i, j) = (line[0] as i64, line[1] as i64);
    let (on_x, on_y) = ((p[0] - line[0]).abs() <= eps, (p[1] - line[1]).abs() <= eps);
    let (x, y) = (p[0].floor() as i64, p[1].floor() as i64);
    let at = |x, y| shut(set, x, y);
    match (on_x, on_y) {
        (true, true) => !(at(i - 1, j - 1) && at(i, j - 1) && at(i - 1, j) && at(i, j)),
        (true, false) => !(at(i - 1, y) && at(i, y)),
        (false, true) => !(at(x, j - 1) && at(x, j)),
        (false, false) => true,
    }
}
