//! A room with cubes that go to and fro, and judges of motions among movers that share no code with the search.

use guideway::query::{Limits, Query};
use guideway::timing::Trajectory;
use guideway::world::{Footprint, Loop, Mover, Shape, World};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use std::sync::Arc;

pub const KEPT: f64 = 0.3;

pub fn limits() -> Limits {
    Limits {
        speed: 2.0,
        acceleration: 5.0,
        deceleration: 5.0,
        jerk: 10.0,
        turn_rate: Some(2.0),
        turn_acceleration: None,
        lateral_acceleration: Some(2.0),
    }
}

pub fn shuttle(from: [f64; 2], to: [f64; 2], speed: f64, phase: f64) -> Mover {
    let period = (to[0] - from[0]).hypot(to[1] - from[1]) / speed;
    let track = vec![[0.0, from[0], from[1]], [period, to[0], to[1]]];
    Mover { phase, repeat: Loop::Shuttle, ..Mover::new(Footprint::Box([0.8, 0.8]), track).unwrap() }
}

/// The room with its four cubes at phases of a seed.
pub fn room(seed: u64) -> Query {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let discs =
        [(1.2, 0.95, 0.8), (2.35, 1.55, 0.6), (2.1, 3.0, 1.0), (3.7, 2.05, 0.9), (4.1, 0.6, 0.7), (6.5, 1.5, 1.2), (7.5, 4.2, 1.0), (0.9, 3.9, 0.5)];
    let shapes = discs.map(|(x, y, d)| Shape::Disc { center: [x, y], radius: 0.5 * d }).to_vec();
    let courses = [([3.2, 2.95], [3.2, 4.3], 0.4), ([2.1, 0.5], [3.2, 0.5], 0.4), ([1.5, 5.2], [6.5, 5.2], 0.6), ([5.3, 0.4], [5.3, 2.0], 0.3)];
    let movers = courses.map(|(from, to, speed)| shuttle(from, to, speed, rng.random_range(0.0..20.0))).to_vec();
    let world = World::from_shapes([0.0, 0.0, 10.0, 6.0], shapes, 0.05).unwrap().with_movers(movers);
    Query { clearance: KEPT, limits: limits(), ..Query::new(Arc::new(world), [0.0, 0.0], [5.0, 3.0]) }
}

/// Smallest distance at every millisecond, m, by positions alone.
pub fn least(trajectory: &Trajectory, movers: &[Mover]) -> f64 {
    let n = (trajectory.duration() * 1000.0).ceil() as usize;
    let gap = |k: usize| {
        let t = (k as f64 * 1e-3).min(trajectory.duration());
        let [x, y, _] = trajectory.at(t).pose;
        movers.iter().map(|m| m.distance([x, y], t)).fold(f64::INFINITY, f64::min)
    };
    (0..=n).map(gap).fold(f64::INFINITY, f64::min)
}

/// Smallest distance (m) that is left if, at any of many moments, the robot brakes after a latency (s) and a mover comes for it at its top speed. The brake is worked out
/// in small steps: jerk down, hold, jerk up as soon as that ends the motion without acceleration.
pub fn least_after_a_brake(trajectory: &Trajectory, movers: &[Mover], latency: f64) -> f64 {
    let limits = &trajectory.limits;
    let tops: Vec<f64> = movers.iter().map(Mover::top_speed).collect();
    let (mut least, moments) = (f64::INFINITY, (trajectory.duration() / 0.017) as usize);
    for k in 0..moments {
        let now = 0.017 * k as f64;
        let taken_effect = trajectory.at(now + latency);
        let (mut s, mut v, mut a, mut t) = (taken_effect.s, taken_effect.speed, taken_effect.acceleration, latency);
        let dt = 1e-3;
        while v > 1e-3 {
            let release = a < 0.0 && v <= 0.5 * a * a / limits.jerk;
            a = if release { (a + limits.jerk * dt).min(-1e-3) } else { (a - limits.jerk * dt).max(-limits.deceleration) };
            v += a * dt;
            s += v.max(0.0) * dt;
            t += dt;
            let point = trajectory.path.planar(s.min(trajectory.path.length())).point;
            least = movers.iter().zip(&tops).map(|(m, top)| m.distance(point, now) - top * t).fold(least, f64::min);
        }
    }
    least
}
