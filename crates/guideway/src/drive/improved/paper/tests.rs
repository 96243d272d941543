use super::super::super::testing::{curve, legs, query, room};
use super::super::super::{Course, Job, Observation, Outcome, Robot, Run, Setup, controller, execute};
use super::*;
use crate::query::Limits;
use crate::world::{Footprint, Shape};
use serde_json::{Value, json};

const HALL: [f64; 4] = [0.0, 0.0, 12.0, 8.0];

/// The robot of the source.
fn weak() -> Limits {
    let slow = Limits { speed: 1.0, acceleration: 0.25, deceleration: 0.25, jerk: 10.0, ..Limits::default() };
    Limits { turn_rate: Some(0.56), turn_acceleration: Some(0.85), ..slow }
}

/// The window of a disc of 0.2 m in a hall with discs.
fn window(set: &Value, discs: &[(Point, f64)]) -> Window {
    let mut all = json!({"preset": "paper"});
    all.as_object_mut().unwrap().extend(set.as_object().cloned().unwrap_or_default());
    let mut given = serde_json::to_value(ImprovedDwa::paper()).unwrap();
    given.as_object_mut().unwrap().extend(all.as_object().cloned().unwrap());
    let world = room(HALL, discs.iter().map(|(c, r)| Shape::disc(*c, *r).unwrap()).collect(), Vec::new());
    let robot = Robot::new(Footprint::Disc(0.2), &weak()).unwrap();
    made(serde_json::from_value(given).unwrap(), &Setup { world, robot, clearance: 0.35 })
}

/// What it decides on the way from (1, 4) to (11, 4), at `x` with speed `v`.
fn decided(mut window: Window, x: f64, v: f64) -> Decision {
    let guide = Arc::new(Guide::along(Arc::new(Course::new(&legs(&[[1.0, 4.0], [11.0, 4.0]], weak())).unwrap())));
    window.follow(&guide);
    window.decide(&Observation::new(0.0, [x, 4.0, 0.0], v, 0.0), &mut Context::new(0))
}

/// A drive along a path among discs.
fn driven(name: &str, set: Value, (path, discs): (&[Point], &[(Point, f64)])) -> Run {
    let world = room(HALL, discs.iter().map(|(c, r)| Shape::disc(*c, *r).unwrap()).collect(), Vec::new());
    let mut query = query(&world, path);
    query.footprint = Footprint::Disc(0.2);
    let motion = legs(path, weak());
    let mut job = Job::new(&query, &motion).unwrap();
    (job.time_limit, job.arrival) = (Some(4.0 * motion.duration()), 0.2);
    let setup = Setup { world, robot: job.robot.clone(), clearance: 0.35 };
    execute(&job, controller(name, set, &setup).unwrap().as_mut(), &mut Context::new(1)).unwrap()
}

/// Around a disc that is beside the straight line, with 0.4 m to spare.
const AROUND: ([Point; 3], [(Point, f64); 2]) = ([[1.0, 4.0], [6.0, 5.2], [11.0, 4.0]], [([6.0, 4.1], 0.5), ([6.5, 6.8], 0.4)]);

fn first_reading() -> Value {
    json!({"preset": "paper", "heading": 0.08, "path": 0.45, "aim": 0.1, "room": "least", "clear": true})
}

#[test]
fn it_arrives_around_an_obstacle_and_in_the_first_reading_it_does_not() {
    let run = driven("improved-dwa", json!({"preset": "paper"}), (&AROUND.0, &AROUND.1));
    assert_eq!(run.outcome, Outcome::Arrived, "{:?}", run.events);
    assert!(run.min_separation.still.unwrap() > 0.2);
    let run = driven("improved-dwa", first_reading(), (&AROUND.0, &AROUND.1));
    assert_ne!(run.outcome, Outcome::Arrived, "{} s", run.time);
}

#[test]
fn the_weights_are_the_printed_ones_in_the_order_of_the_objective() {
    let w = ImprovedDwa::paper().weights();
    assert_eq!([w.heading, w.dist, w.velocity, w.path], [0.45, 0.35, 0.12, 0.08]);
}

#[test]
fn nearer_than_the_safety_distance_it_brakes_and_then_turns_or_goes_on() {
    // 0.3 m from the hull, 0.5 m from the reference point, on the left and a little behind.
    let near = [([2.9, 4.99], 0.5)];
    let slow = |set: Value| decided(window(&set, &near), 3.0, 0.1);
    assert!(matches!(decided(window(&json!({}), &near), 3.0, 0.5), Decision::Stop(_)));
    assert!(matches!(decided(window(&json!({"centred": true}), &near), 3.0, 0.5), Decision::Drive(_)));
    // Towards the sub-goal already: the window goes on either way.
    assert!(matches!(slow(json!({})), Decision::Drive(command) if command.v > 0.0));
    let turned = |set: Value| {
        let mut window = window(&set, &near);
        let guide = Arc::new(Guide::along(Arc::new(Course::new(&legs(&[[3.0, 4.0], [3.0, 1.0]], weak())).unwrap())));
        window.follow(&guide);
        window.decide(&Observation::new(0.0, [3.0, 4.0, 0.0], 0.1, 0.0), &mut Context::new(0))
    };
    assert!(matches!(turned(json!({})), Decision::Drive(command) if command.v == 0.0 && command.w < -0.5));
    assert!(matches!(turned(json!({"pivot": false})), Decision::Drive(command) if command.v > 0.0));
}

#[test]
fn what_can_still_be_stopped_for_is_open_unless_all_contacts_are_out() {
    // 1.5 m free, met within 3 s at 0.6 m/s; braking takes 0.72 m.
    let wall = [([5.2 + 0.35 + 1.5, 4.0], 2.0)];
    assert!(matches!(decided(window(&json!({}), &wall), 3.0, 0.6), Decision::Drive(_)));
    assert!(matches!(decided(window(&json!({"clear": true}), &wall), 3.0, 0.6), Decision::Stop(_)));
    // 0.5 m free: neither.
    assert!(matches!(decided(window(&json!({}), &wall), 4.0, 0.6), Decision::Stop(_)));
}

#[test]
fn distances_are_what_they_are_called() {
    let disc = [([6.0, 4.0], 0.5)];
    let value = |set: Value| {
        let window = window(&set, &disc);
        let seen = Observation::new(0.0, [3.0, 4.0, 0.0], 0.5, 0.0);
        let margins = Margins { still: 0.35, moving: 0.35, growth: 0.0 };
        let field = Field::new(&window.setup.world, &window.setup.robot, &window.body, &seen, (margins, 3.0));
        let dist = |v: f64| window.dist(&field, seen.pose, [v, 0.0], field.contact(seen.pose, [v, 0.0], window.sight(v)).map(|c| c.0));
        (dist(0.5), dist(0.0))
    };
    // 2.3 m between the hulls now, 0.8 m after 3 s at 0.5 m/s.
    let near = |set: Value, wanted: f64| {
        let (found, _) = value(set);
        assert!((found - wanted).abs() < 0.02, "{found} {wanted}");
    };
    near(json!({"room": "least", "far": 3.0}), 0.8);
    near(json!({"room": "end", "far": 3.0}), 0.8);
    near(json!({"room": "mean", "far": 3.0}), 1.55);
    near(json!({"room": "free", "far": 3.0}), 1.95);
    near(json!({"room": "free"}), 1.95);
    near(json!({"room": "free", "far": 1.0}), 1.0);
    near(json!({"room": "least", "far": 0.5}), 0.5);
    assert_eq!(value(json!({"room": "free"})).1, 2.0);
}

#[test]
fn scores_are_divided_by_their_sum_or_by_what_they_can_be() {
    let p = ImprovedDwa { divide: Divide::Scale, ..ImprovedDwa::paper() };
    let all = Candidate { v: 0.5, dist: p.far, target: [1.0, 0.0], ..Candidate::default() };
    let total = scaled(p, 0.5).total(&all);
    assert!((total - 1.0).abs() < 1e-12, "the best there is scores the sum of the weights, 1: {total}");
    assert!(matches!(decided(window(&json!({"divide": "scale"}), &[]), 3.0, 0.5), Decision::Drive(command) if command.v > 0.5));
}

#[test]
fn the_direction_of_the_path_is_that_of_its_nearest_point() {
    let course = Course::new(&curve(&[[1.0, 1.0], [2.5, 1.0], [4.5, 1.0], [6.0, 2.0], [6.0, 3.5], [6.0, 5.0]])).unwrap();
    for from in [0.0, 1.7, 4.0] {
        let ahead = Ahead::new(&course, from);
        for k in 0..200 {
            let p = [1.0 + 0.03 * f64::from(k), 1.0 + 0.02 * f64::from(k % 37)];
            let exact = course.at_length(course.project(p, from, from + AHEAD).0).pose[2];
            assert!(wrap(ahead.direction(p) - exact).abs() < 1e-3, "{p:?} {} {exact}", ahead.direction(p));
        }
    }
}

#[test]
fn measured_from_the_reference_point_both_windows_pass_a_gap_that_is_too_narrow_else() {
    // 1.0 m wide: 0.3 m on both sides of the hull.
    let (path, gap) = ([[1.0, 4.0], [11.0, 4.0]], [([6.0, 5.5], 1.0), ([6.0, 2.5], 1.0)]);
    for (name, set) in [("dwa", json!({"safety": 0.35})), ("improved-dwa", json!({"preset": "paper"}))] {
        let centred = set.as_object().cloned().map(|mut map| {
            map.insert("centred".into(), Value::Bool(true));
            Value::Object(map)
        });
        let beyond = |run: &Run| run.driven.iter().find(|row| row[1] > 7.5).map_or(f64::INFINITY, |row| row[0]);
        let (free, kept) = (driven(name, centred.unwrap(), (&path, &gap)), driven(name, set, (&path, &gap)));
        assert!(beyond(&free) < 20.0 && free.outcome != Outcome::Collision, "{name} {} {:?}", beyond(&free), free.events);
        assert!(beyond(&kept) > 1.2 * beyond(&free), "{name} {} {}", beyond(&kept), beyond(&free));
    }
}
