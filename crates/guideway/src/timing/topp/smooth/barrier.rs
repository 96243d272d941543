//! The barrier method on the squared speed `y` of the reference's time: Newton steps with a pentadiagonal matrix, every iterate within all limits.

use super::lines::Lines;

/// Factor between the weights of successive rounds, and most Newton steps in each.
const COOLING: f64 = 0.1;
const STEPS: usize = 9;
/// What a Newton step must gain, in units of the weight of all cells, to be followed by another one: in the rounds on the way, and in the last one.
const ROUGH: f64 = 0.3;
const EXACT: f64 = 1e-2;

/// Share of the way to the bounds of `y` that a step may take.
const ASIDE: f64 = 0.98;

/// A problem: minimise the time under limits and bounds of `y`.
pub(super) struct Barrier<'a> {
    /// Lengths of the cells.
    pub step: &'a [f64],
    pub lines: &'a Lines,
    /// Largest `y` of the cells.
    pub top: &'a [f64],
    /// What a change of `y` by 1 costs besides, s: of some cells.
    pub pull: &'a [(usize, f64)],
}

/// Values of `y` with their time and their barrier, the derivatives of which are kept beside.
struct Point {
    y: Vec<f64>,
    time: f64,
    barrier: f64,
    gradient: Vec<f64>,
    matrix: Vec<[f64; 3]>,
}

impl Barrier<'_> {
    /// From a point within all limits, down to the weight `last`; returns the number of Newton steps.
    pub fn minimise(&self, y: &mut Vec<f64>, first: f64, last: f64) -> usize {
        let n = y.len();
        let empty = |y| Point { y, time: 0.0, barrier: 0.0, gradient: vec![0.0; n], matrix: vec![[0.0; 3]; n] };
        let (mut here, mut next) = (empty(std::mem::take(y)), empty(vec![0.0; n]));
        let (mut weight, mut steps) = (first, 0);
        // Rounds whose weights fall by the same factor.
        let rounds = ((last / first).ln() / COOLING.ln()).ceil().max(1.0);
        let cooling = (last / first).powf(1.0 / rounds);
        self.read(&mut here);
        let (mut matrix, mut step) = (Vec::with_capacity(n), Vec::with_capacity(n));
        loop {
            for _ in 0..STEPS {
                steps += 1;
                let slope = self.newton(&here, weight, &mut matrix, &mut step);
                let moved = self.search(&here, &mut next, (&step, slope), weight);
                if moved {
                    std::mem::swap(&mut here, &mut next);
                }
                // In units of the weight: what the barrier itself gives away.
                if !moved || slope <= if weight > last { ROUGH } else { EXACT } * weight * n as f64 {
                    break;
                }
            }
            if weight <= last {
                *y = here.y;
                return steps;
            }
            weight = if weight * cooling < last * 1.5 { last } else { weight * cooling };
        }
    }

    /// Time, barrier and the derivatives of the barrier at a point; false if it is not within the limits.
    fn read(&self, point: &mut Point) -> bool {
        point.gradient.fill(0.0);
        point.matrix.fill([0.0; 3]);
        let mut logs = Logs::default();
        point.time = 0.0;
        for (k, (y, (h, top))) in point.y.iter().zip(self.step.iter().zip(self.top)).enumerate() {
            let room = top - y;
            if !(*y > 0.0 && room > 0.0) {
                return false;
            }
            let inverse = 1.0 / room;
            (point.gradient[k], point.matrix[k][0]) = (inverse, inverse * inverse);
            logs.factor(room / top);
            point.time += h / y.sqrt();
        }
        point.time += self.pull.iter().map(|(k, cost)| cost * point.y[*k]).sum::<f64>();
        let inside = self.lines.read(&point.y, &mut point.gradient, &mut point.matrix, &mut logs);
        point.barrier = -logs.sum();
        inside
    }

    /// The Newton step, to be subtracted; returns its product with the gradient.
    fn newton(&self, here: &Point, weight: f64, matrix: &mut Vec<[f64; 3]>, step: &mut Vec<f64>) -> f64 {
        let cubes = self.step.iter().zip(&here.y).map(|(h, y)| h / (y * y.sqrt()));
        matrix.clear();
        step.clear();
        for ((cube, y), (gradient, row)) in cubes.zip(&here.y).zip(here.gradient.iter().zip(&here.matrix)) {
            step.push(weight * gradient - 0.5 * cube);
            matrix.push([weight * row[0] + 0.75 * cube / y, weight * row[1], weight * row[2]]);
        }
        for (k, cost) in self.pull {
            step[*k] += cost;
        }
        let gradient = step.clone();
        solve(matrix, step);
        step.iter().zip(&gradient).map(|(s, g)| s * g).sum()
    }

    /// The first of ever shorter steps that gains enough, read into `next`.
    fn search(&self, here: &Point, next: &mut Point, (step, slope): (&[f64], f64), weight: f64) -> bool {
        let before = here.time + weight * here.barrier;
        let room = |((y, top), step): ((&f64, &f64), &f64)| ASIDE * if *step > 0.0 { y / step } else { (y - top) / step };
        let room = here.y.iter().zip(self.top).zip(step).filter(|(_, step)| **step != 0.0).map(room).fold(1.0, f64::min);
        let mut share = self.lines.longest(&here.y, step, room);
        for _ in 0..40 {
            for ((next, y), step) in next.y.iter_mut().zip(&here.y).zip(step) {
                *next = y - share * step;
            }
            if self.read(next) && next.time + weight * next.barrier <= before - 1e-4 * share * slope {
                return true;
            }
            share *= 0.6;
        }
        false
    }
}

/// A sum of logarithms, taken of products: one call for many factors.
pub(super) struct Logs {
    sum: f64,
    product: f64,
}

impl Default for Logs {
    fn default() -> Self {
        Self { sum: 0.0, product: 1.0 }
    }
}

impl Logs {
    /// Adds the logarithm of a factor of at most 1, not far below 1e-100.
    pub fn factor(&mut self, factor: f64) {
        self.product *= factor;
        if self.product < 1e-200 {
            self.sum += self.product.ln();
            self.product = 1.0;
        }
    }

    fn sum(&self) -> f64 {
        self.sum + self.product.ln()
    }
}

/// Solves a symmetric system of five diagonals (the upper three are given) for the right side in `x`.
fn solve(matrix: &mut [[f64; 3]], x: &mut [f64]) {
    let n = x.len();
    for k in 0..n {
        let [d, a, b] = matrix[k];
        let inverse = 1.0 / d.max(f64::MIN_POSITIVE);
        let (l, m) = (a * inverse, b * inverse);
        if k + 1 < n {
            matrix[k + 1][0] -= l * a;
            matrix[k + 1][1] -= l * b;
            x[k + 1] -= l * x[k];
        }
        if k + 2 < n {
            matrix[k + 2][0] -= m * b;
            x[k + 2] -= m * x[k];
        }
        matrix[k] = [inverse, l, m];
    }
    for k in (0..n).rev() {
        let [inverse, l, m] = matrix[k];
        let mut value = x[k] * inverse;
        if k + 1 < n {
            value -= l * x[k + 1];
        }
        if k + 2 < n {
            value -= m * x[k + 2];
        }
        x[k] = value;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn five_diagonals() {
        let upper = [[4.0, 1.0, 0.5], [5.0, -1.0, 0.3], [6.0, 0.7, 0.1], [3.0, 0.2, 0.0], [2.0, 0.0, 0.0]];
        let right = [1.0, 2.0, 3.0, 4.0, 5.0];
        let mut x = right.to_vec();
        solve(&mut upper.to_vec(), &mut x);
        for i in 0..5usize {
            let entry = |j: usize| if i.abs_diff(j) > 2 { 0.0 } else { upper[i.min(j)][i.abs_diff(j)] };
            let value: f64 = (0..5).map(|j| entry(j) * x[j]).sum();
            assert!((value - right[i]).abs() < 1e-12);
        }
    }
}
