//! A million random motions of several axes, every one checked: run with `make test-slow`.
#![cfg(feature = "slow")]

mod common_axes;

#[test]
fn a_million_random_problems() {
    common_axes::random(1_000_000, 2);
}

#[test]
fn a_hundred_thousand_random_starts_outside_the_limits() {
    common_axes::outside(100_000, 2);
}
