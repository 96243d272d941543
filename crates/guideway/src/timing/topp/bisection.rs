//! The bisection method of \[barnett2021\]: the maximum velocity curve is lowered until the limits can be kept, by bisection on the speed at each node,
//! without integration and without a search for switching points. The source leaves the details open; ours are in docs/methods/topp.md.
//!
//! For a given speed at the start of an interval every limit is a condition on the speed at its end, solved in closed form, the square root of viscous
//! friction included: so nothing is linearised here, and the sets of speeds need not be connected.

use super::limits::Bounds;
use super::problem::{Problem, Raw};
use super::strips::Stuck;

/// Most bisections of a speed: beside a turn it is some 1e-20 of the ceiling.
const HALVINGS: u32 = 200;
/// Places tried where the set of speeds may have gaps.
const SCAN: u32 = 40;
/// Share of the bound by which a limit may be missed by rounding.
const ROUNDING: f64 = 1e-10;

/// Limits of all intervals, and the bound of `x` at the nodes.
struct Search {
    limits: Vec<Raw>,
    width: usize,
    reach: Vec<f64>,
    gain: Vec<f64>,
    gaps: bool,
}

/// The fastest profile below `ceiling` with `ends` at its boundaries.
pub(super) fn fastest(problem: &Problem, ceiling: &[f64], bounds: &Bounds, ends: [f64; 2]) -> Result<Vec<f64>, Stuck> {
    let n = ceiling.len() - 1;
    let (mut limits, mut row) = (Vec::with_capacity(n * problem.lines()), Vec::new());
    for k in 0..n {
        problem.limits(k, bounds, &mut row);
        limits.append(&mut row);
    }
    let reach = problem.s.windows(2).map(|w| 2.0 * (w[1] - w[0])).collect();
    let gain = problem.s.windows(2).zip(&problem.bend).map(|(w, g)| g * (w[1] - w[0]) * (w[1] - w[0])).collect();
    let search = Search { gaps: limits.iter().any(|l| l.d != 0.0 || l.c != 0.0), limits, width: problem.lines(), reach, gain };
    if ends[1] > ceiling[n] {
        return Err(Stuck { node: n, boundary: Some([0.0, ceiling[n]]) });
    }
    let mut top = ceiling.to_vec();
    top[n] = ends[1];
    for k in (0..n).rev() {
        let least = if k + 1 == n { ends[1] } else { 0.0 };
        let next = [least, top[k + 1]];
        top[k] = search.highest(top[k], |x| search.reachable(k, x, next).is_some()).ok_or(Stuck { node: k, boundary: None })?;
    }
    if ends[0] > top[0] * (1.0 + ROUNDING) {
        return Err(Stuck { node: 0, boundary: Some([0.0, top[0]]) });
    }
    search.forward(top, ends)
}

impl Search {
    /// The largest value up to `top` that passes; `None` if none was found.
    fn highest(&self, top: f64, mut passes: impl FnMut(f64) -> bool) -> Option<f64> {
        if passes(top) {
            return Some(top);
        }
        let mut bad = top;
        let mut good = None;
        if self.gaps {
            for i in (0..SCAN).rev() {
                let x = top * f64::from(i) / f64::from(SCAN);
                if passes(x) {
                    good = Some(x);
                    break;
                }
                bad = x;
            }
        } else if passes(0.0) {
            good = Some(0.0);
        }
        let mut good = good?;
        for _ in 0..HALVINGS {
            let middle = 0.5 * (good + bad);
            if middle <= good || middle >= bad {
                break;
            }
            if passes(middle) {
                good = middle;
            } else {
                bad = middle;
            }
        }
        Some(good)
    }

    /// Forward with the largest admissible speed; where there is none, the speed before is lowered and the step repeated.
    fn forward(&self, mut top: Vec<f64>, ends: [f64; 2]) -> Result<Vec<f64>, Stuck> {
        let n = top.len() - 1;
        let mut x = vec![ends[0].min(top[0])];
        let mut repairs = 0;
        while x.len() <= n {
            let k = x.len() - 1;
            let least = if k + 1 == n { ends[1] * (1.0 - ROUNDING) } else { 0.0 };
            if let Some(next) = self.reachable(k, x[k], [least, top[k + 1]]) {
                x.push(next);
                continue;
            }
            repairs += 1;
            if k == 0 || repairs > 20 * n {
                return Err(Stuck { node: k, boundary: None });
            }
            let after = [least, top[k + 1]];
            let below = x[k] * (1.0 - 1e-9);
            top[k] = self.highest(below, |x| self.reachable(k, x, after).is_some()).ok_or(Stuck { node: k, boundary: None })?;
            x.pop();
        }
        Ok(x)
    }

    /// The largest `x` at the end of interval `k` within `next` that the limits admit from `x` at its start.
    fn reachable(&self, k: usize, x: f64, next: [f64; 2]) -> Option<f64> {
        // In `y`, the speed at the end without the given gain.
        let next = next.map(|y| y - self.gain[k]);
        let mut top = next[1];
        let limits = &self.limits[k * self.width..(k + 1) * self.width];
        // Every limit admits at most two intervals; the largest common value is found from above.
        'lower: for _ in 0..4 * self.width {
            for raw in limits {
                match below(raw, self.reach[k], x, top) {
                    Some(value) if value < top => {
                        top = value;
                        if top < next[0] - ROUNDING * (next[0].abs() + x) {
                            return None;
                        }
                        continue 'lower;
                    }
                    Some(_) => {}
                    None => return None,
                }
            }
            return Some((top.max(next[0]) + self.gain[k]).max(0.0));
        }
        None
    }
}

/// The largest `y <= top` for which a limit holds on an interval that leads from `x` to `y`.
fn below(raw: &Raw, reach: f64, x: f64, top: f64) -> Option<f64> {
    let slope = raw.a / reach;
    let size = slope.abs() * (x + top.abs()) + (raw.b * x).abs() + raw.c.abs() + raw.d.abs() * (x + top.abs()).sqrt();
    let slack = 0.1 * ROUNDING * size;
    let [low, high] = [raw.low - slack, raw.high + slack];
    let share = 2.0 * raw.way / reach;
    if raw.d == 0.0 || share == 0.0 {
        let fixed = raw.b * x + raw.c + raw.d * x.sqrt() - slope * x;
        let [low, high] = [low - fixed, high - fixed];
        if slope.abs() * (x + top.abs()) < 1e-13 * size || slope == 0.0 {
            return (low <= slope * x && high >= slope * x).then_some(top);
        }
        let [least, most] = if slope > 0.0 { [low / slope, high / slope] } else { [high / slope, low / slope] };
        let most = most.min(top);
        return (most >= least).then_some(most);
    }
    // In w = sqrt of the value at the place of the row: slope (y - x) + b x + c + d w with y = x + (w^2 - x) / share.
    let (p, q, r) = (slope / share, raw.d, raw.b * x + raw.c - slope * (x + raw.lift) / share);
    let value = |w: f64| (p * w + q) * w + r;
    let at = |y: f64| (x + share * (y - x) + raw.lift).max(0.0).sqrt();
    let w = at(top);
    if value(w) >= low && value(w) <= high {
        return Some(top);
    }
    let w =
        [raw.low, raw.high].into_iter().flat_map(|bound| roots(p, q, r - bound)).filter(|v| *v < w && *v >= 0.0).fold(f64::NEG_INFINITY, f64::max);
    let y = x + (w * w - x - raw.lift) / share;
    // A root is a bound of the set; it belongs to it up to rounding.
    (w >= 0.0 && value(w) >= low && value(w) <= high).then_some(y)
}

/// Real roots of p w^2 + q w + r.
fn roots(p: f64, q: f64, r: f64) -> [f64; 2] {
    if !r.is_finite() {
        return [f64::NAN; 2];
    }
    if p == 0.0 {
        return [-r / q; 2];
    }
    let h = -0.5 * (q + q.signum() * (q * q - 4.0 * p * r).sqrt());
    [h / p, r / h]
}
