//! Analytic obstacles: discs and convex polygons, with exact distances.

use crate::Point;
use crate::error::PlanError;
use serde::{Deserialize, Serialize};

/// A solid, closed shape.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Shape {
    /// Centre and radius, m.
    Disc {
        /// m.
        center: Point,
        /// m.
        radius: f64,
    },
    /// Convex, counter-clockwise, at least three corners, m.
    Polygon {
        /// Corners, counter-clockwise, m.
        points: Vec<Point>,
    },
}

impl Shape {
    /// A disc of radius `radius` >= 0 m.
    /// # Errors
    /// [`PlanError::BadParameter`] for values that are not finite or a negative radius.
    pub fn disc(center: Point, radius: f64) -> Result<Self, PlanError> {
        if !(center.iter().all(|v| v.is_finite()) && radius.is_finite() && radius >= 0.0) {
            return Err(PlanError::bad("disc", format!("center {center:?}, radius {radius}"), "finite numbers, radius >= 0 m"));
        }
        Ok(Self::Disc { center, radius })
    }

    /// A convex polygon; the corners may be given in either sense and are stored counter-clockwise.
    /// # Errors
    /// [`PlanError::BadParameter`] for fewer than three corners, no area, values that are not finite, or a polygon that is not convex.
    pub fn polygon(mut points: Vec<Point>) -> Result<Self, PlanError> {
        let shown = || format!("{} corners", points.len());
        if points.len() < 3 || !points.iter().flatten().all(|v| v.is_finite()) {
            return Err(PlanError::bad("polygon", shown(), "at least 3 corners with finite coordinates"));
        }
        let n = points.len();
        let area: f64 = (0..n).map(|i| cross(points[i], points[(i + 1) % n])).sum::<f64>() / 2.0;
        if area.abs() < 1e-12 {
            return Err(PlanError::bad("polygon", shown(), "corners that span an area"));
        }
        if area < 0.0 {
            points.reverse();
        }
        let mut turning = 0.0;
        for i in 0..n {
            let (a, b, c) = (points[i], points[(i + 1) % n], points[(i + 2) % n]);
            let (u, v) = (sub(b, a), sub(c, b));
            if cross(u, v) < -1e-12 * (norm(u) * norm(v)).max(1e-300) {
                return Err(PlanError::bad(
                    "polygon",
                    format!("{n} corners, reflex at ({}, {})", b[0], b[1]),
                    "a convex polygon (split it into convex parts)",
                ));
            }
            turning += cross(u, v).atan2(dot(u, v));
        }
        if turning > 2.0 * std::f64::consts::PI + 1e-6 {
            return Err(PlanError::bad("polygon", format!("{n} corners"), "a polygon that does not cross itself"));
        }
        Ok(Self::Polygon { points })
    }

    /// Signed distance from `p` to the boundary, m; negative inside.
    pub fn distance(&self, p: Point) -> f64 {
        match self {
            Self::Disc { center, radius } => norm(sub(p, *center)) - radius,
            Self::Polygon { points } => {
                let n = points.len();
                let (mut inside, mut best) = (f64::NEG_INFINITY, f64::INFINITY);
                for i in 0..n {
                    let (a, b) = (points[i], points[(i + 1) % n]);
                    let e = sub(b, a);
                    inside = inside.max(cross(sub(p, a), e) / norm(e).max(1e-300));
                    best = best.min(point_segment(p, a, b));
                }
                if inside <= 0.0 { inside } else { best }
            }
        }
    }

    /// Smallest signed distance from the points of the segment `a b` to the shape, m; negative when it enters the interior.
    pub fn segment_distance(&self, a: Point, b: Point) -> f64 {
        match self {
            Self::Disc { center, radius } => point_segment(*center, a, b) - radius,
            Self::Polygon { points } => {
                let deepest = deepest(points, a, b);
                if deepest <= 0.0 {
                    return deepest;
                }
                let n = points.len();
                (0..n).map(|i| segment_segment(a, b, points[i], points[(i + 1) % n])).fold(f64::INFINITY, f64::min)
            }
        }
    }
}

impl Shape {
    /// Distance from the shape to a convex body, m, as [`convex_distance`] tells it.
    pub fn body_distance(&self, corners: &[Point]) -> f64 {
        match self {
            Self::Disc { center, radius } => convex_distance(corners, std::slice::from_ref(center)) - radius,
            Self::Polygon { points } => convex_distance(corners, points),
        }
    }

    /// The same shape if its values make sense (also for shapes that were read from a file).
    /// # Errors
    /// As [`Shape::disc`] and [`Shape::polygon`].
    pub fn validated(self) -> Result<Self, PlanError> {
        match self {
            Self::Disc { center, radius } => Self::disc(center, radius),
            Self::Polygon { points } => Self::polygon(points),
        }
    }
}

/// Distance of two convex bodies, each one point, two (a segment), or a polygon counter-clockwise, m. When they overlap, minus the least overlap along
/// the normals of their sides (separating axes); two crossing segments are at distance 0.
pub fn convex_distance(a: &[Point], b: &[Point]) -> f64 {
    let apart = separation(a, b).max(separation(b, a));
    let solid = a.len() > 2 || b.len() > 2;
    if solid && apart <= 0.0 {
        return apart;
    }
    if let ([p, q], [r, s]) = (a, b) {
        return segment_segment(*p, *q, *r, *s);
    }
    let corners = |from: &[Point], to: &[Point]| {
        let side = |i: usize| (to[i], to[(i + 1) % to.len()]);
        let near = |p: Point| (0..to.len()).map(|i| point_segment(p, side(i).0, side(i).1)).fold(f64::INFINITY, f64::min);
        from.iter().map(|p| near(*p)).fold(f64::INFINITY, f64::min)
    };
    corners(a, b).min(corners(b, a))
}

/// Largest distance between two convex bodies along an outward normal of a side of `a`.
fn separation(a: &[Point], b: &[Point]) -> f64 {
    let n = a.len();
    let along = |i: usize| {
        let e = sub(a[(i + 1) % n], a[i]);
        let length = norm(e);
        if length > 0.0 { b.iter().map(|p| cross(sub(*p, a[i]), e)).fold(f64::INFINITY, f64::min) / length } else { f64::NEG_INFINITY }
    };
    (0..n).map(along).fold(f64::NEG_INFINITY, f64::max)
}

/// Smallest value along the segment `a b` of the largest signed distance to the lines through the sides of a convex polygon: negative depth
/// where the segment enters it. That function of the way along the segment is convex and piecewise linear, so cutting planes find its
/// minimum in at most one step per side.
fn deepest(points: &[Point], a: Point, b: Point) -> f64 {
    let n = points.len();
    // Value and slope of the highest line at `t`.
    let top = |t: f64| {
        let mut best = (f64::NEG_INFINITY, 0.0);
        for i in 0..n {
            let (c, e) = (points[i], sub(points[(i + 1) % n], points[i]));
            let length = norm(e).max(1e-300);
            let (at_a, at_b) = (cross(sub(a, c), e) / length, cross(sub(b, c), e) / length);
            let value = at_a + t * (at_b - at_a);
            if value > best.0 {
                best = (value, at_b - at_a);
            }
        }
        best
    };
    let (mut t0, mut t1) = (0.0, 1.0);
    let (mut left, mut right) = (top(t0), top(t1));
    if left.1 >= 0.0 {
        return left.0;
    }
    if right.1 <= 0.0 {
        return right.0;
    }
    let mut best = left.0.min(right.0);
    for _ in 0..=n {
        let (u, v) = (left.0 - left.1 * t0, right.0 - right.1 * t1);
        let t = ((v - u) / (left.1 - right.1)).clamp(t0, t1);
        let middle = top(t);
        best = best.min(middle.0);
        if t <= t0 || t >= t1 || middle.1 == 0.0 {
            break;
        }
        if middle.1 < 0.0 { (t0, left) = (t, middle) } else { (t1, right) = (t, middle) }
    }
    best
}

/// `a - b`.
#[inline]
pub fn sub(a: Point, b: Point) -> Point {
    [a[0] - b[0], a[1] - b[1]]
}
/// z component of the cross product.
#[inline]
pub fn cross(a: Point, b: Point) -> f64 {
    a[0] * b[1] - a[1] * b[0]
}
/// Dot product.
#[inline]
pub fn dot(a: Point, b: Point) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}
/// Euclidean length.
#[inline]
pub fn norm(a: Point) -> f64 {
    a[0].hypot(a[1])
}
/// Euclidean distance of two points.
#[inline]
pub fn distance(a: Point, b: Point) -> f64 {
    norm(sub(a, b))
}
/// Distance from `p` to the segment `a b`.
pub fn point_segment(p: Point, a: Point, b: Point) -> f64 {
    let (e, v) = (sub(b, a), sub(p, a));
    let l2 = dot(e, e);
    let t = if l2 > 0.0 { (dot(v, e) / l2).clamp(0.0, 1.0) } else { 0.0 };
    norm([v[0] - t * e[0], v[1] - t * e[1]])
}
/// Distance of two segments; zero if they cross.
pub fn segment_segment(a: Point, b: Point, c: Point, d: Point) -> f64 {
    let (u, v) = (sub(b, a), sub(d, c));
    let (s1, s2) = (cross(u, sub(c, a)), cross(u, sub(d, a)));
    let (t1, t2) = (cross(v, sub(a, c)), cross(v, sub(b, c)));
    if s1 * s2 < 0.0 && t1 * t2 < 0.0 {
        return 0.0;
    }
    point_segment(a, c, d).min(point_segment(b, c, d)).min(point_segment(c, a, b)).min(point_segment(d, a, b))
}
/// Angle wrapped to (-pi, pi].
#[inline]
pub fn wrap(angle: f64) -> f64 {
    let t = std::f64::consts::TAU;
    // What is less than a turn needs no division; the rest as `f64::rem_euclid` has it.
    let r = if angle.abs() < t { angle } else { angle % t };
    let w = if r < 0.0 { r + t } else { r };
    if w > std::f64::consts::PI { w - t } else { w }
}
