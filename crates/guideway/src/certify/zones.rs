//! Checks a motion against a map of speed limits.

use super::check::Check;
use crate::timing::{Piece, Trajectory};
use crate::world::SpeedMap;

/// Farthest between two samples, as a share of the side of a cell.
const SHARE: f64 = 0.2;
/// Most samples of a piece.
const MOST: f64 = 1e6;

/// Is the speed nowhere above what the map allows at the reference point? The worst value is speed minus limit, m/s; `at` is the time, s.
pub fn zones(trajectory: &Trajectory, map: &SpeedMap) -> Check {
    let mut check = Check::below("speed zones", Some(0.0));
    let path = &trajectory.path;
    for piece in &trajectory.pieces {
        let Piece::Along { t, s, speed, acceleration, jerk, duration } = *piece else { continue };
        let fastest = speed.abs() + acceleration.abs() * duration + 0.5 * jerk.abs() * duration * duration;
        let n = (fastest * duration / (SHARE * map.resolution())).ceil().clamp(8.0, MOST);
        for k in 0..=n as u32 {
            let u = duration * f64::from(k) / n;
            let v = speed + u * (acceleration + 0.5 * jerk * u);
            let place = s + u * (speed + u * (0.5 * acceleration + jerk * u / 6.0));
            let limit = map.at(path.planar(place.clamp(0.0, path.length())).point);
            check.see(if limit.is_finite() { v - limit } else { f64::NEG_INFINITY }, t + u, 1e-6);
        }
    }
    if check.worst == f64::NEG_INFINITY {
        check.worst = -trajectory.limits.speed;
    }
    check
}
