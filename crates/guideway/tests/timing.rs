//! Motions along paths: limits, corners, headings, files.

use guideway::certify::motion::{Asked, motion};
use guideway::context::Context;
use guideway::path::Path;
use guideway::query::Limits;
use guideway::timing::{CSV_HEADER, JerkLimited, Method, Piece, Timing, TimingOptions, Trajectory, safe_speed, stopping_distance, time, turn_time};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use std::f64::consts::FRAC_PI_2;

fn limits() -> Limits {
    Limits {
        speed: 2.0,
        acceleration: 2.0,
        deceleration: 3.0,
        jerk: 10.0,
        turn_rate: Some(2.0),
        turn_acceleration: Some(6.0),
        lateral_acceleration: Some(2.0),
    }
}

fn wave() -> Path {
    let control: Vec<f64> = [[0.0, 0.0], [1.5, 0.0], [3.0, 2.0], [4.5, -2.0], [6.0, 2.0], [7.5, 0.0], [9.0, 0.0]].concat();
    let knots = vec![0.0, 0.0, 0.0, 0.0, 1.0, 2.0, 3.0, 4.0, 4.0, 4.0, 4.0];
    Path::new(3, 2, knots, control).unwrap()
}

/// Every limit at a spacing of 0.2 ms, by differences as well as by the states.
fn keeps_limits(trajectory: &Trajectory) {
    let (l, slack) = (trajectory.limits, 1.0 + 1e-6);
    let step = 2e-4;
    let n = (trajectory.duration() / step).ceil() as usize;
    let mut last = trajectory.at(0.0);
    for k in 0..=n {
        let now = trajectory.at(k as f64 * step);
        assert!(now.speed >= -1e-9 && now.speed <= l.speed * slack, "{now:?}");
        assert!(now.acceleration <= l.acceleration * slack && -now.acceleration <= l.deceleration * slack, "{now:?}");
        assert!(now.jerk.abs() <= l.jerk * slack, "{now:?}");
        assert!(now.turn_rate.abs() <= l.turn_rate.unwrap() * slack, "{now:?}");
        assert!(now.curvature.abs() * now.speed.powi(2) <= l.lateral_acceleration.unwrap() * slack, "{now:?}");
        assert!(now.s >= last.s - 1e-12 && now.s - last.s <= l.speed * step * slack + 1e-12, "{now:?}");
        assert!((now.speed - last.speed).abs() <= 3.0 * step * slack + 1e-12, "{last:?} {now:?}");
        assert!((now.acceleration - last.acceleration).abs() <= l.jerk * step * slack + 1e-9, "{last:?} {now:?}");
        last = now;
    }
}

#[test]
fn a_smooth_path_is_driven_without_a_stop() {
    let path = wave();
    let trajectory = time(&path, &limits(), &TimingOptions::default(), &mut Context::new(1)).unwrap();
    keeps_limits(&trajectory);
    let (start, end) = (trajectory.at(0.0), trajectory.at(trajectory.duration()));
    assert!(start.speed == 0.0 && end.speed.abs() < 1e-9 && (end.s - path.length()).abs() < 1e-9);
    let slowest = trajectory.samples(1000.0).iter().filter(|s| s.s > 0.5 && s.s < path.length() - 0.5).map(|s| s.speed).fold(f64::INFINITY, f64::min);
    assert!(slowest > 0.3, "{slowest}");
    let again = time(&path, &limits(), &TimingOptions::default(), &mut Context::new(2)).unwrap();
    assert_eq!(trajectory.pieces, again.pieces);
}

#[test]
fn corners_and_headings_are_turned_in_place() {
    let path = Path::polyline(&[[0.0, 0.0], [3.0, 0.0], [3.0, 2.0]]);
    let method = JerkLimited { start_yaw: Some(FRAC_PI_2), goal_yaw: Some(-FRAC_PI_2), ..JerkLimited::default() };
    let trajectory = method.time(&path, &limits(), &mut Context::new(1)).unwrap();
    keeps_limits(&trajectory);
    let turns: Vec<(f64, f64)> =
        trajectory.pieces.iter().filter_map(|p| if let Piece::Turn { turn, s, .. } = p { Some((*turn, *s)) } else { None }).collect();
    assert_eq!(turns.len(), 3);
    assert!((turns[0].0 + FRAC_PI_2).abs() < 1e-12 && turns[0].1 == 0.0);
    assert!((turns[1].0 - FRAC_PI_2).abs() < 1e-12 && (turns[1].1 - 3.0).abs() < 1e-12);
    assert!((turns[2].0.abs() - 2.0 * FRAC_PI_2).abs() < 1e-12 && (turns[2].1 - 5.0).abs() < 1e-12);
    let (start, end) = (trajectory.at(0.0), trajectory.at(trajectory.duration()));
    assert!((start.pose[2] - FRAC_PI_2).abs() < 1e-12 && (end.pose[2] + FRAC_PI_2).abs() < 1e-9, "{start:?} {end:?}");
    // Rate 2 rad/s with 6 rad/s2: a quarter takes pi / 4 + 1 / 3 seconds.
    assert!((turn_time(FRAC_PI_2, &limits()) - (FRAC_PI_2 / 2.0 + 2.0 / 6.0)).abs() < 1e-12);
}

#[test]
fn a_path_of_no_length_is_a_turn_or_nothing() {
    let path = Path::polyline(&[[1.0, 1.0]]);
    let still = time(&path, &limits(), &TimingOptions::default(), &mut Context::new(1)).unwrap();
    assert!(still.duration() == 0.0 && still.at(1.0).pose[..2] == [1.0, 1.0]);
    let options = TimingOptions { start_yaw: Some(0.0), goal_yaw: Some(1.0), ..TimingOptions::default() };
    let turned = time(&path, &limits(), &options, &mut Context::new(1)).unwrap();
    assert!((turned.at(f64::MAX).pose[2] - 1.0).abs() < 1e-12);
}

#[test]
fn clearance_and_boundary_speeds() {
    let path = Path::polyline(&[[0.0, 0.0], [10.0, 0.0]]);
    let narrow = |s: f64| safe_speed((s - 5.0).abs() + 0.05, &limits());
    let options = TimingOptions { start_speed: 1.0, end_speed: 0.5, clearance_ceiling: Some(&narrow), ..TimingOptions::default() };
    let trajectory = time(&path, &limits(), &options, &mut Context::new(1)).unwrap();
    keeps_limits(&trajectory);
    assert!(trajectory.samples(1000.0).iter().all(|s| s.speed <= narrow(s.s) * (1.0 + 1e-6)));
    assert!((trajectory.at(0.0).speed - 1.0).abs() < 1e-12 && (trajectory.at(f64::MAX).speed - 0.5).abs() < 1e-9);
    for v in [0.01, 0.1, 0.5, 0.9, 1.5, 2.0] {
        assert!((safe_speed(stopping_distance(v, &limits()), &limits()) - v).abs() < 1e-12);
    }
    let refused = TimingOptions { start_speed: 3.0, ..TimingOptions::default() };
    assert!(time(&path, &limits(), &refused, &mut Context::new(1)).is_err());
    let too_fast = TimingOptions { start_speed: 2.0, ..TimingOptions::default() };
    let short = Path::polyline(&[[0.0, 0.0], [0.1, 0.0]]);
    assert_eq!(time(&short, &limits(), &too_fast, &mut Context::new(1)).unwrap_err().name(), "Infeasible");
}

#[test]
fn csv_has_a_row_each_hundredth_of_a_second() {
    let trajectory = time(&wave(), &limits(), &TimingOptions::default(), &mut Context::new(1)).unwrap();
    let text = trajectory.csv(100.0);
    let mut lines = text.lines();
    assert_eq!(lines.next(), Some(CSV_HEADER));
    let rows: Vec<Vec<f64>> = lines.map(|l| l.split(',').map(|x| x.parse().unwrap()).collect()).collect();
    assert!(rows.iter().all(|r| r.len() == 8));
    assert_eq!(rows.len(), (trajectory.duration() * 100.0).ceil() as usize + 1);
    assert!((rows[7][0] - 0.07).abs() < 1e-12 && (rows[rows.len() - 1][0] - trajectory.duration()).abs() < 1e-9);
}

/// A cubic path through random control points; now and then two or three of them coincide.
fn random_path(rng: &mut ChaCha8Rng) -> Path {
    let n = rng.random_range(4..14);
    let mut points: Vec<[f64; 2]> = Vec::new();
    for i in 0..n {
        let next = [1.2 * f64::from(i) + rng.random::<f64>(), 3.0 * rng.random::<f64>()];
        let again = if rng.random::<f64>() < 0.1 { 2 } else { 1 };
        points.extend(std::iter::repeat_n(next, again));
    }
    let inner = (1..points.len() - 3).map(|i| i as f64);
    let last = (points.len() - 3) as f64;
    let knots = [0.0; 4].into_iter().chain(inner).chain([last; 4]).collect();
    Path::new(3, 2, knots, points.concat()).unwrap()
}

#[test]
fn random_paths_pass_their_certificate() {
    let mut rng = ChaCha8Rng::seed_from_u64(11);
    for case in 0..24 {
        let path = random_path(&mut rng);
        let mut limits = limits();
        if case % 3 == 0 {
            limits = Limits { speed: 1.0, acceleration: 0.5, deceleration: 0.5, jerk: 2.0, ..limits };
        }
        let yaw = |rng: &mut ChaCha8Rng| (rng.random::<f64>() < 0.5).then(|| 6.0 * rng.random::<f64>() - 3.0);
        let (start_yaw, goal_yaw) = (yaw(&mut rng), yaw(&mut rng));
        let [fastest, nodes, trapezoid] = [Method::TimeOptimal, Method::Iascv, Method::Trapezoid].map(|method| {
            let options = TimingOptions { start_yaw, goal_yaw, method, ..TimingOptions::default() };
            let trajectory = time(&path, &limits, &options, &mut Context::new(1)).unwrap();
            let checks = motion(&trajectory, &Asked { start_yaw, goal_yaw, ..Asked::default() });
            let failed: Vec<_> = checks.into_iter().filter(|c| !c.ok).map(|c| c.name).collect();
            let allowed: &[&str] = if method == Method::Trapezoid { &["acceleration continuity", "ends"] } else { &[] };
            assert!(failed.iter().all(|name| allowed.contains(name)), "case {case}, {method:?}: {failed:?}");
            trajectory.duration()
        });
        // Without a limit of jerk the trapezoid is the lower bound of all.
        assert!(trapezoid < fastest && fastest <= nodes, "case {case}: {trapezoid} {fastest} {nodes}");
    }
}
