//! The guarantee of the default controller over a million random steps.
#![cfg(feature = "slow")]

mod guarded;

use rayon::prelude::*;
use serde_json::Value;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Instant;

/// Rooms of 500 steps, and after how many a line tells how far it is.
const ROOMS: u64 = 2200;
const LINE: u64 = 50;

#[test]
fn no_collision_while_moving_in_a_million_random_steps() {
    let (started, done) = (Instant::now(), AtomicU64::new(0));
    let room = |i: u64| {
        let tally = guarded::drive(10_000 + i, &Value::Null);
        let n = done.fetch_add(1, Ordering::Relaxed) + 1;
        if n.is_multiple_of(LINE) {
            eprintln!("{n} of {ROOMS} rooms, {:.0} s", started.elapsed().as_secs_f64());
        }
        tally
    };
    let all = (0..ROOMS).into_par_iter().map(room).reduce(guarded::Tally::default, guarded::Tally::add);
    println!("{all:?}");
    assert_eq!(all.moving, 0, "{:?}", all.first);
    assert!(all.steps >= 1_000_000, "{all:?}");
    assert!(all.metres > 5000.0, "the robot hardly moved: {all:?}");
}
