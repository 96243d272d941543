//! The kernel: the fastest profile on a fixed grid with limits at the grid points.

use super::rows::Rows;
use super::strips::{Strips, Stuck};
use crate::error::PlanError;

/// Change of x, as a share, below which tangents to its square root are taken as they are: they are then wrong by less than its square.
pub(super) const SETTLED: f64 = 1e-5;
/// A first guess is solved for on every so many points, where so many remain.
const COARSER: usize = 8;
const LEAST: usize = 16;

/// The fastest squared path speed at the points `s` (increasing) under `ceiling` and `rows` at the points, the path acceleration being constant between
/// them and the rows kept at both ends of every interval; `ends`: squared path speeds at both ends. Rows with `d` are linearised at the solution, repeatedly.
/// # Errors
/// [`PlanError::BadParameter`] for arrays that do not fit, [`PlanError::Infeasible`] with the place.
pub fn kernel(s: &[f64], ceiling: &[f64], rows: &Rows, ends: [f64; 2]) -> Result<Vec<f64>, PlanError> {
    if s.len() < 2 || !s.windows(2).all(|w| w[0] < w[1]) || !s.iter().all(|v| v.is_finite()) {
        return Err(PlanError::bad("s", format!("{} values", s.len()), "at least two finite, increasing arc lengths"));
    }
    if ceiling.len() != s.len() || !ceiling.iter().all(|x| *x >= 0.0 && *x < f64::INFINITY) {
        return Err(PlanError::bad("x_max", format!("{} values", ceiling.len()), format!("{} finite values >= 0", s.len())));
    }
    let infeasible = |stuck: Stuck| {
        let reason = match stuck.boundary {
            Some([low, high]) => format!("the squared path speed at point {} can be {low} to {high}", stuck.node),
            None => format!("the rows leave no path acceleration at point {}", stuck.node),
        };
        PlanError::Infeasible { reason, best_end_speed: None }
    };
    if rows.d.iter().all(|d| *d == 0.0) {
        let mut strips = Strips::new(s, ceiling.to_vec(), 2 * rows.count);
        strips.fill(rows);
        return strips.fastest(ends).map_err(infeasible);
    }
    // What a coarse grid lets hope for may have no motion on the fine one.
    let guess = guess(s, ceiling, rows, ends);
    let found = if guess.is_some() { settle(s, ceiling, rows, ends, guess) } else { Err(Stuck { node: 0, boundary: None }) };
    found.or_else(|_| settle(s, ceiling, rows, ends, None)).map_err(infeasible)
}

/// The fastest profile on every so many points, and lines between them.
fn guess(s: &[f64], ceiling: &[f64], rows: &Rows, ends: [f64; 2]) -> Option<Vec<f64>> {
    let last = s.len() - 1;
    if last < LEAST * COARSER {
        return None;
    }
    let kept: Vec<usize> = (0..last).step_by(COARSER).chain([last]).collect();
    let pick = |values: &[f64]| kept.iter().map(|k| values[*k]).collect::<Vec<_>>();
    let few = settle(&pick(s), &pick(ceiling), &rows.only(&kept), ends, None).ok()?;
    let mut x = Vec::with_capacity(s.len());
    for (pair, ends) in kept.windows(2).zip(few.windows(2)) {
        let [a, b] = [s[pair[0]], s[pair[1]]];
        x.extend(s[pair[0]..pair[1]].iter().map(|s| ends[0] + (ends[1] - ends[0]) * (s - a) / (b - a)));
    }
    x.push(few[few.len() - 1]);
    Some(x)
}

/// The fastest profile by tangents to the square root of x: the first at `x`, or else the chord from rest to the ceiling, which is right at rest.
pub(super) fn settle(s: &[f64], ceiling: &[f64], rows: &Rows, ends: [f64; 2], mut x: Option<Vec<f64>>) -> Result<Vec<f64>, Stuck> {
    let mut strips = Strips::new(s, ceiling.to_vec(), 2 * rows.count);
    let mut linear = Rows { d: Vec::new(), ..rows.clone() };
    let least = f64::MIN_POSITIVE;
    for _ in 0..30 {
        for (k, top) in ceiling.iter().enumerate() {
            let [level, rate] = match &x {
                None => [0.0, 1.0 / top.max(least).sqrt()],
                Some(x) => {
                    let root = x[k].max(1e-9 * top).max(least).sqrt();
                    [0.5 * root, 0.5 / root]
                }
            };
            let of = k * rows.count..(k + 1) * rows.count;
            for (((d, b), c), (to_b, to_c)) in rows.d[of.clone()]
                .iter()
                .zip(&rows.b[of.clone()])
                .zip(&rows.c[of.clone()])
                .zip(linear.b[of.clone()].iter_mut().zip(&mut linear.c[of]))
            {
                (*to_b, *to_c) = (b + d * rate, c + d * level);
            }
        }
        strips.refill(ceiling, &linear);
        let next = strips.fastest(ends)?;
        let change = |x: &Vec<f64>| next.iter().zip(x).map(|(a, b)| (a - b).abs() / (a + b + least)).fold(0.0, f64::max);
        let settled = x.as_ref().is_some_and(|x| change(x) < SETTLED);
        x = Some(next);
        if settled {
            break;
        }
    }
    Ok(x.unwrap_or_default())
}
