//! Is a path gentle enough? From positions alone.

use super::Check;
use crate::path::Path;
use crate::world::shape::{cross, distance, sub};

/// Distance between the positions that are compared, m.
const STEP: f64 = 0.01;
/// Most positions along a path; the step grows beyond.
const MOST: f64 = 200_000.0;
/// What comparing positions may overstate, as a share of the limit.
const SLACK: f64 = 1e-3;

/// Checks the curvature of `path` (1/m) against `limit`: the circle through three positions one step apart. Corners are infinitely sharp.
pub fn curvature(path: &Path, limit: Option<f64>) -> Check {
    let length = path.length();
    let n = (length / STEP).ceil().clamp(8.0, MOST);
    let at = |i: f64| path.planar(length * i / n).point;
    let mut check = Check::below("curvature", limit);
    check.see(0.0, 0.0, 0.0);
    for corner in path.corners() {
        check.see(f64::INFINITY, corner.s, 0.0);
    }
    let (mut a, mut b) = (at(0.0), at(1.0));
    for i in 2..=n as u64 {
        let c = at(i as f64);
        let sides = distance(a, b) * distance(b, c) * distance(a, c);
        if sides > 0.0 {
            check.see(2.0 * cross(sub(b, a), sub(c, b)).abs() / sides, length * (i - 1) as f64 / n, SLACK * limit.unwrap_or(0.0));
        }
        (a, b) = (b, c);
    }
    check
}
