//! Cheap random draws: 32 bits where 32 bits do.

use rand::{Rng, RngExt};
use rand_chacha::ChaCha8Rng;
use std::f64::consts::TAU;

const UNIT: f64 = 1.0 / (1u64 << 32) as f64;

/// A uniform number from 0 to below 1, in steps of 2^-32.
pub(super) fn unit(rng: &mut ChaCha8Rng) -> f64 {
    f64::from(rng.next_u32()) * UNIT
}

/// Two uniform numbers from one draw.
pub(super) fn pair(rng: &mut ChaCha8Rng) -> [f64; 2] {
    let bits = rng.next_u64();
    [(bits >> 32) as f64 * UNIT, (bits & 0xffff_ffff) as f64 * UNIT]
}

/// A uniform number below `count`.
pub(super) fn index(count: usize, rng: &mut ChaCha8Rng) -> usize {
    ((u64::from(rng.next_u32()) * count as u64) >> 32) as usize
}

/// A probability as what 32 random bits must stay below.
#[derive(Clone, Copy)]
pub(super) struct Chance(u64);

impl Chance {
    pub fn new(probability: f64) -> Self {
        Self((probability / UNIT) as u64)
    }

    pub fn hit(self, rng: &mut ChaCha8Rng) -> bool {
        u64::from(rng.next_u32()) < self.0
    }
}

/// Two independent normal deviates, mean 0, variance 1.
pub(super) fn normals(rng: &mut ChaCha8Rng) -> [f64; 2] {
    let [u, w] = [1.0 - rng.random::<f64>(), rng.random::<f64>()];
    let (sin, cos) = (TAU * w).sin_cos();
    let r = (-2.0 * u.ln()).sqrt();
    [r * cos, r * sin]
}

/// A place between the bounds of one number.
pub(super) fn between((low, high): (f64, f64), rng: &mut ChaCha8Rng) -> f64 {
    (low + (high - low) * unit(rng)).min(high)
}
