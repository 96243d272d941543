//! Shortcuts: straight ways between random places of a path that are free replace what lies between.

use super::ground::Ground;
use crate::Point;
use crate::world::shape::distance;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

/// How often the reach of shortcuts is halved before it is the whole path again.
const SCALES: u32 = 7;

/// Length of a polyline, m.
pub(super) fn length(points: &[Point]) -> f64 {
    points.windows(2).map(|w| distance(w[0], w[1])).sum()
}

/// Shortens a path: from each point straight to the farthest that is in sight, then `tries` shortcuts between random places. Never longer.
pub(super) fn shorten(points: &[Point], tries: u32, ground: &mut Ground, rng: &mut ChaCha8Rng) -> Vec<Point> {
    if tries == 0 || points.len() < 3 {
        return points.to_vec();
    }
    let mut way = pulled(points, ground);
    for k in 0..tries {
        if way.len() < 3 {
            break;
        }
        let total = length(&way);
        // Between any two places first, then between nearer and nearer ones, over and over.
        let (a, reach) = (rng.random_range(0.0..=total), total * 0.5f64.powi((k % SCALES) as i32));
        let b = (a + rng.random_range(-reach..=reach)).clamp(0.0, total);
        let ((i, p), (j, q)) = (place(&way, a.min(b)), place(&way, a.max(b)));
        let straight = distance(p, q);
        if i < j && (b - a).abs() - straight > 1e-12 * total && ground.free(p, q) && ground.free(way[i], p) && ground.free(q, way[j + 1]) {
            let tail = way.split_off(j + 1);
            way.truncate(i + 1);
            way.extend([p, q]);
            way.extend(tail);
            way.dedup();
        }
    }
    let way = pulled(&way, ground);
    if length(&way) < length(points) { way } else { points.to_vec() }
}

/// From each point straight to the farthest in sight.
fn pulled(points: &[Point], ground: &mut Ground) -> Vec<Point> {
    let last = points.len() - 1;
    let (mut at, mut out) = (0, vec![points[0]]);
    while at < last {
        at = (at + 2..=last).rev().find(|&to| ground.free(points[at], points[to])).unwrap_or(at + 1);
        out.push(points[at]);
    }
    out
}

/// The place at arc length `s`: number of its segment, and where.
fn place(points: &[Point], mut s: f64) -> (usize, Point) {
    let last = points.len() - 2;
    for (i, w) in points.windows(2).enumerate() {
        let d = distance(w[0], w[1]);
        if s <= d || i == last {
            let t = if d > 0.0 { (s / d).min(1.0) } else { 0.0 };
            return (i, [w[0][0] + t * (w[1][0] - w[0][0]), w[0][1] + t * (w[1][1] - w[0][1])]);
        }
        s -= d;
    }
    (last, points[last + 1])
}
