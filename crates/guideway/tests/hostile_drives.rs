//! Drives by lidar with everything that goes wrong on a robot: each has a defined outcome, and none is a collision of a robot that moves.

use guideway::Point;
use guideway::context::Context;
use guideway::drive::{
    Ask, CONTROLLERS, Eyes, Lidar, Observation, Outline, OwnReplanner, Pilot, Planning, Plant, Robot, Scan, Setup, Step, Unicycle, UnicyclePlant,
    controller, visible,
};
use guideway::plan;
use guideway::query::{Limits, Query};
use guideway::world::{Appears, Footprint, Loop, Mover, Shape, World};
use serde_json::Value;
use std::sync::Arc;

const DT: f64 = 0.05;

/// A disc of 0.25 m that drives from (1, 3) to (9, 3) past two pillars, seen by its lidar alone.
struct Trial {
    world: Arc<World>,
    pilot: Pilot<'static>,
    plant: UnicyclePlant,
    lidar: Lidar,
    rng: rand_chacha::ChaCha8Rng,
    ctx: Context<'static>,
    t: f64,
    /// Steps so far, and what the robot was told in each.
    steps: Vec<Step>,
    /// Least distance to anything, m, while the robot moved.
    room: f64,
}

impl Trial {
    fn new(movers: Vec<Mover>, map_known: bool) -> Self {
        let pillars = [[4.0, 2.8], [6.5, 3.4]].map(|p| Shape::disc(p, 0.3).unwrap());
        let world = Arc::new(World::from_shapes([0.0, 0.0, 10.0, 6.0], pillars.to_vec(), 0.05).unwrap().with_movers(movers));
        let limits = Limits {
            speed: 1.0,
            acceleration: 1.0,
            deceleration: 1.0,
            jerk: 10.0,
            turn_rate: Some(2.0),
            turn_acceleration: Some(4.0),
            ..Limits::default()
        };
        let footprint = Footprint::Disc(0.25);
        let known = if map_known { Arc::clone(&world) } else { Arc::new(World::from_shapes(world.bounds(), Vec::new(), 0.05).unwrap()) };
        let mut query = Query::new(Arc::clone(&known), [1.0, 3.0], [9.0, 3.0]);
        (query.footprint, query.clearance) = (footprint.clone(), 0.1);
        let planning = Arc::new(Planning::new(plan::planner("visibility", Value::Null).unwrap(), limits));
        let motion = planning.motion(&Ask { query: query.clone(), speed: 0.0 }, &mut Context::new(0)).unwrap();
        let robot = Robot::new(footprint, &limits).unwrap();
        let setup = Setup { world: known, robot: robot.clone(), clearance: query.clearance };
        let chosen = controller(CONTROLLERS[0].name, Value::Null, &setup).unwrap();
        let again: Box<OwnReplanner<'static>> = Box::new(move |ask, ctx| planning.motion(ask, ctx));
        let lidar = Lidar::default();
        let eyes = Eyes::new(lidar, &world, map_known).unwrap();
        let pilot = Pilot::new((&query, &motion), &robot, chosen, Some(again)).unwrap().with_eyes(eyes);
        let plant = Unicycle::default().place(&robot, [1.0, 3.0, 0.0], 3);
        let (rng, ctx) = (Lidar::random(3), Context::new(3));
        Self { world, pilot, plant, lidar, rng, ctx, t: 0.0, steps: Vec::new(), room: f64::INFINITY }
    }

    fn there(&self) -> Vec<(Outline, Point)> {
        visible(self.world.movers(), self.t).into_iter().map(|t| (t.outline, t.position)).collect()
    }

    /// One step; `change` edits what the robot is told.
    fn step(&mut self, change: impl FnOnce(&mut Observation, &mut Option<Scan>)) {
        let mut seen = self.plant.observe();
        seen.time = self.t;
        let pose = self.plant.motion().pose;
        let mut scan = Some(self.lidar.scan(&self.world, &self.there(), (pose, self.t), &mut self.rng));
        change(&mut seen, &mut scan);
        let step = self.pilot.step(&mut seen, scan, &mut self.ctx);
        for _ in 0..5 {
            self.plant.step(step.command, DT / 5.0);
            self.t += DT / 5.0;
            let m = self.plant.motion();
            if m.v.abs() > 0.01 {
                let p = [m.pose[0], m.pose[1]];
                let movers = self.there().into_iter().map(|(o, at)| o.distance([p[0] - at[0], p[1] - at[1]]));
                self.room = movers.fold(self.room.min(self.world.clearance(p) - 0.25), |a, b| a.min(b - 0.25));
            }
        }
        self.steps.push(step);
    }

    /// Steps until the robot rests at the goal; false if it does not within `limit` s.
    fn arrives(&mut self, limit: f64, mut change: impl FnMut(f64, &mut Observation, &mut Option<Scan>)) -> bool {
        let end = self.t + limit;
        while self.t < end {
            let t = self.t;
            self.step(|seen, scan| change(t, seen, scan));
            let m = self.plant.motion();
            if (m.pose[0] - 9.0).hypot(m.pose[1] - 3.0) < 0.1 && m.v.abs() < 0.01 {
                return true;
            }
        }
        false
    }

    fn kinds(&self) -> Vec<&str> {
        self.steps.iter().flat_map(|s| s.events.iter().map(|e| e.kind.as_str())).collect()
    }

    fn rests(&self) -> bool {
        self.plant.motion().v.abs() < 0.01
    }

    fn reason(&self) -> String {
        self.steps.last().and_then(|s| s.stop.clone()).unwrap_or_default()
    }
}

fn disc(radius: f64, at: Point, appears: Option<Appears>) -> Mover {
    Mover { shape: Footprint::Disc(radius), track: vec![[0.0, at[0], at[1]]], repeat: Loop::Once, phase: 0.0, appears }
}

#[test]
fn by_lidar_it_arrives_with_and_without_a_map() {
    for map_known in [true, false] {
        let mut trial = Trial::new(Vec::new(), map_known);
        assert!(trial.arrives(40.0, |_, _, _| {}), "{map_known}: {:?} {:?}", trial.plant.motion(), trial.kinds());
        assert!(trial.room > 0.0, "{map_known}: {}", trial.room);
    }
}

#[test]
fn a_lidar_that_goes_silent_stops_the_robot_until_it_speaks_again() {
    let mut trial = Trial::new(Vec::new(), false);
    let mut rested = false;
    let arrived = trial.arrives(60.0, |t, seen, scan| {
        if (2.0..6.0).contains(&t) {
            *scan = None;
        }
        rested |= t > 4.5 && t < 6.0 && seen.v.abs() < 0.01;
    });
    assert!(rested && arrived && trial.room > 0.0, "{:?}", trial.kinds());
    assert!(trial.kinds().contains(&"blind") && trial.kinds().contains(&"go"));
}

#[test]
fn a_clock_that_jumps_back_and_forth_costs_time_and_nothing_else() {
    for (at, offset) in [(3.0, 100.0), (3.0, -50.0), (3.0, 0.8), (3.0, -0.3)] {
        let mut trial = Trial::new(vec![disc(0.3, [5.2, 3.9], None)], false);
        let arrived = trial.arrives(60.0, |t, seen, scan| {
            if t > at {
                seen.time += offset;
                for s in scan.iter_mut() {
                    s.time += offset;
                }
            }
        });
        assert!(arrived && trial.room > 0.0, "{offset}: {} {:?}", trial.room, trial.kinds());
    }
    // A clock of the lidar alone that runs away: nothing fresh is seen any more.
    let mut trial = Trial::new(Vec::new(), false);
    let arrived = trial.arrives(10.0, |t, _, scan| {
        if t > 3.0 {
            for s in scan.iter_mut() {
                s.time += 100.0;
            }
        }
    });
    assert!(!arrived && trial.rests() && trial.kinds().contains(&"blind"));
}

#[test]
fn broken_ranges_are_no_danger() {
    let bad = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, -1.0, 1e300];
    let mut trial = Trial::new(Vec::new(), false);
    let arrived = trial.arrives(60.0, |t, _, scan| {
        let first = (t / DT).round() as usize;
        if let Some(scan) = scan {
            // Three of ten rays, others in every scan, now and then a scan that is no good at all.
            scan.ranges.iter_mut().enumerate().filter(|(i, _)| (i + first) % 10 < 3).for_each(|(i, r)| *r = bad[i % 5]);
            match first % 20 {
                7 => scan.ranges.truncate(10),
                11 => scan.ranges.fill(f64::NAN),
                13 => scan.ranges.fill(-2.0),
                17 => scan.step = 0.0,
                _ => {}
            }
        }
    });
    assert!(arrived && trial.room > 0.0, "{} {:?}", trial.room, trial.kinds());
    // Nothing but broken scans: blind.
    for change in [|s: &mut Scan| s.ranges.fill(f64::NAN), |s: &mut Scan| s.ranges.truncate(359), |s: &mut Scan| s.ranges.fill(f64::NEG_INFINITY)] {
        let mut trial = Trial::new(Vec::new(), false);
        let arrived = trial.arrives(5.0, |t, _, scan| {
            if t > 2.0 {
                scan.iter_mut().for_each(change);
            }
        });
        assert!(!arrived && trial.rests() && trial.reason().contains("seen"), "{}", trial.reason());
    }
}

#[test]
fn poses_that_are_no_numbers_stop_the_robot_while_they_last() {
    let mut trial = Trial::new(Vec::new(), false);
    let arrived = trial.arrives(60.0, |t, seen, _| {
        if (2.0..4.0).contains(&t) {
            seen.pose[0] = f64::NAN;
        }
    });
    assert!(arrived && trial.room > 0.0, "{:?}", trial.kinds());
}

#[test]
fn an_obstacle_spawned_on_the_robot_keeps_it_there() {
    for map_known in [true, false] {
        let mut trial = Trial::new(vec![disc(0.5, [2.0, 3.0], Some(Appears::At(2.0)))], map_known);
        assert!(!trial.arrives(12.0, |_, _, _| {}), "{map_known}: it cannot get out of a disc that covers it");
        assert!(trial.rests() && !trial.reason().is_empty(), "{map_known}: {:?}", trial.plant.motion());
    }
}

#[test]
fn walled_in_it_stands_and_says_that_there_is_no_way() {
    let ring = |i: u32| {
        let (s, c) = (f64::from(i) * std::f64::consts::TAU / 14.0).sin_cos();
        disc(0.35, [1.4 + 1.3 * c, 3.0 + 1.3 * s], Some(Appears::At(0.2)))
    };
    for map_known in [true, false] {
        let mut trial = Trial::new((0..14).map(ring).collect(), map_known);
        assert!(!trial.arrives(15.0, |_, _, _| {}));
        assert!(trial.kinds().contains(&"no-plan") && trial.room > 0.0, "{map_known}: {} {:?}", trial.room, trial.kinds());
    }
}

#[test]
fn before_a_goal_that_is_occupied_for_good_it_waits() {
    for map_known in [true, false] {
        let mut trial = Trial::new(vec![disc(0.4, [9.0, 3.0], None)], map_known);
        assert!(!trial.arrives(25.0, |_, _, _| {}));
        let m = trial.plant.motion();
        let left = (m.pose[0] - 9.0).hypot(m.pose[1] - 3.0);
        assert!(trial.room > 0.0 && left < 3.0 && m.v.abs() < 0.3, "{map_known}: {left} {m:?} {:?}", trial.kinds());
    }
}
