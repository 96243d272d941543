//! Paths as splines: the encoding and the objective that turn any optimizer into a continuous planner.
//!
//! Source: \[zhang2025\], repaired: a clamped cubic B-spline from start to goal with free control points, an objective of length, time, turning and clearance,
//! and the seven-phase motion over the whole path. Departures: clearance is exact, not sampled; places where the motion would exceed the speed ceiling cost half of their share;
//! via points are passed by one spline of continuous curvature.

mod basis;
mod clearance;
mod curves;
mod samples;
mod settings;
mod speed;
#[cfg(test)]
mod tests;

pub use curves::{Curves, Judged};
pub use settings::{Form, Settings};
