//! Path: one clamped B-spline type of any degree and any dimension; a polyline is degree 1.

mod arc_length;
mod bezier;
mod bspline;
mod eval;
mod interpolate;
mod measure;
mod project;
#[cfg(test)]
mod tests;

pub use bezier::Bezier;
pub use bspline::Path;
pub use eval::{Corner, Planar};
pub use measure::{ENERGY, Metrics, TURNING, measure};
