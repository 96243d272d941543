//! Speeds at the ends where the limits of jerk are kept.

use super::*;

/// Inserts a knot: the same curve.
fn insert(knots: &mut Vec<f64>, control: &mut Vec<f64>, [degree, joints]: [usize; 2], u: f64) {
    let (k, count) = (knots.partition_point(|t| *t <= u) - 1, control.len() / joints);
    let point = |i: usize| &control[i.min(count - 1) * joints..(i.min(count - 1) + 1) * joints];
    let mut refined = Vec::with_capacity(control.len() + joints);
    for i in 0..=count {
        let share = if i + degree <= k { 1.0 } else { ((u - knots[i]) / (knots[(i + degree).min(knots.len() - 1)] - knots[i])).max(0.0) };
        let share = if i > k { 0.0 } else { share };
        refined.extend(point(i).iter().zip(point(i.saturating_sub(1))).map(|(here, before)| share * here + (1.0 - share) * before));
    }
    *control = refined;
    knots.insert(k + 1, u);
}

/// The part of a path between two parameters.
fn part(path: &Path, [from, to]: [f64; 2]) -> Path {
    let (degree, joints) = (path.degree(), path.dimension());
    let (mut knots, mut control) = (path.knots().to_vec(), path.control().to_vec());
    for u in [from, to] {
        while knots.iter().filter(|t| **t == u).count() < degree {
            insert(&mut knots, &mut control, [degree, joints], u);
        }
    }
    let inner: Vec<f64> = knots.iter().copied().filter(|t| *t > from && *t < to).collect();
    let first = knots.partition_point(|t| *t <= from) - degree - 1;
    let count = inner.len() + degree + 1;
    let knots = [vec![from; degree + 1], inner, vec![to; degree + 1]].concat();
    Path::new(degree, joints, knots, control[first * joints..(first + count) * joints].to_vec()).unwrap()
}

fn jerky([start_speed, end_speed]: [f64; 2]) -> TopOptions {
    TopOptions { jerk: true, start_speed, end_speed, ..TopOptions::default() }
}

/// All limits by the path's own evaluation, the speeds asked for, and no step of the acceleration on the way.
fn sound(motion: &JointMotion, limits: &JointLimits, speeds: [f64; 2], what: &str) {
    let used = worst_jerk(motion, limits, 10);
    assert!(used.iter().all(|used| *used <= 1.0 + 1e-6), "{what}: {used:?}");
    let [start, end] = [0.0, motion.duration()].map(|t| motion.at(t).speed);
    assert!((start - speeds[0]).abs() < 1e-9 && (end - speeds[1]).abs() < 1e-9, "{what}: {start} {end} {speeds:?}");
    for w in motion.pieces.windows(2) {
        let [Piece::Along { acceleration, jerk, duration, .. }, Piece::Along { acceleration: next, .. }] = w else { unreachable!() };
        assert!((acceleration + jerk * duration - next).abs() < 1e-6, "{what}: the acceleration jumps");
    }
}

/// From the speed of the whole motion at a place the rest takes no longer than it did, to that speed neither, nor from one to another.
#[test]
fn parts_of_a_jerk_limited_motion_take_as_long_as_within_it() {
    let limits = with_jerk(usual(), 1e4f64.to_radians());
    let mut refused = 0;
    for seed in 0..12 {
        let path = random_path(seed, 3 + seed as usize % 9, 1 + seed as usize % 7);
        let whole = fastest(&path, &limits, &jerky([0.0; 2]));
        let knots = path.knots();
        let (first, span) = (knots[0], knots[knots.len() - 1] - knots[0]);
        let u = [0.31, 0.74].map(|share| first + share * span);
        let t = u.map(|u| when(&whole, path.length_at(u)));
        let v = t.map(|t| whole.at(t).speed);
        for (ends, speeds, took) in
            [([u[0], first + span], [v[0], 0.0], whole.duration() - t[0]), ([first, u[1]], [0.0, v[1]], t[1]), (u, v, t[1] - t[0])]
        {
            let what = format!("seed {seed}, {ends:?}");
            match time_joints(&part(&path, ends), &limits, &jerky(speeds), &mut Demands::default()) {
                Ok(motion) => {
                    sound(&motion, &limits, speeds, &what);
                    assert!(motion.duration() < 1.002 * took, "{what}: {} s instead of {took} s", motion.duration());
                }
                // Beside a sharp turn that the whole motion stops in.
                Err(PlanError::Infeasible { best_end_speed: Some(most), .. }) => {
                    refused += 1;
                    assert!(most > 0.985 * speeds[1], "{what}: {most} {speeds:?}");
                }
                Err(error) => panic!("{what}: {error}"),
            }
        }
    }
    assert!(refused <= 1, "{refused} of 36 are refused");
}

#[test]
fn speeds_from_very_small_to_the_largest_are_met_and_larger_ones_refused() {
    let limits = with_jerk(usual(), 1e4f64.to_radians());
    for seed in 0..6 {
        let path = random_path(seed, 4 + seed as usize % 5, 2 + seed as usize % 5);
        let rest = fastest(&path, &limits, &jerky([0.0; 2])).duration();
        let largest = [[50.0, 0.0], [0.0, 50.0]].map(|speeds| {
            let refused = time_joints(&path, &limits, &jerky(speeds), &mut Demands::default()).unwrap_err().to_string();
            let place = if speeds[0] > 0.0 { "the path speed at the start can be at most " } else { "the path speed at the end can be at most " };
            let (_, told) = refused.split_once(place).unwrap_or_else(|| panic!("{refused}"));
            told.split(' ').next().unwrap().parse::<f64>().unwrap()
        });
        for share in [1e-6, 1e-3, 0.03, 0.3, 0.8, 0.998] {
            for speeds in [[share * largest[0], 0.0], [0.0, share * largest[1]], largest.map(|v| share * v)] {
                let motion = fastest(&path, &limits, &jerky(speeds));
                sound(&motion, &limits, speeds, &format!("seed {seed}, {share}"));
                assert!(motion.duration() < 1.001 * rest, "seed {seed}, {share}: {} s, from rest {rest} s", motion.duration());
            }
        }
        let faster = time_joints(&path, &limits, &jerky([1.01 * largest[0], 0.0]), &mut Demands::default());
        assert!(matches!(faster, Err(PlanError::Infeasible { .. })), "seed {seed}");
    }
}

/// A line of one joint: from a speed to rest in four phases, and what cannot be.
#[test]
fn a_straight_line_is_left_and_reached_at_speed_as_by_hand() {
    let limits = with_jerk(limits(1.0, 100.0), 10.0);
    let path = Path::through(&[0.0, 1.0], 1).unwrap();
    // At full speed to the end, but for losing it with jerk 10: 2 sqrt(1 / 10) s over half as much way; the acceleration at the start is 0.
    let brake = 2.0 * 0.1f64.sqrt();
    let motion = fastest(&path, &limits, &jerky([1.0, 0.0]));
    let exact = (1.0 - 0.5 * brake) + brake;
    sound(&motion, &limits, [1.0, 0.0], "from full speed");
    assert!(motion.duration() > exact * (1.0 - 1e-9) && motion.duration() < 1.01 * exact, "{} {exact}", motion.duration());
    let motion = fastest(&path, &limits, &jerky([1.0, 1.0]));
    sound(&motion, &limits, [1.0; 2], "at full speed");
    assert!(motion.duration() < 1.001, "{}", motion.duration());
    // From rest at jerk 10 all the way: v = (4.5 * 10 * d^2)^(1/3).
    let short = Path::through(&[0.0, 0.01], 1).unwrap();
    let refused = time_joints(&short, &limits, &jerky([0.0, 0.9]), &mut Demands::default()).unwrap_err();
    let PlanError::Infeasible { best_end_speed: Some(most), .. } = refused else { panic!("{refused}") };
    assert!((most / (45.0 * 1e-4f64).cbrt() - 1.0).abs() < 5e-3, "{most}");
}

#[test]
fn speeds_at_the_ends_hold_with_rows_rates_and_sharp_turns() {
    let path = random_path(5, 6, 3);
    let limits = with_jerk(usual(), 200.0);
    for speeds in [[0.4, 0.0], [0.0, 0.3], [0.5, 0.5]] {
        let motion = super::rates::timed(&path, &limits, &jerky(speeds), 400.0).unwrap();
        sound(&motion, &limits, speeds, "rates");
        assert!(super::rates::steepest(&motion) <= 400.0 * (1.0 + 1e-6));
    }
    let cusp = Path::through(&[0.0, 0.0, 0.6, 0.8, 0.15, 0.21], 2).unwrap();
    let motion = fastest(&cusp, &limits, &jerky([0.3, 0.3]));
    sound(&motion, &limits, [0.3; 2], "a sharp turn");
    let late = Window { s: cusp.length(), earliest: 2.0 * motion.duration(), latest: f64::INFINITY };
    let refused = time_joints(&cusp, &limits, &TopOptions { windows: vec![late], ..jerky([0.3, 0.3]) }, &mut Demands::default());
    assert!(refused.unwrap_err().to_string().contains("from rest to rest"));
}
