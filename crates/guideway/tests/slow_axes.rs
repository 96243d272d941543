//! A million random motions of several axes, every one checked: run with `make test-slow`.
#![cfg(feature = "slow")]

mod common_axes;

#[test]
fn a_million_random_problems() {
    common_axes::random(1_000_000, 2);
}
