use super::*;

mod ends;
mod long;
mod rates;

/// A spline through random points, as benches draw them.
pub(super) fn random_path(seed: u64, points: usize, joints: usize) -> Path {
    let mut state = seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) ^ 0x1234_5678_9ABC_DEF1;
    let mut draw = || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 11) as f64 / (1u64 << 53) as f64
    };
    let values: Vec<f64> = (0..points * joints).map(|_| 3.0 * draw() - 1.5).collect();
    Path::through(&values, joints).unwrap()
}

pub(super) fn limits(speed: f64, acceleration: f64) -> JointLimits {
    JointLimits { speed: Some(PerJoint::All(speed)), acceleration: Some(PerJoint::All(acceleration)), ..JointLimits::default() }
}

/// Those of the benches.
pub(super) fn usual() -> JointLimits {
    limits(180f64.to_radians(), 800f64.to_radians())
}

pub(super) fn fastest(path: &Path, limits: &JointLimits, options: &TopOptions) -> JointMotion {
    time_joints(path, limits, options, &mut Demands::default()).unwrap()
}

/// Largest use of the limits, on `count` times per piece, by the path's own evaluation.
pub(super) fn worst(motion: &JointMotion, limits: &JointLimits, count: usize) -> [f64; 2] {
    let bounds = limits.bounds(motion.path.dimension()).unwrap();
    let mut worst = [0.0f64; 2];
    for piece in &motion.pieces {
        // Inside the pieces: at their ends the acceleration jumps.
        for j in 0..count {
            let state = motion.at(piece.start() + piece.duration() * (j as f64 + 0.5) / count as f64);
            for i in 0..motion.path.dimension() {
                let (v, a) = (state.joints[1][i], state.joints[2][i]);
                let bound = if v * a >= 0.0 { bounds.acceleration[i] } else { bounds.deceleration[i] };
                worst = [worst[0].max(v.abs() / bounds.speed[i]), worst[1].max(a.abs() / bound)];
            }
        }
    }
    worst
}

#[test]
fn random_splines_keep_their_limits_everywhere_and_are_near_the_optimum() {
    for seed in 0..20 {
        let path = random_path(seed, 3 + seed as usize % 10, 1 + seed as usize % 7);
        let motion = fastest(&path, &usual(), &TopOptions::default());
        let [v, a] = worst(&motion, &usual(), 20);
        assert!(v <= 1.0 + 1e-6 && a <= 1.0 + 1e-6, "seed {seed}: {v} {a}");
        assert!(motion.report.excess <= 1e-6);
        let fine = fastest(&path, &usual(), &TopOptions { grid: Some(3000), check: 4, ..TopOptions::default() });
        assert!(motion.duration() <= 1.001 * fine.duration(), "seed {seed}: {} {}", motion.duration(), fine.duration());
        assert_eq!((motion.s.len(), motion.active.len(), motion.mvc.len()), (motion.x.len(), motion.s.len(), motion.s.len()));
        assert!(motion.x.iter().zip(&motion.mvc).all(|(x, top)| *x <= top * (1.0 + 1e-6) + 1e-12), "seed {seed}");
    }
}

#[test]
fn straight_lines_are_bang_bang() {
    // Cases with known optima: twice the root of distance over acceleration; trapezoid where the speed binds.
    for (d, expected) in [(1.0, 0.2), (1e-4, 0.002), (1e-9, 2.0 * 1e-11f64.sqrt())] {
        let path = Path::through(&[0.0, 0.0, 0.0, 0.0, d, 0.0], 3).unwrap();
        let motion = fastest(&path, &limits(100.0, 100.0), &TopOptions::default());
        assert!((motion.duration() / expected - 1.0).abs() < 1e-9, "{d}: {}", motion.duration());
        assert!(motion.active.iter().all(|name| name == "acceleration of joint 2"));
    }
    let path = Path::through(&[0.0, 0.0, 3.0, 4.0], 2).unwrap();
    let motion = fastest(&path, &limits(2.0, 4.0), &TopOptions::default());
    // Joint 2 goes 4 rad: 2 s at speed 2, and half a second for the ramps.
    assert!((motion.duration() - 2.5).abs() < 1e-6, "{}", motion.duration());
    let asymmetric = JointLimits { deceleration: Some(PerJoint::Each(vec![8.0, 2.0])), ..limits(1e9, 8.0) };
    let motion = fastest(&Path::through(&[0.0, 1.0], 1).unwrap(), &limits(1e9, 8.0), &TopOptions::default());
    assert!((motion.duration() - 2.0 * (1.0f64 / 8.0).sqrt()).abs() < 1e-9);
    let motion = fastest(&Path::through(&[0.0, 0.0, 0.0, -1.0], 2).unwrap(), &asymmetric, &TopOptions::default());
    // v^2 = 2 * 8 * a = 2 * 2 * (1 - a): a = 0.2.
    assert!((motion.duration() - 2.0 / 3.2f64.sqrt()).abs() < 1e-5, "{}", motion.duration());
}

#[test]
fn a_path_that_turns_back_stops_there() {
    for d in [1e-5, 1e-7] {
        let path = Path::through_at(&[0.0, 0.0, 0.0, 0.0, d, 0.0, 0.0, 0.0, 0.0], 3, &[0.0, 0.5, 1.0]).unwrap();
        let motion = fastest(&path, &limits(100.0, 100.0), &TopOptions::default());
        let expected = 4.0 * (d / 100.0f64).sqrt();
        assert!((motion.duration() / expected - 1.0).abs() < 1e-4, "{} {expected}", motion.duration());
    }
    let corners = Path::new(1, 2, vec![0.0, 0.0, 1.0, 2.0, 2.0], vec![0.0, 0.0, 1.0, 0.0, 1.0, 1.0]).unwrap();
    let motion = fastest(&corners, &limits(100.0, 4.0), &TopOptions::default());
    assert!((motion.duration() - 2.0).abs() < 1e-9 && motion.at(1.0).speed < 1e-6);
}

#[test]
fn bisection_and_reachability_agree() {
    for seed in 0..5 {
        let path = random_path(seed, 8, 6);
        let options = TopOptions { grid: Some(300), ..TopOptions::default() };
        let theirs = fastest(&path, &usual(), &TopOptions { method: TopMethod::Bisection, ..options.clone() });
        let ours = fastest(&path, &usual(), &options);
        assert!((theirs.duration() / ours.duration() - 1.0).abs() < 2e-3, "{} {}", theirs.duration(), ours.duration());
    }
}

#[test]
fn boundary_speeds_are_met_or_refused() {
    let path = random_path(3, 6, 4);
    let options = TopOptions { start_speed: 0.7, end_speed: 0.3, ..TopOptions::default() };
    let motion = fastest(&path, &usual(), &options);
    assert!((motion.at(0.0).speed - 0.7).abs() < 1e-9 && (motion.at(motion.duration()).speed - 0.3).abs() < 1e-9);
    let [v, a] = worst(&motion, &usual(), 20);
    assert!(v <= 1.0 + 1e-6 && a <= 1.0 + 1e-6);
    for (start, end) in [(50.0, 0.0), (0.0, 50.0), (-1.0, 0.0), (f64::NAN, 0.0)] {
        let options = TopOptions { start_speed: start, end_speed: end, ..TopOptions::default() };
        assert!(time_joints(&path, &usual(), &options, &mut Demands::default()).is_err());
    }
}

/// Largest use of speed, acceleration and jerk, by the path's own evaluation.
fn worst_jerk(motion: &JointMotion, limits: &JointLimits, count: usize) -> [f64; 3] {
    let bounds = limits.bounds(motion.path.dimension()).unwrap();
    let mut worst = [0.0f64; 3];
    for piece in &motion.pieces {
        for j in 0..count {
            let state = motion.at(piece.start() + piece.duration() * (j as f64 + 0.5) / count as f64);
            for i in 0..motion.path.dimension() {
                for (k, bound) in [&bounds.speed, &bounds.acceleration, &bounds.jerk].into_iter().enumerate() {
                    worst[k] = worst[k].max(state.joints[k + 1][i].abs() / bound[i]);
                }
            }
        }
    }
    worst
}

fn with_jerk(limits: JointLimits, jerk: f64) -> JointLimits {
    JointLimits { jerk: Some(PerJoint::All(jerk)), ..limits }
}

#[test]
fn jerk_limited_motions_keep_every_limit_and_cost_little() {
    let limits = with_jerk(usual(), 1e4f64.to_radians());
    for seed in 0..6 {
        let path = random_path(seed, 6 + seed as usize, 3 + seed as usize % 4);
        let second = fastest(&path, &limits, &TopOptions::default());
        let motion = fastest(&path, &limits, &TopOptions { jerk: true, ..TopOptions::default() });
        let used = worst_jerk(&motion, &limits, 10);
        assert!(used.iter().all(|used| *used <= 1.0 + 1e-6), "seed {seed}: {used:?}");
        assert!(motion.duration() > second.duration() && motion.duration() < 1.06 * second.duration(), "seed {seed}: {}", motion.duration());
        let price: f64 = motion.price.iter().map(|p| p.1).sum();
        assert!((price - (motion.duration() - second.duration())).abs() < 2e-3 * second.duration());
        let states: Vec<JointState> = motion.pieces.iter().map(|p| motion.at(p.start())).collect();
        for (piece, next) in motion.pieces.iter().zip(&states[1..]) {
            let Piece::Along { acceleration, jerk, duration, .. } = piece else { continue };
            assert!((acceleration + jerk * duration - next.acceleration).abs() < 1e-6, "the acceleration jumps");
        }
    }
}

/// Even parameters make sharp turns where points are close: there a place is hard to find by its arc length.
#[test]
fn limits_of_jerk_hold_in_sharp_turns() {
    let limits = with_jerk(usual(), 1e4f64.to_radians());
    for seed in 20..24 {
        let points = random_path(seed, 10, 6);
        let even: Vec<f64> = (0..points.count()).map(|i| i as f64).collect();
        let path = Path::through_at(points.control(), 6, &even).unwrap();
        for grid in [None, Some(600)] {
            let motion = fastest(&path, &limits, &TopOptions { grid, jerk: true, ..TopOptions::default() });
            let used = worst_jerk(&motion, &limits, 10);
            assert!(used.iter().all(|used| *used <= 1.0 + 1e-6), "seed {seed} {grid:?}: {used:?}");
        }
    }
}

#[test]
fn jerk_limited_straight_lines_are_s_curves() {
    use crate::timing::scurve::{Bounds, Jerks, SCurve};
    for (d, v, a, j) in
        [(1.0, 100.0, 100.0, 1000.0), (1.0, 1.0, 100.0, 100.0), (2.0, 1.0, 4.0, 40.0), (1e-5, 10.0, 10.0, 100.0), (3.0, 100.0, 1.0, 50.0)]
    {
        let limits = with_jerk(limits(v, a), j);
        let path = Path::through(&[0.0, 0.0, 0.0, d], 2).unwrap();
        let motion = fastest(&path, &limits, &TopOptions { jerk: true, ..TopOptions::default() });
        let bounds = Bounds { speed: v, acceleration: a, deceleration: a, jerk: Jerks::all(j) };
        let exact = SCurve { distance: d, start: (0.0, 0.0), end: (0.0, 0.0), bounds }.plan().unwrap().duration();
        let ratio = motion.duration() / exact;
        let used = worst_jerk(&motion, &limits, 10);
        assert!(ratio > 1.0 - 1e-9 && ratio < 1.01 && used.iter().all(|u| *u <= 1.0 + 1e-6), "{d} {v} {a} {j}: {ratio} {used:?}");
    }
}

/// One joint turns back, two at once turn back on a line, and two nearly do: each turn costs hardly more than to lose and to regain the acceleration.
#[test]
fn jerk_limited_motions_turn_back() {
    let limits = with_jerk(usual(), 1e4f64.to_radians());
    let most = 800.0 / 1e4;
    for (points, joints) in [
        (vec![0.0, 1.0, 0.3, 1.2, -0.4], 1),
        (vec![0.0, 0.0, 0.6, 0.8, 0.15, 0.2], 2),
        // The turn takes place within 1e-6 rad.
        (vec![0.0, 0.0, 0.6, 0.8, 0.15, 0.201], 2),
        (vec![0.0, 0.0, 0.6, 0.8, 0.15, 0.21], 2),
        (vec![0.0, 0.0, 0.6, 0.8, 0.15, 0.25], 2),
    ] {
        let path = Path::through(&points, joints).unwrap();
        let second = fastest(&path, &limits, &TopOptions::default());
        let motion = fastest(&path, &limits, &TopOptions { jerk: true, ..TopOptions::default() });
        assert!(worst_jerk(&motion, &limits, 100).iter().all(|used| *used <= 1.0 + 1e-6), "{points:?} {:?}", worst_jerk(&motion, &limits, 100));
        let turns = points.len() / joints - 1;
        assert!(motion.duration() - second.duration() < 1.3 * most * turns as f64, "{points:?} {} {}", motion.duration(), second.duration());
    }
}

/// When a motion is at an arc length, s.
fn when(motion: &JointMotion, s: f64) -> f64 {
    let (mut low, mut high) = (0.0, motion.duration());
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        *(if motion.at(middle).s < s { &mut low } else { &mut high }) = middle;
    }
    0.5 * (low + high)
}

#[test]
fn jerk_limited_motions_stop_at_corners() {
    let limits = with_jerk(limits(2.0, 4.0), 40.0);
    let corners = Path::new(1, 2, vec![0.0, 0.0, 1.0, 2.0, 2.0], vec![0.0, 0.0, 1.0, 0.0, 1.0, 1.0]).unwrap();
    let motion = fastest(&corners, &limits, &TopOptions { jerk: true, ..TopOptions::default() });
    let half = motion.at(0.5 * motion.duration());
    assert!((half.s - 1.0).abs() < 1e-6 && half.speed < 1e-3);
    assert!(worst_jerk(&motion, &limits, 10).iter().all(|u| *u <= 1.0 + 1e-6));
    let passed = fastest(&corners, &limits, &TopOptions { jerk: true, start_speed: 1.0, ..TopOptions::default() });
    assert!(worst_jerk(&passed, &limits, 10).iter().all(|u| *u <= 1.0 + 1e-6) && passed.duration() < motion.duration());
    assert!(passed.at(when(&passed, 1.0)).speed < 1e-3, "it stops at the corner");
}

#[test]
fn windows_are_met_and_nothing_else_is_lost() {
    let path = random_path(4, 6, 4);
    let free = fastest(&path, &usual(), &TopOptions::default());
    let window = |s: f64, earliest: f64| Window { s, earliest, latest: f64::INFINITY };
    let timed = |windows: Vec<Window>| time_joints(&path, &usual(), &TopOptions { windows, ..TopOptions::default() }, &mut Demands::default());
    let slow = timed(vec![window(path.length(), 2.0 * free.duration())]).unwrap();
    assert!((slow.duration() / free.duration() - 2.0).abs() < 1e-9);
    // Half of the way not before three quarters of the time: late there, then as fast as can be.
    let half = 0.5 * path.length();
    let late = timed(vec![window(half, 0.75 * free.duration())]).unwrap();
    let at = |motion: &JointMotion, t: f64| motion.at(t).s;
    assert!((at(&late, 0.75 * free.duration()) - half).abs() < 1e-3 * half);
    assert!(late.duration() < 1.5 * free.duration() && late.duration() > free.duration());
    let [v, a] = worst(&late, &usual(), 20);
    assert!(v <= 1.0 + 1e-6 && a <= 1.0 + 1e-6);
    let passed = timed(vec![Window { s: half, earliest: 0.0, latest: 0.1 * free.duration() }]);
    assert!(matches!(passed, Err(PlanError::Infeasible { .. })));
    assert!(timed(vec![window(half, f64::NAN)]).is_err() && timed(vec![window(-1.0, 1.0)]).is_err());
    let limits = with_jerk(usual(), 200.0);
    let options = TopOptions { jerk: true, windows: vec![window(Window::END, 9.0)], ..TopOptions::default() };
    assert!((fastest(&path, &limits, &options).duration() - 9.0).abs() < 1e-9);
}

/// Rows like those of torque: one mass that hangs on a spring of sorts, with friction.
fn loaded(s: &[f64], load: f64) -> Rows {
    let each = |f: &dyn Fn(f64) -> f64| s.iter().map(|s| f(*s)).collect::<Vec<f64>>();
    let (low, high) = (vec![-40.0; s.len()], vec![40.0; s.len()]);
    Rows {
        count: 1,
        a: each(&|s| 2.0 + s.cos()),
        b: each(&|s| -0.5 * s.sin()),
        c: each(&|s| load * s.sin()),
        d: each(&|s| 3.0 * (0.3 * s).cos()),
        low,
        high,
    }
}

#[test]
fn rows_with_friction_hold_and_both_methods_agree() {
    for seed in 0..3 {
        let path = random_path(seed, 6, 3);
        let mut durations = Vec::new();
        for method in [TopMethod::Reachability, TopMethod::Bisection] {
            let mut demands =
                Demands { names: vec!["torque of a mass".into()], rows: Some(Box::new(|s: &[f64]| Ok(loaded(s, 20.0)))), ..Demands::default() };
            let options = TopOptions { method, ..TopOptions::default() };
            let motion = time_joints(&path, &usual(), &options, &mut demands).unwrap();
            assert!(motion.active.iter().any(|name| name == "torque of a mass"));
            for i in 0..20_000 {
                let state = motion.at(motion.duration() * (f64::from(i) + 0.5) / 20_000.0);
                let row = loaded(&[state.s], 20.0);
                let value = row.a[0] * state.acceleration + row.b[0] * state.speed.powi(2) + row.c[0] + row.d[0] * state.speed;
                assert!(value.abs() <= 40.0 * (1.0 + 1e-6), "seed {seed}: {value}");
            }
            durations.push(motion.duration());
        }
        assert!((durations[0] / durations[1] - 1.0).abs() < 2e-3, "seed {seed}: {durations:?}");
    }
}

/// Coulomb friction jumps where a joint turns back: neither a fixed grid nor a refined one may count both of its sides at once.
#[test]
fn friction_that_turns_round_is_no_static_overload() {
    let path = Path::through(&[0.0, 0.0, 1.0, 1.0, 0.0, 2.0], 2).unwrap();
    let rows = |s: &[f64]| {
        let first: Vec<f64> = s.iter().map(|s| path.eval(*s, 1)[1][0]).collect();
        let c = first.iter().map(|q| 3.0 + 6.0 * q.signum()).collect();
        let bound = |v: f64| vec![v; s.len()];
        Ok(Rows { count: 1, b: bound(0.0), c, d: Vec::new(), low: bound(-10.0), high: bound(10.0), a: first })
    };
    let mut durations = Vec::new();
    for method in [TopMethod::Reachability, TopMethod::Bisection] {
        for grid in [None, Some(10), Some(51), Some(1000)] {
            let mut demands = Demands { rows: Some(Box::new(rows)), ..Demands::default() };
            let motion = time_joints(&path, &usual(), &TopOptions { method, grid, ..TopOptions::default() }, &mut demands).unwrap();
            for i in 0..5000 {
                let state = motion.at(motion.duration() * (f64::from(i) + 0.5) / 5000.0);
                let row = rows(&[state.s]).unwrap();
                assert!((row.a[0] * state.acceleration + row.c[0]).abs() <= 10.0 * (1.0 + 1e-6), "{grid:?} at {}", state.s);
            }
            durations.push(motion.duration());
        }
    }
    assert!(durations.iter().all(|d| (d / durations[3] - 1.0).abs() < 0.1), "{durations:?}");
}

/// Limits of jerk and rows together; the paths of the seeds 1 and 2 all but stop in a sharp turn.
#[test]
fn jerk_limited_motions_keep_rows() {
    for (seed, most) in [(0, 1.03), (1, 1.06), (2, 1.06), (3, 1.03), (5, 1.03)] {
        let path = random_path(seed, 6, 3);
        let limits = with_jerk(usual(), 200.0);
        let mut found = Vec::new();
        for jerk in [false, true] {
            let mut demands =
                Demands { names: vec!["torque of a mass".into()], rows: Some(Box::new(|s: &[f64]| Ok(loaded(s, 20.0)))), ..Demands::default() };
            let motion = time_joints(&path, &limits, &TopOptions { jerk, ..TopOptions::default() }, &mut demands).unwrap();
            for i in 0..20_000 {
                let state = motion.at(motion.duration() * (f64::from(i) + 0.5) / 20_000.0);
                let row = loaded(&[state.s], 20.0);
                let value = row.a[0] * state.acceleration + row.b[0] * state.speed.powi(2) + row.c[0] + row.d[0] * state.speed;
                assert!(value.abs() <= 40.0 * (1.0 + 1e-6), "seed {seed}: {value}");
            }
            found.push(motion);
        }
        let [second, third] = [&found[0], &found[1]];
        assert!(worst_jerk(third, &limits, 10).iter().all(|used| *used <= 1.0 + 1e-6), "seed {seed}");
        assert!(third.duration() > second.duration() && third.duration() < most * second.duration(), "{} {}", third.duration(), second.duration());
        assert!(third.active.iter().any(|name| name == "torque of a mass") && third.active.iter().any(|name| name.starts_with("jerk of joint ")));
    }
}

#[test]
fn static_overload_names_the_limit_and_the_place() {
    let path = random_path(1, 6, 3);
    for options in [
        TopOptions::default(),
        TopOptions { method: TopMethod::Bisection, ..TopOptions::default() },
        TopOptions { grid: Some(100), ..TopOptions::default() },
    ] {
        let mut demands =
            Demands { names: vec!["torque of elbow".into()], rows: Some(Box::new(|s: &[f64]| Ok(loaded(s, 60.0)))), ..Demands::default() };
        match time_joints(&path, &usual(), &options, &mut demands) {
            Err(PlanError::Infeasible { reason, .. }) => assert!(reason.contains("torque of elbow") && reason.contains("s = "), "{reason}"),
            other => panic!("{other:?}"),
        }
    }
}

#[test]
fn hostile_limits_are_refused_and_nothing_to_do_is_done() {
    let path = random_path(1, 5, 3);
    for bad in [0.0, -1.0, f64::NAN] {
        assert!(matches!(
            time_joints(&path, &limits(1.0, bad), &TopOptions::default(), &mut Demands::default()),
            Err(PlanError::BadParameter { .. })
        ));
    }
    let few = JointLimits { speed: Some(PerJoint::Each(vec![1.0; 2])), ..limits(1.0, 1.0) };
    assert!(time_joints(&path, &few, &TopOptions::default(), &mut Demands::default()).is_err());
    let none = time_joints(&path, &JointLimits::default(), &TopOptions::default(), &mut Demands::default());
    assert!(matches!(none, Err(PlanError::BadParameter { .. })), "{none:?}");
    let still = Path::through(&[1.0, 2.0, 3.0, 1.0, 2.0, 3.0], 3).unwrap();
    let motion = fastest(&still, &usual(), &TopOptions::default());
    assert_eq!((motion.duration(), motion.at(1.0).joints[0].clone()), (0.0, vec![1.0, 2.0, 3.0]));
    let mut broken =
        Demands { names: vec![], rows: Some(Box::new(|s: &[f64]| Ok(Rows { a: vec![f64::NAN; s.len()], ..loaded(s, 1.0) }))), ..Demands::default() };
    assert!(matches!(time_joints(&path, &usual(), &TopOptions::default(), &mut broken), Err(PlanError::BadParameter { .. })));
    for scale in [1e-9, 1e-3, 1e6] {
        let points: Vec<f64> = (0..18).map(|i| scale * f64::from(i * i % 7)).collect();
        let motion = fastest(&Path::through(&points, 3).unwrap(), &limits(1e3, 1e3), &TopOptions::default());
        assert!(motion.duration() > 0.0 && motion.duration().is_finite() && motion.report.excess <= 1e-6, "{scale}");
    }
}

#[test]
fn rows_that_hardly_have_an_acceleration_bound_the_speed() {
    // |u| <= 10, and x <= 3 by a row whose coefficient of u is rounding.
    let n = 100;
    let s: Vec<f64> = (0..=n).map(|k| f64::from(k) / f64::from(n)).collect();
    for tiny in [0.0, 1e-19, -3e-19, 1e-16, -1e-13] {
        let places = s.len();
        let rows = Rows {
            count: 2,
            a: [1.0, tiny].repeat(places),
            b: [0.0, 0.7].repeat(places),
            c: vec![0.0; 2 * places],
            low: [-10.0, -5.0].repeat(places),
            high: [10.0, 2.1].repeat(places),
            ..Rows::default()
        };
        let x = kernel(&s, &vec![100.0; places], &rows, [0.0; 2]).unwrap();
        for (k, (s, x)) in s.iter().zip(&x).enumerate() {
            let exact = (20.0 * s.min(1.0 - s)).min(3.0);
            assert!((x - exact).abs() < 1e-9, "{tiny} {k}: {x} {exact}");
        }
    }
}

#[test]
fn viscous_rows_near_the_static_limit_have_a_motion() {
    // Gravity takes 99 % of the upper bound, friction grows with speed.
    let n = 200;
    let s: Vec<f64> = (0..=n).map(|k| f64::from(k) / f64::from(n)).collect();
    let places = s.len();
    let rows = Rows {
        count: 1,
        a: vec![1.0; places],
        b: vec![0.0; places],
        c: vec![9.9; places],
        d: vec![0.5; places],
        low: vec![-10.0; places],
        high: vec![10.0; places],
    };
    let x = kernel(&s, &vec![4.0; places], &rows, [0.0; 2]).unwrap();
    for k in 0..n as usize {
        let u = (x[k + 1] - x[k]) / (2.0 * (s[k + 1] - s[k]));
        for x in [x[k], x[k + 1]] {
            let demand = u + 9.9 + 0.5 * x.sqrt();
            assert!((-10.0 - 1e-6..=10.0 + 1e-6).contains(&demand), "{k}: {demand}");
        }
    }
    assert!(x[100] > 0.03, "{}", x[100]);
}

#[test]
fn viscous_rows_settle_at_the_same_profile_from_a_coarse_guess_and_without() {
    let n = 1000;
    let s: Vec<f64> = (0..=n).map(|k| 3.0 * f64::from(k) / f64::from(n)).collect();
    let at = |f: &dyn Fn(f64) -> [f64; 2]| s.iter().flat_map(|s| f(*s)).collect::<Vec<f64>>();
    let rows = Rows {
        count: 2,
        a: at(&|s| [1.0 + 0.5 * (5.0 * s).sin(), (3.0 * s).cos()]),
        b: at(&|s| [(4.0 * s).cos(), 0.8 * (2.0 * s).sin()]),
        c: at(&|s| [2.0 * (7.0 * s).sin(), 1.0]),
        d: at(&|s| [0.7 + s.sin(), -0.4]),
        low: [-6.0, -4.0].repeat(s.len()),
        high: [6.0, 4.0].repeat(s.len()),
    };
    let ceiling = vec![9.0; s.len()];
    let [fast, plain] = [kernel(&s, &ceiling, &rows, [0.0; 2]).unwrap(), super::kernel::settle(&s, &ceiling, &rows, [0.0; 2], None).unwrap()];
    assert!(fast.iter().all(|x| *x < 9.0) && fast[500] > 0.1);
    for (k, (a, b)) in fast.iter().zip(&plain).enumerate() {
        assert!((a - b).abs() <= 1e-8 * (1.0 + b), "{k}: {a} {b}");
    }
}
