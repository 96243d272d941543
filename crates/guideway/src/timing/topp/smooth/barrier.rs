//! The barrier method on the squared speed `y` of the reference's time: Newton steps with a pentadiagonal matrix, every iterate within all limits.

/// A limit `|root^power (c . y[at..at + 3])| <= 1`, where `root` is the square root of `e . y[at..at + 3]`, and something constant inside may be added.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Row {
    pub at: usize,
    /// Coefficients of three neighbouring cells.
    pub c: [f64; 3],
    pub constant: f64,
    /// Coefficient of the root, inside.
    pub rooted: f64,
    /// Weights of the cells at the place of the row.
    pub e: [f64; 3],
    /// Whether the whole is multiplied by the root.
    pub times: bool,
    /// Which limit it belongs to.
    pub owner: usize,
    /// Cell that is tightened with it.
    pub cell: usize,
}

/// Largest factor between the weights of successive rounds, and Newton steps in each.
const COOLING: f64 = 0.2;
const STEPS: usize = 9;

/// A problem: minimise the time under rows and bounds of `y`.
pub(super) struct Barrier<'a> {
    /// Lengths of the cells.
    pub step: &'a [f64],
    pub rows: &'a [Row],
    /// Largest `y` of the cells.
    pub top: &'a [f64],
}

impl Row {
    /// Value as a share of the limit, and its derivatives.
    fn value(&self, y: &[f64]) -> (f64, [f64; 3]) {
        let y = [y[self.at], y[self.at + 1], y[self.at + 2]];
        let inner = self.c[0] * y[0] + self.c[1] * y[1] + self.c[2] * y[2] + self.constant;
        if !self.times && self.rooted == 0.0 {
            return (inner, self.c);
        }
        let root = (self.e[0] * y[0] + self.e[1] * y[1] + self.e[2] * y[2]).sqrt();
        let inside = inner + self.rooted * root;
        let slope = 0.5 / root;
        let (value, scale, extra) =
            if self.times { (root * inside, root, slope * (inside + self.rooted * root)) } else { (inside, 1.0, slope * self.rooted) };
        let d = [0, 1, 2].map(|i| scale * self.c[i] + extra * self.e[i]);
        (value, d)
    }

    /// Value as a share of the limit.
    pub fn share(&self, y: &[f64]) -> f64 {
        self.value(y).0
    }
}

impl Barrier<'_> {
    /// From a point within all limits, down to the weight `last`; returns the number of Newton steps.
    pub fn minimise(&self, y: &mut Vec<f64>, first: f64, last: f64) -> usize {
        let (mut weight, mut steps) = (first, 0);
        loop {
            for _ in 0..STEPS {
                steps += 1;
                if !self.newton(y, weight, if weight > last { 1e-2 } else { 1e-4 }) {
                    break;
                }
            }
            if weight <= last {
                return steps;
            }
            weight = (weight * COOLING).max(last);
        }
    }

    /// Time and barrier; infinite beyond the limits.
    fn merit(&self, y: &[f64], weight: f64) -> f64 {
        let mut sum = 0.0;
        // Logarithms of products: one call for many factors.
        let mut product = 1.0f64;
        let mut log = |factor: f64| {
            product *= factor;
            if product < 1e-200 {
                sum += product.ln();
                product = 1.0;
            }
        };
        for (y, top) in y.iter().zip(self.top) {
            if *y <= 0.0 || y >= top {
                return f64::INFINITY;
            }
            log(1.0 - y / top);
        }
        for row in self.rows {
            let g = row.share(y);
            let factor = 1.0 - g * g;
            if factor.is_nan() || factor <= 0.0 {
                return f64::INFINITY;
            }
            log(factor);
        }
        self.time(y) - weight * (sum + product.ln())
    }

    /// Time of the motion.
    pub fn time(&self, y: &[f64]) -> f64 {
        self.step.iter().zip(y).map(|(h, y)| h / y.sqrt()).sum()
    }

    /// One damped Newton step; false when it no longer pays.
    fn newton(&self, y: &mut Vec<f64>, weight: f64, enough: f64) -> bool {
        let n = y.len();
        let (mut gradient, mut matrix) = (vec![0.0; n], vec![[0.0; 3]; n]);
        for (k, (h, y)) in self.step.iter().zip(y.iter()).enumerate() {
            let cube = h / (y * y.sqrt());
            gradient[k] -= 0.5 * cube;
            matrix[k][0] += 0.75 * cube / y;
        }
        for k in 0..n {
            let room = self.top[k] - y[k];
            gradient[k] += weight / room;
            matrix[k][0] += weight / (room * room);
        }
        for row in self.rows {
            let (g, d) = row.value(y);
            let inverse = 1.0 / (1.0 - g * g);
            let (first, second) = (2.0 * weight * g * inverse, 2.0 * weight * (1.0 + g * g) * inverse * inverse);
            for i in 0..3 {
                gradient[row.at + i] += first * d[i];
                for j in i..3 {
                    matrix[row.at + i][j - i] += second * d[i] * d[j];
                }
            }
        }
        let step = solve(&mut matrix, &gradient);
        let slope: f64 = step.iter().zip(&gradient).map(|(s, g)| s * g).sum();
        let before = self.merit(y, weight);
        let mut share = 1.0;
        for _ in 0..40 {
            let next: Vec<f64> = y.iter().zip(&step).map(|(y, s)| y - share * s).collect();
            let after = self.merit(&next, weight);
            if after <= before - 1e-4 * share * slope {
                *y = next;
                // In units of the weight: what the barrier itself gives away.
                return slope > enough * weight * n as f64;
            }
            share *= 0.6;
        }
        false
    }
}

/// Solves a symmetric system of five diagonals (the upper three are given) for one right side.
fn solve(matrix: &mut [[f64; 3]], right: &[f64]) -> Vec<f64> {
    let n = right.len();
    let mut x = right.to_vec();
    for k in 0..n {
        let [d, a, b] = matrix[k];
        let d = d.max(f64::MIN_POSITIVE);
        let (l, m) = (a / d, b / d);
        if k + 1 < n {
            matrix[k + 1][0] -= l * a;
            matrix[k + 1][1] -= l * b;
            x[k + 1] -= l * x[k];
        }
        if k + 2 < n {
            matrix[k + 2][0] -= m * b;
            x[k + 2] -= m * x[k];
        }
        matrix[k] = [d, l, m];
    }
    for k in (0..n).rev() {
        let [d, l, m] = matrix[k];
        let mut value = x[k] / d;
        if k + 1 < n {
            value -= l * x[k + 1];
        }
        if k + 2 < n {
            value -= m * x[k + 2];
        }
        x[k] = value;
    }
    x
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn five_diagonals() {
        let upper = [[4.0, 1.0, 0.5], [5.0, -1.0, 0.3], [6.0, 0.7, 0.1], [3.0, 0.2, 0.0], [2.0, 0.0, 0.0]];
        let right = [1.0, 2.0, 3.0, 4.0, 5.0];
        let x = solve(&mut upper.to_vec(), &right);
        for i in 0..5usize {
            let entry = |j: usize| if i.abs_diff(j) > 2 { 0.0 } else { upper[i.min(j)][i.abs_diff(j)] };
            let value: f64 = (0..5).map(|j| entry(j) * x[j]).sum();
            assert!((value - right[i]).abs() < 1e-12);
        }
    }
}
