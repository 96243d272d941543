//! The jerk-limited problem in the time of a reference: cells, junctions, rows.
//!
//! The squared speed `y` of the reference's time is a quadratic spline with knots at the junctions of the cells; its coefficients, one per cell, are the
//! unknowns. In the first and the last cell it is linear. Its slope changes evenly on a cell, and so, nearly, does the path jerk stay the same there. An end
//! that is passed in motion is the junction with a cell of no length: its coefficient is `y` there, and the cell beside it is like the others.

use super::lines::{Lines, Place, Row};
use super::pieces::{Moving, Walker};
use super::rates::{RATE, Rates};
use crate::error::PlanError;
use crate::timing::topp::limits::Bounds;
use crate::timing::topp::problem::{Demands, checked_ceiling, shrunk};
use crate::timing::topp::rows::Rows;
use crate::timing::topp::table::Table;
use std::ops::Range;

/// Most that the reference may be sped up, squared.
const MOST: f64 = 400.0;

/// Speeds tried for a start: limits of rates may ask for far less than the reference.
const STARTS: usize = 2000;
/// What the speed asked for at the start and at the end is worth, in durations: that at the end comes first.
const WORTH: [f64; 2] = [10.0, 100.0];
/// Share of a speed at an end by which it may be missed.
const MISSED: f64 = 3e-6;
/// How far inside a cell the rows at its ends are read, as a share of the path.
const ASIDE: f64 = 1e-12;

/// A reference motion at the ends of a cell: arc length, path speed, acceleration, jerk.
pub(super) type Kinetic = [f64; 4];

/// A problem posed for the barrier.
pub(super) struct Posed {
    /// Lengths of the cells, s.
    pub step: Vec<f64>,
    pub lines: Lines,
    pub top: Vec<f64>,
    /// Path speeds asked for at the two ends, 0 at rest: limits there.
    pub speeds: [f64; 2],
    /// The reference at the two ends of every cell.
    cells: Vec<[Kinetic; 2]>,
    /// First three derivatives of the joints by the time of the reference, end after end.
    shapes: Vec<f64>,
    joints: usize,
    /// Limits of rates per place.
    rates: usize,
}

/// What is called for besides the limits of joints.
pub(super) struct Called<'a, 'd, 't> {
    pub demands: &'a mut Demands<'d>,
    pub rates: Option<&'a mut Table<'t>>,
}

impl Posed {
    /// From the lengths of the cells and the reference at their ends, and the path speeds asked for at both ends.
    pub fn new((mut step, mut cells): (Vec<f64>, Vec<[Kinetic; 2]>), speeds: [f64; 2], walker: &mut Walker) -> Self {
        if speeds[0] > 0.0 {
            step.insert(0, 0.0);
            cells.insert(0, [cells[0][0]; 2]);
        }
        if speeds[1] > 0.0 {
            step.push(0.0);
            cells.push([cells[cells.len() - 1][1]; 2]);
        }
        let joints = walker.shape.first.len();
        let mut shapes = Vec::with_capacity(6 * joints * cells.len());
        let mut last = f64::NAN;
        for [s, v, a, j] in cells.iter().flatten().copied() {
            if s != last {
                walker.go(s);
                last = s;
            }
            let q = &walker.shape;
            let (square, cube, mixed) = (v * v, v * v * v, 3.0 * v * a);
            shapes.extend(q.first.iter().map(|first| first * v));
            shapes.extend(q.first.iter().zip(&q.second).map(|(first, second)| second * square + first * a));
            let third = q.first.iter().zip(&q.second).zip(&q.third);
            shapes.extend(third.map(|((first, second), third)| third * cube + second * mixed + first * j));
        }
        Self { step, lines: Lines::default(), top: Vec::new(), speeds, cells, shapes, joints, rates: 0 }
    }

    /// How the joints move at the start or the end of a cell.
    fn shapes(&self, cell: usize, end: usize) -> [&[f64]; 3] {
        let from = (2 * cell + end) * 3 * self.joints;
        [0, 1, 2].map(|order| &self.shapes[from + order * self.joints..from + (order + 1) * self.joints])
    }

    /// Weights of two cells for y, and for half its slope, at the junction after cell `k`.
    fn junction(&self, k: usize) -> [[f64; 2]; 2] {
        let (a, b) = (self.step[k], self.step[k + 1]);
        let inverse = 1.0 / (a + b);
        [[b * inverse, a * inverse], [-inverse, inverse]]
    }

    /// The place of the junction after cell `k`.
    fn place(&self, k: usize) -> Place {
        let at = k.min(self.step.len() - 3);
        let [y, w] = self.junction(k).map(|pair| wide(k - at, pair));
        Place { at, basis: [y, w, [0.0; 3]] }
    }

    /// All limits; those of cells are divided by `tight` (speed, acceleration, jerk, rows called for, rates). With `prune` without the rows of jerk that stay far
    /// from their bounds when the reference is nearly the solution.
    pub fn limits(&mut self, bounds: &Bounds, tight: &[[f64; 5]], asked: Called, prune: bool) -> Result<(), PlanError> {
        let real = self.real();
        let tight: Vec<[f64; 5]> = (0..self.step.len()).map(|j| if real.contains(&j) { tight[j - real.start] } else { [1.0; 5] }).collect();
        self.tops(bounds, &tight);
        self.lines.clear();
        let rates = asked.rates.map(|table| self.rates(table)).transpose()?;
        self.rates = rates.as_ref().map_or(0, Rates::count);
        let called = self.called(asked.demands)?;
        for end in self.moving() {
            self.top[end * (tight.len() - 1)] = self.level(end);
        }
        let mut rows = Vec::new();
        for k in 0..self.step.len() - 1 {
            let [acceleration, demanded] = [1, 3].map(|kind| tight[k][kind].max(tight[k + 1][kind]));
            rows.clear();
            self.accelerations(k, bounds, acceleration, &mut rows);
            if let Some(called) = &called {
                self.demanded(k, called, demanded, &mut rows);
            }
            self.lines.add(self.place(k), &rows);
        }
        for j in real {
            self.jerks(j, bounds, (tight[j][2], prune), &mut rows);
            if let Some(rates) = &rates {
                self.rated(j, rates, tight[j][RATE], &mut rows);
            }
        }
        Ok(())
    }

    /// Rows of rates at both ends of every cell, from within.
    fn rates(&self, table: &mut Table) -> Result<Rates, PlanError> {
        let aside = ASIDE * table.length();
        let ends = |cell: &[Kinetic; 2]| {
            let [from, to] = [cell[0][0], cell[1][0]];
            let near = aside.min(0.5 * (to - from).max(0.0));
            [from + near, to - near]
        };
        Rates::at(table, &self.cells.iter().flat_map(ends).collect::<Vec<f64>>())
    }

    /// Limits of rates on cell `j`, at its two ends.
    fn rated(&mut self, j: usize, rates: &Rates, tight: f64, rows: &mut Vec<Row>) {
        for (end, place) in self.ends(j).into_iter().enumerate() {
            let [_, v, a, jerk] = self.cells[j][end];
            let at = (2 * j + end) * rates.count();
            rows.clear();
            rows.extend((0..rates.count()).map(|r| Row { owner: 2 * self.joints + r, ..rates.limit(at + r, [v, a, jerk], tight) }));
            self.lines.add(place, rows);
        }
    }

    /// Largest `y` of the cells.
    fn tops(&mut self, bounds: &Bounds, tight: &[[f64; 5]]) {
        let fastest = |rates: &[f64]| rates.iter().zip(&bounds.speed).map(|(q, v)| (q / v) * (q / v)).fold(1.0 / MOST, f64::max);
        let n = self.step.len();
        self.top = vec![MOST; n];
        let junctions: Vec<f64> = (0..n - 1).map(|k| 1.0 / fastest(self.shapes(k, 1)[0])).collect();
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
    }

    /// The cells that have a length.
    fn real(&self) -> Range<usize> {
        usize::from(self.speeds[0] > 0.0)..self.step.len() - usize::from(self.speeds[1] > 0.0)
    }

    /// How many they are.
    pub fn count(&self) -> usize {
        self.real().len()
    }

    /// Ends that are passed in motion.
    fn moving(&self) -> impl Iterator<Item = usize> + use<> {
        let speeds = self.speeds;
        [0, 1].into_iter().filter(move |end| speeds[*end] > 0.0)
    }

    /// The `y` asked for at an end.
    fn level(&self, end: usize) -> f64 {
        let share = self.speeds[end] / self.cells[end * (self.cells.len() - 1)][end][1];
        share * share
    }

    /// What the unknowns cost that stand for the speeds asked for, s.
    pub fn pull(&self) -> Vec<(usize, f64)> {
        let time: f64 = self.step.iter().sum();
        self.moving().map(|end| (end * (self.step.len() - 1), -WORTH[end] * time / self.level(end))).collect()
    }

    /// How much more than time they are worth.
    pub fn worth(&self) -> f64 {
        self.moving().map(|end| WORTH[end]).fold(1.0, f64::max)
    }

    /// Share of the speeds asked for that is reached at both ends.
    pub fn reached(&self, y: &[f64]) -> [f64; 2] {
        let mut reached = [1.0; 2];
        for end in self.moving() {
            let share = (y[end * (y.len() - 1)] / self.level(end)).sqrt();
            reached[end] = if share > 1.0 - MISSED { 1.0 } else { share };
        }
        reached
    }

    /// Rows of acceleration at the junction after cell `k`.
    fn accelerations(&self, k: usize, bounds: &Bounds, tight: f64, rows: &mut Vec<Row>) {
        let [first, second, _] = self.shapes(k, 1);
        for i in 0..self.joints {
            let [low, high] = bounds.acceleration(i, [first[i], first[i]]);
            if !high.is_finite() || !low.is_finite() {
                continue;
            }
            let (inverse, constant) = (2.0 * tight / (high - low), -(high + low) / (high - low));
            rows.push(Row { plain: [second[i] * inverse, first[i] * inverse], constant, owner: i, ..Row::default() });
        }
    }

    /// Rows of jerk on cell `j`, at its two ends.
    fn jerks(&mut self, j: usize, bounds: &Bounds, (tight, prune): (f64, bool), rows: &mut Vec<Row>) {
        let places = self.ends(j);
        rows.clear();
        for end in 0..2 {
            let [first, second, third] = self.shapes(j, end);
            for i in (0..self.joints).filter(|i| bounds.jerk[*i].is_finite()) {
                let inverse = tight / bounds.jerk[i];
                rows.push(Row { rooted: [third[i], 3.0 * second[i], first[i]].map(|q| q * inverse), owner: self.joints + i, ..Row::default() });
            }
        }
        let count = (rows.len() / 2).max(1);
        let most = rows.iter().enumerate().map(|(i, row)| row.reach(&places[i / count])[0]).fold(0.0, f64::max);
        for (place, rows) in places.iter().zip(rows.chunks_mut(count)) {
            let mut kept = 0;
            for i in 0..rows.len() {
                // Those that are small, and would not grow much if the jerk on the cell changed by as much as the row most sensitive to it admits, are not.
                let [size, share] = rows[i].reach(place);
                if !prune || share + size / most > 1.0 {
                    rows.swap(kept, i);
                    kept += 1;
                }
            }
            self.lines.add(*place, &rows[..kept]);
        }
    }

    /// The two ends of cell `j` as places, where the slope of `w` is that of the cell.
    fn ends(&self, j: usize) -> [Place; 2] {
        let n = self.step.len();
        let at = j.clamp(1, n - 2) - 1;
        let pair = |k: usize| self.junction(k).map(|pair| wide(k - at, pair));
        let inner = j > 0 && j + 1 < n;
        let ends = if inner {
            [pair(j - 1), pair(j)]
        } else {
            // Linear in an end cell: on to its outer end.
            let k = if j == 0 { 0 } else { n - 2 };
            let [y, w] = pair(k);
            let reach = if j == 0 { -2.0 * self.step[0] } else { 2.0 * self.step[n - 1] };
            let outer = [[0, 1, 2].map(|p| y[p] + reach * w[p]), w];
            if j == 0 { [outer, [y, w]] } else { [[y, w], outer] }
        };
        let inverse = if inner { 1.0 / self.step[j] } else { 0.0 };
        let curve = [0, 1, 2].map(|p| inverse * (ends[1][1][p] - ends[0][1][p]));
        ends.map(|[y, w]| Place { at, basis: [y, w, curve] })
    }

    /// What the demands ask at the junctions; their ceilings lower the largest `y`.
    fn called(&mut self, demands: &mut Demands) -> Result<Option<Rows>, PlanError> {
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
        demands.rows.as_mut().map(|rows| rows(&s)?.checked(n - 1)).transpose()
    }

    /// Rows of the demands at the junction after cell `k`.
    fn demanded(&self, k: usize, called: &Rows, tight: f64, out: &mut Vec<Row>) {
        let [_, v, a, _] = self.cells[k][1];
        for r in 0..called.count {
            let i = k * called.count + r;
            let [low, high] = closed(shrunk([called.low[i], called.high[i]], tight), called.c[i]);
            let (inverse, centre) = (2.0 / (high - low), 0.5 * (high + low));
            out.push(Row {
                root: called.d.get(i).map_or(0.0, |d| d * v * inverse),
                plain: [(called.a[i] * a + called.b[i] * v * v) * inverse, called.a[i] * v * inverse],
                constant: (called.c[i] - centre) * inverse,
                owner: 2 * self.joints + self.rates + r,
                ..Row::default()
            });
        }
    }

    /// A constant speed of the reference within all limits.
    pub fn start(&self, most: f64) -> Option<Vec<f64>> {
        let lowest = self.top.iter().copied().fold(f64::INFINITY, f64::min);
        let first = 1.0f64.min(most * lowest);
        let y = std::iter::successors(Some(first), |y| Some(most * y)).take(STARTS).find(|y| self.lines.admits(*y, most))?;
        Some(vec![y; self.top.len()])
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
        // Between cells that have a length.
        let real = self.real();
        let mut states = states[real.start..=real.end].to_vec();
        let (last, reached) = (states.len() - 1, self.reached(y));
        for end in self.moving() {
            states[end * last][1] = self.speeds[end] * reached[end];
        }
        states
    }

    /// Adds what a relative change of each limit of jerk, and of each rate, is worth, s.
    pub fn sensitivities(&self, y: &[f64], weight: f64, prices: &mut [f64]) {
        let jerks = self.joints..2 * self.joints + self.rates;
        self.lines.shares(y, |owner, g| {
            if jerks.contains(&owner) {
                prices[owner - self.joints] += 2.0 * weight * g * g / (1.0 - g * g).max(1e-9);
            }
        });
    }
}

/// Weights of two neighbouring cells as those of three.
fn wide(first: usize, pair: [f64; 2]) -> [f64; 3] {
    let mut weights = [0.0; 3];
    (weights[first], weights[first + 1]) = (pair[0], pair[1]);
    weights
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
