//! Motions among movers: separation at every millisecond, limits, brakes.

use guideway::certify::motion::{Asked, motion};
use guideway::context::Context;
use guideway::error::PlanError;
use guideway::path::Path;
use guideway::plan::planner;
use guideway::query::{Limits, Query};
use guideway::timing::movers::{Among, Timed, among};
use guideway::timing::{Piece, TimingOptions, Trajectory, stop_distance, stopping_distance, time};
use guideway::world::{Appears, Footprint, Loop, Mover, Shape, World};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use std::sync::Arc;

const KEPT: f64 = 0.3;

fn limits() -> Limits {
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

fn shuttle(from: [f64; 2], to: [f64; 2], speed: f64, phase: f64) -> Mover {
    let period = (to[0] - from[0]).hypot(to[1] - from[1]) / speed;
    let track = vec![[0.0, from[0], from[1]], [period, to[0], to[1]]];
    Mover { phase, repeat: Loop::Shuttle, ..Mover::new(Footprint::Box([0.8, 0.8]), track).unwrap() }
}

/// The room with its four cubes at phases of a seed.
fn room(seed: u64) -> Query {
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
fn least(trajectory: &Trajectory, movers: &[Mover]) -> f64 {
    let n = (trajectory.duration() * 1000.0).ceil() as usize;
    let gap = |k: usize| {
        let t = (k as f64 * 1e-3).min(trajectory.duration());
        let [x, y, _] = trajectory.at(t).pose;
        movers.iter().map(|m| m.distance([x, y], t)).fold(f64::INFINITY, f64::min)
    };
    (0..=n).map(gap).fold(f64::INFINITY, f64::min)
}

fn sound(timed: &Timed, movers: &[Mover], kept: f64) {
    let failed: Vec<_> = motion(&timed.trajectory, &Asked::default()).into_iter().filter(|c| !c.ok).collect();
    assert!(failed.is_empty(), "{failed:#?}");
    let least = least(&timed.trajectory, movers);
    assert!(least >= kept - 1e-9, "{least} m, {:?}", timed.record);
}

/// The shortest way leads over a course that a cube never leaves; the way between two discs in the middle is free now and then.
#[test]
fn the_room_at_eight_phases() {
    let (mut solved, mut delayed) = (0, 0);
    for seed in 0..8 {
        let mut query = room(seed);
        for via in [vec![], vec![[2.25, 2.17]]] {
            let closed = via.is_empty();
            query.via = via;
            let plan = planner("iascv", serde_json::json!({"movers": false, "timing": "time-optimal"})).unwrap();
            let path = plan.plan(&query, &mut Context::new(seed)).unwrap().path;
            match among(&path, &query.limits, &TimingOptions::default(), &Among::new(query.world.movers(), KEPT), &mut Context::new(seed)) {
                Ok(timed) => {
                    println!("{seed}: {:?} of {:.3} s", timed.record, timed.trajectory.duration());
                    assert!(!closed);
                    sound(&timed, query.world.movers(), KEPT);
                    solved += 1;
                    delayed += usize::from(timed.record.delay > 0.0);
                }
                Err(PlanError::Infeasible { reason, .. }) => assert!(closed && reason.contains("at all times"), "{reason}"),
                Err(error) => panic!("{error}"),
            }
        }
    }
    println!("{solved} of 8, {delayed} delayed");
    assert!(solved == 8 && delayed >= 3, "{solved} solved, {delayed} delayed");
}

/// `iascv` says what became of the movers.
#[test]
fn a_planner_tells_how_its_motion_was_timed() {
    let mut query = room(1);
    let plan = |query: &Query, movers: bool| {
        let solution = planner("iascv", serde_json::json!({ "movers": movers })).unwrap().plan(query, &mut Context::new(1)).unwrap();
        (solution.trace["speed"]["movers"].clone(), solution.trajectory.unwrap())
    };
    let (closed, _) = plan(&query, true);
    assert!(closed["timed"] == false && closed["reason"].as_str().unwrap().contains("mover 2"), "{closed}");
    query.via = vec![[2.25, 2.17]];
    let (told, motion) = plan(&query, true);
    assert!(told["timed"] == true && least(&motion, query.world.movers()) >= KEPT - 1e-9, "{told}");
    assert!(plan(&query, false).0.is_null());
}

fn straight(length: f64) -> Path {
    Path::polyline(&[[0.0, 0.0], [length, 0.0]])
}

fn ask(path: &Path, movers: &[Mover], passive: bool) -> Result<Timed, PlanError> {
    let around = Among { passive, ..Among::new(movers, KEPT) };
    among(path, &limits(), &TimingOptions::default(), &around, &mut Context::new(1))
}

#[test]
fn the_plain_motion_stays_where_nobody_is_near() {
    let far = shuttle([0.0, 5.0], [5.0, 5.0], 0.5, 0.0);
    let timed = ask(&straight(4.0), &[far], true).unwrap();
    assert_eq!(timed.trajectory, time(&straight(4.0), &limits(), &TimingOptions::default(), &mut Context::new(1)).unwrap());
    assert!(timed.record.passive && timed.record.delay == 0.0 && timed.record.waiting == 0.0);
}

#[test]
fn it_waits_for_one_who_crosses_and_goes_on() {
    let track = vec![[0.0, 2.0, -1.5], [6.0, 2.0, 4.5]];
    let crossing = [Mover::new(Footprint::Disc(0.3), track).unwrap()];
    for passive in [true, false] {
        let timed = ask(&straight(4.0), &crossing, passive).unwrap();
        sound(&timed, &crossing, KEPT);
        assert!(timed.record.delay > 0.1 && timed.record.delay < 4.0, "{:?}", timed.record);
        assert_eq!(timed.record.passive, passive);
    }
}

#[test]
fn corners_and_waits_before_them() {
    let path = Path::polyline(&[[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [4.0, 2.0]]);
    for phase in 0..12 {
        let movers = [shuttle([2.0, -1.0], [2.0, 4.0], 0.5, f64::from(phase)), shuttle([0.5, 2.0], [6.0, 2.0], 0.6, 1.7 * f64::from(phase))];
        match ask(&path, &movers, true) {
            Ok(timed) => sound(&timed, &movers, KEPT),
            Err(error) => assert!(matches!(error, PlanError::Infeasible { .. }), "{error}"),
        }
    }
}

#[test]
fn no_motion_names_the_mover_and_the_place() {
    let parked = [Mover::new(Footprint::Disc(0.3), vec![[0.0, 3.0, 0.1]]).unwrap()];
    let error = ask(&straight(4.0), &parked, true).unwrap_err();
    assert!(matches!(&error, PlanError::Infeasible { reason, .. } if reason.contains("mover 1") && reason.contains("at all times")), "{error}");
    let late = [Mover { appears: Some(Appears::At(10.0)), ..parked[0].clone() }];
    assert_eq!(ask(&straight(4.0), &late, true).unwrap().record.delay, 0.0);
    let around = Among { latency: f64::NAN, ..Among::new(&parked, KEPT) };
    let error = among(&straight(4.0), &limits(), &TimingOptions::default(), &around, &mut Context::new(1)).unwrap_err();
    assert!(matches!(error, PlanError::BadParameter { .. }));
}

#[test]
fn braking_is_possible_everywhere() {
    let (movers, latency) = ([shuttle([3.0, -2.0], [3.0, 2.0], 0.5, 1.0)], 0.1);
    let timed = ask(&straight(6.0), &movers, true).unwrap();
    assert!(timed.record.passive);
    let speeds: Vec<_> = (0..(timed.trajectory.duration() * 20.0) as usize).map(|k| timed.trajectory.at(k as f64 / 20.0)).collect();
    for now in speeds.iter().filter(|q| q.speed > 1e-3 && q.acceleration <= 0.0 && q.acceleration > -0.1) {
        let place = (now.s + stop_distance(now.speed, latency, &limits())).min(6.0);
        let time = latency + 2.0 * (now.speed / limits().jerk).sqrt();
        assert!(movers[0].distance([place, 0.0], now.t) - 0.5 * time >= KEPT - 0.02, "{now:?}");
    }
}

#[test]
fn distance_to_stop() {
    let l = limits();
    assert_eq!(stop_distance(1.5, 0.0, &l), stopping_distance(1.5, &l));
    // Below B^2/J = 2.5 m/s: v t + v sqrt(v/J); above: v t + v^2/(2B) + vB/(2J).
    assert!((stop_distance(2.0, 0.1, &l) - (0.2 + 2.0 * 0.2f64.sqrt())).abs() < 1e-12);
    assert!((stop_distance(4.0, 0.1, &l) - (0.4 + 1.6 + 1.0)).abs() < 1e-12);
}

#[test]
fn waiting_is_a_turn_by_nothing() {
    let crossing = [Mover::new(Footprint::Disc(0.3), vec![[0.0, 2.0, -1.5], [6.0, 2.0, 4.5]]).unwrap()];
    let timed = ask(&straight(4.0), &crossing, true).unwrap();
    let waits = timed.trajectory.pieces.iter().filter(|p| matches!(p, Piece::Turn { turn, .. } if *turn == 0.0));
    assert!((waits.map(Piece::duration).sum::<f64>() - timed.record.waiting).abs() < 1e-9);
}
