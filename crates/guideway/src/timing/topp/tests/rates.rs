//! Limits of the rates of rows.

use super::*;

/// The load on the row.
const LOAD: f64 = 20.0;

/// The row of the other tests with the limit of its rate.
fn rated(s: &[f64], rate: f64) -> Rows {
    Rows { low: vec![-rate; s.len()], high: vec![rate; s.len()], ..loaded(s, LOAD) }
}

pub(super) fn timed(path: &Path, limits: &JointLimits, options: &TopOptions, rate: f64) -> Result<JointMotion, PlanError> {
    let mut demands = Demands {
        names: vec!["torque of a mass".into()],
        rows: Some(Box::new(|s: &[f64]| Ok(loaded(s, LOAD)))),
        rate_names: vec!["torque rate of a mass".into()],
        rates: Some(Box::new(move |s: &[f64]| Ok(rated(s, rate)))),
        ..Demands::default()
    };
    time_joints(path, limits, options, &mut demands)
}

fn jerky() -> TopOptions {
    TopOptions { jerk: true, ..TopOptions::default() }
}

/// The largest rate, by differences of the row within the pieces.
pub(super) fn steepest(motion: &JointMotion) -> f64 {
    let torque = |t: f64| {
        let state = motion.at(t);
        let row = loaded(&[state.s], LOAD);
        row.a[0] * state.acceleration + row.b[0] * state.speed.powi(2) + row.c[0] + row.d[0] * state.speed
    };
    let mut most = 0.0f64;
    for piece in &motion.pieces {
        for j in 0..12 {
            let step = piece.duration() / 12.0;
            let t = piece.start() + step * (f64::from(j) + 0.001);
            let to = t + 0.998 * step;
            most = most.max((torque(to) - torque(t)).abs() / (to - t));
        }
    }
    most
}

#[test]
fn rates_are_kept_used_and_cheaper_than_a_slow_down() {
    for seed in [0, 3, 5] {
        let path = random_path(seed, 6, 3);
        let limits = with_jerk(usual(), 200.0);
        let free = timed(&path, &limits, &jerky(), 1e6).unwrap();
        let rate = 0.4 * steepest(&free);
        let motion = timed(&path, &limits, &jerky(), rate).unwrap();
        let used = steepest(&motion) / rate;
        assert!(used > 0.95 && used <= 1.0 + 1e-6, "seed {seed}: {used}");
        assert!(worst_jerk(&motion, &limits, 10).iter().all(|used| *used <= 1.0 + 1e-6), "seed {seed}");
        // Slowed down as a whole it would take at least the cube root of 1 / 0.4 times as long.
        let share = (motion.duration() / free.duration() - 1.0) / (2.5f64.cbrt() - 1.0);
        assert!(share > 0.0 && share < 0.2, "seed {seed}: {share}");
        assert!(motion.active.iter().any(|name| name == "torque rate of a mass"), "seed {seed}");
        let price = motion.price.iter().find(|(name, _)| name == "torque rate of a mass").unwrap().1;
        assert!(price > 0.0 && price < motion.duration(), "seed {seed}: {price}");
    }
}

/// One joint, one row: without a limit of jerk the rate alone bounds it.
#[test]
fn rates_stand_for_a_limit_of_jerk() {
    let path = Path::through(&[0.0, 1.0], 1).unwrap();
    let motion = timed(&path, &usual(), &jerky(), 300.0).unwrap();
    let used = steepest(&motion) / 300.0;
    assert!(used > 0.95 && used <= 1.0 + 1e-6, "{used}");
    assert_eq!(motion.price.len(), 1);
    // A mass of 3 without load or friction: four ramps of equal length, 1 rad = jerk T^3 / 32.
    let plain = |s: &[f64]| {
        Ok(Rows {
            count: 1,
            a: vec![3.0; s.len()],
            b: vec![0.0; s.len()],
            c: vec![0.0; s.len()],
            d: vec![],
            low: vec![-60.0; s.len()],
            high: vec![60.0; s.len()],
        })
    };
    let mut demands = Demands { rates: Some(Box::new(plain)), ..Demands::default() };
    let motion = time_joints(&path, &usual(), &jerky(), &mut demands).unwrap();
    let exact = (32.0f64 / 20.0).cbrt();
    assert!(motion.duration() >= exact * (1.0 - 1e-9) && motion.duration() < 1.005 * exact, "{} {exact}", motion.duration());
}

#[test]
fn rates_are_kept_by_motions_that_wait_and_bounds_need_both_sides() {
    let path = random_path(3, 6, 3);
    let limits = with_jerk(usual(), 200.0);
    let rate = 0.5 * steepest(&timed(&path, &limits, &jerky(), 1e6).unwrap());
    let short = timed(&path, &limits, &jerky(), rate).unwrap().duration();
    let window = Window { s: Window::END, earliest: 1.2 * short, latest: f64::INFINITY };
    let motion = timed(&path, &limits, &TopOptions { windows: vec![window], ..jerky() }, rate).unwrap();
    assert!(steepest(&motion) <= rate * (1.0 + 1e-6) && motion.duration() >= 1.2 * short);
    let refused = timed(&path, &limits, &jerky(), 0.0).unwrap_err().to_string();
    assert!(refused.contains("rates.low"), "{refused}");
}
