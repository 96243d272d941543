//! A planar range sensor on the robot: rays cast exactly against everything solid, then noise.

use super::Outline;
use super::rays::Rays;
use crate::Point;
use crate::error::PlanError;
use crate::world::World;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use serde::{Deserialize, Serialize};

/// Rays beyond this number are refused.
const MOST: u32 = 100_000;

/// A 2-D lidar at the robot's reference point, its middle beam straight ahead.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Lidar {
    /// Rays of one scan.
    pub beams: u32,
    /// Angle between the first and the last ray, rad; a full circle has no ray twice.
    pub field_of_view: f64,
    /// Farthest that is seen, m.
    pub range: f64,
    /// Standard deviation of a range, m.
    pub noise: f64,
    /// Scans per second, Hz.
    pub rate: f64,
}

impl Default for Lidar {
    fn default() -> Self {
        Self { beams: 360, field_of_view: std::f64::consts::TAU, range: 10.0, noise: 0.01, rate: 20.0 }
    }
}

/// One turn of a lidar.
#[derive(Debug, Clone, PartialEq)]
pub struct Scan {
    /// When it was taken, s.
    pub time: f64,
    /// Direction of the first ray against the heading, rad.
    pub first: f64,
    /// From ray to ray, rad, positive to the left.
    pub step: f64,
    /// Farthest that is seen, m.
    pub range: f64,
    /// m; infinite: nothing within range; not a number: no measurement.
    pub ranges: Vec<f64>,
}

impl Lidar {
    /// Checks the values.
    /// # Errors
    /// [`PlanError::BadParameter`] names the first out of range. A field of view may exceed a full turn by 0.001 rad, as few digits of it do.
    pub fn validated(self) -> Result<Self, PlanError> {
        let full = std::f64::consts::TAU + 1e-3;
        let named = [
            ("beams", f64::from(self.beams), [1.0, f64::from(MOST)]),
            ("field_of_view", self.field_of_view, [1e-6, full]),
            ("range", self.range, [1e-3, 1e6]),
            ("noise", self.noise, [0.0, 1e3]),
            ("rate", self.rate, [1e-3, 1e6]),
        ];
        match named.into_iter().find(|(_, v, range)| !(range[0]..=range[1]).contains(v)) {
            Some((name, value, range)) => Err(PlanError::bad(format!("lidar.{name}"), value, format!("{} to {}", range[0], range[1]))),
            None => Ok(self),
        }
    }

    /// Direction of the first ray against the heading and the angle from ray to ray, rad.
    pub fn rays(&self) -> (f64, f64) {
        let n = f64::from(self.beams);
        let full = self.field_of_view >= std::f64::consts::TAU - 1e-3;
        let gaps = if full { n } else { (n - 1.0).max(1.0) };
        let step = self.field_of_view / gaps;
        (-0.5 * step * (n - 1.0), step)
    }

    /// One scan from the true `pose` (x, y in m, yaw in rad) at `time` (s): the first point of each ray in a blocked cell, a shape or a mover. `movers` are
    /// outlines with the position of their reference points, m. A range is never negative and never not a number.
    pub fn scan(&self, world: &World, movers: &[(Outline, Point)], (pose, time): ([f64; 3], f64), rng: &mut ChaCha8Rng) -> Scan {
        let (first, step) = self.rays();
        let mut rays = Rays::new(pose, (first, step, self.beams as usize), self.range);
        rays.shapes(world.shapes());
        for (outline, at) in movers {
            rays.outline(outline, *at);
        }
        if let Some(grid) = world.grid() {
            rays.grid(grid);
        }
        let mut ranges = rays.into_ranges();
        if self.noise > 0.0 {
            let mut normal = normals(rng);
            for r in ranges.iter_mut().filter(|r| r.is_finite()) {
                let noisy = (*r + self.noise * normal()).max(0.0);
                *r = if noisy > self.range { f64::INFINITY } else { noisy };
            }
        }
        Scan { time, first, step, range: self.range, ranges }
    }

    /// The noise of a lidar in a run: a stream of its own.
    pub fn random(seed: u64) -> ChaCha8Rng {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        rng.set_stream(0x6c69_6461_7200);
        rng
    }
}

/// Standard normal draws in pairs (Box and Muller).
fn normals(rng: &mut ChaCha8Rng) -> impl FnMut() -> f64 + '_ {
    let mut spare = None;
    move || {
        spare.take().unwrap_or_else(|| {
            let (a, b): (f64, f64) = (rng.random(), rng.random());
            let r = (-2.0 * (1.0 - a).ln()).sqrt();
            let (s, c) = (std::f64::consts::TAU * b).sin_cos();
            spare = Some(r * s);
            r * c
        })
    }
}

#[cfg(test)]
mod tests;
