//! Evaluation: by parameter, and by arc length.

use super::bezier::derivatives;
use super::bspline::Path;
use crate::Point;
use crate::world::shape::{cross, wrap};

/// Heading jumps below this are rounding, rad (as in the definition of turns).
const SAME_HEADING: f64 = 1e-6;

/// A place on a planar path.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Planar {
    /// m.
    pub point: Point,
    /// Direction of travel, rad, in (-pi, pi]; at a corner the outgoing one.
    pub heading: f64,
    /// Signed, positive to the left, 1/m; 0 on straight legs and at their corners.
    pub curvature: f64,
}

/// A jump of the heading: the robot turns in place there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Corner {
    /// Arc length, m.
    pub s: f64,
    /// Heading before, rad.
    pub heading_in: f64,
    /// Heading after, rad.
    pub heading_out: f64,
}

impl Corner {
    /// Signed turn, rad, in (-pi, pi].
    pub fn turn(&self) -> f64 {
        wrap(self.heading_out - self.heading_in)
    }
}

impl Path {
    /// Length of the curve, m (relative error below 1e-9; exact for polylines).
    pub fn length(&self) -> f64 {
        self.table().length
    }

    /// Position and its derivatives with respect to the knot parameter `u`, clamped to the knots: `order + 1` rows of `dimension` values.
    pub fn at(&self, u: f64, order: usize) -> Vec<Vec<f64>> {
        let (p, n, dim) = (self.degree(), self.count(), self.dimension());
        let (first, last) = (self.knots()[p], self.knots()[n]);
        let u = u.clamp(first, last);
        let mut span = (self.knots().partition_point(|k| *k <= u) - 1).min(n - 1);
        while span > p && self.knots()[span] == self.knots()[span + 1] {
            span -= 1;
        }
        let width = self.knots()[span + 1] - self.knots()[span];
        let mut out = vec![0.0; (order + 1) * dim];
        if width > 0.0 {
            derivatives(&self.extract(span), dim, (u - self.knots()[span]) / width, &mut out);
        } else {
            out[..dim].copy_from_slice(&self.control()[..dim]);
        }
        let scale = |k: usize| if width > 0.0 { width.powi(-(k as i32)) } else { 1.0 };
        out.chunks_exact(dim).enumerate().map(|(k, row)| row.iter().map(|v| v * scale(k)).collect()).collect()
    }

    /// Position and its derivatives with respect to arc length at `s` (m, clamped to the path): `order + 1` rows of `dimension` values, order at
    /// most 3. Rows beyond that, and all derivatives of a path of no length, are zero.
    pub fn eval(&self, s: f64, order: usize) -> Vec<Vec<f64>> {
        let dim = self.dimension();
        let table = self.table();
        let Some((piece, t)) = table.locate(s) else {
            let mut rows = vec![vec![0.0; dim]; order + 1];
            rows[0].copy_from_slice(&self.control()[..dim]);
            return rows;
        };
        let mut r = vec![0.0; 4 * dim];
        regular(table.piece(piece), dim, t, &mut r);
        by_length(&mut r, dim);
        (0..=order).map(|k| if k <= 3 { r[k * dim..(k + 1) * dim].to_vec() } else { vec![0.0; dim] }).collect()
    }

    /// Position, heading and curvature of a planar path at arc length `s` (m, clamped to the path), without allocation for degrees up to 15.
    pub fn planar(&self, s: f64) -> Planar {
        let table = self.table();
        let Some((piece, t)) = table.locate(s) else {
            return Planar { point: self.point(0), heading: 0.0, curvature: 0.0 };
        };
        if self.dimension() == 2 {
            let mut r = [0.0; 8];
            regular(table.piece(piece), 2, t, &mut r);
            return planar(&r, 2);
        }
        let mut r = vec![0.0; 4 * self.dimension()];
        regular(table.piece(piece), self.dimension(), t, &mut r);
        planar(&r, self.dimension())
    }

    /// Every place where the heading of a planar path jumps, in order of arc length.
    pub fn corners(&self) -> Vec<Corner> {
        let (table, dim) = (self.table(), self.dimension());
        let mut r = vec![0.0; 4 * dim];
        let mut heading = |piece: usize, t: f64| {
            regular(table.piece(piece), dim, t, &mut r);
            r[dim + 1].atan2(r[dim])
        };
        let joints = table.leaves.windows(2).filter(|w| w[0].piece != w[1].piece);
        let corners = joints.map(|w| Corner { s: w[1].s[0], heading_in: heading(w[0].piece, 1.0), heading_out: heading(w[1].piece, 0.0) });
        corners.filter(|c| c.turn().abs() > SAME_HEADING).collect()
    }

    /// Arc lengths where polynomial pieces meet, with both ends of the path, m, increasing.
    pub fn joints(&self) -> Vec<f64> {
        let table = self.table();
        let mut joints = vec![0.0];
        for w in table.leaves.windows(2).filter(|w| w[0].piece != w[1].piece) {
            joints.push(w[0].s[1]);
        }
        joints.push(table.length);
        joints
    }

    /// Arc length (m) at knot parameter `u`.
    pub fn length_at(&self, u: f64) -> f64 {
        let table = self.table();
        let piece = table.spans.partition_point(|span| span[0] <= u);
        if piece == 0 {
            return 0.0;
        }
        let [a, b] = table.spans[piece - 1];
        table.length_at(piece - 1, ((u - a) / (b - a)).min(1.0))
    }

    /// Knot parameters, increasing, at which to sample a planar path so that the curve between two of them stays within `tolerance` (m) of
    /// the chord, and the chord of it.
    pub fn sample_chords(&self, tolerance: f64) -> Vec<f64> {
        let pieces = self.beziers();
        let mut at = vec![self.knots()[self.degree()]];
        for piece in pieces {
            let mut stack = vec![(piece, 0)];
            while let Some((piece, depth)) = stack.pop() {
                if piece.bulge() <= tolerance || depth >= 24 {
                    at.push(piece.u[1]);
                } else {
                    let [left, right] = piece.halves();
                    stack.push((right, depth + 1));
                    stack.push((left, depth + 1));
                }
            }
        }
        at
    }
}

/// Rows 0..=3 by `t` at a place where the curve moves: where the speed vanishes (repeated control points) the derivatives are those a little inside.
pub(super) fn regular(control: &[f64], dim: usize, t: f64, r: &mut [f64]) {
    derivatives(control, dim, t, r);
    let size = |rows: &[f64]| rows.iter().map(|v| v.abs()).fold(0.0, f64::max);
    let scale = control.chunks_exact(dim).map(|row| row.iter().zip(control).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)).fold(0.0, f64::max);
    let mut step = 1e-5;
    while size(&r[dim..2 * dim]) < 1e-9 * scale && step < 0.5 {
        let mut moved = vec![0.0; r.len()];
        derivatives(control, dim, if t < 0.5 { t + step } else { t - step }, &mut moved);
        r[dim..].copy_from_slice(&moved[dim..]);
        step *= 10.0;
    }
}

/// Turns derivatives by `t` into derivatives by arc length (chain rule).
fn by_length(r: &mut [f64], dim: usize) {
    let (first, rest) = r[dim..].split_at_mut(dim);
    let (second, third) = rest.split_at_mut(dim);
    let inner = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(x, y)| x * y).sum::<f64>();
    let v = inner(first, first).sqrt();
    if v == 0.0 {
        return;
    }
    let dv = inner(first, second) / v;
    let ddv = (inner(second, second) + inner(first, third) - dv * dv) / v;
    for d in 0..dim {
        first[d] /= v;
        second[d] = (second[d] - first[d] * dv) / (v * v);
        third[d] = (third[d] - 3.0 * second[d] * v * dv - first[d] * ddv) / (v * v * v);
    }
}

fn planar(r: &[f64], dim: usize) -> Planar {
    let (d1, d2) = ([r[dim], r[dim + 1]], [r[2 * dim], r[2 * dim + 1]]);
    let v = d1[0].hypot(d1[1]);
    let curvature = if v > 0.0 { cross(d1, d2) / (v * v * v) } else { 0.0 };
    Planar { point: [r[0], r[1]], heading: d1[1].atan2(d1[0]), curvature }
}
