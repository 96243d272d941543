//! Proof that a curve is free, piece by piece, and the chords that stand for it in files.
//!
//! A Bezier piece lies in the convex hull of its control points, the hull in a capsule around the chord whose radius is the largest distance of a
//! control point from the chord. If that capsule, widened by the robot's radius, is free, so is the piece; if not, its halves are tried.

use crate::Point;
use crate::path::{Bezier, Path};
use crate::query::Query;
use crate::world::World;
use crate::world::shape::distance;

/// Halvings before a piece counts as not proved.
const DEPTH: u32 = 14;

/// Can the robot's disc of `radius` (m) be proved to stay free along the piece? On failure the knot parameter where the proof ended.
pub(super) fn prove(piece: &Bezier, world: &World, radius: f64) -> Result<(), f64> {
    descend(piece, world, radius, 0)
}

fn descend(piece: &Bezier, world: &World, radius: f64, depth: u32) -> Result<(), f64> {
    let ([a, b], bulge) = (piece.ends(), piece.bulge());
    let inside = || piece.points.iter().all(|p| world.segment_free(*p, *p, 0.0));
    if world.segment_free(a, b, radius + bulge) && inside() {
        return Ok(());
    }
    let middle = f64::midpoint(piece.u[0], piece.u[1]);
    // A straight piece and one that has been halved often enough will not get better; one whose end is blocked cannot.
    if bulge <= 1e-12 * distance(a, b) || depth >= DEPTH || !world.segment_free(a, a, radius) || !world.segment_free(b, b, radius) {
        return Err(middle);
    }
    let halves = piece.halves();
    descend(&halves[0], world, radius, depth + 1).and_then(|()| descend(&halves[1], world, radius, depth + 1))
}

/// Points of a planar path (m), start to goal, so dense that the straight segments between them keep the query's radius to 1e-9 m and stay within a
/// fiftieth of a cell of the curve. A polyline is itself. Where the path itself is not free, as fine as is sensible.
pub fn polyline(path: &Path, query: &Query) -> Vec<Point> {
    if path.degree() == 1 {
        return path.points();
    }
    let (tolerance, radius) = (query.world.resolution() / 50.0, query.radius());
    let mut points = vec![path.point(0)];
    for piece in path.beziers() {
        let mut stack = vec![(piece, 0)];
        while let Some((piece, depth)) = stack.pop() {
            let [a, b] = piece.ends();
            let (bulge, fine) = (piece.bulge(), depth >= DEPTH);
            if fine || (bulge <= tolerance && (query.world.segment_free(a, b, radius) || bulge <= 1e-12 * distance(a, b))) {
                if distance(points[points.len() - 1], b) > 0.0 {
                    points.push(b);
                }
            } else {
                let [left, right] = piece.halves();
                stack.push((right, depth + 1));
                stack.push((left, depth + 1));
            }
        }
    }
    let goal = path.point(path.count() - 1);
    if let Some(last) = points.last_mut() {
        *last = if distance(*last, goal) < 1e-9 { goal } else { *last };
    }
    points
}
