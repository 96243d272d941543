//! The intervals of a discretised problem as lines, and the passes over them.
//!
//! On interval k the path acceleration begins with `u` and has a given slope (none on fixed grids), so every limit that is affine in (u, x) anywhere on the
//! interval is a line in the plane of `u` and `x_k`: `low <= u + slope * x_k <= high`. The set of `x_k` from which the rest of the path can be finished is
//! an interval; its ends are linear programs in two variables, solved exactly by Newton's method on the convex, piecewise linear gap between the
//! highest lower line and the lowest upper line.

use super::rows::Rows;

/// Lines are kept in groups of this many for the vector units.
pub(super) const LANES: usize = 4;
/// Share of the size of `u` that counts as rounding.
const ROUNDING: f64 = 1e-12;
/// Share of `x` by which a step beside a bound of `x` keeps off it.
const ASIDE: f64 = 8.0 * f64::EPSILON;
/// Coefficients of `u` below this share of that of `x` times the reach count as none: over an interval `u` then changes the limit by less than 1e-7 of what
/// `x` does, while a line so steep would round to anything.
const STEEP: f64 = 1e-7;
/// Coefficients of `u` below this are none.
const NOTHING: f64 = 1e-140;

/// Limits per interval, bounds of `x` per node.
#[derive(Debug, Clone, Default)]
pub(super) struct Strips {
    width: usize,
    slope: Vec<f64>,
    low: Vec<f64>,
    high: Vec<f64>,
    /// Twice the length of each interval.
    pub reach: Vec<f64>,
    /// What `x` gains over each interval besides `reach * u`: the path acceleration need not be constant.
    pub gain: Vec<f64>,
    /// Whether each interval admits rest: `u = 0` at `x = 0`.
    rests: Vec<bool>,
    /// Lowest `x` at each node.
    pub floor: Vec<f64>,
    /// Highest `x` at each node.
    pub ceiling: Vec<f64>,
}

/// An affine limit `low <= a u + b x + c <= high` in the `u` of an interval and the `x` at its start.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Limit {
    pub a: f64,
    pub b: f64,
    pub c: f64,
    pub low: f64,
    pub high: f64,
}

/// Where the passes find no way on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Stuck {
    /// Node.
    pub node: usize,
    /// Whether the boundary speed, not the limits on the way, stands against it: the interval of `x` that would do.
    pub boundary: Option<[f64; 2]>,
}

impl Strips {
    /// Room for `lines` per interval on nodes at the given arc lengths; no limits yet but `x >= 0` and the ceiling.
    pub fn new(s: &[f64], ceiling: Vec<f64>, lines: usize) -> Self {
        let width = lines.next_multiple_of(LANES);
        let count = width * (s.len() - 1);
        Self {
            width,
            slope: vec![0.0; count],
            low: vec![f64::NEG_INFINITY; count],
            high: vec![f64::INFINITY; count],
            reach: s.windows(2).map(|w| 2.0 * (w[1] - w[0])).collect(),
            gain: vec![0.0; s.len() - 1],
            rests: vec![true; s.len() - 1],
            floor: vec![0.0; s.len()],
            ceiling,
        }
    }

    /// Sets line `i` of interval `k`.
    pub fn set(&mut self, k: usize, i: usize, limit: Limit) {
        let Limit { a, b, c, low, high } = limit;
        let at = k * self.width + i;
        if a.abs() < self.least(k, b) {
            (self.slope[at], self.low[at], self.high[at]) = (0.0, f64::NEG_INFINITY, f64::INFINITY);
            return self.bound(k, b, low - c, high - c);
        }
        let inverse = 1.0 / a;
        let (p, q) = ((low - c) * inverse, (high - c) * inverse);
        self.slope[at] = b * inverse;
        (self.low[at], self.high[at]) = if a > 0.0 { (p, q) } else { (q, p) };
        self.rests[k] &= self.low[at] <= 0.0 && self.high[at] >= 0.0;
    }

    /// Coefficients of `u` below this leave a bound of `x` alone, where that of `x` is `b`.
    #[inline]
    fn least(&self, k: usize, b: f64) -> f64 {
        (STEEP * self.reach[k] * b.abs()).max(NOTHING)
    }

    /// Bounds `x` at a node by `low <= b x <= high`.
    fn bound(&mut self, k: usize, b: f64, low: f64, high: f64) {
        if b.abs() < NOTHING {
            if low > 0.0 || high < 0.0 {
                self.ceiling[k] = f64::NEG_INFINITY;
            }
            return;
        }
        let (p, q) = if b > 0.0 { (low / b, high / b) } else { (high / b, low / b) };
        self.floor[k] = self.floor[k].max(p);
        self.ceiling[k] = self.ceiling[k].min(q);
    }

    /// All lines of an interval at once from rows at its two ends; `end` counts at the far one.
    pub fn set_ends(&mut self, k: usize, [start, end]: [Columns; 2]) {
        self.rests[k] = true;
        self.set_columns(k, 0, start, 0.0);
        self.set_columns(k, start.a.len(), end, self.reach[k]);
    }

    /// The lines of interval `k` from `first` on, rows read after the way `far / 2`.
    pub fn set_columns(&mut self, k: usize, first: usize, columns: Columns, far: f64) {
        let Columns { a, b, c, bottom, top } = columns;
        let (rows, offset, steep) = (a.len(), k * self.width + first, STEEP * self.reach[k]);
        let slope = &mut self.slope[offset..offset + rows];
        let low = &mut self.low[offset..offset + rows];
        let high = &mut self.high[offset..offset + rows];
        let (b, c, bottom, top) = (&b[..rows], &c[..rows], &bottom[..rows], &top[..rows]);
        let (mut regular, mut rests) = (true, true);
        for i in 0..rows {
            let by = a[i] + far * b[i];
            regular &= by.abs() >= (steep * b[i].abs()).max(NOTHING);
            let inverse = 1.0 / by;
            let (p, q) = ((bottom[i] - c[i]) * inverse, (top[i] - c[i]) * inverse);
            slope[i] = b[i] * inverse;
            (low[i], high[i]) = (if p < q { p } else { q }, if p < q { q } else { p });
            rests &= low[i] <= 0.0 && high[i] >= 0.0;
        }
        if regular {
            self.rests[k] &= rests;
            return;
        }
        for i in 0..rows {
            self.set(k, first + i, Limit { a: a[i] + far * b[i], b: b[i], c: c[i], low: bottom[i], high: top[i] });
        }
    }

    /// All intervals from rows at the nodes, kept at both ends of each.
    pub fn fill(&mut self, rows: &Rows) {
        for k in 0..self.reach.len() {
            self.set_ends(k, [rows.at(k), rows.at(k + 1)]);
        }
    }

    /// As [`Strips::fill`] once more, from other rows.
    pub fn refill(&mut self, ceiling: &[f64], rows: &Rows) {
        self.floor.fill(0.0);
        self.ceiling.copy_from_slice(ceiling);
        self.fill(rows);
    }

    fn lines(&self, k: usize) -> [&[[f64; LANES]]; 3] {
        let range = k * self.width..(k + 1) * self.width;
        [&self.slope[range.clone()], &self.low[range.clone()], &self.high[range]].map(|v| v.as_chunks().0)
    }

    /// Highest lower and lowest upper line of interval `k` at `x`.
    fn bounds(&self, k: usize, x: f64) -> [f64; 2] {
        let [slope, low, high] = self.lines(k);
        let (mut bottom, mut top) = ([f64::NEG_INFINITY; LANES], [f64::INFINITY; LANES]);
        for ((slope, low), high) in slope.iter().zip(low).zip(high) {
            for i in 0..LANES {
                let shift = slope[i] * x;
                let (l, h) = (low[i] - shift, high[i] - shift);
                bottom[i] = if l > bottom[i] { l } else { bottom[i] };
                top[i] = if h < top[i] { h } else { top[i] };
            }
        }
        [bottom.into_iter().fold(f64::NEG_INFINITY, f64::max), top.into_iter().fold(f64::INFINITY, f64::min)]
    }

    /// Lowest upper line of interval `k` at `x`.
    fn upper(&self, k: usize, x: f64) -> f64 {
        let [slope, _, high] = self.lines(k);
        let mut top = [f64::INFINITY; LANES];
        for (slope, high) in slope.iter().zip(high) {
            for i in 0..LANES {
                let h = high[i] - slope[i] * x;
                top[i] = if h < top[i] { h } else { top[i] };
            }
        }
        top.into_iter().fold(f64::INFINITY, f64::min)
    }

    /// Slopes of the lines of interval `k` that take the given bounds at `x`.
    fn slopes(&self, k: usize, x: f64, bounds: [f64; 2]) -> [f64; 2] {
        let [slope, low, high] = self.lines(k);
        let mut found = [0.0; 2];
        for ((slope, low), high) in slope.iter().zip(low).zip(high) {
            for i in 0..LANES {
                let shift = slope[i] * x;
                found[0] = if low[i] - shift >= bounds[0] { slope[i] } else { found[0] };
                found[1] = if high[i] - shift <= bounds[1] { slope[i] } else { found[1] };
            }
        }
        found
    }

    /// Bounds of `u` on interval `k` when it starts at `x`, by its lines alone.
    pub fn accelerations(&self, k: usize, x: f64) -> [f64; 2] {
        self.bounds(k, x)
    }

    /// Which line bounds `u` on interval `k` at `x` from below and from above.
    pub fn active(&self, k: usize, x: f64) -> [usize; 2] {
        let lines = k * self.width..(k + 1) * self.width;
        let low = lines.clone().max_by(|i, j| (self.low[*i] - self.slope[*i] * x).total_cmp(&(self.low[*j] - self.slope[*j] * x)));
        let high = lines.min_by(|i, j| (self.high[*i] - self.slope[*i] * x).total_cmp(&(self.high[*j] - self.slope[*j] * x)));
        [low, high].map(|i| i.unwrap_or(0) % self.width.max(1))
    }

    /// The largest `x` at the start of interval `k` with an admissible `u`, whatever comes after.
    pub fn highest(&self, k: usize) -> Option<f64> {
        let any = [f64::NEG_INFINITY, f64::INFINITY];
        self.edge(k, any, [self.floor[k], self.ceiling[k]], true)
    }

    /// Largest (`upper`) or smallest `x` in `range` at the start of interval `k` from which an `x` in `next` is reached.
    fn edge(&self, k: usize, next: [f64; 2], range: [f64; 2], upper: bool) -> Option<f64> {
        let slope = 1.0 / self.reach[k];
        let target = next.map(|x| (x - self.gain[k]) * slope);
        let [first, last] = if upper { [range[1], range[0]] } else { range };
        let mut x = first;
        for _ in 0..100 {
            let lines = self.bounds(k, x);
            let next = target.map(|t| t - slope * x);
            let [low, high] = [lines[0].max(next[0]), lines[1].min(next[1])];
            let gap = low - high;
            if gap <= ROUNDING * (low.abs() + high.abs()).min(f64::MAX) {
                return Some(x);
            }
            let slopes = self.slopes(k, x, lines);
            let low_slope = if next[0] > lines[0] { slope } else { slopes[0] };
            let rate = if next[1] < lines[1] { slope } else { slopes[1] } - low_slope;
            let mut step = x - gap / rate;
            if upper && step < 0.5 * x {
                // A long step rounds to the size of where it began; the next one must still come from above.
                step += 4.0 * f64::EPSILON * x;
            }
            if step == x {
                // A line so steep that it bounds x alone rounds to anything beside its own bound: it does not count a little further on.
                step *= if upper { 1.0 - ASIDE } else { 1.0 + ASIDE };
            }
            // The gap is convex: where it does not fall towards the other end, there is nothing; where the step ends beyond, nothing either. From below it is
            // known that there is something, so there only rounding is left.
            let falls = if upper { rate > 0.0 } else { rate < 0.0 };
            let inside = if upper { step >= last } else { step <= last };
            if !falls && !upper {
                return Some(x);
            }
            if !falls || x == last {
                return None;
            }
            x = if inside { step } else { last };
        }
        Some(x)
    }

    /// The intervals of `x` at every node from which the path can be finished at `end`.
    pub fn controllable(&self, end: f64) -> Result<Vec<[f64; 2]>, Stuck> {
        let n = self.reach.len();
        if !(end >= self.floor[n] && end <= self.ceiling[n] * (1.0 + ROUNDING)) {
            return Err(Stuck { node: n, boundary: Some([self.floor[n], self.ceiling[n]]) });
        }
        let mut sets = vec![[end; 2]; n + 1];
        for k in (0..n).rev() {
            let range = [self.floor[k], self.ceiling[k]];
            let found = if range[0] <= range[1] { self.edge(k, sets[k + 1], range, true) } else { None };
            let high = found.ok_or(Stuck { node: k, boundary: None })?;
            let rest = range[0] == 0.0 && self.rests[k] && sets[k + 1][0] <= self.gain[k] && self.gain[k] <= sets[k + 1][1];
            let low = if rest { 0.0 } else { self.edge(k, sets[k + 1], [range[0], high], false).unwrap_or(high) };
            sets[k] = [low, high];
        }
        Ok(sets)
    }

    /// The fastest `x` at every node, from `ends[0]` to `ends[1]`.
    pub fn fastest(&self, ends: [f64; 2]) -> Result<Vec<f64>, Stuck> {
        let sets = self.controllable(ends[1])?;
        let [low, high] = sets[0];
        if !(ends[0] >= low * (1.0 - ROUNDING) && ends[0] <= high * (1.0 + ROUNDING)) {
            return Err(Stuck { node: 0, boundary: Some([low, high]) });
        }
        let mut x = Vec::with_capacity(sets.len());
        let mut here = ends[0].clamp(low, high);
        x.push(here);
        for (k, next) in sets[1..].iter().enumerate() {
            let u = self.upper(k, here);
            here = (here + self.reach[k] * u + self.gain[k]).min(next[1]).max(next[0]);
            x.push(here);
        }
        Ok(x)
    }
}

/// Rows of one place: `bottom <= a u + b x + c <= top`.
#[derive(Debug, Clone, Copy)]
pub(super) struct Columns<'a> {
    pub a: &'a [f64],
    pub b: &'a [f64],
    pub c: &'a [f64],
    pub bottom: &'a [f64],
    pub top: &'a [f64],
}
