//! Motions among movers: separation at every millisecond, limits, brakes.

mod common_movers;

use common_movers::{KEPT, least, least_after_a_brake, limits, room, shuttle};
use guideway::certify::motion::{Asked, motion as motion_checks};
use guideway::context::Context;
use guideway::error::PlanError;
use guideway::path::Path;
use guideway::plan::planner;
use guideway::timing::movers::{Among, Timed, among};
use guideway::timing::{Piece, TimingOptions, stop_distance, stopping_distance, time};
use guideway::world::{Appears, Footprint, Mover, World};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;

fn sound(timed: &Timed, movers: &[Mover], kept: f64) {
    let failed: Vec<_> = motion_checks(&timed.trajectory, &Asked::default()).into_iter().filter(|c| !c.ok).collect();
    assert!(failed.is_empty(), "{failed:#?}");
    let least = least(&timed.trajectory, movers);
    assert!(least >= kept - 1e-9, "{least} m, {:?}", timed.record);
    if timed.record.passive {
        let left = least_after_a_brake(&timed.trajectory, movers, 0.1);
        assert!(left >= kept - 0.01, "{left} m after a brake, {:?}", timed.record);
    }
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

/// The shortest way is closed by a cube: both planners take another one, and say so.
#[test]
fn planners_take_another_way() {
    for seed in 0..3 {
        let query = room(seed);
        for (name, settings) in [("iascv", serde_json::json!({})), ("aide", serde_json::json!({"generations": 20, "bound": false}))] {
            let solution = planner(name, settings).unwrap().plan(&query, &mut Context::new(1)).unwrap();
            let (told, motion) = (&solution.trace["speed"]["movers"], solution.trajectory.unwrap());
            println!("{seed} {name}: {told}");
            assert!(told["timed"] == true && told["way"].as_u64().unwrap() > 0, "{told}");
            assert!(motion.path == solution.path && least(&motion, query.world.movers()) >= KEPT - 1e-9);
            let failed: Vec<_> = motion_checks(&motion, &Asked::default()).into_iter().filter(|c| !c.ok).collect();
            assert!(failed.is_empty(), "{failed:#?}");
        }
    }
}

/// Where no way can be timed, the reason says what, where and what to do. Nobody looks at movers if not asked.
#[test]
fn a_planner_tells_why_there_is_no_motion() {
    let mut query = room(1);
    let parked = Mover::new(Footprint::Disc(0.3), vec![[0.0, 5.0, 3.2]]).unwrap();
    let world = World::from_shapes([0.0, 0.0, 10.0, 6.0], Vec::new(), 0.05).unwrap().with_movers(vec![parked]);
    query.world = std::sync::Arc::new(world);
    let plan = |movers: bool| {
        let solution = planner("iascv", serde_json::json!({ "movers": movers })).unwrap().plan(&query, &mut Context::new(1)).unwrap();
        solution.trace["speed"]["movers"].clone()
    };
    let told = plan(true);
    let reason = told["reason"].as_str().unwrap();
    assert!(told["timed"] == false && ["mover 1", "(", "smaller clearance"].iter().all(|word| reason.contains(word)), "{reason}");
    assert!(plan(false).is_null());
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

/// Corners whose arc lengths are no round numbers: a turn must not get lost where a motion pauses before it.
#[test]
fn turns_at_crooked_corners() {
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    let mut delayed = 0;
    for _ in 0..40 {
        let mut draw = |low: f64, high: f64| rng.random_range(low..high);
        let points: Vec<[f64; 2]> = (0..5).map(|k| [1.7 * f64::from(k) + draw(-0.2, 0.2), draw(-0.6, 0.6)]).collect();
        let movers = [shuttle([3.1, -3.0], [3.1, 3.0], draw(0.4, 0.9), draw(0.0, 15.0))];
        match ask(&Path::polyline(&points), &movers, true) {
            Ok(timed) => {
                sound(&timed, &movers, KEPT);
                delayed += usize::from(timed.record.delay > 0.0);
            }
            Err(error) => assert!(matches!(error, PlanError::Infeasible { .. }), "{error}"),
        }
    }
    assert!(delayed >= 10, "{delayed}");
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
