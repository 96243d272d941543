//! Paths as splines: the encoding and the objective that turn any optimizer into a continuous planner.
//!
//! Source: \[zhang2025\], repaired: a clamped cubic B-spline from start to goal with free control points, an objective of length, time, turning and clearance,
//! and the seven-phase motion over the whole path. Departures: clearance is exact, not sampled; places where the motion would exceed the speed ceiling cost half of their share;
//! via points are passed by one spline of continuous curvature.

mod basis;
mod clearance;
mod curves;
mod methods;
mod planner;
mod route;
mod samples;
mod settings;
mod speed;
#[cfg(test)]
mod tests;
mod watch;

pub use curves::{Curves, Judged};
pub use methods::{CmaEs, De, Firefly, ImprovedDe, LShade};
pub use planner::Spline;
pub(super) use planner::{follow, nothing, objective, plan, thinned};
pub(super) use route::{layout, legs, lines, seed};
pub use settings::{Form, Settings};
pub(super) use watch::{Watch, points};
