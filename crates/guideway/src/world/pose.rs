//! Whole footprints at poses, and turning in place.

use super::footprint::Footprint;
use super::shape::{cross, sub};
use super::{TOUCH, World, segment};
use crate::Point;

/// What [`World::sweep_free`] may wrongly refuse, m.
const FINE: f64 = 1e-6;

impl World {
    /// Does `footprint` at `pose` (x, y in m, yaw in rad) keep `clearance` (m) to every static obstacle, with its reference point inside the world?
    /// Exact up to 1e-9 m: touching is allowed.
    pub fn pose_free(&self, footprint: &Footprint, pose: [f64; 3], clearance: f64) -> bool {
        let p = [pose[0], pose[1]];
        match footprint.at(pose) {
            None => pose[2].is_finite() && self.segment_free(p, p, footprint.circumscribed() + clearance),
            Some(corners) => pose[2].is_finite() && self.segment_inside(p, p) && self.body_free(&corners, clearance),
        }
    }

    /// Does `footprint` keep `clearance` (m) while it turns in place at `point` from `yaw` by `turn` (rad, positive to the left)?
    ///
    /// Never wrongly yes. May say no where a corner of the footprint passes an obstacle by less than 1e-6 m more than the clearance. Source: the hull of two
    /// headings, grown by the height of the arc over its chord, holds all headings between.
    pub fn sweep_free(&self, footprint: &Footprint, point: Point, [yaw, turn]: [f64; 2], clearance: f64) -> bool {
        let reach = footprint.circumscribed();
        if !(turn.is_finite() && self.pose_free(footprint, [point[0], point[1], yaw], clearance)) {
            return false;
        }
        if self.clearance_within(point, reach + clearance) >= reach + clearance - TOUCH {
            return true;
        }
        let full = turn.clamp(-std::f64::consts::TAU, std::f64::consts::TAU);
        let parts = (full.abs() / 0.5).ceil().max(1.0);
        let part = |i: f64| yaw + full * i / parts;
        (0..parts as u32).map(f64::from).all(|i| self.turn_free(footprint, point, [part(i), part(i + 1.0)], clearance))
    }

    fn turn_free(&self, footprint: &Footprint, point: Point, yaw: [f64; 2], clearance: f64) -> bool {
        let Some([from, to]) = corners_at(footprint, point, yaw) else { return true };
        let rise = footprint.circumscribed() * (1.0 - (0.5 * (yaw[1] - yaw[0])).cos());
        if self.body_free(&hull([from, to].concat()), clearance + rise) {
            return true;
        }
        let middle = f64::midpoint(yaw[0], yaw[1]);
        rise > FINE
            && self.pose_free(footprint, [point[0], point[1], middle], clearance)
            && self.turn_free(footprint, point, [yaw[0], middle], clearance)
            && self.turn_free(footprint, point, [middle, yaw[1]], clearance)
    }

    /// Does a convex body (corners counter-clockwise, map frame, m) keep `clearance` to every static obstacle?
    fn body_free(&self, corners: &[Point], clearance: f64) -> bool {
        let cells = self.grid().is_none_or(|grid| {
            let (q, scale): (Vec<Point>, _) = (corners.iter().map(|p| grid.to_cells(*p)).collect(), grid.resolution());
            let eps = TOUCH / scale;
            if clearance > 2.0 * TOUCH {
                segment::polygon_free(grid.blocked(), &q, clearance / scale - eps, 0.0)
            } else {
                segment::polygon_free(grid.blocked(), &q, 0.0, eps)
            }
        });
        cells && self.shapes().iter().all(|s| s.body_distance(corners) >= clearance - TOUCH)
    }
}

fn corners_at(footprint: &Footprint, point: Point, yaw: [f64; 2]) -> Option<[Vec<Point>; 2]> {
    Some([footprint.at([point[0], point[1], yaw[0]])?, footprint.at([point[0], point[1], yaw[1]])?])
}

/// Convex hull, counter-clockwise (monotone chains).
fn hull(mut points: Vec<Point>) -> Vec<Point> {
    points.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
    let chain = |points: &mut dyn Iterator<Item = &Point>| {
        let mut out: Vec<Point> = Vec::new();
        for &p in points {
            while let [.., a, b] = out[..]
                && cross(sub(b, a), sub(p, b)) <= 0.0
            {
                out.pop();
            }
            out.push(p);
        }
        out.pop();
        out
    };
    let mut lower = chain(&mut points.iter());
    lower.extend(chain(&mut points.iter().rev()));
    lower
}
