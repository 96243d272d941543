//! The guarantee of the default controller: no collision while moving, whatever movers do within their speed bounds.

mod guarded;

use serde_json::{Value, json};

fn drive(steps: u64, set: &Value) -> guarded::Tally {
    let (mut all, mut seed) = (guarded::Tally::default(), 0);
    while all.steps < steps {
        all = all.add(guarded::drive(seed, set));
        seed += 1;
    }
    assert_eq!(all.moving, 0, "{:?}", all.first);
    println!("{all:?}");
    all
}

#[test]
fn no_collision_while_moving_in_20_000_random_steps() {
    let all = drive(20_000, &Value::Null);
    assert!(all.metres > 100.0, "the robot hardly moved: {all:?}");
}

#[test]
fn nor_in_10_000_with_limited_jerk() {
    let all = drive(10_000, &json!({"jerk_limited": true}));
    assert!(all.metres > 40.0, "the robot hardly moved: {all:?}");
}
