//! Hand-made motions and worlds for the tests of this floor.

use super::{Job, Replanner, Run, Setup, controller, execute};
use crate::Point;
use crate::context::Context;
use crate::path::Path;
use crate::query::{Limits, Query};
use crate::timing::{Piece, TimingOptions, Trajectory, time};
use crate::world::shape::{distance, wrap};
use crate::world::{Footprint, Loop, Mover, Shape, World};
use std::sync::Arc;

/// 1 m/s, 1 m/s2, 2 rad/s, 4 rad/s2.
pub fn limits() -> Limits {
    Limits { speed: 1.0, acceleration: 1.0, deceleration: 1.0, jerk: 10.0, turn_rate: Some(2.0), turn_acceleration: Some(4.0), ..Limits::default() }
}

/// A polyline driven leg by leg from rest to rest, with turns in place between them.
pub fn legs(points: &[Point], limits: Limits) -> Trajectory {
    let (mut pieces, mut t, mut s) = (Vec::new(), 0.0, 0.0);
    let heading = |i: usize| (points[i + 1][1] - points[i][1]).atan2(points[i + 1][0] - points[i][0]);
    for i in 0..points.len() - 1 {
        if i > 0 {
            let turn = wrap(heading(i) - heading(i - 1));
            let duration = 2.5 * (turn.abs() / 4.0).sqrt().max(turn.abs() / 2.0);
            pieces.push(Piece::Turn { turn, t, duration, s, from: heading(i - 1) });
            t += duration;
        }
        let length = distance(points[i], points[i + 1]);
        let (a, d) = (0.8 * limits.acceleration, 0.8 * limits.deceleration);
        let top = (0.9 * limits.speed).min((2.0 * length * a * d / (a + d)).sqrt());
        let ramps = [top * top / (2.0 * a), top * top / (2.0 * d)];
        let cruise = (length - ramps[0] - ramps[1]).max(0.0) / top;
        for (duration, speed, acceleration) in [(top / a, 0.0, a), (cruise, top, 0.0), (top / d, top, -d)] {
            pieces.push(Piece::Along { t, s, speed, acceleration, jerk: 0.0, duration });
            t += duration;
            s += duration * (speed + 0.5 * acceleration * duration);
        }
    }
    Trajectory { path: Path::polyline(points), pieces, limits }
}

/// A cubic B-spline with these control points, driven at 0.9 of the limits.
pub fn curve(control: &[Point]) -> Trajectory {
    let n = control.len();
    let knots = (0..n + 4).map(|i| i.clamp(3, n) as f64 - 3.0).collect();
    let path = Path::new(3, 2, knots, control.iter().flatten().copied().collect()).unwrap();
    let full = limits();
    let slower = Limits { speed: 0.9 * full.speed, acceleration: 0.8 * full.acceleration, deceleration: 0.8 * full.deceleration, jerk: 5.0, ..full };
    let mut trajectory = time(&path, &slower, &TimingOptions::default(), &mut Context::new(0)).unwrap();
    trajectory.limits = full;
    trajectory
}

/// Drives a trajectory with a controller; `change` edits the job.
pub fn drive_along(
    name: &str,
    query: &Query,
    (trajectory, replanner): (&Trajectory, Option<&Replanner>),
    seed: u64,
    change: impl FnOnce(&mut Job),
) -> Run {
    let mut job = Job::new(query, trajectory).unwrap();
    job.replanner = replanner;
    change(&mut job);
    let setup = Setup { world: Arc::clone(&query.world), robot: job.robot.clone(), clearance: query.clearance };
    let mut chosen = controller(name, serde_json::Value::Null, &setup).unwrap();
    execute(&job, chosen.as_mut(), &mut Context::new(seed)).unwrap()
}

/// A room with shapes and movers.
pub fn room(bounds: [f64; 4], shapes: Vec<Shape>, movers: Vec<Mover>) -> Arc<World> {
    Arc::new(World::from_shapes(bounds, shapes, 0.05).unwrap().with_movers(movers))
}

/// A disc that shuttles between two points; `phase` in s.
pub fn shuttle(radius: f64, [a, b]: [Point; 2], speed: f64, phase: f64) -> Mover {
    let track = vec![[0.0, a[0], a[1]], [distance(a, b) / speed, b[0], b[1]]];
    Mover { shape: Footprint::Disc(radius), track, repeat: Loop::Shuttle, phase, appears: None }
}

/// A disc that stays.
pub fn parked(radius: f64, at: Point) -> Mover {
    Mover { shape: Footprint::Disc(radius), track: vec![[0.0, at[0], at[1]]], repeat: Loop::Once, phase: 0.0, appears: None }
}

/// A query along points for a disc of 0.25 m with 0.1 m clearance.
pub fn query(world: &Arc<World>, points: &[Point]) -> Query {
    let mut query = Query::new(Arc::clone(world), points[0], points[points.len() - 1]);
    query.footprint = Footprint::Disc(0.25);
    query.clearance = 0.1;
    query
}

/// Drives `points` with a controller; `change` edits the job.
pub fn drive(name: &str, query: &Query, points: &[Point], seed: u64, change: impl FnOnce(&mut Job)) -> Run {
    drive_with(name, query, (points, None), seed, change)
}

/// As [`drive`], with a replanner.
pub fn drive_with(name: &str, query: &Query, (points, replanner): (&[Point], Option<&Replanner>), seed: u64, change: impl FnOnce(&mut Job)) -> Run {
    drive_along(name, query, (&legs(points, limits()), replanner), seed, change)
}
