//! A path as its polynomial pieces in power form, for fast derivatives by arc length at many places.

use crate::path::Path;

/// Nodes and weights of the 8-point Gauss-Legendre rule on [-1, 1], positive half.
const GAUSS: [(f64, f64); 4] = [
    (0.183_434_642_495_649_8, 0.362_683_783_378_362),
    (0.525_532_409_916_329, 0.313_706_645_877_887_3),
    (0.796_666_477_413_626_7, 0.222_381_034_453_374_48),
    (0.960_289_856_497_536_2, 0.101_228_536_290_376_26),
];
/// Jumps of the unit tangent below this are rounding (as for corners of planar paths).
const SAME: f64 = 1e-6;
/// Speed by the parameter, as a share of the largest on the piece, below which the curve stands still.
const STILL: f64 = 1e-7;
/// Share of the second derivative by the parameter below which what is left of it across the direction of motion is rounding.
const CANCELLED: f64 = 16.0 * f64::EPSILON;
/// How far from a place where the curve stands still its derivatives are taken, as a share of the interval.
pub(super) const ASIDE: f64 = 1e-4;
/// Share of its largest speed by the parameter below which the curve is slow.
const SLOW: f64 = 0.5;
/// Share of the path below which a joint does not move but for rounding.
const STANDING: f64 = 1e-9;
/// Samples per piece in the search for places where the speed by the parameter is least.
const SAMPLES: usize = 24;

/// Polynomial pieces of positive length.
#[derive(Debug)]
pub(super) struct Course {
    pub dimension: usize,
    degree: usize,
    /// Per piece `degree + 1` rows of `dimension` values: coefficients of the powers of t in [0, 1].
    coefficients: Vec<f64>,
    /// Arc length at the start of leaves of the path, with their piece and parameter.
    anchors: Vec<(usize, f64, f64)>,
    pub length: f64,
}

/// A place: piece, its parameter in [0, 1], arc length.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Place {
    pub piece: usize,
    pub t: f64,
    pub s: f64,
}

/// A stretch of one piece between two places.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Span {
    pub piece: usize,
    pub t: [f64; 2],
    pub s: [f64; 2],
}

/// Derivatives of the joints by arc length.
#[derive(Debug, Clone, Default)]
pub(super) struct Shape {
    /// q', -.
    pub first: Vec<f64>,
    /// q'', 1/rad.
    pub second: Vec<f64>,
    /// q''', 1/rad2.
    pub third: Vec<f64>,
    /// Arc length by the parameter, and its derivative.
    pub rate: [f64; 2],
}

impl Shape {
    pub fn new(dimension: usize) -> Self {
        let zeros = || vec![0.0; dimension];
        Self { first: zeros(), second: zeros(), third: zeros(), rate: [0.0; 2] }
    }
}

impl Course {
    pub fn new(path: &Path) -> Self {
        let (degree, dimension) = (path.degree(), path.dimension());
        let (pieces, anchors) = path.pieces();
        let rows = (degree + 1) * dimension;
        let mut coefficients = Vec::with_capacity(pieces.len());
        for control in pieces.chunks_exact(rows) {
            coefficients.extend(powers(control, dimension));
        }
        Self { dimension, degree, coefficients, anchors, length: path.length() }
    }

    fn piece(&self, piece: usize) -> &[f64] {
        let rows = (self.degree + 1) * self.dimension;
        &self.coefficients[piece * rows..(piece + 1) * rows]
    }

    pub fn count(&self) -> usize {
        self.coefficients.len() / ((self.degree + 1) * self.dimension)
    }

    /// First three derivatives by the parameter, into the rows of a shape.
    fn by_parameter(&self, piece: usize, t: f64, shape: &mut Shape) {
        let (n, p, rows) = (self.dimension, self.degree, self.piece(piece));
        let Shape { first, second, third, .. } = shape;
        if p == 3 {
            let (one, rows) = rows[n..].split_at(n);
            let (two, three) = rows.split_at(n);
            let (t2, t3) = (2.0 * t, 3.0 * t);
            for (d, ((first, second), third)) in first.iter_mut().zip(second).zip(third).enumerate() {
                let (b, c) = (two[d], three[d]);
                *first = one[d] + t2 * b + t3 * t * c;
                *second = 2.0 * (b + t3 * c);
                *third = 6.0 * c;
            }
            return;
        }
        for d in 0..n {
            let (mut one, mut two, mut three) = (0.0, 0.0, 0.0);
            for k in (1..=p).rev() {
                let c = rows[k * n + d];
                let k = k as f64;
                one = one * t + k * c;
                if k >= 2.0 {
                    two = two * t + k * (k - 1.0) * c;
                }
                if k >= 3.0 {
                    three = three * t + k * (k - 1.0) * (k - 2.0) * c;
                }
            }
            (first[d], second[d], third[d]) = (one, two, three);
        }
    }

    /// First two derivatives by the parameter, with the square of the first and the product of the two.
    pub fn moving(&self, piece: usize, t: f64, shape: &mut Shape) -> [f64; 2] {
        self.by_parameter(piece, t, shape);
        [inner(&shape.first, &shape.first), inner(&shape.first, &shape.second)]
    }

    /// First three derivatives by the parameter, and those of the parameter by time where the path moves with a speed, an acceleration and a jerk.
    pub fn driven(&self, piece: usize, t: f64, [v, a, j]: [f64; 3], shape: &mut Shape) -> [f64; 3] {
        self.by_parameter(piece, t, shape);
        let Shape { first, second, third, rate } = shape;
        let speed = inner(first, first).sqrt();
        let inverse = 1.0 / speed;
        let turning = inner(first, second) * inverse;
        let bending = (inner(second, second) + inner(first, third) - turning * turning) * inverse;
        *rate = [speed, turning];
        let once = v * inverse;
        let twice = (a - turning * once * once) * inverse;
        [once, twice, (j - once * (3.0 * turning * twice + bending * once * once)) * inverse]
    }

    /// First two derivatives by arc length; the curve must move there.
    pub fn shape(&self, piece: usize, t: f64, shape: &mut Shape) {
        self.by_parameter(piece, t, shape);
        let Shape { first, second, third, rate } = shape;
        let v = inner(first, first).sqrt();
        if v == 0.0 {
            first.fill(0.0);
            second.fill(0.0);
            third.fill(0.0);
            *rate = [0.0; 2];
            return;
        }
        // Divided, not multiplied by an inverse: along a line nothing is left of q'' but what rounds to nothing, however slow the curve is.
        for first in first.iter_mut() {
            *first /= v;
        }
        let dv = inner(first, second);
        let square = 1.0 / (v * v);
        for (first, second) in first.iter().zip(second) {
            *second = across(*second, *first, dv) * square;
        }
        *rate = [v, dv];
    }

    /// [`Course::shape`] with the third derivative as well: what of the third derivative by the parameter is across the direction of motion and not due to
    /// the curvature, and along the direction what keeps the first at length 1.
    pub fn full_shape(&self, piece: usize, t: f64, shape: &mut Shape) {
        self.shape(piece, t, shape);
        let Shape { first, second, third, rate: [v, dv] } = shape;
        if *v > 0.0 {
            let (along, bend) = (inner(first, third), inner(second, second));
            let (turning, cube) = (3.0 * *v * *dv, 1.0 / (*v * *v * *v));
            for ((third, first), second) in third.iter_mut().zip(first).zip(second) {
                *third = (across(*third, *first, along) - turning * *second) * cube - *first * bend;
            }
        }
    }

    /// [`Course::shape`] at share `tau` of a span; where the curve stands still at an end, a little inside.
    pub fn shape_in(&self, span: &Span, tau: f64, shape: &mut Shape) {
        let t = span.t[0] + (span.t[1] - span.t[0]) * tau;
        self.shape(span.piece, t, shape);
        let mean = (span.s[1] - span.s[0]) / (span.t[1] - span.t[0]);
        if shape.rate[0] < ASIDE * mean && !(ASIDE..=1.0 - ASIDE).contains(&tau) {
            let rate = shape.rate;
            let inside = if tau < 0.5 { ASIDE } else { 1.0 - ASIDE };
            self.shape(span.piece, span.t[0] + (span.t[1] - span.t[0]) * inside, shape);
            shape.rate = rate;
        }
    }

    /// Arc length by the parameter.
    pub fn speed(&self, piece: usize, t: f64) -> f64 {
        let (n, p, rows) = (self.dimension, self.degree, self.piece(piece));
        let mut sum = 0.0;
        for d in 0..n {
            let first = (1..=p).rev().fold(0.0, |first, k| first * t + k as f64 * rows[k * n + d]);
            sum += first * first;
        }
        sum.sqrt()
    }

    /// Arc length at parameter `t` of a piece.
    pub fn length_at(&self, piece: usize, t: f64) -> f64 {
        let i = self.anchors.partition_point(|a| (a.0, a.1) <= (piece, t)).max(1) - 1;
        let (_, from, s) = self.anchors[i];
        if from == t {
            return s;
        }
        let (half, middle) = (0.5 * (t - from), 0.5 * (t + from));
        let sum: f64 = GAUSS.iter().map(|(x, w)| w * (self.speed(piece, middle - half * x) + self.speed(piece, middle + half * x))).sum();
        let next = self.anchors.get(i + 1).map_or(self.length, |a| a.2);
        (s + half * sum).min(next)
    }

    pub fn place(&self, piece: usize, t: f64) -> Place {
        let next = || self.anchors.get(self.anchors.partition_point(|a| a.0 <= piece)).map_or(self.length, |a| a.2);
        let s = if t >= 1.0 { next() } else { self.length_at(piece, t) };
        Place { piece, t, s }
    }

    /// Parameters inside a piece where the curve slows down much by its parameter (cusps are among them), and where the joints turn back.
    pub fn breaks(&self, piece: usize, turns: bool) -> Vec<f64> {
        if self.degree == 1 {
            return Vec::new();
        }
        let mut shape = Shape::new(self.dimension);
        // Joint by joint how fast it goes, and whether the curve slows down.
        let mut values = |t: f64| {
            self.by_parameter(piece, t, &mut shape);
            let mut row = shape.first.clone();
            row.push(inner(&shape.first, &shape.second));
            row
        };
        let rows: Vec<Vec<f64>> = (0..=SAMPLES).map(|i| values(i as f64 / SAMPLES as f64)).collect();
        let slowing = self.dimension;
        let speed = |row: &Vec<f64>| inner(&row[..slowing], &row[..slowing]).sqrt();
        let fastest = rows.iter().map(speed).fold(0.0, f64::max);
        let moves = |d: usize| rows.iter().any(|row| row[d].abs() > STANDING * speed(row));
        let mut found = Vec::new();
        for c in (0..=slowing).filter(|c| *c == slowing || (turns && moves(*c))) {
            for (i, w) in rows.windows(2).enumerate() {
                let [a, b] = [i, i + 1].map(|i| i as f64 / SAMPLES as f64);
                let (before, after) = (w[0][c], w[1][c]);
                let crosses = if c == slowing { before < 0.0 && after > 0.0 && speed(&w[0]) < SLOW * fastest } else { before * after < 0.0 };
                if crosses {
                    found.push(root(|t| values(t)[c], [a, b]));
                } else if after == 0.0 && i + 1 < SAMPLES && before != 0.0 {
                    found.push(b);
                }
            }
        }
        found.sort_by(f64::total_cmp);
        found.dedup_by(|b, a| *b - *a < 1e-6);
        found.retain(|t| *t > 1e-6 && *t < 1.0 - 1e-6);
        found
    }

    /// Whether the direction jumps between the end of one span and the start of the next: the motion must stop there.
    pub fn jumps(&self, before: &Span, after: &Span) -> bool {
        let (mut left, mut right) = (Shape::new(self.dimension), Shape::new(self.dimension));
        if before.piece == after.piece {
            self.shape(before.piece, before.t[1], &mut left);
            let mean = |s: &Span| (s.s[1] - s.s[0]) / (s.t[1] - s.t[0]);
            if left.rate[0] > STILL * mean(before).max(mean(after)) {
                return false;
            }
        }
        self.shape_in(before, 1.0, &mut left);
        self.shape_in(after, 0.0, &mut right);
        left.first.iter().zip(&right.first).any(|(a, b)| (a - b).abs() > SAME)
    }
}

impl Span {
    pub fn length(&self) -> f64 {
        self.s[1] - self.s[0]
    }
}

/// Arc length from the start of a span by the share of its parameter: the quintic through length and two derivatives at both ends.
#[derive(Debug, Clone, Copy)]
pub(super) struct Way([f64; 5]);

impl Way {
    /// From the rates (first and second derivative by the parameter) at both ends.
    pub fn new(span: &Span, rates: [[f64; 2]; 2]) -> Self {
        let h = span.t[1] - span.t[0];
        let [[v0, a0], [v1, a1]] = rates.map(|[v, a]| [v * h, a * h * h]);
        let rest = span.length() - v0 - 0.5 * a0;
        let (dv, da) = (v1 - v0 - a0, a1 - a0);
        Self([v0, 0.5 * a0, 10.0 * rest - 4.0 * dv + 0.5 * da, -15.0 * rest + 7.0 * dv - da, 6.0 * rest - 3.0 * dv + 0.5 * da])
    }

    /// Of a span of a path.
    pub fn of(course: &Course, span: &Span) -> Self {
        let mut shape = Shape::new(course.dimension);
        let rates = [0.0, 1.0].map(|tau| {
            course.shape_in(span, tau, &mut shape);
            shape.rate
        });
        Self::new(span, rates)
    }

    pub fn at(&self, tau: f64) -> f64 {
        let [a, b, c, d, e] = self.0;
        tau * (a + tau * (b + tau * (c + tau * (d + tau * e))))
    }

    /// Derivative by the share.
    pub fn slope(&self, tau: f64) -> f64 {
        let [a, b, c, d, e] = self.0;
        a + tau * (2.0 * b + tau * (3.0 * c + tau * (4.0 * d + tau * 5.0 * e)))
    }
}

/// What is left of one component of a vector across the direction of motion, where `along` is its share along it; nothing if that is rounding.
fn across(component: f64, direction: f64, along: f64) -> f64 {
    let left = component - direction * along;
    if left.abs() <= CANCELLED * component.abs() { 0.0 } else { left }
}

fn inner(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}

/// Coefficients of the powers of t of a Bezier piece.
fn powers(control: &[f64], dimension: usize) -> Vec<f64> {
    let degree = control.len() / dimension - 1;
    let (mut differences, mut out) = (control.to_vec(), Vec::with_capacity(control.len()));
    let mut binomial = 1.0;
    for k in 0..=degree {
        out.extend(differences[..dimension].iter().map(|d| binomial * d));
        for i in 0..(degree - k) * dimension {
            differences[i] = differences[i + dimension] - differences[i];
        }
        binomial *= (degree - k) as f64 / (k + 1) as f64;
    }
    out
}

/// Where a function changes its sign, by bisection.
fn root(mut f: impl FnMut(f64) -> f64, [mut a, mut b]: [f64; 2]) -> f64 {
    let rising = f(b) > 0.0;
    for _ in 0..60 {
        let middle = 0.5 * (a + b);
        let value = f(middle);
        if value == 0.0 {
            return middle;
        }
        if (value > 0.0) == rising {
            b = middle;
        } else {
            a = middle;
        }
    }
    0.5 * (a + b)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn derivatives_are_those_of_the_path() {
        let points: Vec<f64> = (0..60).map(|i| (f64::from(i * i) * 1.7).sin()).collect();
        let path = Path::through(&points, 6).unwrap();
        let course = Course::new(&path);
        let mut shape = Shape::new(6);
        for i in 0..70 {
            let place = course.place(i / 10, f64::from((i % 10) as u32) / 10.0 + 0.03);
            course.full_shape(place.piece, place.t, &mut shape);
            let expected = path.eval(place.s, 3);
            for (row, scale) in [(&shape.first, 1), (&shape.second, 2), (&shape.third, 3)] {
                let size = expected[scale].iter().fold(1.0, |m: f64, v| m.max(v.abs()));
                assert!(row.iter().zip(&expected[scale]).all(|(a, b)| (a - b).abs() < 1e-7 * size), "{i}: {row:?} {:?}", expected[scale]);
            }
        }
    }

    #[test]
    fn the_way_within_a_span() {
        let path = Path::through(&[0.0, 0.0, 1.0, 0.3, 1.4, 1.2, 3.0, -0.4, 3.2, 0.8], 2).unwrap();
        let course = Course::new(&path);
        let (a, b) = (course.place(1, 0.2), course.place(1, 0.22));
        let span = Span { piece: 1, t: [0.2, 0.22], s: [a.s, b.s] };
        let mut shape = Shape::new(2);
        let rates = [0.2, 0.22].map(|t| {
            course.shape(1, t, &mut shape);
            shape.rate
        });
        let way = Way::new(&span, rates);
        for i in 0..=10 {
            let tau = f64::from(i) / 10.0;
            assert!((way.at(tau) - (course.length_at(1, 0.2 + 0.02 * tau) - a.s)).abs() < 1e-8 * span.length());
        }
    }

    #[test]
    fn cusps_are_found() {
        let path = Path::through_at(&[0.0, 0.0, 0.0, 1e-5, 0.0, 0.0], 2, &[0.0, 0.5, 1.0]).unwrap();
        let course = Course::new(&path);
        let breaks = course.breaks(0, false);
        assert!(breaks.len() == 1 && (breaks[0] - 0.5).abs() < 1e-9);
        let places = [0.0, 0.5, 1.0].map(|t| course.place(0, t));
        let spans: Vec<Span> = places.windows(2).map(|w| Span { piece: 0, t: [w[0].t, w[1].t], s: [w[0].s, w[1].s] }).collect();
        assert!(course.jumps(&spans[0], &spans[1]));
    }
}
