//! One polynomial piece of a curve in Bernstein form: the shape on which lengths are integrated and freedom from collision is proved.

use crate::Point;
use crate::world::shape::{point_segment, sub};

/// Largest degree that is evaluated on the stack.
const STACK: usize = 32;

/// Value and derivatives with respect to `t` in [0, 1] of a Bezier piece with `control` rows of `dim` values; `out` holds `order + 1` rows.
/// de Casteljau: the triangle yields every derivative on its way.
pub(super) fn derivatives(control: &[f64], dim: usize, t: f64, out: &mut [f64]) {
    // Planar pieces of degree 3 and 5, with one derivative or three, are nearly all there are.
    match (dim, control.len(), out.len()) {
        (2, 8, 4) => fixed::<8, 4>(control, t, out),
        (2, 8, 8) => fixed::<8, 8>(control, t, out),
        (2, 12, 4) => fixed::<12, 4>(control, t, out),
        (2, 12, 8) => fixed::<12, 8>(control, t, out),
        _ => any(control, dim, t, out),
    }
}

/// [`triangle`] of a planar piece with sizes that the compiler knows.
fn fixed<const N: usize, const M: usize>(control: &[f64], t: f64, out: &mut [f64]) {
    let (mut work, mut rows) = ([0.0; N], [0.0; M]);
    work.copy_from_slice(control);
    triangle(&mut work, 2, t, &mut rows);
    out.copy_from_slice(&rows);
}

fn any(control: &[f64], dim: usize, t: f64, out: &mut [f64]) {
    if control.len() <= STACK {
        let mut work = [0.0; STACK];
        work[..control.len()].copy_from_slice(control);
        triangle(&mut work[..control.len()], dim, t, out);
    } else {
        triangle(&mut control.to_vec(), dim, t, out);
    }
}

#[expect(clippy::inline_always, reason = "its loops are short and disappear where the sizes are known")]
#[inline(always)]
fn triangle(work: &mut [f64], dim: usize, t: f64, out: &mut [f64]) {
    let degree = work.len() / dim - 1;
    let order = out.len() / dim - 1;
    out.fill(0.0);
    for stage in 0..=degree {
        let k = degree - stage; // k + 1 rows remain; their k-th difference is the k-th derivative
        if k <= order {
            let factor: f64 = (0..k).map(|i| (degree - i) as f64).product();
            for d in 0..dim {
                out[k * dim + d] = factor * difference(work, dim, d, k);
            }
        }
        for i in 0..k * dim {
            work[i] += t * (work[i + dim] - work[i]);
        }
    }
}

/// k-th forward difference of component `d` of the first k + 1 rows.
#[expect(clippy::inline_always, reason = "as above")]
#[inline(always)]
fn difference(work: &[f64], dim: usize, d: usize, k: usize) -> f64 {
    let (mut sum, mut binomial) = (0.0, 1.0);
    for i in 0..=k {
        let sign = if (k - i).is_multiple_of(2) { 1.0 } else { -1.0 };
        sum += sign * binomial * work[i * dim + d];
        binomial *= (k - i) as f64 / (i + 1) as f64;
    }
    sum
}

/// A planar Bezier piece of a path. It lies inside the convex hull of its control points.
#[derive(Debug, Clone, PartialEq)]
pub struct Bezier {
    /// Control points, m; the first and last are on the curve.
    pub points: Vec<Point>,
    /// Parameters of the path at its ends.
    pub u: [f64; 2],
}

impl Bezier {
    /// The two halves.
    pub fn halves(&self) -> [Self; 2] {
        let (mut left, mut work) = (Vec::with_capacity(self.points.len()), self.points.clone());
        let mut right = vec![[0.0; 2]; work.len()];
        for k in (0..work.len()).rev() {
            left.push(work[0]);
            right[k] = work[k];
            for i in 0..k {
                work[i] = [f64::midpoint(work[i][0], work[i + 1][0]), f64::midpoint(work[i][1], work[i + 1][1])];
            }
        }
        let middle = f64::midpoint(self.u[0], self.u[1]);
        [Self { points: left, u: [self.u[0], middle] }, Self { points: right, u: [middle, self.u[1]] }]
    }

    /// First and last control point, m.
    pub fn ends(&self) -> [Point; 2] {
        [self.points[0], self.points[self.points.len() - 1]]
    }

    /// Largest distance of a control point from the chord, m: the piece stays within a capsule of that radius around its chord, and the chord
    /// deviates no more than that from the piece.
    pub fn bulge(&self) -> f64 {
        let [a, b] = self.ends();
        self.points.iter().map(|p| point_segment(*p, a, b)).fold(0.0, f64::max)
    }

    /// Length of the control polygon, m; at least that of the piece.
    pub fn polygon_length(&self) -> f64 {
        self.points.windows(2).map(|w| sub(w[1], w[0])).map(|v| v[0].hypot(v[1])).sum()
    }
}
