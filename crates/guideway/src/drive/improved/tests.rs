use super::super::testing::{curve, drive, drive_along, legs, limits, parked, query, room, shuttle};
use super::super::{Job, Outcome, Run, Setup, controller, execute};
use crate::context::Context;
use crate::query::Limits;
use crate::world::Mover;

const ROOM: [f64; 4] = [0.0, 0.0, 10.0, 6.0];
const BEND: [[f64; 2]; 3] = [[1.0, 1.0], [5.0, 1.0], [5.0, 4.0]];

fn bend(movers: Vec<Mover>, seed: u64) -> Run {
    let world = room(ROOM, Vec::new(), movers);
    drive("improved-dwa", &query(&world, &BEND), &BEND, seed, |_| {})
}

#[test]
fn a_free_path_is_followed_closely() {
    let control = [[1.0, 1.0], [2.5, 1.0], [4.5, 1.0], [6.0, 2.0], [6.0, 3.5], [6.0, 5.0]];
    let world = room(ROOM, Vec::new(), Vec::new());
    let motion = curve(&control);
    let run = drive_along("improved-dwa", &query(&world, &[control[0], control[5]]), (&motion, None), 0, |_| {});
    assert_eq!((run.outcome, run.emergency_stops), (Outcome::Arrived, 0), "{:?}", run.events);
    assert!(run.tracking.tte < 0.1 && run.tracking.tpe < 0.06 && run.time < 1.3 * motion.duration(), "{} {:?}", run.time, run.tracking);
}

#[test]
fn a_sharp_corner_is_taken() {
    let run = bend(Vec::new(), 0);
    assert_eq!(run.outcome, Outcome::Arrived, "{:?}", run.events);
}

#[test]
fn a_parked_mover_is_passed_without_a_new_plan() {
    let run = bend(vec![parked(0.3, [3.0, 1.0])], 0);
    assert_eq!((run.outcome, run.replans), (Outcome::Arrived, 0), "{:?}", run.events);
    assert!(run.min_separation.movers.unwrap() > 0.05);
}

#[test]
fn crossing_movers_are_let_through() {
    for seed in 0..8_u32 {
        let phase = f64::from(seed) * 1.7;
        let movers = vec![shuttle(0.3, [[3.0, 0.0], [3.0, 4.0]], 0.4, phase), shuttle(0.3, [[3.0, 2.5], [7.0, 2.5]], 0.4, 2.0 * phase)];
        let run = bend(movers, u64::from(seed));
        assert_eq!(run.outcome, Outcome::Arrived, "seed {seed} {:?}", run.events);
    }
}

/// Largest jerk of a run at its control steps, m/s3, and of its time outside full brakes the share.
fn jerk(run: &Run) -> (f64, f64) {
    let speeds: Vec<[f64; 2]> = run.driven.iter().map(|r| [r[0], r[4]]).collect();
    // From a stop that is made while the robot moves until the command has left the ramp behind.
    let braked: Vec<f64> = run.events.iter().filter(|e| e.kind == "stop").map(|e| e.t).filter(|t| moves(run, *t)).collect();
    let calm = |t: f64| !braked.iter().any(|b| (b - 0.05..b + 2.0).contains(&t));
    let all: Vec<(f64, f64)> = speeds.windows(3).map(|w| (w[2][0], (w[2][1] - 2.0 * w[1][1] + w[0][1]) / 0.0004)).collect();
    let kept: Vec<f64> = all.iter().filter(|(t, _)| calm(*t)).map(|(_, j)| j.abs()).collect();
    (kept.iter().copied().fold(0.0, f64::max), kept.len() as f64 / all.len() as f64)
}

fn moves(run: &Run, t: f64) -> bool {
    run.driven.iter().any(|r| (r[0] - t).abs() < 0.011 && r[4].abs() > 0.03)
}

#[test]
fn commanded_speeds_keep_to_the_jerk() {
    let set = serde_json::json!({"jerk_limited": true});
    for seed in 0..6_u32 {
        let phase = f64::from(seed) * 1.7;
        let movers = vec![shuttle(0.3, [[3.0, 0.0], [3.0, 4.0]], 0.4, phase), shuttle(0.3, [[3.0, 2.5], [7.0, 2.5]], 0.4, 2.0 * phase)];
        let world = room(ROOM, Vec::new(), movers);
        let query = query(&world, &BEND);
        let motion = legs(&BEND, Limits { jerk: 4.0, ..limits() });
        let mut job = Job::new(&query, &motion).unwrap();
        job.plant.odometry_scale = 0.0;
        let setup = Setup { world: std::sync::Arc::clone(&query.world), robot: job.robot.clone(), clearance: query.clearance };
        let mut chosen = controller("improved-dwa", set.clone(), &setup).unwrap();
        let run = execute(&job, chosen.as_mut(), &mut Context::new(u64::from(seed))).unwrap();
        assert_eq!(run.outcome, Outcome::Arrived, "seed {seed} {:?}", run.events);
        let (worst, share) = jerk(&run);
        assert!(worst <= 4.0 * (1.0 + 1e-6) && share > 0.8, "seed {seed}: {worst} m/s3, {share}, {:?}", run.events);
    }
}
