//! The kernel: the fastest profile on a fixed grid with limits at the grid points.

use super::rows::Rows;
use super::strips::{Strips, Stuck};
use crate::error::PlanError;

/// Change of x, as a share, below which tangents to its square root are taken as they are: they are then wrong by its square.
pub(super) const SETTLED: f64 = 1e-6;

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
    let mut strips = Strips::new(s, ceiling.to_vec(), 2 * rows.count);
    if rows.d.iter().all(|d| *d == 0.0) {
        strips.fill(rows);
        return strips.fastest(ends).map_err(infeasible);
    }
    // First the chord from rest to the ceiling, which is right at rest, then tangents.
    let mut x: Option<Vec<f64>> = None;
    let mut linear = Rows { d: Vec::new(), ..rows.clone() };
    for _ in 0..30 {
        for (i, d) in rows.d.iter().enumerate() {
            let (k, least) = (i / rows.count, f64::MIN_POSITIVE);
            let [level, rate] = match &x {
                None => [0.0, 1.0 / ceiling[k].max(least).sqrt()],
                Some(x) => {
                    let root = x[k].max(1e-9 * ceiling[k]).max(least).sqrt();
                    [0.5 * root, 0.5 / root]
                }
            };
            linear.b[i] = rows.b[i] + d * rate;
            linear.c[i] = rows.c[i] + d * level;
        }
        strips = Strips::new(s, ceiling.to_vec(), 2 * rows.count);
        strips.fill(&linear);
        let next = strips.fastest(ends).map_err(infeasible)?;
        let change = |x: &Vec<f64>| next.iter().zip(x).map(|(a, b)| (a - b).abs() / (a + b + f64::MIN_POSITIVE)).fold(0.0, f64::max);
        let settled = x.as_ref().is_some_and(|x| change(x) < SETTLED);
        x = Some(next);
        if settled {
            break;
        }
    }
    Ok(x.unwrap_or_default())
}
