use super::super::testing::{curve, legs, limits, parked, query, room};
use super::super::{Ask, Delivery, Outcome, Outline, Planning, Plant, Run, Setup, Track, Unicycle, UnicyclePlant, controller, execute};
use super::*;
use crate::context::stream;
use crate::plan;
use crate::world::shape::distance;
use crate::world::{Appears, Footprint, Mover, Shape, SpeedMap, World};
use rand::RngExt;
use serde_json::Value;

const ROOM: [f64; 4] = [0.0, 0.0, 10.0, 6.0];

fn planning() -> Planning {
    Planning::new(plan::planner("visibility", Value::Null).unwrap(), limits())
}

fn wall(x: [f64; 2], y: [f64; 2]) -> Shape {
    Shape::polygon(vec![[x[0], y[0]], [x[1], y[0]], [x[1], y[1]], [x[0], y[1]]]).unwrap()
}

/// Drives from (1, 3) to (9, 3) with the tracker and the exact planner.
fn run(world: &Arc<World>, change: impl FnOnce(&mut Job)) -> Run {
    let query = query(world, &[[1.0, 3.0], [9.0, 3.0]]);
    let planning = planning();
    let motion = planning.motion(&Ask { query: query.clone(), speed: 0.0 }, &mut Context::new(0)).unwrap();
    let replanner = |ask: &Ask, ctx: &mut Context| planning.motion(ask, ctx);
    let mut job = Job::new(&query, &motion).unwrap();
    job.replanner = Some(&replanner);
    job.trace = true;
    change(&mut job);
    let setup = Setup { world: Arc::clone(world), robot: job.robot.clone(), clearance: query.clearance };
    let mut tracker = controller("tracker", Value::Null, &setup).unwrap();
    execute(&job, tracker.as_mut(), &mut Context::new(1)).unwrap()
}

fn kinds(run: &Run) -> Vec<&str> {
    run.events.iter().map(|e| e.kind.as_str()).collect()
}

#[test]
fn a_blocked_corridor_becomes_tabu_and_the_way_leads_around() {
    // Two corridors; the lower one, on the straight line, gets blocked when the robot comes.
    let walls = vec![wall([4.0, 6.0], [3.6, 4.4]), wall([4.0, 6.0], [0.0, 2.4])];
    let blocker = Mover { appears: Some(Appears::Within(3.0)), ..parked(0.5, [5.0, 3.0]) };
    let world = room(ROOM, walls, vec![blocker]);
    let run = run(&world, |_| {});
    assert_eq!(run.outcome, Outcome::Arrived, "{:?}", run.events);
    let seen = kinds(&run);
    let at = |kind: &str| seen.iter().position(|k| *k == kind).unwrap_or_else(|| panic!("no {kind} in {:?}", run.events));
    assert!(at("stop") < at("blocked") && at("blocked") < at("tabu") && at("tabu") < at("replan"));
    assert!(run.replans >= 1 && run.replans <= 3, "{:?}", run.events);
    let trace = run.trace.unwrap();
    assert_eq!(trace.plans.len() as u32, run.replans + 1);
    assert!(trace.plans[1].path.iter().any(|p| p[1] > 4.4) && trace.steps.len() > 50 && trace.steps.len() <= 2000);
    assert!(trace.steps.iter().any(|s| s.state != "drive") && trace.steps.iter().any(|s| !s.tracks.is_empty()));
}

#[test]
fn a_robot_that_is_walled_in_is_stuck() {
    let ring = |i: u32| {
        let (s, c) = (f64::from(i) * std::f64::consts::TAU / 12.0).sin_cos();
        Mover { appears: Some(Appears::At(0.5)), ..parked(0.35, [1.2 + 1.1 * c, 3.0 + 1.1 * s]) }
    };
    let world = room(ROOM, Vec::new(), (0..12).map(ring).collect());
    let run = run(&world, |job| job.stuck_after = 15.0);
    assert_eq!(run.outcome, Outcome::Stuck, "{:?}", run.events);
    assert!(kinds(&run).contains(&"no-plan") && run.events.iter().any(|e| e.reason == "NoPath"), "{:?}", run.events);
    assert!(run.collision.is_none());
}

#[test]
fn a_goal_that_stays_occupied_ends_stuck_before_it() {
    let world = room(ROOM, Vec::new(), vec![Mover { appears: Some(Appears::At(1.0)), ..parked(0.5, [9.0, 3.0]) }]);
    let run = run(&world, |job| job.stuck_after = 15.0);
    assert_eq!(run.outcome, Outcome::Stuck, "{:?} {:?}", run.events, run.driven.iter().step_by(50).collect::<Vec<_>>());
    assert!(run.collision.is_none() && run.tracking.tpe < 2.0, "{:?}", run.tracking);
    let appeared: Vec<_> = run.events.iter().filter(|e| e.kind == "appeared").map(|e| (e.t, e.reason.as_str())).collect();
    assert_eq!(appeared, [(1.0, "mover 0 at (9.00, 3.00), 0.00 m/s")]);
}

/// A pilot along a straight line in an empty room, and the room.
fn pilot(replan: bool) -> (Pilot<'static>, Arc<World>) {
    let world = room(ROOM, Vec::new(), Vec::new());
    let query = query(&world, &[[1.0, 3.0], [9.0, 3.0]]);
    let motion = legs(&[[1.0, 3.0], [9.0, 3.0]], limits());
    let robot = Robot::new(query.footprint.clone(), &limits()).unwrap();
    let setup = Setup { world: Arc::clone(&world), robot: robot.clone(), clearance: 0.1 };
    let planning = planning();
    let replanner: Option<Box<OwnReplanner<'static>>> = replan.then(|| -> Box<OwnReplanner> { Box::new(move |ask, ctx| planning.motion(ask, ctx)) });
    (Pilot::new((&query, &motion), &robot, controller("tracker", Value::Null, &setup).unwrap(), replanner).unwrap(), world)
}

#[test]
fn what_is_seen_newly_on_the_way_is_planned_around_while_driving() {
    let (mut pilot, world) = pilot(true);
    let mut ctx = Context::new(0);
    let mut seen = Observation::new(0.0, [1.0, 3.0, 0.0], 0.5, 0.0);
    seen.known = Some(Arc::clone(&world));
    assert!(!pilot.step(&mut seen, None, &mut ctx).replanned);
    let pillar = World::from_shapes(ROOM, vec![Shape::disc([5.0, 3.0], 0.5).unwrap()], 0.05).unwrap();
    let mut seen = Observation::new(0.5, [1.5, 3.0, 0.0], 0.5, 0.0);
    seen.known = Some(Arc::new(pillar));
    let step = pilot.step(&mut seen, None, &mut ctx);
    assert!(step.replanned && step.stop.is_none() && step.command.v > 0.1, "{step:?}");
    let course = &pilot.guide().course;
    assert!(course.states().iter().all(|s| distance([s.pose[0], s.pose[1]], [5.0, 3.0]) > 0.74));
    assert!(course.start().speed > 0.4 && pilot.guide().to_go.as_ref().unwrap().at([1.5, 3.0]) > 7.5);
    // The same again is no reason, and nothing blocked is none either.
    let again = seen.known.clone();
    let mut seen = Observation::new(0.8, [1.6, 3.0, 0.0], 0.5, 0.0);
    seen.known = again;
    assert!(!pilot.step(&mut seen, None, &mut ctx).replanned);
}

#[test]
fn without_any_way_it_stands_says_why_and_goes_when_there_is_one_again() {
    let (mut pilot, world) = pilot(true);
    let mut ctx = Context::new(0);
    let closed = Arc::new(World::from_shapes(ROOM, vec![wall([4.0, 4.2], [0.0, 6.0])], 0.05).unwrap());
    let mut events = Vec::new();
    for k in 0..100 {
        let mut seen = Observation::new(0.02 * f64::from(k), [1.0, 3.0, 0.0], 0.0, 0.0);
        seen.known = Some(Arc::clone(&closed));
        let step = pilot.step(&mut seen, None, &mut ctx);
        assert!(step.stop.as_deref() == Some("no way to the goal (NoPath)") && step.command == Command::default(), "{step:?}");
        events.extend(step.events);
    }
    assert_eq!(events.iter().filter(|e| e.kind == "no-plan").count(), 1, "{events:?}");
    let mut seen = Observation::new(3.0, [1.0, 3.0, 0.0], 0.0, 0.0);
    seen.known = Some(world);
    let step = pilot.step(&mut seen, None, &mut ctx);
    assert!(step.stop.is_none(), "{step:?}");
}

#[test]
fn a_way_that_is_no_better_is_not_taken_after_a_tabu_has_expired() {
    let (mut pilot, _) = pilot(true);
    let mut ctx = Context::new(0);
    let track = |at: [f64; 2]| Track { id: 0, outline: Outline::of(&Footprint::Disc(0.3)), position: at, velocity: [0.0; 2], bound: 0.0, doubt: 0.0 };
    let (mut replans, mut expired) = (Vec::new(), 0);
    for k in 0..700 {
        let t = 0.02 * f64::from(k);
        let mut seen = Observation::new(t, [2.0, 3.0, 0.0], 0.0, 0.0);
        seen.tracks = if t < 1.2 { vec![track([2.65, 3.0])] } else { Vec::new() };
        let step = pilot.step(&mut seen, None, &mut ctx);
        replans.extend(step.replanned.then_some(t));
        expired += step.events.iter().filter(|e| e.kind == "expired").count();
    }
    assert_eq!((replans.len(), expired), (1, 1), "{replans:?}");
}

#[test]
fn blind_and_senseless_readings_stop_with_a_reason() {
    let (mut pilot, _) = pilot(false);
    let mut ctx = Context::new(0);
    let mut old = Observation::new(0.0, [1.0, 3.0, 0.0], 0.0, 0.0);
    old.age = 0.6;
    let step = pilot.step(&mut old, None, &mut ctx);
    assert!(step.stop.as_deref() == Some("nothing is seen") && step.events.iter().any(|e| e.kind == "blind"), "{step:?}");
    for bad in [f64::NAN, f64::INFINITY] {
        for k in 0..6 {
            let mut seen = Observation::new(1.0, [1.0, 3.0, 0.0], 0.0, 0.0);
            let all = [&mut seen.time, &mut seen.v, &mut seen.w];
            match all.into_iter().nth(k) {
                Some(field) => *field = bad,
                None => seen.pose[k - 3] = bad,
            }
            let step = pilot.step(&mut seen, None, &mut ctx);
            assert!(step.stop.is_some() && step.command == Command::default());
        }
    }
    let mut good = Observation::new(2.0, [1.0, 3.0, 0.0], 0.0, 0.0);
    assert!(pilot.step(&mut good, None, &mut ctx).stop.is_none());
}

/// Steps a pilot and an ideal base along; what it drives at each step.
fn go(pilot: &mut Pilot, plant: &mut UnicyclePlant, steps: std::ops::Range<u32>) -> Vec<Command> {
    steps
        .map(|k| {
            let mut seen = Observation { time: 0.02 * f64::from(k), ..plant.observe() };
            let command = pilot.step(&mut seen, None, &mut Context::new(0)).command;
            plant.step(command, 0.02);
            command
        })
        .collect()
}

#[test]
fn an_override_and_a_stop_keep_to_the_path_and_to_the_limits() {
    let (mut pilot, _) = pilot(false);
    let robot = Robot::new(Footprint::Disc(0.25), &limits()).unwrap();
    let mut plant = Unicycle::ideal().place(&robot, [1.0, 3.0, 0.0], 0);
    assert!(pilot.set_share(1.5).is_err() && pilot.set_share(f64::NAN).is_err());
    let mut driven = go(&mut pilot, &mut plant, 0..150);
    pilot.set_share(0.5).unwrap();
    driven.extend(go(&mut pilot, &mut plant, 150..300));
    assert!((driven[149].v - 0.9).abs() < 0.05 && (driven[299].v - 0.45).abs() < 0.05, "{} {}", driven[149].v, driven[299].v);
    pilot.hold(true);
    driven.extend(go(&mut pilot, &mut plant, 300..450));
    assert!(driven[440..].iter().all(|c| *c == Command::default()));
    pilot.hold(false);
    driven.extend(go(&mut pilot, &mut plant, 450..650));
    assert!(driven[649].v > 0.4 && plant.motion().pose[1].abs() - 3.0 < 0.01);
    let rates: Vec<f64> = driven.windows(2).map(|w| (w[1].v - w[0].v) / 0.02).collect();
    assert!(rates[100..].iter().all(|a| a.abs() < 1.5), "{:?}", rates[100..].iter().copied().fold(0.0, f64::max));
}

#[test]
fn a_map_of_speeds_is_kept_to_by_the_plan_and_by_the_drive() {
    let world = room(ROOM, Vec::new(), Vec::new());
    let mut slow = vec![f64::INFINITY; 100 * 60];
    (0..60).for_each(|y| slow[y * 100 + 40..y * 100 + 60].fill(0.3));
    let map = Arc::new(SpeedMap::new(&slow, [100, 60], 0.1, [0.0; 3]).unwrap());
    let query = query(&world, &[[1.0, 3.0], [9.0, 3.0]]);
    let ask = Ask { query: query.clone(), speed: 0.0 };
    let fast = planning().motion(&ask, &mut Context::new(0)).unwrap();
    let motion = planning().with_speed_map(Some(Arc::clone(&map))).motion(&ask, &mut Context::new(0)).unwrap();
    let (bad, good) = (crate::certify::zones(&fast, &map), crate::certify::zones(&motion, &map));
    assert!(!bad.ok && bad.worst > 0.5 && good.ok, "{bad:?} {good:?}");
    assert!(motion.duration() > fast.duration() + 3.0);
    // The drive slows down by itself too, where the plan does not know.
    let mut job = Job::new(&query, &fast).unwrap();
    (job.speed_map, job.plant) = (Some(Arc::clone(&map)), Unicycle::ideal());
    let setup = Setup { world: Arc::clone(&world), robot: job.robot.clone(), clearance: 0.1 };
    let mut tracker = controller("tracker", Value::Null, &setup).unwrap();
    let run = execute(&job, tracker.as_mut(), &mut Context::new(1)).unwrap();
    assert_eq!(run.outcome, Outcome::Arrived);
    let over = run.driven.iter().map(|r| r[4] - map.at([r[1], r[2]])).fold(f64::NEG_INFINITY, f64::max);
    assert!(over < 0.02 && run.driven.iter().any(|r| r[4] > 0.8), "{over}");
}

#[test]
fn ramped_speeds_keep_to_zones_shares_and_stops() {
    let world = room(ROOM, Vec::new(), Vec::new());
    let mut slow = vec![f64::INFINITY; 100 * 60];
    (0..60).for_each(|y| slow[y * 100 + 40..y * 100 + 60].fill(0.3));
    let map = Arc::new(SpeedMap::new(&slow, [100, 60], 0.1, [0.0; 3]).unwrap());
    let query = query(&world, &[[1.0, 3.0], [9.0, 3.0]]);
    let motion = legs(&[[1.0, 3.0], [9.0, 3.0]], crate::query::Limits { jerk: 3.0, ..limits() });
    let mut job = Job::new(&query, &motion).unwrap();
    (job.speed_map, job.plant) = (Some(Arc::clone(&map)), Unicycle { lag_speed: 0.08, ..Unicycle::ideal() });
    let setup = Setup { world: Arc::clone(&world), robot: job.robot.clone(), clearance: 0.1 };
    let ramped = || controller("improved-dwa", serde_json::json!({"jerk_limited": true}), &setup).unwrap();
    let run = execute(&job, ramped().as_mut(), &mut Context::new(1)).unwrap();
    let over = run.driven.iter().map(|r| r[4] - map.at([r[1], r[2]])).fold(f64::NEG_INFINITY, f64::max);
    assert!(run.outcome == Outcome::Arrived && over < 0.01 && run.driven.iter().any(|r| r[4] > 0.7), "{over} {:?}", run.events);
    // The speed of a base with a lag, driven by hand with an override and a stop on the path.
    let mut pilot = Pilot::owned(&Job { speed_map: None, ..job }, ramped(), None).unwrap();
    let mut plant = Unicycle { lag_speed: 0.08, ..Unicycle::ideal() }.place(&setup.robot, [1.0, 3.0, 0.0], 0);
    let mut speeds = Vec::new();
    for k in 0..600_u32 {
        pilot.set_share(if (150..250).contains(&k) { 0.4 } else { 1.0 }).unwrap();
        pilot.hold((350..450).contains(&k));
        let mut seen = Observation { time: 0.02 * f64::from(k), ..plant.observe() };
        let step = pilot.step(&mut seen, None, &mut Context::new(0));
        assert!(step.stop.is_none() || plant.motion().v < 0.05, "{k} {step:?}");
        plant.step(step.command, 0.02);
        speeds.push(plant.motion().v);
    }
    assert!(speeds[149] > 0.8 && (speeds[249] - 0.4).abs() < 0.05 && speeds[449] < 1e-3 && speeds[599] > 0.8, "{speeds:.2?}");
    let worst = speeds.windows(3).map(|w| (w[2] - 2.0 * w[1] + w[0]).abs() / 0.0004).fold(0.0, f64::max);
    assert!(worst <= 3.0 * (1.0 + 1e-6), "{worst}");
}

/// The pilot of [`pilot`] whose plans take a while, and what it sees at `x` at time `t`, with a pillar around (5, 3).
fn waiting(delivery: Delivery) -> (Pilot<'static>, impl Fn(f64, f64, f64) -> Observation) {
    let (mut pilot, _) = pilot(true);
    pilot.navigator.delivery = delivery;
    let pillar = Arc::new(World::from_shapes(ROOM, vec![Shape::disc([5.0, 3.0], 0.5).unwrap()], 0.05).unwrap());
    let seen = move |t, x, v| Observation { known: Some(Arc::clone(&pillar)), ..Observation::new(t, [x, 3.0, 0.0], v, 0.0) };
    (pilot, seen)
}

#[test]
fn a_plan_that_takes_time_is_joined_where_the_robot_is_by_then() {
    let (mut pilot, seen) = waiting(Delivery::After(0.2));
    let mut events = Vec::new();
    for k in 0..=10 {
        let t = 0.02 * f64::from(k);
        let step = pilot.step(&mut seen(t, 1.5 + 0.5 * t, 0.5), None, &mut Context::new(0));
        assert_eq!(step.replanned, k == 10, "{k} {step:?}");
        assert!(step.stop.is_none() && step.plan_seconds.len() == usize::from(k == 0), "{k} {step:?}");
        events.extend(step.events.into_iter().map(|e| (e.kind, e.t)));
    }
    assert_eq!(events, [("asked".to_owned(), 0.0), ("replan".to_owned(), 0.2)]);
    let guide = pilot.guide();
    assert_eq!(guide.course.start().pose[0], 1.5, "made from where the robot was");
    assert!((guide.from - 0.1).abs() < 0.01 && (pilot.navigator.reached() - guide.from).abs() < 1e-9, "{}", guide.from);
}

#[test]
fn before_what_blocks_the_way_the_robot_waits_for_its_plan() {
    let (mut pilot, seen) = waiting(Delivery::After(30.0));
    // The disc of the plan, 0.25 m and a quarter of the 0.1 m of clearance, fits up to x = 4.225; from 0.6 m/s it takes 0.18 m to stop, and 0.22 m are kept, at rest 0.1 m.
    let steps = [(0.0, 1.5, 0.5, false), (1.0, 2.4, 0.6, false), (2.0, 3.3, 0.6, false), (2.5, 3.7, 0.6, false), (2.8, 3.9, 0.6, true)];
    for (t, x, v, stands) in steps.into_iter().chain([(4.0, 4.0, 0.0, false), (5.0, 4.2, 0.0, true)]) {
        let step = pilot.step(&mut seen(t, x, v), None, &mut Context::new(0));
        assert_eq!(step.stop.as_deref() == Some("waits for a plan around what blocks the way"), stands, "{t} {step:?}");
        assert!(!step.replanned && step.plan_seconds.len() == usize::from(t == 0.0), "one at a time");
    }
}

#[test]
fn a_plan_that_comes_too_late_is_made_again_from_rest() {
    let (mut pilot, seen) = waiting(Delivery::After(0.2));
    let mut ctx = Context::new(0);
    let mut at = |t: f64, y: f64, v: f64| {
        let mut seen = seen(t, 1.5, v);
        seen.pose[1] = y;
        let step = pilot.step(&mut seen, None, &mut ctx);
        (step.replanned, step.stop.is_some(), step.events.into_iter().map(|e| e.kind).collect::<Vec<_>>())
    };
    assert_eq!(at(0.0, 3.0, 0.5), (false, false, vec!["asked".to_owned()]));
    // It has got out of the way of somebody.
    let (replanned, stands, events) = at(0.2, 3.6, 0.5);
    assert!(!replanned && stands && events.contains(&"late".to_owned()), "{events:?}");
    assert_eq!(at(0.22, 3.6, 0.3), (false, true, Vec::new()), "not before it rests");
    assert_eq!(at(0.4, 3.6, 0.0), (false, true, vec!["asked".to_owned()]));
    let (replanned, stands, events) = at(0.6, 3.6, 0.0);
    assert!(replanned && !stands && events.contains(&"replan".to_owned()), "{events:?}");
    assert_eq!(pilot.guide().course.start().pose[1], 3.6);
}

#[test]
fn plans_can_be_made_elsewhere() {
    let (mut pilot, seen) = waiting(Delivery::Elsewhere);
    let mut ctx = Context::new(0);
    assert!(!pilot.plan_due() && pilot.request().is_none());
    assert!(!pilot.step(&mut seen(0.0, 1.5, 0.5), None, &mut ctx).replanned && pilot.plan_due());
    let (request, planning) = (pilot.request().unwrap(), planning());
    assert!(!pilot.plan_due() && pilot.request().is_none(), "handed out once");
    assert!(!pilot.step(&mut seen(0.3, 1.6, 0.5), None, &mut ctx).replanned && !pilot.plan_due(), "one at a time");
    let found = request.solve(|ask, ctx| planning.motion(ask, ctx));
    pilot.deliver(found);
    let step = pilot.step(&mut seen(0.4, 1.7, 0.5), None, &mut ctx);
    assert!(step.replanned && step.plan_seconds.len() == 1, "{step:?}");
    // What nobody waits for any more changes nothing.
    pilot.deliver(request.solve(|ask, ctx| planning.motion(ask, ctx)));
    assert!(!pilot.step(&mut seen(0.42, 1.7, 0.5), None, &mut ctx).replanned);
}

#[test]
fn with_plans_that_take_time_a_blocked_corridor_is_left_as_well() {
    let walls = vec![wall([4.0, 6.0], [3.6, 4.4]), wall([4.0, 6.0], [0.0, 2.4])];
    let blocker = Mover { appears: Some(Appears::Within(3.0)), ..parked(0.5, [5.0, 3.0]) };
    let world = room(ROOM, walls, vec![blocker]);
    let at_once = run(&world, |_| {});
    for wait in [0.1, 1.5] {
        let run = run(&world, |job| job.delivery = Delivery::After(wait));
        assert_eq!(run.outcome, Outcome::Arrived, "{:?}", run.events);
        let first = |kind: &str| run.events.iter().find(|e| e.kind == kind).map_or(f64::NAN, |e| e.t);
        assert!((first("replan") - first("asked") - wait).abs() <= 0.02, "{:?}", run.events);
        assert!(run.time > at_once.time, "{} {}", run.time, at_once.time);
    }
    let zero = run(&world, |job| job.delivery = Delivery::After(0.0));
    assert_eq!(zero.outcome, Outcome::Arrived);
}

/// Whatever the override and the stops, and whenever they come.
#[test]
fn commands_keep_the_limits_of_acceleration_and_jerk_under_any_override() {
    let bends = [[1.0, 3.0], [3.0, 3.0], [4.0, 4.5], [6.0, 4.5], [7.0, 1.5], [8.0, 3.0], [9.0, 3.0]];
    let world = room(ROOM, Vec::new(), Vec::new());
    let (motion, query) = (curve(&bends), query(&world, &[bends[0], bends[6]]));
    let robot = Robot::new(query.footprint.clone(), &motion.limits).unwrap();
    let setup = Setup { world: Arc::clone(&world), robot: robot.clone(), clearance: 0.1 };
    let (jerk, dt) = (motion.limits.jerk, 0.02);
    for (name, set) in [("tracker", Value::Null), ("dwa", Value::Null), ("improved-dwa", serde_json::json!({"preset": "paper"}))] {
        for seed in 0..if name == "tracker" { 12 } else { 3 } {
            let mut rng = stream(seed, 7, 0);
            let mut pilot = Pilot::new((&query, &motion), &robot, controller(name, set.clone(), &setup).unwrap(), None).unwrap();
            let mut plant = Unicycle::default().place(&robot, [1.0, 3.0, 0.0], seed);
            let (mut speeds, mut reduced, mut next) = (Vec::new(), false, 40);
            for k in 0..1500_u32 {
                if k == next {
                    pilot.set_share(if rng.random_bool(0.3) { 1.0 } else { rng.random_range(0.05..1.0) }).unwrap();
                    pilot.hold(rng.random_bool(0.3));
                    next += rng.random_range(5..150);
                }
                let mut seen = Observation { time: dt * f64::from(k), ..plant.observe() };
                let step = pilot.step(&mut seen, None, &mut Context::new(0));
                let braked = step.stop.as_deref().is_some_and(|why| why != "held");
                // Without an override windows step from speed to speed.
                reduced = pilot.pace.now() < 1.0 || (reduced && name == "tracker");
                if braked || !reduced {
                    speeds.clear();
                }
                speeds.push(step.command.v);
                plant.step(step.command, dt);
                let [.., a, b, c] = speeds[..] else { continue };
                let (before, now) = ((b - a) / dt, (c - b) / dt);
                // Windows slow down as they decide, which may be more: what they slow down for may be in the way.
                let from = if name == "tracker" { before } else { before.max(-robot.deceleration) };
                let rises = now <= robot.acceleration * (1.0 + 1e-9) && now - from <= jerk * dt * (1.0 + 1e-6);
                assert!(rises || (name != "tracker" && now <= 0.0), "{name} {seed} {k}: {before} {now}");
                let falls = now >= -robot.deceleration * (1.0 + 1e-9) && before - now <= jerk * dt * (1.0 + 1e-6);
                assert!(name != "tracker" || falls, "{name} {seed} {k}: {before} {now}");
            }
            assert!(distance([plant.motion().pose[0], plant.motion().pose[1]], bends[0]) > 1.0, "{name} {seed} goes on");
        }
    }
}
