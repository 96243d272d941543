//! Limits on the intervals of a grid: three rows per limit and interval that enclose it between the ends too.
//!
//! On an interval a limit reads `low <= A u + B x_k + C + D sqrt(x_k + 2 w u) <= high` with coefficients that change along it (`w` is the way from its
//! start). Taken as parabolas through start, middle and end, they stay in the triangle of start, end and the crossing of the end tangents, so a limit
//! kept at these three is kept on the whole interval, up to terms of third order that the check afterwards finds.

use super::course::{Course, Shape, Way};
use super::grid::Grid;
use super::limits::Bounds;
use super::rows::Rows;
use super::strips::{Columns, Limit, Strips};
use crate::error::PlanError;

/// Places of an interval, as shares of its parameter.
const PLACES: [f64; 3] = [0.0, 0.5, 1.0];
/// How far inside an interval its ends are called for, as a share of it.
const ASIDE: f64 = 1e-7;

/// A callback with rows at arc lengths (rad).
pub type RowsAt<'a> = dyn FnMut(&[f64]) -> Result<Rows, PlanError> + 'a;
/// A callback with a bound of the squared path speed at arc lengths (rad).
pub type CeilingAt<'a> = dyn FnMut(&[f64]) -> Result<Vec<f64>, PlanError> + 'a;

/// Limits besides those of joint speed and acceleration.
#[derive(Default)]
pub struct Demands<'a> {
    /// Names of the rows.
    pub names: Vec<String>,
    /// Rows: torque, acceleration of the tip ...
    pub rows: Option<Box<RowsAt<'a>>>,
    /// Bound of the squared path speed.
    pub ceiling: Option<Box<CeilingAt<'a>>>,
    /// Names of the rates.
    pub rate_names: Vec<String>,
    /// Rows whose rate by time is limited, by `low < 0 < high`, where limits of jerk are kept: torque. Jumps of the rows do not count.
    pub rates: Option<Box<RowsAt<'a>>>,
}

/// A limit on an interval: `low <= a u + b x + c + d sqrt(x + 2 way u + lift) <= high`, `x` at the start of the interval.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Raw {
    pub a: f64,
    pub b: f64,
    pub c: f64,
    pub d: f64,
    pub way: f64,
    /// Added to x below the square root.
    pub lift: f64,
    pub low: f64,
    pub high: f64,
}

/// Limits of acceleration on an interval.
#[derive(Debug, Clone, Default)]
pub(super) struct Accelerations {
    /// Lower and upper, joint by joint.
    pub bounds: [Vec<f64>; 2],
    /// Coefficients a, b, c, joint by joint, at the start, between, at the end.
    pub rows: [[Vec<f64>; 3]; 3],
}

impl Accelerations {
    pub fn columns(&self, p: usize) -> Columns<'_> {
        let [a, b, c] = &self.rows[p];
        Columns { a, b, c, bottom: &self.bounds[0], top: &self.bounds[1] }
    }
}

/// A discretised problem.
#[derive(Debug)]
pub(super) struct Problem {
    /// Arc lengths of the nodes.
    pub s: Vec<f64>,
    joints: usize,
    /// q' and q'' at the three places of every interval.
    first: Vec<f64>,
    second: Vec<f64>,
    /// Way from the start of the interval to the three places.
    ways: Vec<[f64; 3]>,
    /// Rows of the demands at the three places of every interval.
    extra: Option<Rows>,
    /// Highest x at the nodes.
    pub ceiling: Vec<f64>,
    /// Slope of the path acceleration on each interval, 1/s2.
    pub bend: Vec<f64>,
    /// Ceilings in the middle of the intervals.
    middles: Vec<f64>,
    /// By how much the rows of each interval are tightened, >= 1.
    pub tightened: Vec<f64>,
}

impl Problem {
    /// On a grid; intervals that were on the grid `before` as well keep their shape.
    pub fn new(course: &Course, grid: &Grid, bounds: &Bounds, demands: &mut Demands, before: Option<(&Self, &Grid)>) -> Result<Self, PlanError> {
        let (n, joints) = (grid.spans.len(), course.dimension);
        let size = 3 * n * joints;
        let mut problem = Self {
            s: grid.nodes(),
            joints,
            first: Vec::with_capacity(size),
            second: Vec::with_capacity(size),
            ways: Vec::with_capacity(n),
            extra: None,
            ceiling: vec![f64::INFINITY; n + 1],
            bend: vec![0.0; n],
            middles: Vec::new(),
            tightened: vec![1.0; n],
        };
        let (mut shape, mut old) = (Shape::new(joints), 0);
        for span in &grid.spans {
            if let Some((before, grid)) = before {
                old += grid.spans[old..].iter().take_while(|other| other.s[1] <= span.s[0]).count();
                if grid.spans.get(old) == Some(span) {
                    let range = 3 * old * joints..3 * (old + 1) * joints;
                    problem.first.extend_from_slice(&before.first[range.clone()]);
                    problem.second.extend_from_slice(&before.second[range]);
                    problem.ways.push(before.ways[old]);
                    continue;
                }
            }
            let mut rates = [[0.0; 2]; 3];
            for (place, rate) in PLACES.iter().zip(&mut rates) {
                course.shape_in(span, *place, &mut shape);
                problem.first.extend_from_slice(&shape.first);
                problem.second.extend_from_slice(&shape.second);
                *rate = shape.rate;
            }
            problem.ways.push([0.0, Way::new(span, [rates[0], rates[2]]).at(0.5), span.length()]);
        }
        problem.cap(bounds);
        problem.called(demands)?;
        for (x, stop) in problem.ceiling.iter_mut().zip(&grid.stops) {
            *x = if *stop { 0.0 } else { *x };
        }
        Ok(problem)
    }

    /// q' or q'' at place `p` of interval `k`.
    fn shape(values: &[f64], joints: usize, k: usize, p: usize) -> &[f64] {
        &values[(3 * k + p) * joints..(3 * k + p + 1) * joints]
    }

    /// Ceilings of the nodes from the joint speeds at both ends and in the middle of the intervals.
    fn cap(&mut self, bounds: &Bounds) {
        let joints = self.joints;
        let at = |k: usize, p: usize| {
            let q = Self::shape(&self.first, joints, k, p);
            let share = q.iter().zip(&bounds.speed).map(|(q, v)| (q / v) * (q / v)).fold(0.0, f64::max);
            1.0 / share
        };
        for k in 0..self.ways.len() {
            let [x, y] = [at(k, 0), at(k, 2)];
            self.ceiling[k] = self.ceiling[k].min(x);
            self.ceiling[k + 1] = self.ceiling[k + 1].min(y);
        }
        self.middles = (0..self.ways.len()).map(|k| at(k, 1)).collect();
    }

    /// Ceilings of the nodes, lowered at both ends of intervals whose middle does not allow what the ends do.
    pub fn lowered(&self) -> Vec<f64> {
        let top = &self.ceiling;
        let mut out = top.clone();
        for (k, (middle, way)) in self.middles.iter().zip(&self.ways).enumerate() {
            let share = way[1] / way[2];
            let chord = top[k] + (top[k + 1] - top[k]) * share;
            let between = chord - self.bend[k] * way[1] * (way[2] - way[1]);
            if *middle < between && chord > 0.0 {
                let factor = 1.0 - (between - middle) / chord;
                for node in [k, k + 1] {
                    out[node] = out[node].min(top[node] * factor.max(0.1));
                }
            }
        }
        out
    }

    /// Arc lengths of the three places of every interval, the ends a little inside: rows may jump from one interval to the next.
    fn places(&self) -> Vec<f64> {
        let place = |(k, ways): (usize, &[f64; 3])| [ASIDE * ways[2], ways[1], (1.0 - ASIDE) * ways[2]].map(|way| self.s[k] + way);
        self.ways.iter().enumerate().flat_map(place).collect()
    }

    /// Rows and ceilings of the demands.
    fn called(&mut self, demands: &mut Demands) -> Result<(), PlanError> {
        if demands.rows.is_none() && demands.ceiling.is_none() {
            return Ok(());
        }
        let places = self.places();
        if let Some(rows) = &mut demands.rows {
            self.extra = Some(rows(&places)?.checked(places.len())?);
        }
        if let Some(ceiling) = &mut demands.ceiling {
            let x = checked_ceiling(ceiling(&places)?, places.len())?;
            for (k, x) in x.chunks_exact(3).enumerate() {
                self.ceiling[k] = self.ceiling[k].min(x[0]);
                self.ceiling[k + 1] = self.ceiling[k + 1].min(x[2]);
            }
            for (middle, x) in self.middles.iter_mut().zip(x.chunks_exact(3)) {
                *middle = middle.min(x[1]);
            }
        }
        Ok(())
    }

    /// Whether the square root of x occurs.
    pub fn viscous(&self) -> bool {
        self.extra.as_ref().is_some_and(|rows| rows.d.iter().any(|d| *d != 0.0))
    }

    fn extra_count(&self) -> usize {
        self.extra.as_ref().map_or(0, |rows| rows.count)
    }

    /// Number of limits per interval.
    pub fn lines(&self) -> usize {
        3 * (self.joints + self.extra_count())
    }

    /// Which limit line `i` of the strips belongs to: a joint's acceleration, or a demand.
    pub fn owner(&self, line: usize) -> Result<usize, usize> {
        if line < 3 * self.joints { Ok(line % self.joints) } else { self.limit(line / 3) }
    }

    /// What a limit belongs to.
    pub fn limit(&self, limit: usize) -> Result<usize, usize> {
        if limit < self.joints { Ok(limit) } else { Err(limit - self.joints) }
    }

    /// The limits of acceleration on interval `k`: bounds, then coefficients joint by joint at its start, between, at its end.
    fn accelerations(&self, k: usize, bounds: &Bounds, out: &mut Accelerations) {
        let (joints, ways, tight, bend) = (self.joints, self.ways[k], self.tightened[k], self.bend[k]);
        let first = [0, 1, 2].map(|p| Self::shape(&self.first, joints, k, p));
        let second = [0, 1, 2].map(|p| Self::shape(&self.second, joints, k, p));
        out.bounds.iter_mut().chain(out.rows.as_flattened_mut()).for_each(|values| values.resize(joints, 0.0));
        let inverse = 1.0 / tight;
        for (i, ends) in first[0].iter().zip(first[2]).enumerate() {
            [out.bounds[0][i], out.bounds[1][i]] = bounds.acceleration(i, [*ends.0, *ends.1]).map(|v| v * inverse);
        }
        for (p, rows) in out.rows.iter_mut().enumerate() {
            let ([a, b, c], way, first, second) = (rows, ways[p], &first[p][..joints], &second[p][..joints]);
            let (a, b, c) = (&mut a[..joints], &mut b[..joints], &mut c[..joints]);
            for i in 0..joints {
                a[i] = first[i] + 2.0 * way * second[i];
                b[i] = second[i];
                c[i] = bend * way * (first[i] + way * second[i]);
            }
        }
        let [start, middle, end] = &mut out.rows;
        for (start, (middle, end)) in start.iter().zip(middle.iter_mut().zip(end.iter())) {
            for (start, (middle, end)) in start.iter().zip(middle.iter_mut().zip(end)) {
                *middle = 2.0 * *middle - 0.5 * (start + end);
            }
        }
    }

    /// All limits of interval `k`, three for each: at its start, between, at its end.
    pub fn limits(&self, k: usize, bounds: &Bounds, out: &mut Vec<Raw>) {
        let mut own = Accelerations::default();
        self.accelerations(k, bounds, &mut own);
        out.clear();
        for i in 0..self.joints {
            let [low, high] = [0, 1].map(|side| own.bounds[side][i]);
            out.extend(own.rows.iter().map(|[a, b, c]| Raw { a: a[i], b: b[i], c: c[i], low, high, ..Raw::default() }));
        }
        self.demanded(k, out);
    }

    /// Adds the limits of the demands on interval `k`, three for each.
    fn demanded(&self, k: usize, out: &mut Vec<Raw>) {
        let (ways, tight, bend) = (self.ways[k], self.tightened[k], self.bend[k]);
        let Some(extra) = &self.extra else { return };
        for r in 0..extra.count {
            let rows = [0, 1, 2].map(|p| {
                let at = (3 * k + p) * extra.count + r;
                let (a, b, c) = (extra.a[at], extra.b[at], extra.c[at]);
                let [low, high] = shrunk([extra.low[at], extra.high[at]], tight);
                let (way, d) = (ways[p], extra.d.get(at).copied().unwrap_or(0.0));
                Raw { a: a + 2.0 * way * b, b, c: c + bend * way * (a + way * b), d, way, lift: bend * way * way, low, high }
            });
            enclose(rows, out);
        }
    }

    /// How far from every bound a profile stays on interval `k`, as a share of the nearest bound, on average over start, middle and end: an optimum has
    /// something at its bound everywhere.
    pub fn slack(&self, k: usize, bounds: &Bounds, x: &[f64], (own, limits): (&mut Accelerations, &mut Vec<Raw>)) -> f64 {
        let (length, bend) = (self.ways[k][2], self.bend[k]);
        let u = (x[k + 1] - x[k]) / (2.0 * length) - 0.5 * bend * length;
        let at = |way: f64| (x[k] + way * (2.0 * u + bend * way)).max(0.0);
        let tops = [self.ceiling[k], self.middles[k], self.ceiling[k + 1]];
        let mut used = [0, 1, 2].map(|p| if tops[p] > 0.0 { at(self.ways[k][p]) / tops[p] } else { 1.0 });
        let mut note = |[start, control, end]: [f64; 3], bounds: [[f64; 2]; 3]| {
            for (used, (value, [low, high])) in used.iter_mut().zip([start, 0.25 * (start + end) + 0.5 * control, end].into_iter().zip(bounds)) {
                *used = used.max(1.0 + (value - high).max(low - value) / scale([low, high]));
            }
        };
        self.accelerations(k, bounds, own);
        for i in 0..self.joints {
            let value = |[a, b, c]: &[Vec<f64>; 3]| a[i] * u + b[i] * x[k] + c[i];
            note([value(&own.rows[0]), value(&own.rows[1]), value(&own.rows[2])], [[own.bounds[0][i], own.bounds[1][i]]; 3]);
        }
        limits.clear();
        self.demanded(k, limits);
        for rows in limits.as_chunks::<3>().0 {
            let value = |raw: &Raw| raw.a * u + raw.b * x[k] + raw.c + if raw.d == 0.0 { 0.0 } else { raw.d * at(raw.way).sqrt() };
            note([value(&rows[0]), value(&rows[1]), value(&rows[2])], [0, 1, 2].map(|p| [rows[p].low, rows[p].high]));
        }
        (1.0 - (used[0] + 4.0 * used[1] + used[2]) / 6.0).clamp(0.0, 1.0)
    }

    /// The intervals as lines. Square roots of x are replaced by their tangents at the profile `x`, or by the chord from 0 to the ceiling.
    pub fn strips(&self, bounds: &Bounds, x: Option<&[f64]>) -> Strips {
        let mut strips = Strips::new(&self.s, self.lowered(), self.lines());
        let (mut own, mut limits) = (Accelerations::default(), Vec::with_capacity(self.lines()));
        for k in 0..self.ways.len() {
            strips.gain[k] = self.bend[k] * self.ways[k][2] * self.ways[k][2];
            self.accelerations(k, bounds, &mut own);
            (0..3).for_each(|p| strips.set_columns(k, p * self.joints, own.columns(p), 0.0));
            limits.clear();
            self.demanded(k, &mut limits);
            for (i, raw) in limits.iter().enumerate() {
                strips.set(k, 3 * self.joints + i, if raw.d == 0.0 { raw.affine(0.0, 0.0) } else { self.tangent(k, raw, x) });
            }
        }
        strips
    }

    /// A limit with its square root replaced by a line.
    fn tangent(&self, k: usize, raw: &Raw, x: Option<&[f64]>) -> Limit {
        let share = raw.way / self.ways[k][2];
        let at = |v: &[f64]| v[k] + (v[k + 1] - v[k]) * share;
        if let Some(x) = x {
            let root = at(x).max(1e-9 * at(&self.ceiling).min(1e9)).sqrt();
            return raw.affine(0.5 * root, 0.5 / root);
        }
        raw.affine(0.0, 1.0 / at(&self.ceiling).max(f64::MIN_POSITIVE).sqrt())
    }
}

impl Raw {
    /// With the square root of `v = x + 2 way u + lift` replaced by `level + rate v`.
    fn affine(&self, level: f64, rate: f64) -> Limit {
        let b = self.d * rate;
        Limit { a: self.a + 2.0 * self.way * b, b: self.b + b, c: self.c + self.d * level + b * self.lift, low: self.low, high: self.high }
    }
}

/// Adds start, end and, in between, the crossing of the tangents of the parabola through three rows.
fn enclose([start, middle, end]: [Raw; 3], out: &mut Vec<Raw>) {
    let control = |m: f64, s: f64, e: f64| 2.0 * m - 0.5 * (s + e);
    let between = Raw {
        a: control(middle.a, start.a, end.a),
        b: control(middle.b, start.b, end.b),
        c: control(middle.c, start.c, end.c),
        d: control(middle.d, start.d, end.d),
        way: middle.way,
        lift: middle.lift,
        low: if middle.low.is_finite() && start.low.is_finite() && end.low.is_finite() {
            control(middle.low, start.low, end.low)
        } else {
            middle.low
        },
        high: if middle.high.is_finite() && start.high.is_finite() && end.high.is_finite() {
            control(middle.high, start.high, end.high)
        } else {
            middle.high
        },
    };
    out.extend([start, between, end]);
}

/// Bounds moved towards each other; `tight` >= 1 is the share by which the demand exceeded them, counted from their middle.
pub(super) fn shrunk([low, high]: [f64; 2], tight: f64) -> [f64; 2] {
    if tight == 1.0 {
        return [low, high];
    }
    let scale = scale([low, high]);
    [low + (tight - 1.0) * scale, high - (tight - 1.0) * scale]
}

/// What an excess over bounds is measured by: half their distance, or the size of the only one.
pub(super) fn scale([low, high]: [f64; 2]) -> f64 {
    if low.is_finite() && high.is_finite() {
        return (0.5 * (high - low)).max(f64::MIN_POSITIVE);
    }
    let one = if low.is_finite() { low } else { high };
    if one.is_finite() && one != 0.0 { one.abs() } else { 1.0 }
}

/// A ceiling that a callback gave.
pub(super) fn checked_ceiling(x: Vec<f64>, count: usize) -> Result<Vec<f64>, PlanError> {
    if x.len() != count || x.iter().any(|v| v.is_nan() || *v < 0.0) {
        return Err(PlanError::bad("ceiling", format!("{} values", x.len()), format!("{count} values >= 0")));
    }
    Ok(x)
}
