//! Rows that are called for, by interpolation: between the breaks of a path they are smooth, so a few places of each stretch give them everywhere.
//!
//! Stretches end where polynomial pieces meet and where a joint turns back (Coulomb friction jumps there). Each is halved until polynomials through a few
//! places inside meet the rows near its ends and their last coefficients vanish; what stays rough, round places of which the path knows nothing, is
//! called for directly. Since no place at which the rows are called is a break, each stretch sees the rows from its own side.

use super::course::Course;
use super::grid::breaks;
use super::problem::RowsAt;
use super::rows::Rows;
use crate::error::PlanError;
use std::f64::consts::PI;

/// Places inside a stretch, and where near its ends the polynomials are compared, as a share of half its length.
const NODES: usize = 6;
const NEAR: f64 = 0.999;
/// Error of the polynomials, as a share of the largest value of their kind along the path.
const ERROR: f64 = 1e-9;
/// Step of differences on stretches without polynomials, as a share of the stretch: they lie round turns far smaller than themselves.
const STEP: f64 = 1e-4;
/// Times that a stretch is halved.
const HALVINGS: u32 = 9;
/// Kinds of values: a, b, c, d, low, high.
const KINDS: usize = 6;
/// Places called for after which nothing is halved any more.
const MOST: usize = 40_000;

/// Polynomials of the rows on the stretches of a path.
pub(super) struct Table<'a> {
    rows: &'a mut RowsAt<'a>,
    size: Size,
    stretches: Vec<Stretch>,
    /// Coefficients of the Chebyshev polynomials of each stretch: kinds times rows for the first one, then for the second ...
    values: Vec<f64>,
}

/// How many rows there are, whether with square roots, and the largest finite value of each kind.
#[derive(Debug, Default)]
struct Size {
    count: usize,
    rooted: bool,
    most: [f64; KINDS],
}

/// A stretch of the path; without an index it is called for directly.
#[derive(Debug, Clone, Copy)]
struct Stretch {
    from: f64,
    to: f64,
    halved: u32,
    index: Option<usize>,
}

/// The arrays of rows, kind by kind.
fn kinds(rows: &Rows) -> [&[f64]; KINDS] {
    [&rows.a, &rows.b, &rows.c, &rows.d, &rows.low, &rows.high]
}

/// The same to be filled.
fn kinds_mut(rows: &mut Rows) -> [&mut [f64]; KINDS] {
    [&mut rows.a, &mut rows.b, &mut rows.c, &mut rows.d, &mut rows.low, &mut rows.high]
}

impl Stretch {
    /// The places at which the rows are called: nodes, then near both ends.
    fn places(&self) -> [f64; NODES + 2] {
        let (half, middle) = (0.5 * (self.to - self.from), 0.5 * (self.from + self.to));
        let node = |j: usize| if j < NODES { (PI * (j as f64 + 0.5) / NODES as f64).cos() } else { [-NEAR, NEAR][j - NODES] };
        std::array::from_fn(|j| middle + half * node(j))
    }

    /// Chebyshev polynomials at an arc length.
    fn polynomials(&self, s: f64) -> [f64; NODES] {
        let z = (2.0 * s - self.from - self.to) / (self.to - self.from);
        let mut t = [1.0, z, 0.0, 0.0, 0.0, 0.0];
        for j in 2..NODES {
            t[j] = 2.0 * z * t[j - 1] - t[j - 2];
        }
        t
    }

    /// Their derivatives.
    fn slopes(&self, s: f64) -> [f64; NODES] {
        let inverse = 2.0 / (self.to - self.from);
        let z = (2.0 * s - self.from - self.to) / (self.to - self.from);
        let mut u = [0.0, 1.0, 2.0 * z, 0.0, 0.0, 0.0];
        for j in 3..NODES {
            u[j] = 2.0 * z * u[j - 1] - u[j - 2];
        }
        // The derivative of a polynomial of the first kind is its degree times one of the second kind.
        std::array::from_fn(|j| j as f64 * u[j] * inverse)
    }

    /// Two places nearby on the stretch.
    fn beside(&self, s: f64) -> [f64; 2] {
        let step = STEP * (self.to - self.from);
        let inside = |s: f64| s.clamp(self.from + 0.1 * step, self.to - 0.1 * step);
        [inside(s - step), inside(s + step)]
    }

    fn halves(&self) -> Option<[Self; 2]> {
        let (middle, halved) = (0.5 * (self.from + self.to), self.halved + 1);
        let fits = halved <= HALVINGS && middle > self.from && middle < self.to;
        fits.then_some([Self { to: middle, halved, ..*self }, Self { from: middle, halved, ..*self }])
    }
}

impl Size {
    fn seen(&mut self, rows: &Rows) {
        self.count = rows.count;
        self.rooted |= !rows.d.is_empty();
        for (most, values) in self.most.iter_mut().zip(kinds(rows)) {
            *most = values.iter().filter(|v| v.is_finite()).fold(*most, |m, v| m.max(v.abs()));
        }
    }

    /// Coefficients of the polynomials of a stretch if they are good enough; its rows begin at `first`.
    fn fitted(&self, stretch: &Stretch, rows: &Rows, first: usize) -> Option<Vec<f64>> {
        let (count, width) = (self.count, KINDS * self.count);
        let mut out = vec![0.0; NODES * width];
        for (kind, values) in kinds(rows).into_iter().enumerate().filter(|(_, values)| !values.is_empty()) {
            let error = ERROR * self.most[kind];
            for r in 0..count {
                let value = |j: usize| values[(first + j) * count + r];
                let column = kind * count + r;
                if (1..NODES + 2).all(|j| value(j) == value(0)) {
                    out[column] = value(0);
                    continue;
                }
                let found = coefficients(&value);
                let places = stretch.places();
                let sum = |j: usize| stretch.polynomials(places[j]).iter().zip(&found).map(|(t, c)| t * c).sum::<f64>();
                let good = (NODES..NODES + 2).all(|j| (sum(j) - value(j)).abs() <= error);
                if !good || found[NODES - 1].abs() > error {
                    return None;
                }
                (0..NODES).for_each(|k| out[k * width + column] = found[k]);
            }
        }
        Some(out)
    }
}

/// Coefficients of the Chebyshev polynomials through values at the nodes.
fn coefficients(value: &dyn Fn(usize) -> f64) -> [f64; NODES] {
    std::array::from_fn(|k| {
        let norm = if k == 0 { 1.0 } else { 2.0 } / NODES as f64;
        (0..NODES).map(|j| norm * (PI * k as f64 * (j as f64 + 0.5) / NODES as f64).cos() * value(j)).sum()
    })
}

/// The sum of polynomials weighted by the coefficients of a stretch.
fn summed(values: &[f64], polynomials: &[f64; NODES], out: &mut [f64]) {
    let width = out.len();
    for (out, value) in out.iter_mut().zip(&values[..width]) {
        *out = polynomials[0] * value;
    }
    for (t, values) in polynomials[1..].iter().zip(values[width..].chunks_exact(width)) {
        for (out, value) in out.iter_mut().zip(values) {
            *out += t * value;
        }
    }
}

impl<'a> Table<'a> {
    /// From a callback.
    pub fn new(course: &Course, rows: &'a mut RowsAt<'a>) -> Result<Self, PlanError> {
        let ends = breaks(course, true);
        let mut pending: Vec<Stretch> = ends.windows(2).map(|w| Stretch { from: w[0], to: w[1], halved: 0, index: None }).collect();
        let (mut size, mut stretches, mut values, mut called) = (Size::default(), Vec::new(), Vec::new(), 0);
        while !pending.is_empty() {
            let places: Vec<f64> = pending.iter().flat_map(Stretch::places).collect();
            let found = rows(&places)?.checked(places.len())?;
            size.seen(&found);
            called += places.len();
            let mut rough = Vec::new();
            for (i, stretch) in pending.iter().enumerate() {
                let fitted = size.fitted(stretch, &found, i * (NODES + 2));
                match stretch.halves().filter(|_| fitted.is_none() && called < MOST) {
                    Some(halves) => rough.extend(halves),
                    None => stretches.push(Stretch { index: fitted.as_ref().map(|_| values.len()), ..*stretch }),
                }
                values.extend(fitted.unwrap_or_default());
            }
            pending = rough;
        }
        stretches.sort_by(|a, b| a.from.total_cmp(&b.from));
        Ok(Self { rows, size, stretches, values })
    }

    /// Rows per place.
    pub fn count(&self) -> usize {
        self.size.count
    }

    /// Length of the path.
    pub fn length(&self) -> f64 {
        self.stretches.last().map_or(0.0, |stretch| stretch.to)
    }

    /// The rows at arc lengths.
    pub fn at(&mut self, s: &[f64]) -> Result<Rows, PlanError> {
        let (mut out, direct) = self.read(s, Stretch::polynomials);
        if !direct.is_empty() {
            let places: Vec<f64> = direct.iter().map(|(i, _)| s[*i]).collect();
            let found = (self.rows)(&places)?.checked(places.len())?;
            for (from, (to, _)) in direct.into_iter().enumerate() {
                copy(&mut out, to, &found, |values, r| values[from * found.count + r]);
            }
        }
        Ok(out)
    }

    /// The derivatives of the rows by arc length, each from the side of its stretch; bounds have no meaning.
    pub fn slopes(&mut self, s: &[f64]) -> Result<Rows, PlanError> {
        let (mut out, direct) = self.read(s, Stretch::slopes);
        if !direct.is_empty() {
            let places: Vec<f64> = direct.iter().flat_map(|(i, k)| self.stretches[*k].beside(s[*i])).collect();
            let found = (self.rows)(&places)?.checked(places.len())?;
            for (n, (to, _)) in direct.into_iter().enumerate() {
                let (from, inverse) = (2 * n * found.count, 1.0 / (places[2 * n + 1] - places[2 * n]));
                copy(&mut out, to, &found, |values, r| (values[from + found.count + r] - values[from + r]) * inverse);
            }
        }
        Ok(out)
    }

    /// Sums of the polynomials of the stretches, and the places (with their stretches) that must be called for.
    fn read(&self, s: &[f64], weights: impl Fn(&Stretch, f64) -> [f64; NODES]) -> (Rows, Vec<(usize, usize)>) {
        let (count, width) = (self.size.count, KINDS * self.size.count);
        let zeros = || vec![0.0; s.len() * count];
        let d = if self.size.rooted { zeros() } else { Vec::new() };
        let mut rows = Rows { count, a: zeros(), b: zeros(), c: zeros(), d, low: zeros(), high: zeros() };
        let (mut sum, mut direct, mut k) = (vec![0.0; width], Vec::new(), 0);
        if count == 0 {
            return (rows, direct);
        }
        for (i, s) in s.iter().enumerate() {
            if !(self.stretches[k].from <= *s && *s < self.stretches[k].to) {
                k = self.stretches.partition_point(|stretch| stretch.from <= *s).max(1) - 1;
            }
            let stretch = &self.stretches[k];
            let Some(at) = stretch.index else {
                direct.push((i, k));
                continue;
            };
            summed(&self.values[at..at + NODES * width], &weights(stretch, *s), &mut sum);
            for (out, sum) in kinds_mut(&mut rows).into_iter().zip(sum.chunks_exact(count)).filter(|(out, _)| !out.is_empty()) {
                out[i * count..(i + 1) * count].copy_from_slice(sum);
            }
        }
        (rows, direct)
    }
}

/// Fills the rows of place `to` with values of each kind.
fn copy(out: &mut Rows, to: usize, found: &Rows, value: impl Fn(&[f64], usize) -> f64) {
    let count = out.count;
    for (out, found) in kinds_mut(out).into_iter().zip(kinds(found)).filter(|(out, found)| !out.is_empty() && !found.is_empty()) {
        for (r, out) in out[to * count..(to + 1) * count].iter_mut().enumerate() {
            *out = value(found, r);
        }
    }
}
