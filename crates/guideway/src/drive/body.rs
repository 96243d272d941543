//! What the robot covers: exactly, and as a few discs that are quick to look at.

use super::Outline;
use crate::Point;
use crate::world::Footprint;
use crate::world::shape::{distance, sub};

/// Most discs of a cover.
const DISCS: usize = 5;

/// A footprint in the forms that predictions need.
#[derive(Debug, Clone)]
pub(super) struct Body {
    /// Exactly, in the robot's frame.
    pub outline: Outline,
    /// Centre (robot's frame) and radius of discs that cover it, m.
    pub discs: Vec<(Point, f64)>,
    /// Radius of the disc around the reference point that covers it, m.
    pub reach: f64,
    /// Radius of the largest disc around the reference point inside, m.
    pub inscribed: f64,
}

impl Body {
    pub fn of(footprint: &Footprint) -> Self {
        let outline = Outline::of(footprint);
        let discs = match &outline.points[..] {
            [point] => vec![(*point, outline.radius)],
            corners => cover(corners),
        };
        Self { discs, reach: outline.circumscribed(), inscribed: footprint.inscribed(), outline }
    }

    /// What of a distance from the reference point is left beyond the hull, m.
    pub fn beyond(&self, distance: f64) -> f64 {
        (distance - self.reach).max(0.0)
    }

    /// Is it a disc around the reference point?
    pub fn round(&self) -> bool {
        self.outline.points.len() == 1
    }
}

/// Slabs across the longer side, each in a disc around its middle.
fn cover(corners: &[Point]) -> Vec<(Point, f64)> {
    let range = |k: usize| {
        let low = corners.iter().map(|p| p[k]).fold(f64::INFINITY, f64::min);
        (low, corners.iter().map(|p| p[k]).fold(f64::NEG_INFINITY, f64::max))
    };
    let (x, y) = (range(0), range(1));
    let long = usize::from(y.1 - y.0 > x.1 - x.0);
    let ((low, high), across) = if long == 0 { (x, y.1 - y.0) } else { (y, x.1 - x.0) };
    let n = ((2.0 * (high - low) / across.max(1e-9)).ceil() as usize).clamp(1, DISCS);
    let side = (high - low) / n as f64;
    (0..n).filter_map(|i| disc_around(&slab(corners, long, [low + side * i as f64, low + side * (i + 1) as f64]))).collect()
}

/// The corners of a convex polygon between two lines across axis `k`.
fn slab(corners: &[Point], k: usize, [low, high]: [f64; 2]) -> Vec<Point> {
    let mut points: Vec<Point> = corners.iter().copied().filter(|p| (low..=high).contains(&p[k])).collect();
    for i in 0..corners.len() {
        let (a, b) = (corners[i], corners[(i + 1) % corners.len()]);
        for cut in [low, high] {
            if (a[k] - cut) * (b[k] - cut) < 0.0 {
                let r = (cut - a[k]) / (b[k] - a[k]);
                let e = sub(b, a);
                points.push([a[0] + r * e[0], a[1] + r * e[1]]);
            }
        }
    }
    points
}

/// The disc around the middle of the bounding box.
fn disc_around(points: &[Point]) -> Option<(Point, f64)> {
    let first = *points.first()?;
    let (mut low, mut high) = (first, first);
    for p in points {
        for k in 0..2 {
            (low[k], high[k]) = (low[k].min(p[k]), high[k].max(p[k]));
        }
    }
    let center = [f64::midpoint(low[0], high[0]), f64::midpoint(low[1], high[1])];
    Some((center, points.iter().map(|p| distance(center, *p)).fold(0.0, f64::max)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn the_discs_cover_the_footprint_and_stay_inside_its_reach(l in 0.1..3.0_f64, w in 0.1..3.0_f64, u in -0.5..0.5_f64, v in -0.5..0.5_f64) {
            let body = Body::of(&Footprint::Box([l, w]));
            let p = [u * l, v * w];
            prop_assert!(body.discs.iter().any(|(c, r)| distance(*c, p) <= r + 1e-12));
            prop_assert!(body.discs.iter().all(|(c, r)| (c[0].hypot(c[1]) + r) <= 1.3 * body.reach));
        }
    }

    #[test]
    fn a_triangle_is_covered_and_a_disc_is_itself() {
        let triangle = Body::of(&Footprint::Polygon(vec![[-0.3, -0.4], [0.9, 0.0], [-0.3, 0.4]]));
        for (i, j) in (0..=20).flat_map(|i| (0..=20 - i).map(move |j| (f64::from(i) / 20.0, f64::from(j) / 20.0))) {
            let p = [-0.3 + 1.2 * i, -0.4 + 0.4 * i + 0.8 * j];
            assert!(triangle.discs.iter().any(|(c, r)| distance(*c, p) <= r + 1e-12), "{p:?}");
        }
        let disc = Body::of(&Footprint::Disc(0.2));
        assert!(disc.round() && disc.discs == vec![([0.0; 2], 0.2)]);
    }
}
