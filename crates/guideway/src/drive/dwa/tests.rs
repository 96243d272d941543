use super::super::testing::{drive, legs, limits, query, room, shuttle};
use super::super::{Job, Outcome, Run, controller, execute};
use super::*;
use crate::Point;
use crate::world::{Loop, Mover, Shape};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use serde_json::json;

const HALL: [f64; 4] = [0.0, 0.0, 12.0, 8.0];

/// Discs and boxes all over the hall, and a straight line through them that no one has checked.
fn cluttered(rng: &mut ChaCha8Rng) -> (Vec<Shape>, [Point; 2]) {
    let ends = [[1.0, rng.random_range(1.0..7.0)], [11.0, rng.random_range(1.0..7.0)]];
    let mut shapes = Vec::new();
    while shapes.len() < 14 {
        let center: Point = [rng.random_range(0.5..11.5), rng.random_range(0.5..7.5)];
        let r: f64 = rng.random_range(0.1..0.6);
        if ends.iter().all(|e| (e[0] - center[0]).hypot(e[1] - center[1]) > r + 0.6) {
            let corner = |x: f64, y: f64| [center[0] + x * 0.7 * r, center[1] + y * 0.7 * r];
            let square = vec![corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)];
            shapes.push(if shapes.len() % 2 == 0 { Shape::disc(center, r) } else { Shape::polygon(square) }.unwrap());
        }
    }
    (shapes, ends)
}

#[test]
fn no_dynamic_window_drives_into_static_obstacles() {
    for (name, worlds) in [("dwa", 8), ("improved-dwa", 4)] {
        for seed in 0..worlds {
            let (shapes, ends) = cluttered(&mut ChaCha8Rng::seed_from_u64(seed));
            let world = room(HALL, shapes, Vec::new());
            let run = drive(name, &query(&world, &ends), &ends, seed, |job| job.time_limit = Some(15.0));
            assert_ne!(run.outcome, Outcome::Collision, "{name} {seed} {:?}", run.collision);
            assert!(run.min_separation.still.unwrap() > 0.0 && run.tracking.length > 0.5);
        }
    }
}

#[test]
fn no_moving_robot_meets_a_mover_that_keeps_its_velocity() {
    let ends = [[1.0, 4.0], [11.0, 4.0]];
    for seed in 0..6 {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let movers: Vec<Mover> = (0..3)
            .map(|_| {
                let (x, up): (f64, bool) = (rng.random_range(3.0..10.0), rng.random());
                let (from, to) = if up { (-1.0, 40.0) } else { (9.0, -40.0) };
                let lean = rng.random_range(-10.0..10.0);
                Mover { repeat: Loop::Once, ..shuttle(0.3, [[x, from], [x + lean, to]], rng.random_range(0.3..1.0), rng.random_range(0.0..6.0)) }
            })
            .collect();
        let world = room(HALL, Vec::new(), movers);
        let run = drive("improved-dwa", &query(&world, &ends), &ends, seed, |_| {});
        assert!(run.collision.as_ref().is_none_or(|c| c.unavoidable), "{seed} {:?}", run.collision);
        assert_eq!(run.outcome, Outcome::Arrived, "{seed} {:?}", run.events);
    }
}

/// A pocket that opens towards the robot, across the straight line to the goal.
fn pocket() -> Vec<Shape> {
    let plank = |x0: f64, y0: f64, x1: f64, y1: f64| Shape::polygon(vec![[x0, y0], [x1, y0], [x1, y1], [x0, y1]]).unwrap();
    vec![plank(6.0, 2.5, 6.2, 5.5), plank(4.0, 5.5, 6.2, 5.7), plank(4.0, 2.3, 6.2, 2.5)]
}

fn in_the_pocket(name: &str, path: &[Point], parameters: serde_json::Value) -> Run {
    let world = room(HALL, pocket(), Vec::new());
    let query = query(&world, path);
    let trajectory = legs(path, limits());
    let mut job = Job::new(&query, &trajectory).unwrap();
    (job.stuck_after, job.time_limit) = (10.0, Some(60.0));
    let setup = Setup { world, robot: job.robot.clone(), clearance: query.clearance };
    execute(&job, controller(name, parameters, &setup).unwrap().as_mut(), &mut Context::new(1)).unwrap()
}

#[test]
fn aimed_at_the_goal_alone_the_window_is_caught_in_a_pocket_and_with_a_path_it_is_not() {
    let straight = [[1.0, 4.0], [11.0, 4.0]];
    let around = [[1.0, 4.0], [2.8, 1.2], [7.0, 1.2], [11.0, 4.0]];
    let caught = in_the_pocket("dwa", &straight, json!({"look_ahead": 1e6}));
    assert_eq!(caught.outcome, Outcome::Stuck, "{:?}", caught.events);
    for name in ["dwa", "improved-dwa"] {
        let free = in_the_pocket(name, &around, serde_json::Value::Null);
        assert_eq!(free.outcome, Outcome::Arrived, "{name} {:?}", free.events);
    }
}

#[test]
fn the_window_holds_what_the_base_can_reach() {
    let world = room(HALL, Vec::new(), Vec::new());
    let setup = Setup { world, robot: crate::drive::Robot::new(crate::world::Footprint::Disc(0.2), &limits()).unwrap(), clearance: 0.1 };
    let seen = Observation::new(0.0, [1.0, 1.0, 0.0], 0.95, 0.1);
    let all = window(&setup.robot, &seen, 0.1, [11, 21]);
    assert!(all.iter().all(|(v, w)| (0.85 - 1e-12..=1.0).contains(v) && (-0.3 - 1e-12..=0.5 + 1e-12).contains(w)) && all.len() == 11 * 22);
    let body = Body::of(&setup.robot.footprint);
    let field = Field::new(&setup.world, &setup.robot, &body, &seen, (Margins { still: 0.0, moving: 0.0, growth: 0.0 }, 3.0));
    assert!(field.contact(seen.pose, [1.0, 0.0], 3.0).is_none());
}

#[test]
fn the_first_contact_on_an_arc_is_where_geometry_puts_it() {
    let world = room(HALL, vec![Shape::disc([5.0, 4.0], 0.5).unwrap()], Vec::new());
    let robot = crate::drive::Robot::new(crate::world::Footprint::Disc(0.2), &limits()).unwrap();
    let seen = Observation::new(0.0, [1.0, 4.0, 0.0], 0.0, 0.0);
    let body = Body::of(&robot.footprint);
    let field = Field::new(&world, &robot, &body, &seen, (Margins { still: 0.0, moving: 0.0, growth: 0.0 }, 5.0));
    let (t, met) = field.contact(seen.pose, [1.0, 0.0], 5.0).unwrap();
    assert!(met == Met::Static && (t - 3.3).abs() < 0.011, "{t}");
    assert!(field.contact([1.0, 3.2, 0.0], [1.0, 0.0], 5.0).is_none() && field.contact(seen.pose, [1.0, 1.0], 5.0).is_none());
}

#[test]
fn a_window_that_cannot_stop_in_time_brakes_as_hard_as_it_can() {
    let slow = legs(&[[0.0, 0.0], [8.0, 0.0]], crate::query::Limits { speed: 1.0, acceleration: 0.25, deceleration: 0.25, ..limits() });
    let robot = Robot::new(crate::world::Footprint::Disc(0.2), &slow.limits).unwrap();
    // 2 m of braking, 1.6 m left: neither the present speed nor a little less, but all that the brakes give.
    assert!(!stops(&robot, 1.0, [1.0, 1.6, 0.1, 0.1]) && !stops(&robot, 0.99, [1.0, 1.6, 0.1, 0.1]) && stops(&robot, 0.975, [1.0, 1.6, 0.1, 0.1]));
    assert!(stops(&robot, 1.0, [1.0, 2.2, 0.1, 0.1]) && stops(&robot, 0.0, [0.01, 0.0, 0.1, 0.1]));
}
