//! One-axis cases with published durations (`otg/ruckig_known_cases.json` of the public data): equal where the case lies in our class.

use guideway::timing::scurve::transition;
use guideway::timing::{Bounds, Jerks, SCurve};
use serde_json::Value;
use std::path::PathBuf;

fn data() -> Option<PathBuf> {
    let beside = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data");
    let root = std::env::var_os("GUIDEWAY_DATA").map_or(beside, PathBuf::from);
    Some(root.join("otg/ruckig_known_cases.json")).filter(|p| p.exists())
}

/// One axis of a case, mirrored so that it moves forwards.
fn axis(input: &Value, i: usize) -> Option<SCurve> {
    let number = |name: &str| input[name][i].as_f64();
    let distance = number("target_position")? - number("current_position")?;
    let (v0, v1) = (number("current_velocity")?, number("target_velocity")?);
    let (a0, a1) = (number("current_acceleration")?, number("target_acceleration")?);
    let (speed, acceleration, jerk) = (number("max_velocity")?, number("max_acceleration")?, number("max_jerk")?);
    let bounds = Bounds { speed, acceleration, deceleration: acceleration, jerk: Jerks::all(jerk) };
    Some(SCurve { distance, start: (v0, a0), end: (v1, a1), bounds })
}

fn is(input: &Value, name: &str, value: &str) -> bool {
    input.get(name).is_none_or(|v| v == value)
}

/// Never reverses, as far as the boundary tells.
fn forwards(c: &SCurve) -> bool {
    let sign = if c.distance < 0.0 { -1.0 } else { 1.0 };
    sign * c.start.0 >= 0.0 && sign * c.end.0 >= 0.0
}

#[test]
fn durations_equal_the_published_ones() {
    let Some(file) = data() else {
        println!("skipped: no public data (set GUIDEWAY_DATA)");
        return;
    };
    let cases: Vec<Value> = serde_json::from_str(&std::fs::read_to_string(file).unwrap()).unwrap();
    let (mut positions, mut speeds, mut outside) = (0, 0, 0);
    for case in &cases {
        let input = &case["input"];
        let wanted = case["expected_duration"].as_f64().unwrap();
        let plain = ["min_velocity", "min_acceleration", "minimum_duration"].iter().all(|k| input.get(k).is_none_or(Value::is_null));
        if !plain || !is(input, "duration_discretization", "Continuous") {
            continue;
        }
        let axes: Vec<SCurve> = (0..3).map(|i| axis(input, i).unwrap()).collect();
        if input.get("control_interface").is_some_and(|v| v == "Velocity") {
            let times = axes.iter().map(|c| transition(c.start.into(), c.end.into(), &c.bounds).unwrap().duration());
            let longest = times.fold(0.0, f64::max);
            assert!((longest - wanted).abs() < 1e-6, "{longest} is not {wanted}: {case}");
            speeds += 1;
            continue;
        }
        // The axes of the data are synchronised in time: only equal axes, and motions from rest to rest, keep their own durations.
        let at_rest = |c: &SCurve| c.start == (0.0, 0.0) && c.end == (0.0, 0.0);
        let own = axes.iter().all(|c| *c == axes[0] || at_rest(c));
        let plans: Result<Vec<_>, _> = axes.iter().map(SCurve::plan).collect();
        match plans {
            Ok(plans) if own && axes.iter().all(forwards) => {
                let longest = plans.iter().map(guideway::timing::Profile::duration).fold(0.0, f64::max);
                // A published 0 stands for distances of 1e-17.
                assert!((longest - wanted).abs() < 2e-5 || longest < 1e-5 && wanted < 1e-5, "{longest} is not {wanted}: {case}");
                positions += 1;
            }
            _ => outside += 1,
        }
    }
    println!("{positions} motions and {speeds} velocity transitions equal, {outside} outside the class");
    assert!(positions >= 12 && speeds >= 4, "{positions} {speeds}");
}
