//! The kernel: the fastest profile on a fixed grid with limits at the grid points.

use super::rows::Rows;
use super::strips::{Strips, Stuck};
use crate::error::PlanError;

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
    let mut x: Vec<f64> = ceiling.iter().map(|x| 0.25 * x).collect();
    let mut linear = Rows { d: Vec::new(), ..rows.clone() };
    for _ in 0..30 {
        for (i, d) in rows.d.iter().enumerate() {
            let k = i / rows.count;
            let root = x[k].max(1e-9 * ceiling[k]).max(f64::MIN_POSITIVE).sqrt();
            linear.b[i] = rows.b[i] + 0.5 * d / root;
            linear.c[i] = rows.c[i] + 0.5 * d * root;
        }
        strips = Strips::new(s, ceiling.to_vec(), 2 * rows.count);
        strips.fill(&linear);
        let next = strips.fastest(ends).map_err(infeasible)?;
        let change = next.iter().zip(&x).map(|(a, b)| (a - b).abs() / (a + b + f64::MIN_POSITIVE)).fold(0.0, f64::max);
        x = next;
        if change < 1e-10 {
            break;
        }
    }
    Ok(x)
}
