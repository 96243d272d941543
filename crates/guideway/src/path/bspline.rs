//! The type: clamped B-splines of any degree and dimension.

use super::arc_length::{Lazy, Table};
use super::bezier::Bezier;
use crate::Point;
use crate::error::PlanError;
use serde::{Deserialize, Serialize};

/// A clamped B-spline curve. Knots are non-decreasing, the first and last repeat `degree + 1` times, so the curve starts at the first and ends at the
/// last control point. A polyline is degree 1 with knots at the arc length of its points.
///
/// Arc length and evaluation are built once, when first asked for. In files: `{"degree": 3, "knots": [...], "control_points": [[x, y], ...]}`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Parts", into = "Parts")]
pub struct Path {
    degree: usize,
    dimension: usize,
    knots: Vec<f64>,
    /// Control points, row after row (`n * dimension` values).
    control: Vec<f64>,
    lazy: Lazy,
}

/// A path as files have it.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Parts {
    degree: usize,
    knots: Vec<f64>,
    control_points: Vec<Vec<f64>>,
}

impl From<Path> for Parts {
    fn from(path: Path) -> Self {
        let control_points = path.control.chunks_exact(path.dimension).map(<[f64]>::to_vec).collect();
        Self { degree: path.degree, knots: path.knots, control_points }
    }
}

impl TryFrom<Parts> for Path {
    type Error = PlanError;
    fn try_from(parts: Parts) -> Result<Self, PlanError> {
        let dimension = parts.control_points.first().map_or(0, Vec::len);
        if let Some(row) = parts.control_points.iter().position(|row| row.len() != dimension) {
            return Err(PlanError::bad("path.control_points", format!("row {row}"), format!("{dimension} coordinates, as in the first row")));
        }
        Self::new(parts.degree, dimension, parts.knots, parts.control_points.concat())
    }
}

impl Path {
    /// A polyline through `points` (m); repeated points are dropped. One point alone is a path of length 0, none is such a path at the origin.
    pub fn polyline(points: &[[f64; 2]]) -> Self {
        let mut kept: Vec<[f64; 2]> = Vec::with_capacity(points.len().max(2));
        let mut s = Vec::with_capacity(points.len().max(2) + 2);
        s.push(0.0);
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
        if kept.is_empty() {
            kept.push([0.0; 2]);
            s.push(0.0);
        }
        if kept.len() == 1 {
            kept.push(kept[0]);
            s.push(0.0);
        }
        s.push(s[s.len() - 1]);
        Self { degree: 1, dimension: 2, knots: s, control: kept.into_flattened(), lazy: Lazy::default() }
    }

    /// A clamped B-spline from its parts: `control` holds `n` rows of `dimension` values, `knots` n + degree + 1 values.
    /// # Errors
    /// [`PlanError::BadParameter`] if counts do not fit, knots decrease or are not clamped, or values are not finite.
    pub fn new(degree: usize, dimension: usize, knots: Vec<f64>, control: Vec<f64>) -> Result<Self, PlanError> {
        let n = control.len().checked_div(dimension).unwrap_or(0);
        if degree == 0 || dimension == 0 || control.len() != n * dimension || n <= degree || knots.len() != n + degree + 1 {
            let shown = format!("degree {degree}, dimension {dimension}, {} values, {} knots", control.len(), knots.len());
            return Err(PlanError::bad("path", shown, "n > degree control points of the dimension and n + degree + 1 knots"));
        }
        let clamped = knots[..=degree].iter().all(|k| *k == knots[0]) && knots[n..].iter().all(|k| *k == knots[n]);
        if !clamped || !knots.windows(2).all(|w| w[0] <= w[1]) || !knots.iter().chain(&control).all(|v| v.is_finite()) {
            return Err(PlanError::bad("path.knots", format!("{} knots", knots.len()), "finite, non-decreasing and clamped at both ends"));
        }
        Ok(Self { degree, dimension, knots, control, lazy: Lazy::default() })
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

    pub(super) fn table(&self) -> &Table {
        self.lazy.get(self)
    }

    /// Control rows of the polynomial pieces of positive length in Bernstein form, and anchors of the arc length: piece, its parameter, arc length (m),
    /// so close that eight Gauss nodes give the length from one to the next.
    pub(crate) fn pieces(&self) -> (Vec<f64>, Vec<(usize, f64, f64)>) {
        let table = self.table();
        let control = (0..table.spans.len()).flat_map(|i| table.piece(i).iter().copied()).collect();
        (control, table.leaves.iter().map(|leaf| (leaf.piece, leaf.t[0], leaf.s[0])).collect())
    }

    /// The knot spans of positive length as planar Bezier pieces, in order. The curve is their union; each lies in the convex hull of its points.
    pub fn beziers(&self) -> Vec<Bezier> {
        let spans = (self.degree..self.count()).filter(|&k| self.knots[k] < self.knots[k + 1]);
        spans
            .map(|k| {
                let points = self.extract(k).chunks_exact(self.dimension).map(|row| [row[0], row[1]]).collect();
                Bezier { points, u: [self.knots[k], self.knots[k + 1]] }
            })
            .collect()
    }

    /// Control rows of the Bezier form of knot span `k`: row j is the blossom at (start, ..., start, end x j).
    pub(super) fn extract(&self, k: usize) -> Vec<f64> {
        let (p, dim, u) = (self.degree, self.dimension, &self.knots);
        let mut rows = Vec::with_capacity((p + 1) * dim);
        for j in 0..=p {
            let mut local = self.control[(k - p) * dim..(k + 1) * dim].to_vec();
            for r in 1..=p {
                let at = if r <= p - j { u[k] } else { u[k + 1] };
                for i in (r..=p).rev() {
                    let (low, high) = (u[k - p + i], u[k + 1 + i - r]);
                    let share = (at - low) / (high - low);
                    for d in 0..dim {
                        local[i * dim + d] = (1.0 - share) * local[(i - 1) * dim + d] + share * local[i * dim + d];
                    }
                }
            }
            rows.extend_from_slice(&local[p * dim..]);
        }
        rows
    }

    /// First and last point of a planar path, m.
    pub fn ends(&self) -> [Point; 2] {
        [self.point(0), self.point(self.count() - 1)]
    }
}
