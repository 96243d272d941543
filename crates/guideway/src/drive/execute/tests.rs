use super::super::testing::{drive, drive_with, legs, limits, parked, query, room, shuttle};
use super::super::{Ask, Controller, Decision, Guide, Observation};
use super::*;
use crate::Point;
use crate::world::{Appears, Bits, Footprint, Grid, Loop, Shape, World};
use serde_json::{Value, json};

const ROOM: [f64; 4] = [0.0, 0.0, 10.0, 6.0];
const BEND: [Point; 3] = [[1.0, 1.0], [5.0, 1.0], [5.0, 4.0]];

/// Drives blindly.
struct Blind(Command);
impl Controller for Blind {
    fn follow(&mut self, _guide: &Arc<Guide>) {}
    fn decide(&mut self, _seen: &Observation, _ctx: &mut Context) -> Decision {
        Decision::Drive(self.0)
    }
}

fn blind(query: &Query, command: Command, limit: f64) -> Run {
    let trajectory = legs(&[query.start, query.goal], limits());
    let mut job = Job::new(query, &trajectory).unwrap();
    (job.plant, job.time_limit) = (Unicycle::ideal(), Some(limit));
    execute(&job, &mut Blind(command), &mut Context::new(0)).unwrap()
}

#[test]
fn the_tracker_arrives_around_a_corner_with_small_errors() {
    let world = room(ROOM, Vec::new(), Vec::new());
    for seed in 0..5 {
        let run = drive("tracker", &query(&world, &BEND), &BEND, seed, |_| {});
        let planned = legs(&BEND, limits()).duration();
        assert_eq!(run.outcome, Outcome::Arrived, "{:?}", run.events);
        assert!(run.tracking.tte < 0.02 && run.tracking.worst < 0.05 && run.tracking.tpe < 0.03, "{:?}", run.tracking);
        assert!((run.time - planned).abs() < 1.5, "{} planned {planned}", run.time);
        assert!(run.tracking.length_deviation < 0.05 && run.replans == 0 && run.emergency_stops == 0);
        assert!(run.min_separation.movers.is_none());
    }
}

#[test]
fn the_same_seed_gives_the_same_run() {
    let world = room(ROOM, Vec::new(), vec![shuttle(0.3, [[3.0, 0.2], [3.0, 4.0]], 0.5, 1.0)]);
    let once = |seed| {
        let mut run = drive("tracker", &query(&world, &BEND), &BEND, seed, |_| {});
        run.step_seconds = Percentiles::default();
        serde_json::to_string(&run).unwrap()
    };
    assert_eq!(once(3), once(3));
    assert_ne!(once(3), once(4));
}

#[test]
fn the_tracker_waits_for_a_mover_and_goes_on() {
    let crossing = Mover { track: vec![[0.0, 3.0, 1.0], [6.0, 3.0, 1.0], [10.0, 3.0, 4.0]], ..parked(0.3, [3.0, 1.0]) };
    let world = room(ROOM, Vec::new(), vec![crossing]);
    let run = drive("tracker", &query(&world, &BEND), &BEND, 1, |_| {});
    assert_eq!(run.outcome, Outcome::Arrived, "{:?}", run.events);
    assert!(run.events.iter().any(|e| e.kind == "stop" && e.reason.contains("mover 0")) && run.events.iter().any(|e| e.kind == "go"));
    assert!(run.tracking.stopped > 0.5 && run.min_separation.movers.unwrap() > 0.0);
}

#[test]
fn a_parked_mover_without_a_new_plan_is_stuck_and_with_one_is_passed() {
    let world = room(ROOM, Vec::new(), vec![parked(0.4, [3.0, 1.0])]);
    let query = query(&world, &BEND);
    let run = drive("tracker", &query, &BEND, 1, |job| job.stuck_after = 12.0);
    assert_eq!(run.outcome, Outcome::Stuck);
    assert!(run.events.iter().any(|e| e.kind == "no-plan"));
    let around = |ask: &Ask, _: &mut Context| {
        let q = &ask.query;
        assert!(q.world.clearance([3.0, 1.0]) < 0.0 && (q.start_yaw.is_some() || ask.speed > 0.0));
        Ok(legs(&[q.start, [1.8, 2.5], [5.0, 2.5], q.goal], limits()))
    };
    let run = drive_with("tracker", &query, (&BEND, Some(&around)), 1, |_| {});
    assert_eq!((run.outcome, run.replans), (Outcome::Arrived, 1), "{:?}", run.events);
}

#[test]
fn a_blind_robot_hits_a_wall_and_the_moment_is_exact() {
    let wall = Shape::polygon(vec![[4.0, 0.0], [4.2, 0.0], [4.2, 6.0], [4.0, 6.0]]).unwrap();
    let world = room(ROOM, vec![wall], Vec::new());
    let run = blind(&query(&world, &[[1.0, 1.0], [2.0, 1.0]]), Command { v: 1.0, w: 0.0 }, 20.0);
    assert_eq!(run.outcome, Outcome::Collision);
    let collision = run.collision.unwrap();
    assert_eq!((collision.with.as_str(), collision.unavoidable), ("static", false));
    assert!((collision.t - 3.25).abs() < 1e-3, "2.75 m at 1 m/s after 1 s of acceleration: {}", collision.t);
    assert!(run.min_separation.still.unwrap().abs() < 1e-3);
}

#[test]
fn a_mover_that_runs_into_a_parked_robot_is_unavoidable() {
    let world = room(ROOM, Vec::new(), vec![shuttle(0.3, [[1.0, 5.0], [1.0, 1.0]], 0.5, 0.0)]);
    let run = blind(&query(&world, &[[1.0, 1.0], [4.0, 1.0]]), Command::default(), 20.0);
    let collision = run.collision.unwrap();
    assert!(collision.unavoidable && collision.with == "mover 0" && (collision.t - (4.0 - 0.55) / 0.5).abs() < 1e-3, "{collision:?}");
    let sudden = Mover { appears: Some(Appears::At(2.0)), ..parked(0.5, [1.2, 1.0]) };
    let world = room(ROOM, Vec::new(), vec![sudden]);
    let run = blind(&query(&world, &[[1.0, 1.0], [4.0, 1.0]]), Command::default(), 20.0);
    assert!(run.collision.unwrap().unavoidable && run.movers[0].since == Some(2.0));
}

#[test]
fn leaving_the_world_is_a_collision_with_the_border() {
    let world = room(ROOM, Vec::new(), Vec::new());
    let run = blind(&query(&world, &[[1.0, 1.0], [8.0, 1.0]]), Command { v: 1.0, w: 0.6 }, 20.0);
    assert_eq!(run.outcome, Outcome::Collision);
    assert_eq!(run.collision.unwrap().with, "border");
}

#[test]
fn time_runs_out_and_arrival_may_be_in_passing() {
    let world = room(ROOM, Vec::new(), Vec::new());
    let far = query(&world, &BEND);
    let run = drive("tracker", &far, &BEND, 0, |job| job.time_limit = Some(2.0));
    assert_eq!((run.outcome, run.cancelled), (Outcome::Timeout, false));
    let passing = drive("tracker", &far, &BEND, 0, |job| (job.arrival, job.stop_at_goal) = (1.0, false));
    let resting = drive("tracker", &far, &BEND, 0, |_| {});
    assert_eq!((passing.outcome, resting.outcome), (Outcome::Arrived, Outcome::Arrived));
    assert!(passing.time < resting.time - 1.0 && (passing.tracking.tpe - 1.0).abs() < 0.05);
}

#[test]
fn a_cancelled_run_is_a_partial_record() {
    let world = room(ROOM, Vec::new(), Vec::new());
    let query = query(&world, &BEND);
    let trajectory = legs(&BEND, limits());
    let job = Job::new(&query, &trajectory).unwrap();
    let mut stop = |_: &crate::context::Progress| true;
    let mut ctx = Context::new(0).with_observer(&mut stop);
    let run = execute(&job, &mut Blind(Command::default()), &mut ctx).unwrap();
    assert!(run.cancelled && run.driven.len() == 1 && run.outcome == Outcome::Timeout);
}

#[test]
fn movers_are_recorded_exactly_between_rows() {
    let cycle = Mover { repeat: Loop::Cycle, phase: 0.33, ..shuttle(0.3, [[8.0, 1.0], [8.0, 2.0]], 0.7, 0.0) };
    let back = Mover { shape: Footprint::Box([0.8, 0.8]), ..shuttle(0.3, [[7.0, 1.0], [7.0, 2.0]], 0.37, 0.2) };
    let world = room(ROOM, Vec::new(), vec![cycle.clone(), back.clone()]);
    let run = drive("tracker", &query(&world, &BEND), &BEND, 0, |_| {});
    let mut ts = (0..5000).map(|i| 0.001 * f64::from(i));
    assert!(ts.all(|t| [&cycle, &back].iter().zip(&run.movers).all(|(mover, record)| {
        let i = record.track.partition_point(|r| r[0] <= t).clamp(1, record.track.len() - 1);
        let (a, b) = (record.track[i - 1], record.track[i]);
        let r = (t - a[0]) / (b[0] - a[0]);
        let jump = b[0] - a[0] < 1e-5;
        jump || (a[2] + r * (b[2] - a[2]) - mover.at(t).0[1]).abs() < 1e-6
    })));
}

#[test]
fn bad_jobs_and_controllers_are_refused() {
    let world = room(ROOM, Vec::new(), Vec::new());
    let query = query(&world, &BEND);
    let trajectory = legs(&BEND, limits());
    let mut job = Job::new(&query, &trajectory).unwrap();
    job.arrival = -1.0;
    assert!(
        matches!(execute(&job, &mut Blind(Command::default()), &mut Context::new(0)), Err(PlanError::BadParameter { name, .. }) if name == "arrival")
    );
    let setup = super::super::Setup { world: Arc::clone(&world), robot: job.robot.clone(), clearance: 0.1 };
    let bad = [("nobody", Value::Null), ("tracker", json!({"k_z": 1})), ("tracker", json!({"k_x": -1})), ("tracker", json!({"k_x": "fast"}))];
    assert!(bad.into_iter().all(|(name, v)| matches!(super::super::controller(name, v, &setup), Err(PlanError::BadParameter { .. }))));
    assert!(super::super::CONTROLLERS.iter().all(|e| super::super::controller(e.name, (e.defaults)(), &setup).is_ok()));
}

/// A room of cells with walls, and a band across it that is forbidden but for a gap at the top.
fn banded() -> Arc<World> {
    let (mut walls, mut band) = (Bits::new(120, 60), Bits::new(120, 60));
    (0..60).for_each(|y| (0..120).for_each(|x| walls.set(x, y, x % 119 == 0 || y % 59 == 0)));
    (0..44).for_each(|y| (55..65).for_each(|x| band.set(x, y, true)));
    Arc::new(World::from_grid(Grid::new(walls, None, 0.1, [0.0; 3]).unwrap()).forbidding(Some(&band), Vec::new()).unwrap())
}

#[test]
fn what_is_forbidden_is_kept_off_with_and_without_a_map_though_no_lidar_shows_it() {
    let world = banded();
    let query = query(&world, &[[1.0, 1.0], [11.0, 1.0]]);
    let planning = super::super::Planning::new(crate::plan::planner("visibility", Value::Null).unwrap(), limits());
    let again = |ask: &Ask, ctx: &mut Context| planning.motion(ask, ctx);
    for map_known in [true, false] {
        // The first motion leads straight through.
        let run = drive_with("improved-dwa", &query, (&[query.start, query.goal], Some(&again)), 0, |job| {
            (job.sense, job.map_known) = (Sense::Lidar(Lidar::default()), map_known);
            job.trace = true;
        });
        assert_eq!((run.outcome, run.forbidden), (Outcome::Arrived, Some(0.0)), "map known: {map_known}, {:?}", run.events);
        assert!(run.driven.iter().any(|r| r[2] > 4.4) && run.min_separation.still.unwrap() > 0.1);
    }
    let mut rng = Lidar::random(0);
    let scan = Lidar { noise: 0.0, ..Lidar::default() }.scan(world.solid(), &[], ([1.0, 1.0, 0.0], 0.0), &mut rng);
    let ahead = (-scan.first / scan.step).round() as usize;
    assert!(scan.ranges[ahead] > 9.9, "the wall at 11.9 m or nothing within 10 m, not the band at 5.5 m: {}", scan.ranges[ahead]);
}

#[test]
fn a_forbidden_place_is_no_collision_and_the_time_in_it_is_counted() {
    let world = banded();
    let run = blind(&query(&world, &[[4.0, 1.0], [11.0, 1.0]]), Command { v: 0.5, w: 0.0 }, 10.0);
    // From the front at 5.5 m to the back at 6.5 m: 1.5 m at 0.5 m/s.
    assert!(run.collision.is_none() && (run.forbidden.unwrap() - 3.0).abs() < 0.05, "{:?}", run.forbidden);
}
