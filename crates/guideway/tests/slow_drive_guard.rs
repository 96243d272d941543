//! The guarantee of the default controller over a million random steps.
#![cfg(feature = "slow")]

mod guarded;

use rayon::prelude::*;

#[test]
fn no_collision_while_moving_in_a_million_random_steps() {
    let all = (0..2200_u64).into_par_iter().map(|i| guarded::drive(10_000 + i)).reduce(guarded::Tally::default, guarded::Tally::add);
    println!("{all:?}");
    assert_eq!(all.moving, 0, "{:?}", all.first);
    assert!(all.steps >= 1_000_000, "{all:?}");
}
