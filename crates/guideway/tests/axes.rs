//! Motions of several axes against published durations and random problems.

mod common_axes;

use common_axes::{outside, random};
use guideway::timing::axes::{Axis, AxisGoal, AxisLimits, AxisState, Input, Sync, plan};
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

#[test]
fn random_problems() {
    random(20_000, 1);
}

#[test]
fn random_starts_outside_the_limits() {
    outside(20_000, 1);
}

fn axis(start: [f64; 3], goal: [f64; 3], limits: AxisLimits) -> Axis {
    let state = |s: [f64; 3]| AxisState { position: s[0], velocity: s[1], acceleration: s[2] };
    Axis { start: state(start), goal: AxisGoal { position: Some(goal[0]), velocity: goal[1], acceleration: goal[2] }, limits, enabled: true }
}

fn alone(axis: Axis) -> Input {
    Input { axes: vec![axis], ..Input::default() }
}

const UNIT: AxisLimits = AxisLimits::symmetric(1.0, 1.0, 1.0);

fn close(x: f64, y: f64) {
    assert!((x - y).abs() <= 1e-9 * y.abs().max(1.0), "{x} is not {y}");
}

#[test]
fn closed_forms() {
    // At rest, far apart: v/a + a/j of ramps and the rest at full speed.
    close(plan(&alone(axis([0.0; 3], [10.0, 0.0, 0.0], UNIT))).unwrap().duration, 12.0);
    // At rest, near: four ramps of (d / 2j)^(1/3).
    close(plan(&alone(axis([0.0; 3], [-0.25, 0.0, 0.0], UNIT))).unwrap().duration, 4.0 * 0.125f64.cbrt());
    // Straight on at the limit, and nothing at all.
    close(plan(&alone(axis([0.0, 1.0, 0.0], [3.0, 1.0, 0.0], UNIT))).unwrap().duration, 3.0);
    close(plan(&alone(axis([0.3, 1.0, 0.0], [0.3, 1.0, 0.0], UNIT))).unwrap().duration, 0.0);
    // A ramp that ends before the acceleration is zero; the long way round would take over three times as long.
    let ramp = axis([0.0, 0.0, -1.0], [-0.5 * 0.01 - 0.001 / 6.0, -0.105, -1.0 - 0.1], AxisLimits::symmetric(2.0, 2.0, 1.0));
    close(plan(&alone(ramp)).unwrap().duration, 0.1);
}

#[test]
fn a_start_outside_the_limits_is_brought_back_first() {
    let motion = plan(&alone(axis([0.0, 3.0, 0.5], [20.0, 0.0, 0.0], UNIT))).unwrap();
    let mut last = 3.125;
    for i in 0..=1000 {
        let t = motion.duration * f64::from(i) / 1000.0;
        let v = motion.at(t)[0].velocity;
        // Once the acceleration has gone, a speed outside only falls.
        assert!(v <= 1.0 + 1e-9 || v <= last + 1e-9, "{v} after {last}");
        last = if t < 0.5 { 3.125 } else { v };
    }
}

#[test]
fn a_duration_between_two_that_are_possible_is_passed_over() {
    // Straight on, or much later after slowing down: in a little more time nearly nothing can be lost (j t^3 / 32).
    let start = axis([0.0, 1.0, 0.0], [0.1, 1.0, 0.0], UNIT);
    close(plan(&alone(start)).unwrap().duration, 0.1);
    let later = plan(&Input { minimum_duration: 0.1001, ..alone(start) }).unwrap();
    assert!(later.duration > 5.0, "{}", later.duration);
    // The same for another axis on the way with it.
    let slow = axis([0.0; 3], [0.05, 0.0, 0.0], UNIT);
    let both = plan(&Input { axes: vec![start, slow], ..Input::default() }).unwrap();
    close(both.duration, later.duration);
    let backward = axis([0.0, 1.0, 0.0], [-0.001, 1.0, 0.0], UNIT);
    let around = plan(&alone(backward)).unwrap().duration;
    assert!(around > 3.0, "{around}");
    let fast = axis([0.0, 0.9, 0.0], [0.5, 0.9, 0.0], AxisLimits::symmetric(1.0, 0.1, 0.1));
    let first = plan(&alone(fast)).unwrap().duration;
    let blocked = plan(&Input { minimum_duration: 3.0, ..alone(fast) }).unwrap();
    assert!(first < 0.56 && blocked.duration > 5.0, "{first}, {}", blocked.duration);
}

#[test]
fn straight_lines() {
    let ways = [1.0, -0.5, 0.25, 0.0];
    let axes: Vec<Axis> = ways.iter().map(|d| axis([0.2, 0.0, 0.0], [0.2 + d, 0.0, 0.0], AxisLimits::symmetric(1.0, 2.0, 8.0))).collect();
    let input = Input { axes, sync: Sync::Phase, ..Input::default() };
    let motion = plan(&input).unwrap();
    assert!(motion.straight);
    for i in 0..=100 {
        let states = motion.at(motion.duration * f64::from(i) / 100.0);
        for (state, d) in states.iter().zip(ways) {
            close(state.position - 0.2, d * (states[0].position - 0.2));
        }
    }
    let bent = Input { axes: vec![input.axes[0], axis([0.0, 0.1, 0.0], [1.0, 0.0, 0.0], UNIT)], ..input };
    assert!(!plan(&bent).unwrap().straight);
}

#[test]
fn cycles_and_axes_that_take_no_part() {
    let mut still = axis([0.7, 0.5, 0.0], [9.0, 0.0, 0.0], UNIT);
    still.enabled = false;
    let input = Input { axes: vec![axis([0.0; 3], [1.0, 0.0, 0.0], UNIT), still], cycle: Some(0.004), ..Input::default() };
    let motion = plan(&input).unwrap();
    close(motion.duration, 3.176);
    close(motion.at(1.0)[1].position, 0.7);
    let free = plan(&Input { sync: Sync::None, cycle: None, ..input }).unwrap();
    close(free.axes[1].duration, 0.0);
}

#[test]
fn infinite_limits_of_velocity_and_acceleration() {
    let open = AxisLimits { velocity: (f64::NEG_INFINITY, f64::INFINITY), acceleration: (f64::NEG_INFINITY, f64::INFINITY), jerk: 1.0 };
    close(plan(&alone(axis([0.0; 3], [2000.0, 0.0, 0.0], open))).unwrap().duration, 4.0 * 10.0);
    let input = Input { minimum_duration: 1000.0, ..alone(axis([0.0, 1.0, 0.3], [-2000.0, 3.0, -0.4], open)) };
    close(plan(&input).unwrap().duration, 1000.0);
}

type Change<'a> = &'a dyn Fn(&mut Axis);

#[test]
fn errors_say_what_is_wrong() {
    let good = axis([0.0; 3], [1.0, 0.0, 0.0], UNIT);
    let said = |change: Change<'_>| {
        let mut bad = good;
        change(&mut bad);
        plan(&alone(bad)).unwrap_err().to_string()
    };
    let cases: [(&str, Change<'_>); 9] = [
        ("start velocity of axis 0 = NaN", &|a| a.start.velocity = f64::NAN),
        ("goal position of axis 0 = inf", &|a| a.goal.position = Some(f64::INFINITY)),
        ("jerk limit of axis 0 = 0", &|a| a.limits.jerk = 0.0),
        ("acceleration limits of axis 0 = -1 to 0", &|a| a.limits.acceleration.1 = 0.0),
        ("velocity limits of axis 0 = 0 to 0", &|a| a.limits.velocity = (0.0, 0.0)),
        ("goal velocity of axis 0 = 2", &|a| a.goal.velocity = 2.0),
        ("goal acceleration of axis 0 = -1.5", &|a| a.goal.acceleration = -1.5),
        ("goal acceleration of axis 0 = -1", &|a| (a.goal.velocity, a.goal.acceleration) = (0.9, -1.0)),
        ("axis 0 cannot reach its goal", &|a| a.limits.velocity = (-1.0, 0.0)),
    ];
    for (wanted, change) in cases {
        let text = said(change);
        assert!(text.contains(wanted), "{text}");
    }
    for input in [Input { minimum_duration: -1.0, ..alone(good) }, Input { cycle: Some(0.0), ..alone(good) }] {
        assert!(plan(&input).is_err());
    }
    assert_eq!(plan(&Input::default()).unwrap().duration, 0.0);
}
