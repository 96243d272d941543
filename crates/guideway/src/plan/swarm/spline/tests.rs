use super::speed::FirstPass;
use crate::query::Limits;
use crate::timing::{Bounds, Jerks, SCurve};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

fn limits(speed: f64, acceleration: f64, deceleration: f64, jerk: f64) -> Limits {
    Limits { speed, acceleration, deceleration, jerk, ..Limits::default() }
}

#[test]
fn the_first_pass_is_the_seven_phase_plan() {
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    let mut draw = |low: f64, high: f64| (rng.random_range(low.ln()..high.ln())).exp();
    for _ in 0..5000 {
        let limits = limits(draw(0.1, 5.0), draw(0.1, 10.0), draw(0.1, 10.0), draw(0.1, 50.0));
        let length = draw(1e-3, 50.0);
        let pass = FirstPass::new(length, &limits);
        let bounds =
            Bounds { speed: limits.speed, acceleration: limits.acceleration, deceleration: limits.deceleration, jerk: Jerks::all(limits.jerk) };
        let plan = SCurve { distance: length, start: (0.0, 0.0), end: (0.0, 0.0), bounds }.plan().unwrap();
        assert!((pass.time / plan.duration() - 1.0).abs() < 1e-7, "{limits:?} {length}: {} {}", pass.time, plan.duration());
        for i in 0..=20 {
            let t = plan.duration() * f64::from(i) / 20.0;
            let (s, v, ..) = plan.at(t);
            assert!((pass.place(t) - s).abs() < 1e-6 * length, "{limits:?} {length} at {t}: {} {s}", pass.place(t));
            // Near rest the speed is the cube root of the way.
            assert!((pass.speed(s) - v).abs() < 1e-4 * pass.top, "{limits:?} {length} at {s}: {} {v}", pass.speed(s));
        }
    }
}

#[test]
fn the_first_pass_has_the_regression_values() {
    let nominal = limits(2.0, 5.0, 5.0, 10.0);
    assert!((FirstPass::new(34f64.sqrt(), &nominal).time - 3.80990).abs() < 1e-5);
    let short = FirstPass::new(0.05, &nominal);
    assert!((short.time - 0.54288).abs() < 1e-5 && (short.top - 0.18420).abs() < 1e-5);
}
