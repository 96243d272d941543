//! Clamped B-splines, evaluated by parameter.

use crate::error::PlanError;
use serde::{Deserialize, Serialize};

/// A clamped B-spline curve. Knots are non-decreasing, the first and last repeat `degree + 1` times, so the curve starts at the first and ends at the
/// last control point. A polyline is degree 1 with knots at the arc length of its points.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Path {
    degree: usize,
    dimension: usize,
    knots: Vec<f64>,
    /// Control points, row after row (`n * dimension` values).
    control: Vec<f64>,
}

impl Path {
    /// A polyline through `points` (m); repeated points are dropped. One point alone is a path of length 0.
    pub fn polyline(points: &[[f64; 2]]) -> Self {
        let mut kept: Vec<[f64; 2]> = Vec::with_capacity(points.len().max(2));
        let mut s = vec![0.0];
        for &p in points {
            if let Some(&q) = kept.last() {
                let d = (p[0] - q[0]).hypot(p[1] - q[1]);
                if d == 0.0 {
                    continue;
                }
                s.push(s[s.len() - 1] + d);
            } else {
                s.push(0.0);
            }
            kept.push(p);
        }
        if kept.len() == 1 {
            kept.push(kept[0]);
            s.push(0.0);
        }
        s.push(s[s.len() - 1]);
        Self { degree: 1, dimension: 2, knots: s, control: kept.into_iter().flatten().collect() }
    }

    /// A clamped B-spline from its parts: `control` holds `n` rows of `dimension` values, `knots` n + degree + 1 values.
    /// # Errors
    /// [`PlanError::BadParameter`] if counts do not fit, knots decrease or are not clamped, or values are not finite.
    pub fn new(degree: usize, dimension: usize, knots: Vec<f64>, control: Vec<f64>) -> Result<Self, PlanError> {
        let n = if dimension == 0 { 0 } else { control.len() / dimension };
        if degree == 0 || dimension == 0 || control.len() != n * dimension || n <= degree || knots.len() != n + degree + 1 {
            let shown = format!("degree {degree}, dimension {dimension}, {} values, {} knots", control.len(), knots.len());
            return Err(PlanError::bad("path", shown, "n > degree control points of the dimension and n + degree + 1 knots"));
        }
        let clamped = knots[..=degree].iter().all(|k| *k == knots[0]) && knots[n..].iter().all(|k| *k == knots[n]);
        if !clamped || !knots.windows(2).all(|w| w[0] <= w[1]) || !knots.iter().chain(&control).all(|v| v.is_finite()) {
            return Err(PlanError::bad("path.knots", format!("{} knots", knots.len()), "finite, non-decreasing and clamped at both ends"));
        }
        Ok(Self { degree, dimension, knots, control })
    }

    /// Polynomial degree.
    pub fn degree(&self) -> usize {
        self.degree
    }
    /// Coordinates per point.
    pub fn dimension(&self) -> usize {
        self.dimension
    }
    /// All knots, clamped.
    pub fn knots(&self) -> &[f64] {
        &self.knots
    }
    /// Control points, row after row.
    pub fn control(&self) -> &[f64] {
        &self.control
    }
    /// Control point `i` of a planar path, m.
    pub fn point(&self, i: usize) -> [f64; 2] {
        [self.control[i * self.dimension], self.control[i * self.dimension + 1]]
    }
    /// Number of control points.
    pub fn count(&self) -> usize {
        self.control.len() / self.dimension
    }
    /// Control points of a planar path, m.
    pub fn points(&self) -> Vec<[f64; 2]> {
        (0..self.count()).map(|i| self.point(i)).collect()
    }
}
