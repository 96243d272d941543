//! Outlines of robots and movers, and exact distances between them.

use crate::Point;
use crate::world::Footprint;
use crate::world::shape::{cross, distance, norm, point_segment, sub};
use serde::{Deserialize, Serialize};

/// A convex polygon (counter-clockwise) or one point, grown by a radius: disc, box and polygon in one. In the frame of its owner or in the map frame.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Outline {
    /// One point for a disc, at least three corners else, m.
    pub points: Vec<Point>,
    /// m.
    pub radius: f64,
}

impl Outline {
    /// The outline of a footprint around its reference point.
    pub fn of(footprint: &Footprint) -> Self {
        match (footprint, footprint.corners()) {
            (Footprint::Disc(r), _) => Self { points: vec![[0.0; 2]], radius: *r },
            (_, Some(points)) => Self { points, radius: 0.0 },
            (_, None) => Self { points: vec![[0.0; 2]], radius: footprint.circumscribed() },
        }
    }

    /// Turned by the heading and moved to the position of `pose`.
    #[must_use]
    pub fn at(&self, pose: [f64; 3]) -> Self {
        let (s, c) = pose[2].sin_cos();
        let points = self.points.iter().map(|p| [pose[0] + c * p[0] - s * p[1], pose[1] + s * p[0] + c * p[1]]).collect();
        Self { points, radius: self.radius }
    }

    /// Radius of the disc around the reference point that covers it, m.
    pub fn circumscribed(&self) -> f64 {
        self.points.iter().map(|p| norm(*p)).fold(0.0, f64::max) + self.radius
    }

    /// Distance from `p` to the outline, m; negative inside.
    pub fn distance(&self, p: Point) -> f64 {
        if let [q] = self.points[..] {
            return distance(p, q) - self.radius;
        }
        let side = largest_side(&self.points, &[p]);
        (if side <= 0.0 { side } else { nearest(&self.points, &[p]) }) - self.radius
    }

    /// Distance to another outline in the same frame, m; negative when they overlap (then the least depth along an edge normal).
    pub fn gap(&self, other: &Self) -> f64 {
        let radii = self.radius + other.radius;
        if let ([a], [b]) = (&self.points[..], &other.points[..]) {
            return distance(*a, *b) - radii;
        }
        let side = largest_side(&self.points, &other.points).max(largest_side(&other.points, &self.points));
        let apart = if side <= 0.0 { side } else { nearest(&self.points, &other.points).min(nearest(&other.points, &self.points)) };
        apart - radii
    }
}

/// Largest distance over the edges of `a` at which all of `b` lies outside that edge; positive means separated. A lone point has no edges.
fn largest_side(a: &[Point], b: &[Point]) -> f64 {
    let n = a.len();
    if n < 2 {
        return f64::NEG_INFINITY;
    }
    (0..n)
        .map(|i| {
            let e = sub(a[(i + 1) % n], a[i]);
            let length = norm(e).max(1e-300);
            b.iter().map(|p| cross(sub(*p, a[i]), e) / length).fold(f64::INFINITY, f64::min)
        })
        .fold(f64::NEG_INFINITY, f64::max)
}

/// Smallest distance from a corner of `b` to an edge of `a`.
fn nearest(a: &[Point], b: &[Point]) -> f64 {
    let n = a.len();
    let edge = |p: Point| (0..n).map(|i| point_segment(p, a[i], a[(i + 1) % n])).fold(f64::INFINITY, f64::min);
    b.iter().map(|p| edge(*p)).fold(f64::INFINITY, f64::min)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Points on the boundary of an outline in the map frame, densely.
    fn boundary(outline: &Outline) -> Vec<Point> {
        let n = outline.points.len();
        let mut all = Vec::new();
        for i in 0..n {
            let (a, b) = (outline.points[i], outline.points[(i + 1) % n]);
            all.extend((0..=200).map(|k| f64::from(k) / 200.0).map(|r| [a[0] + r * (b[0] - a[0]), a[1] + r * (b[1] - a[1])]));
        }
        all
    }

    proptest! {
        #[test]
        fn the_gap_is_the_smallest_distance_of_boundary_points(x in -4.0..4.0_f64, y in -4.0..4.0_f64, yaw in -3.1..3.1_f64, r in 0.0..0.5_f64) {
            let a = Outline::of(&Footprint::Box([1.2, 0.6])).at([x, y, yaw]);
            let b = Outline { points: vec![[-0.5, -0.4], [0.7, -0.3], [0.1, 0.9]], radius: r };
            let gap = a.gap(&b);
            let (pa, pb) = (boundary(&a), boundary(&b));
            let brute = pa.iter().flat_map(|p| pb.iter().map(move |q| distance(*p, *q))).fold(f64::INFINITY, f64::min) - r;
            if gap > -r + 1e-9 {
                prop_assert!((gap - brute).abs() < 0.01, "{gap} {brute}");
            } else {
                let touching = brute + r < 0.02 || pa.iter().any(|p| b.distance(*p) < 0.0) || pb.iter().any(|p| a.distance(*p) < 0.0);
                prop_assert!(touching);
            }
            prop_assert!((gap - b.gap(&a)).abs() < 1e-12);
        }
    }

    #[test]
    fn discs_and_boxes_by_hand() {
        let disc = Outline::of(&Footprint::Disc(0.5));
        assert!((disc.gap(&disc.at([3.0, 4.0, 0.0])) - 4.0).abs() < 1e-12);
        let square = Outline::of(&Footprint::Box([2.0, 2.0]));
        assert!((square.distance([4.0, 5.0]) - 5.0).abs() < 1e-12 && (square.distance([0.5, 0.0]) + 0.5).abs() < 1e-12);
        assert!((square.circumscribed() - 2.0_f64.sqrt()).abs() < 1e-12);
    }
}
