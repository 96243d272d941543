//! Paths through many points, and legs that join.

use super::*;
use crate::timing::scurve::advance;

/// A random walk of many small steps, as a recorded path looks.
fn random_walk(seed: u64, points: usize, joints: usize) -> Path {
    let steps = random_path(seed, points, joints);
    let mut at = vec![0.0; joints];
    let walk = steps.control().chunks_exact(joints).take(points).flat_map(|step| {
        at.iter_mut().zip(step).for_each(|(at, step)| *at += 0.06 * step);
        at.clone()
    });
    Path::through(&walk.collect::<Vec<f64>>(), joints).unwrap()
}

#[test]
fn paths_through_many_points_are_timed_as_finely_as_short_ones() {
    for (seed, points) in [(1, 300), (2, 700)] {
        let path = random_walk(seed, points, 6);
        let limits = limits(3.0, 10.0);
        let motion = fastest(&path, &limits, &TopOptions::default());
        let even = fastest(&path, &limits, &TopOptions { grid: Some(70 * points), ..TopOptions::default() });
        let ratio = motion.duration() / even.duration();
        assert!((0.99..1.0003).contains(&ratio), "{points} points: {} s on its own grid, {} s on an even one", motion.duration(), even.duration());
        assert!(motion.x[1..motion.x.len() - 1].iter().all(|x| *x > 0.0), "{points} points: it stops on the way");
        assert!(worst(&motion, &limits, 3)[1] < 1.0 + 1e-6);
        joined(&motion);
    }
}

/// Every piece begins where the one before ended.
fn joined(motion: &JointMotion) {
    for w in motion.pieces.windows(2) {
        let [Piece::Along { s, speed, acceleration, jerk, duration, .. }, Piece::Along { s: next, speed: v, .. }] = [&w[0], &w[1]] else {
            unreachable!()
        };
        let end = advance((*s, *speed, *acceleration), *jerk, *duration);
        assert!((end.0 - next).abs() < 1e-9 && (end.1 - v).abs() < 1e-9, "a gap of {} at {next}", end.0 - next);
    }
}

#[test]
fn legs_join_whatever_their_slope() {
    for (x, bend) in [([0.222, 0.0], 137.0), ([0.0, 0.79], 137.0), ([0.222, 0.0], -900.0), ([0.5, 0.4], 60.0), ([0.5, 0.4], 1e4)] {
        let leg = super::super::motion::Leg::new(0.0296, x, bend);
        let end = advance((0.0, leg.speed, leg.acceleration), leg.jerk, leg.duration);
        assert!((end.0 - 0.0296).abs() < 1e-12 && (end.1 - x[1].sqrt()).abs() < 1e-12, "{x:?} {bend}: {end:?}");
    }
}
