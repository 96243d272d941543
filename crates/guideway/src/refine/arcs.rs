//! Fewer way points where a planner gives an arc as a fine polygon around it.

use super::belt::heading;
use crate::Point;
use crate::query::Query;
use crate::world::shape::{cross, distance, point_segment, sub, wrap};
use std::f64::consts::FRAC_PI_6;

/// Way points may move outwards by this share of the robot's radius.
const HEIGHT: f64 = 0.1;
/// Largest turn of a way point that replaces two, rad.
const TURN: f64 = FRAC_PI_6;

/// Replaces edges of an arc's polygon by the corner of their neighbours, outside of the arc, as long as that is free and near. A bend fits
/// between a few long edges, not between hundreds of short ones. Ends and via points stay.
pub(super) fn coarse(mut points: Vec<Point>, query: &Query) -> Vec<Point> {
    let radius = query.radius();
    let height = HEIGHT * radius;
    while height > 0.0 && points.len() > 3 {
        let before = points.len();
        let mut kept = vec![points[0]];
        let mut i = 1;
        while i + 2 < before {
            let a = kept[kept.len() - 1];
            if let Some(corner) = corner([a, points[i], points[i + 1], points[i + 2]], [height, radius], query) {
                kept.push(corner);
                i += 2;
            } else {
                kept.push(points[i]);
                i += 1;
            }
        }
        kept.extend_from_slice(&points[i..]);
        points = kept;
        if points.len() == before {
            break;
        }
    }
    points
}

/// Where the lines `a b` and `c d` meet, if that may replace `b c`.
fn corner([a, b, c, d]: [Point; 4], [height, radius]: [f64; 2], query: &Query) -> Option<Point> {
    let (into, through, out) = (heading(a, b), heading(b, c), heading(c, d));
    let turns = [wrap(through - into), wrap(out - through)];
    if turns[0] * turns[1] <= 0.0 || (turns[0] + turns[1]).abs() > TURN || query.via.iter().any(|v| point_segment(*v, b, c) < 1e-6) {
        return None;
    }
    let (u, w) = (sub(b, a), sub(d, c));
    let t = cross(sub(c, a), w) / cross(u, w);
    let x = [a[0] + t * u[0], a[1] + t * u[1]];
    let free = |p: Point, q: Point| query.world.segment_free(p, q, radius);
    let near = t.is_finite() && point_segment(x, b, c) <= height && distance(x, c) <= distance(x, d);
    (near && query.world.contains(x) && free(a, x) && free(x, d)).then_some(x)
}
