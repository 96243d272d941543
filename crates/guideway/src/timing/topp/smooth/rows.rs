//! The jerk-limited problem in the time of a reference: cells, junctions, rows.
//!
//! The squared speed `y` of the reference's time is a quadratic spline with knots at the junctions of the cells; its coefficients, one per cell, are the
//! unknowns. In the first and the last cell it is linear. Its slope changes evenly on a cell, and so, nearly, does the path jerk stay the same there.

use super::barrier::Row;
use super::pieces::{Moving, Walker};
use crate::error::PlanError;
use crate::timing::topp::limits::Bounds;
use crate::timing::topp::problem::{Demands, checked_ceiling, shrunk};

/// Most that the reference may be sped up, squared.
const MOST: f64 = 400.0;
/// Share of the limits up to which the start uses them.
const USE: f64 = 0.95;

/// A reference motion at the ends of a cell: arc length, path speed, acceleration, jerk.
pub(super) type Kinetic = [f64; 4];

/// First three derivatives of the joints by the time of the reference.
type Shapes = [Vec<f64>; 3];

/// A problem posed for the barrier.
pub(super) struct Posed {
    /// Lengths of the cells, s.
    pub step: Vec<f64>,
    pub rows: Vec<Row>,
    pub top: Vec<f64>,
    /// The reference at the two ends of every cell, and how the joints move there.
    cells: Vec<[Kinetic; 2]>,
    shapes: Vec<[Shapes; 2]>,
    joints: usize,
}

impl Posed {
    /// From the lengths of the cells and the reference at their ends.
    pub fn new(step: Vec<f64>, cells: Vec<[Kinetic; 2]>, walker: &mut Walker) -> Self {
        let mut shape = |[s, v, a, j]: Kinetic| {
            walker.go(s);
            let q = &walker.shape;
            let each = |f: &dyn Fn(usize) -> f64| (0..q.first.len()).map(f).collect::<Vec<f64>>();
            let first = each(&|i| q.first[i] * v);
            let second = each(&|i| q.second[i] * v * v + q.first[i] * a);
            let third = each(&|i| q.third[i] * v * v * v + 3.0 * q.second[i] * v * a + q.first[i] * j);
            [first, second, third]
        };
        let shapes: Vec<[Shapes; 2]> = cells.iter().map(|ends| ends.map(&mut shape)).collect();
        let joints = shapes[0][0][0].len();
        Self { step, rows: Vec::new(), top: Vec::new(), cells, shapes, joints }
    }

    /// Weights of two cells for y, and for half its slope, at the junction after cell `k`.
    fn junction(&self, k: usize) -> [[f64; 2]; 2] {
        let (a, b) = (self.step[k], self.step[k + 1]);
        let inverse = 1.0 / (a + b);
        [[b * inverse, a * inverse], [-inverse, inverse]]
    }

    /// All rows; the limits of cells are divided by `tight` (speed, acceleration, jerk, rows called for).
    pub fn limits(&mut self, bounds: &Bounds, tight: &[[f64; 4]], demands: &mut Demands) -> Result<(), PlanError> {
        let fastest = |rates: &[f64]| rates.iter().zip(&bounds.speed).map(|(q, v)| (q / v) * (q / v)).fold(1.0 / MOST, f64::max);
        let n = self.step.len();
        self.top = vec![MOST; n];
        let junctions: Vec<f64> = (0..n - 1).map(|k| 1.0 / fastest(&self.shapes[k][1][0])).collect();
        for (k, top) in junctions.iter().enumerate() {
            self.top[k] = self.top[k].min(*top);
        }
        for (k, top) in junctions.iter().enumerate() {
            // A cell lies between two junctions: the mean of both, where they differ, keeps the spline below each.
            let after = junctions.get(k + 1).unwrap_or(top);
            self.top[k + 1] = if k + 1 < n - 1 { 0.5 * (top + after) } else { *top };
        }
        for (k, top) in junctions.iter().enumerate() {
            let [y, _] = self.junction(k);
            let excess = ((y[0] * self.top[k] + y[1] * self.top[k + 1]) / top).max(1.0);
            self.top[k] /= excess;
            self.top[k + 1] /= excess;
        }
        for (top, tight) in self.top.iter_mut().zip(tight) {
            *top /= tight[0] * tight[0];
        }
        self.rows.clear();
        for k in 0..n - 1 {
            self.accelerations(k, bounds, tight[k][1].max(tight[k + 1][1]));
        }
        for (j, tight) in tight.iter().enumerate() {
            self.jerks(j, bounds, tight[2]);
        }
        self.called(demands, tight)
    }

    /// Rows of acceleration at the junction after cell `k`.
    fn accelerations(&mut self, k: usize, bounds: &Bounds, tight: f64) {
        let ([y, w], at) = (self.junction(k), k.min(self.step.len() - 3));
        let [first, second, _] = &self.shapes[k][1];
        for i in 0..self.joints {
            let [low, high] = bounds.acceleration(i, [first[i], first[i]]).map(|v| v / tight);
            if !high.is_finite() || !low.is_finite() {
                continue;
            }
            let (half, centre) = (0.5 * (high - low), 0.5 * (high + low));
            let mut row = Row { at, constant: -centre / half, owner: i, cell: k, ..Row::default() };
            for p in 0..2 {
                row.c[k - at + p] = (second[i] * y[p] + first[i] * w[p]) / half;
                row.e[k - at + p] = y[p];
            }
            self.rows.push(row);
        }
    }

    /// Rows of jerk on cell `j`, at its two ends.
    fn jerks(&mut self, j: usize, bounds: &Bounds, tight: f64) {
        let n = self.step.len();
        let at = j.clamp(1, n - 2) - 1;
        // Weights of y and w at the junction after cell k, within the three cells of the row.
        let wide = |k: usize| {
            let pair = self.junction(k);
            pair.map(|pair| {
                let mut c = [0.0; 3];
                (c[k - at], c[k - at + 1]) = (pair[0], pair[1]);
                c
            })
        };
        let inner = j > 0 && j + 1 < n;
        let ends = if inner {
            [wide(j - 1), wide(j)]
        } else {
            // Linear in an end cell: on to its outer end.
            let k = if j == 0 { 0 } else { n - 2 };
            let [y, w] = wide(k);
            let reach = if j == 0 { -2.0 * self.step[0] } else { 2.0 * self.step[n - 1] };
            let outer = [[0, 1, 2].map(|p| y[p] + reach * w[p]), w];
            if j == 0 { [outer, [y, w]] } else { [[y, w], outer] }
        };
        let curve = if inner { [0, 1, 2].map(|p| (ends[1][1][p] - ends[0][1][p]) / self.step[j]) } else { [0.0; 3] };
        for (shape, [y, w]) in self.shapes[j].iter().zip(ends) {
            let [first, second, third] = shape;
            for i in (0..self.joints).filter(|i| bounds.jerk[*i].is_finite()) {
                let inverse = tight / bounds.jerk[i];
                let c = [0, 1, 2].map(|p| inverse * (first[i] * curve[p] + 3.0 * second[i] * w[p] + third[i] * y[p]));
                self.rows.push(Row { at, c, e: y, times: true, owner: self.joints + i, cell: j, ..Row::default() });
            }
        }
    }

    /// Rows and ceilings of the demands, at the junctions.
    fn called(&mut self, demands: &mut Demands, tight: &[[f64; 4]]) -> Result<(), PlanError> {
        let n = self.step.len();
        let s: Vec<f64> = self.cells[..n - 1].iter().map(|ends| ends[1][0]).collect();
        if let Some(ceiling) = &mut demands.ceiling {
            let x = checked_ceiling(ceiling(&s)?, n - 1)?;
            for (k, x) in x.iter().enumerate() {
                let v = self.cells[k][1][1];
                let top = (x / (v * v)).min(MOST);
                self.top[k] = self.top[k].min(top);
                self.top[k + 1] = self.top[k + 1].min(top);
            }
        }
        let Some(rows) = &mut demands.rows else { return Ok(()) };
        let rows = rows(&s)?.checked(n - 1)?;
        for k in 0..n - 1 {
            let ([y, w], at, [_, v, a, _]) = (self.junction(k), k.min(n - 3), self.cells[k][1]);
            for r in 0..rows.count {
                let i = k * rows.count + r;
                let bounds = shrunk([rows.low[i], rows.high[i]], tight[k][3].max(tight[k + 1][3]));
                let [low, high] = closed(bounds, rows.c[i]);
                let (half, centre) = (0.5 * (high - low), 0.5 * (high + low));
                let (slope, level) = (rows.a[i] * v, rows.a[i] * a + rows.b[i] * v * v);
                let mut row = Row { at, constant: (rows.c[i] - centre) / half, owner: 2 * self.joints + r, cell: k, ..Row::default() };
                for p in 0..2 {
                    row.c[k - at + p] = (level * y[p] + slope * w[p]) / half;
                    row.e[k - at + p] = y[p];
                }
                row.rooted = rows.d.get(i).map_or(0.0, |d| d * v / half);
                self.rows.push(row);
            }
        }
        Ok(())
    }

    /// A constant speed of the reference within all limits.
    pub fn start(&self) -> Option<Vec<f64>> {
        let lowest = self.top.iter().copied().fold(f64::INFINITY, f64::min);
        let mut y = 1.0f64.min(USE * lowest);
        for _ in 0..300 {
            let all = vec![y; self.top.len()];
            if self.rows.iter().all(|row| row.share(&all).abs() < USE.max(0.5 + 0.5 * row.constant.abs()).min(1.0)) {
                return Some(all);
            }
            y *= 0.9;
        }
        None
    }

    /// Arc length, speed, acceleration at the start, the junctions, the end.
    pub fn states(&self, y: &[f64]) -> Vec<Moving> {
        let n = self.step.len();
        let mut states = vec![[self.cells[0][0][0], 0.0, 0.0]];
        for k in 0..n - 1 {
            let ([s, v, a, _], [e, w]) = (self.cells[k][1], self.junction(k));
            let (level, slope) = (e[0] * y[k] + e[1] * y[k + 1], w[0] * y[k] + w[1] * y[k + 1]);
            states.push([s, v * level.sqrt(), a * level + v * slope]);
        }
        states.push([self.cells[n - 1][1][0], 0.0, 0.0]);
        states
    }

    /// Leaves out the rows of jerk that stay far from their bounds when the reference is nearly the solution: those that are small, and that would not grow
    /// much if the jerk on their cell changed by as much as the row most sensitive to it admits.
    pub fn prune(&mut self) {
        let ones = vec![1.0; self.step.len()];
        let size = |row: &Row| row.c.iter().map(|c| c.abs()).sum::<f64>();
        let mut most = vec![0.0f64; self.step.len()];
        for row in self.rows.iter().filter(|row| row.times) {
            most[row.cell] = most[row.cell].max(size(row));
        }
        self.rows.retain(|row| !row.times || row.share(&ones).abs() + size(row) / most[row.cell] > 1.0);
    }

    /// Adds what a relative change of each limit of jerk is worth, s.
    pub fn sensitivities(&self, y: &[f64], weight: f64, prices: &mut [f64]) {
        for row in self.rows.iter().filter(|row| row.owner / self.joints == 1) {
            let g = row.share(y);
            prices[row.owner - self.joints] += 2.0 * weight * g * g / (1.0 - g * g).max(1e-9);
        }
    }
}

/// Bounds on both sides: a missing one far away.
fn closed([low, high]: [f64; 2], at: f64) -> [f64; 2] {
    let far = |bound: f64| 1e3 * (1.0 + bound.abs() + at.abs());
    match (low.is_finite(), high.is_finite()) {
        (true, true) => [low, high],
        (true, false) => [low, low + far(low)],
        (false, true) => [high - far(high), high],
        (false, false) => [-far(at), far(at)],
    }
}
