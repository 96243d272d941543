//! Motions of several axes against published durations and random problems.

mod common_axes;

use common_axes::{errors, problem};
use guideway::timing::axes::{Axis, AxisGoal, AxisLimits, AxisState, Input, Sync, plan};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use serde_json::Value;

/// A problem of the known cases.
fn known(case: &Value) -> Input {
    let given = &case["input"];
    let number = |name: &str, i: usize| given[name].get(i).and_then(Value::as_f64);
    let by_velocity = given["control_interface"] == "Velocity";
    let axis = |i: usize| {
        let (v, a) = (number("max_velocity", i).unwrap(), number("max_acceleration", i).unwrap());
        let state = |side: &str| {
            let of = |what: &str| number(&format!("{side}_{what}"), i).unwrap();
            (of("position"), of("velocity"), of("acceleration"))
        };
        let ((p0, v0, a0), (p1, v1, a1)) = (state("current"), state("target"));
        Axis {
            start: AxisState { position: p0, velocity: v0, acceleration: a0 },
            goal: AxisGoal { position: (!by_velocity).then_some(p1), velocity: v1, acceleration: a1 },
            limits: AxisLimits {
                velocity: (number("min_velocity", i).unwrap_or(-v), v),
                acceleration: (number("min_acceleration", i).unwrap_or(-a), a),
                jerk: number("max_jerk", i).unwrap(),
            },
            enabled: true,
        }
    };
    Input {
        axes: (0..3).map(axis).collect(),
        sync: Sync::Time,
        minimum_duration: given["minimum_duration"].as_f64().unwrap_or(0.0),
        cycle: (given["duration_discretization"] == "Discrete").then_some(0.004),
    }
}

#[test]
fn known_cases() {
    let text = include_str!("../../../tests/data/ruckig_known_cases.json");
    let file: Value = serde_json::from_str(text).unwrap();
    let cases = file["cases"].as_array().unwrap();
    assert_eq!(cases.len(), 34);
    let mut wrong = Vec::new();
    for case in cases {
        let input = known(case);
        let motion = plan(&input).unwrap_or_else(|e| panic!("line {}: {e}", case["source_line"]));
        let (printed, measured) = (case["expected_duration"].as_f64().unwrap(), case["duration_by_ruckig_0.19.4"].as_f64().unwrap());
        println!("line {}: {} (printed {printed}, measured {measured})", case["source_line"], motion.duration);
        if (motion.duration - measured).abs() > 1e-10 * measured.max(1.0) {
            wrong.push(case["source_line"].clone());
        }
    }
    assert!(wrong.is_empty(), "{wrong:?}");
}

fn random(count: usize, seed: u64) {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let (mut worst_off, mut worst_excess) = (0.0f64, 0.0f64);
    for n in 0..count {
        let input = problem(&mut rng);
        let motion = match plan(&input) {
            Ok(motion) => motion,
            Err(e) => panic!("{n}: {e}\n{input:?}"),
        };
        for (axis, moved) in input.axes.iter().zip(&motion.axes) {
            let (off, excess) = errors(axis, moved);
            assert!(off <= 1e-9 && excess <= 1e-9, "{n}: off {off:e}, excess {excess:e}\n{axis:?}\n{moved:?}\n{input:?}");
            (worst_off, worst_excess) = (worst_off.max(off), worst_excess.max(excess));
            let together = input.sync == Sync::None || moved.duration == motion.duration;
            assert!(together && moved.duration >= input.minimum_duration * (1.0 - 1e-12), "{n}: durations\n{input:?}");
        }
    }
    println!("{count} problems: ends off by {worst_off:e}, limits exceeded by {worst_excess:e}");
}

#[test]
fn random_problems() {
    random(20_000, 1);
}
