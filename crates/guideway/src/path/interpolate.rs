//! Curves through given points: the cubic spline with continuous second derivative and no knot at the second and the last but one point.
//!
//! Source: \[deboor1978\], chapters IV and XIII. The collocation matrix is totally positive, so elimination needs no pivots.

use super::bspline::Path;
use crate::error::PlanError;

/// Points closer than this share of the size of the whole are one point.
const SAME: f64 = 1e-12;
/// Diagonals on either side of the main one.
const BAND: usize = 2;

impl Path {
    /// The interpolating spline through `points` (rows of `dimension` values): cubic with continuous curvature from four points on, a parabola through
    /// three, a straight line through two, a path of length 0 at a single one. Parameters are the accumulated distances of the points. A point that
    /// repeats the one before it is dropped.
    /// # Errors
    /// [`PlanError::BadParameter`] if there is no point, rows are incomplete, or values are not finite.
    pub fn through(points: &[f64], dimension: usize) -> Result<Self, PlanError> {
        let rows = distinct(points, dimension, None)?;
        let mut parameters = vec![0.0];
        for w in rows.points.chunks_exact(dimension).zip(rows.points.chunks_exact(dimension).skip(1)) {
            parameters.push(parameters[parameters.len() - 1] + gap(w.0, w.1));
        }
        spline(&Rows { parameters, ..rows }, dimension)
    }

    /// [`Path::through`] with a parameter for each point; they decide the shape, not the speed. Where a point repeats the one before it, both it and its
    /// parameter are dropped.
    /// # Errors
    /// As there, and if parameters are not as many as the points, finite and increasing.
    pub fn through_at(points: &[f64], dimension: usize, parameters: &[f64]) -> Result<Self, PlanError> {
        spline(&distinct(points, dimension, Some(parameters))?, dimension)
    }
}

struct Rows {
    points: Vec<f64>,
    parameters: Vec<f64>,
}

/// The points without repetitions, checked.
fn distinct(points: &[f64], dimension: usize, parameters: Option<&[f64]>) -> Result<Rows, PlanError> {
    let count = points.len().checked_div(dimension).unwrap_or(0);
    if count == 0 || points.len() != count * dimension {
        return Err(PlanError::bad("points", format!("{} values", points.len()), format!("at least one row of {dimension} values")));
    }
    if let Some(i) = points.iter().position(|v| !v.is_finite()) {
        return Err(PlanError::bad("points", format!("row {}: {}", i / dimension, points[i]), "finite values"));
    }
    if let Some(t) = parameters
        && (t.len() != count || !t.iter().all(|v| v.is_finite()) || !t.windows(2).all(|w| w[0] < w[1]))
    {
        return Err(PlanError::bad("parameters", format!("{} values", t.len()), format!("{count} finite, increasing values, one per point")));
    }
    let first = &points[..dimension];
    let size = points.chunks_exact(dimension).map(|row| gap(first, row)).fold(0.0, f64::max);
    if !size.is_finite() {
        return Err(PlanError::bad("points", "their distance", "finite"));
    }
    let mut rows = Rows { points: Vec::with_capacity(points.len()), parameters: Vec::with_capacity(count) };
    for (i, row) in points.chunks_exact(dimension).enumerate() {
        if i > 0 && gap(&rows.points[rows.points.len() - dimension..], row) <= SAME * size {
            continue;
        }
        rows.points.extend_from_slice(row);
        rows.parameters.push(parameters.map_or(0.0, |t| t[i]));
    }
    Ok(rows)
}

fn spline(rows: &Rows, dimension: usize) -> Result<Path, PlanError> {
    let (t, n) = (&rows.parameters, rows.parameters.len());
    if n == 1 {
        return Path::new(1, dimension, vec![0.0; 4], rows.points.repeat(2));
    }
    let degree = (n - 1).min(3);
    let inner = if n > 4 { &t[2..n - 2] } else { &[] };
    let knots: Vec<f64> = [t[0]].repeat(degree + 1).into_iter().chain(inner.iter().copied()).chain([t[n - 1]].repeat(degree + 1)).collect();
    let mut control = rows.points.clone();
    let mut matrix = vec![[0.0; 2 * BAND + 1]; n];
    for i in 0..n {
        let span = (knots.partition_point(|k| *k <= t[i]) - 1).clamp(degree, n - 1);
        let values = basis(&knots, degree, span, t[i]);
        for (k, value) in values.iter().enumerate().take(degree + 1).filter(|(_, v)| **v != 0.0) {
            matrix[i][span - degree + k + BAND - i] = *value;
        }
    }
    solve(&mut matrix, &mut control, dimension);
    Path::new(degree, dimension, knots, control)
}

/// The `degree + 1` basis functions that are not zero on a knot span, at `t`.
fn basis(knots: &[f64], degree: usize, span: usize, t: f64) -> [f64; 4] {
    let mut values = [1.0, 0.0, 0.0, 0.0];
    for j in 1..=degree {
        let mut carried = 0.0;
        for r in 0..j {
            let (right, left) = (knots[span + r + 1] - t, t - knots[span + 1 + r - j]);
            let share = values[r] / (right + left);
            values[r] = carried + right * share;
            carried = left * share;
        }
        values[j] = carried;
    }
    values
}

/// Solves a banded system for `columns` right sides at once, in place.
fn solve(matrix: &mut [[f64; 2 * BAND + 1]], right: &mut [f64], columns: usize) {
    let n = matrix.len();
    for i in 0..n {
        for below in i + 1..(i + BAND + 1).min(n) {
            let factor = matrix[below][BAND + i - below] / matrix[i][BAND];
            if factor == 0.0 {
                continue;
            }
            for k in i..(i + BAND + 1).min(n) {
                matrix[below][BAND + k - below] -= factor * matrix[i][BAND + k - i];
            }
            for c in 0..columns {
                right[below * columns + c] -= factor * right[i * columns + c];
            }
        }
    }
    for i in (0..n).rev() {
        for c in 0..columns {
            let known: f64 = (i + 1..(i + BAND + 1).min(n)).map(|k| matrix[i][BAND + k - i] * right[k * columns + c]).sum();
            right[i * columns + c] = (right[i * columns + c] - known) / matrix[i][BAND];
        }
    }
}

fn gap(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| (y - x) * (y - x)).sum::<f64>().sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Six points in three dimensions on `f`, and their parameters.
    fn sampled(f: impl Fn(f64) -> [f64; 3]) -> (Vec<f64>, Vec<f64>) {
        let t: Vec<f64> = [0.0, 0.3, 0.45, 0.8, 1.3, 2.0].to_vec();
        (t.iter().flat_map(|t| f(*t)).collect(), t)
    }

    #[test]
    fn a_cubic_is_reproduced() {
        let f = |t: f64| [t * t * t - t, 2.0 - t * t, 0.5 * t];
        let (points, t) = sampled(f);
        let path = Path::through_at(&points, 3, &t).unwrap();
        for i in 0..=40 {
            let t = f64::from(i) * 0.05;
            let [q, dq] = [&path.at(t, 1)[0], &path.at(t, 1)[1]];
            let expected = [3.0 * t * t - 1.0, -2.0 * t, 0.5];
            assert!((0..3).all(|k| (q[k] - f(t)[k]).abs() < 1e-12 && (dq[k] - expected[k]).abs() < 1e-11), "{t}");
        }
    }

    #[test]
    fn few_and_repeated_points() {
        let line = Path::through(&[0.0, 0.0, 3.0, 4.0], 2).unwrap();
        assert_eq!((line.degree(), line.length()), (1, 5.0));
        assert_eq!(Path::through(&[1.0, 2.0, 3.0], 3).unwrap().length(), 0.0);
        assert_eq!(Path::through(&[1.0, 2.0, 1.0, 2.0, 1.0, 2.0], 2).unwrap().length(), 0.0);
        let parabola = Path::through_at(&[0.0, 0.0, 1.0, 1.0, 2.0, 4.0], 2, &[0.0, 1.0, 2.0]).unwrap();
        assert_eq!(parabola.degree(), 2);
        assert!((parabola.at(1.5, 0)[0][1] - 2.25).abs() < 1e-14);
        let repeated = Path::through(&[0.0, 0.0, 1.0, 1.0, 1.0, 1.0, 2.0, 4.0, 2.0, 4.0], 2).unwrap();
        assert_eq!(repeated, Path::through(&[0.0, 0.0, 1.0, 1.0, 2.0, 4.0], 2).unwrap());
        for bad in [&[f64::NAN, 0.0, 1.0, 1.0][..], &[0.0, 0.0, f64::INFINITY, 1.0], &[0.0, 0.0, 1.0], &[]] {
            assert!(matches!(Path::through(bad, 2), Err(PlanError::BadParameter { .. })));
        }
        assert!(Path::through(&[1.0], 0).is_err() && Path::through(&[-1e308, 1e308], 1).is_err());
        for bad in [&[0.0, 0.0][..], &[0.0], &[1.0, 0.0], &[0.0, f64::NAN]] {
            assert!(Path::through_at(&[0.0, 0.0, 1.0, 1.0], 2, bad).is_err());
        }
    }

    proptest! {
        /// The curve passes every point, and its first two derivatives do not jump.
        #[test]
        fn through_every_point_with_continuous_curvature(points in prop::collection::vec(-3.0..3.0f64, 4 * 4..4 * 12)) {
            let n = points.len() / 4;
            let points = &points[..4 * n];
            let path = Path::through(points, 4).unwrap();
            let mut t = 0.0;
            for (i, row) in points.chunks_exact(4).enumerate() {
                t += if i > 0 { gap(&points[4 * i - 4..4 * i], row) } else { 0.0 };
                prop_assert!(gap(&path.at(t, 0)[0], row) < 1e-9);
                let (before, after) = (path.at(t - 1e-9, 2), path.at(t + 1e-9, 2));
                let size = after[2].iter().chain(&before[2]).fold(1.0, |m: f64, v| m.max(v.abs()));
                prop_assert!(gap(&before[1], &after[1]) < 1e-6 * size && (gap(&before[2], &after[2]) < 1e-5 * size * size.max(n as f64)));
            }
        }
    }
}
