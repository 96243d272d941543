//! Path: one clamped B-spline type of any degree and any dimension; a polyline is degree 1.

mod bspline;

pub use bspline::Path;
