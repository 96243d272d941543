//! The clamped cubic B-spline of an encoding: its knots, the polynomial of each piece, and the control points that via points take away.
//!
//! Source: \[deboor1978\]; section 5.1 of the page on paths as splines. A curve with via points is one spline of continuous curvature: at knot `k` it is
//! `before P[k] + own P[k+1] + after P[k+2]` (1/6, 4/6, 1/6 where knots are even), so the via point gives `P[k+1]` (2).

use crate::Point;

/// How the pieces of a spline follow from its control points.
#[derive(Debug, Clone)]
pub(super) struct Basis {
    /// Clamped knots.
    pub knots: Vec<f64>,
    /// `power[k][m][i]`: share of control point `k + i` in the coefficient of `t^m` of piece `k`, `t` in [0, 1].
    power: Vec<[[f64; 4]; 4]>,
    /// Control points that a via point decides.
    pins: Vec<Pin>,
    /// Control points that are free, in order.
    pub free: Vec<usize>,
    /// Knot parameter at the start, the via points and the goal.
    pub stops: Vec<f64>,
}

/// A control point that a via point decides.
#[derive(Debug, Clone, Copy)]
struct Pin {
    index: usize,
    point: Point,
    before: f64,
    after: f64,
}

impl Basis {
    /// A spline with `spans[l]` (at least 2, one leg: at least 1) pieces of equal knot distance on leg `l`, whose width follows from the leg's length (m).
    pub fn new(spans: &[usize], lengths: &[f64], via: &[Point]) -> Self {
        let mut breaks = vec![0.0];
        let mut stops = vec![0.0];
        for (&n, &length) in spans.iter().zip(lengths) {
            let from = breaks[breaks.len() - 1];
            let width = length.max(1e-6) / n as f64;
            breaks.extend((1..=n).map(|i| from + i as f64 * width));
            stops.push(breaks[breaks.len() - 1]);
        }
        let (pieces, last) = (breaks.len() - 1, breaks[breaks.len() - 1]);
        let mut knots = vec![0.0; 3];
        knots.extend(&breaks);
        knots.extend([last; 3]);
        let power = (0..pieces).map(|k| power(&knots, k)).collect();
        let mut at = 0;
        let pins: Vec<Pin> = spans
            .iter()
            .zip(via)
            .map(|(n, point)| {
                at += n;
                let [before, after] = shares(&knots, at);
                Pin { index: at + 1, point: *point, before, after }
            })
            .collect();
        let free = (1..pieces + 2).filter(|i| pins.iter().all(|p| p.index != *i)).collect();
        Self { knots, power, pins, free, stops }
    }

    pub fn pieces(&self) -> usize {
        self.power.len()
    }

    /// Control points, with the first and the last.
    pub fn count(&self) -> usize {
        self.power.len() + 3
    }

    /// Sets the control points that via points decide from their neighbours.
    pub fn pin(&self, control: &mut [Point]) {
        for pin in &self.pins {
            let (p, q) = (control[pin.index - 1], control[pin.index + 1]);
            let own = 1.0 - pin.before - pin.after;
            control[pin.index] = [0, 1].map(|d| (pin.point[d] - pin.before * p[d] - pin.after * q[d]) / own); // (2)
        }
    }

    /// Coefficients of piece `k` in powers of `t`, x and y.
    #[inline]
    pub fn piece(&self, k: usize, control: &[Point]) -> [[f64; 4]; 2] {
        let (matrix, local) = (&self.power[k], &control[k..k + 4]);
        let mut out = [[0.0; 4]; 2];
        for (m, row) in matrix.iter().enumerate() {
            for d in 0..2 {
                out[d][m] = row[0] * local[0][d] + row[1] * local[1][d] + row[2] * local[2][d] + row[3] * local[3][d];
            }
        }
        out
    }

    /// Knot parameters at which each control point has the most say (Greville).
    pub fn greville(&self) -> Vec<f64> {
        self.knots.windows(5).take(self.count()).map(|w| (w[1] + w[2] + w[3]) / 3.0).collect()
    }

    /// The point of the curve at knot parameter `u`.
    pub fn at(&self, control: &[Point], u: f64) -> Point {
        let breaks = &self.knots[3..self.knots.len() - 3];
        let k = breaks.partition_point(|b| *b <= u).clamp(1, self.pieces()) - 1;
        let t = (u - breaks[k]) / (breaks[k + 1] - breaks[k]);
        let c = self.piece(k, control);
        [0, 1].map(|d| c[d][0] + t * (c[d][1] + t * (c[d][2] + t * c[d][3])))
    }
}

/// Shares of the neighbours of the control point at knot `k` of the curve's point there.
fn shares(knots: &[f64], k: usize) -> [f64; 2] {
    let j = k + 3;
    let (a, b) = (knots[j] - knots[j - 1], knots[j + 1] - knots[j]);
    let wide = knots[j + 1] - knots[j - 1];
    [b * b / (wide * (knots[j + 1] - knots[j - 2])), a * a / (wide * (knots[j + 2] - knots[j - 1]))]
}

/// The matrix from the control points of piece `k` to its coefficients: blossoms give the Bernstein form, whose differences are the powers.
fn power(knots: &[f64], k: usize) -> [[f64; 4]; 4] {
    let span = k + 3;
    let mut bezier = [[0.0; 4]; 4];
    for (j, row) in bezier.iter_mut().enumerate() {
        let mut local = [[0.0; 4]; 4];
        (0..4).for_each(|i| local[i][i] = 1.0);
        for r in 1..=3 {
            let at = if r <= 3 - j { knots[span] } else { knots[span + 1] };
            for i in (r..=3).rev() {
                let (low, high) = (knots[span - 3 + i], knots[span + 1 + i - r]);
                let share = (at - low) / (high - low);
                local[i] = [0, 1, 2, 3].map(|d| (1.0 - share) * local[i - 1][d] + share * local[i][d]);
            }
        }
        *row = local[3];
    }
    let mix = |w: [f64; 4]| [0, 1, 2, 3].map(|d| (0..4).map(|j| w[j] * bezier[j][d]).sum());
    [mix([1.0, 0.0, 0.0, 0.0]), mix([-3.0, 3.0, 0.0, 0.0]), mix([3.0, -6.0, 3.0, 0.0]), mix([-1.0, 3.0, -3.0, 1.0])]
}
