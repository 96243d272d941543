//! The last steps downhill: quasi-Newton (BFGS) on the objective from a candidate that a population found.
//!
//! Source: BFGS with differences for gradients and an Armijo search, \[nocedal2006\], chapters 6 and 8; on functions with kinks it still descends
//! \[lewis2013\]. Constraints count as an exact penalty; only candidates of the box are judged, and the best feasible one is kept, so the result is as free
//! as any candidate.

use crate::context::{Context, Stop};
use crate::error::PlanError;
use crate::optimize::{Cost, Objective, evaluate};

/// Weight of the violation in the descent.
const PENALTY: f64 = 10.0;
/// Differences for gradients, share of a side of the box.
const DIFFERENCE: f64 = 1e-6;
/// Fresh starts of the model where it leads no further, each with a shorter first step.
const FRESH: u32 = 2;
/// Factor of the first step then.
const SHORTER: f64 = 0.2;
/// Steps are halved no more often than that.
const HALVINGS: u32 = 12;
/// Share of the promised decrease that a step must bring.
const ARMIJO: f64 = 1e-4;
/// First step, share of the mean side of the box.
const FIRST: f64 = 0.005;

/// A candidate and its cost.
#[derive(Debug, Clone)]
pub(super) struct Candidate {
    pub x: Vec<f64>,
    pub cost: Cost,
}

impl Candidate {
    fn merit(&self) -> f64 {
        merit(self.cost)
    }
}

fn merit(cost: Cost) -> f64 {
    if cost.value.is_finite() && cost.violation.is_finite() { cost.value + PENALTY * cost.violation } else { f64::INFINITY }
}

/// Descends from a candidate by up to `steps` steps; the best candidate seen (feasible before cheap), and why it stopped early if the budget did.
pub(super) fn polish(f: &dyn Objective, from: Candidate, steps: u64, ctx: &mut Context) -> Result<(Candidate, Option<Stop>), PlanError> {
    let n = from.x.len();
    let mut best = from.clone();
    let mut at = from;
    let mut slope = gradient(f, &at, ctx)?;
    let mut model = Model::new(n, f.bounds());
    let mut resets = 0;
    for _ in 0..steps {
        if let Some(stop) = ctx.tick(f.shown(best.cost)) {
            return Ok((best, Some(stop)));
        }
        let way = model.downhill(&at.x, &slope, f.bounds());
        let Some(next) = search(f, &at, (&way, &slope), &mut best, ctx)? else {
            resets += 1;
            if resets > FRESH {
                break;
            }
            model.first *= SHORTER;
            model.reset();
            continue;
        };
        let new_slope = gradient(f, &next, ctx)?;
        model.learn(&at.x, &next.x, &slope, &new_slope);
        (at, slope) = (next, new_slope);
    }
    Ok((best, None))
}

/// Gradient of the merit by one-sided differences that stay in the box.
fn gradient(f: &dyn Objective, at: &Candidate, ctx: &mut Context) -> Result<Vec<f64>, PlanError> {
    let steps: Vec<f64> =
        at.x.iter()
            .zip(f.bounds())
            .map(|(x, b)| {
                let h = DIFFERENCE * (b.1 - b.0);
                if x + h > b.1 { -h } else { h }
            })
            .collect();
    let shifted = |k: usize| {
        let mut x = at.x.clone();
        x[k] += steps[k];
        x
    };
    let xs: Vec<Vec<f64>> = (0..at.x.len()).map(shifted).collect();
    let costs = evaluate(f, &xs, ctx)?;
    let here = at.merit();
    Ok(costs.iter().zip(&steps).map(|(c, h)| (merit(*c) - here) / h).map(|g| if g.is_finite() { g } else { 0.0 }).collect())
}

/// Goes along `way` as far as brings a fair part of what the slope promises: the next candidate, if there is one.
fn search(
    f: &dyn Objective,
    at: &Candidate,
    (way, slope): (&[f64], &[f64]),
    best: &mut Candidate,
    ctx: &mut Context,
) -> Result<Option<Candidate>, PlanError> {
    let mut step = 1.0;
    for _ in 0..HALVINGS {
        let x: Vec<f64> = at.x.iter().zip(way).zip(f.bounds()).map(|((x, d), b)| (x + step * d).clamp(b.0, b.1)).collect();
        let promised: f64 = x.iter().zip(&at.x).zip(slope).map(|((y, x), g)| (y - x) * g).sum();
        if promised >= 0.0 {
            return Ok(None);
        }
        let cost = evaluate(f, std::slice::from_ref(&x), ctx)?[0];
        let next = Candidate { x, cost };
        if next.cost.beats(best.cost) {
            *best = next.clone();
        }
        if next.merit() <= at.merit() + ARMIJO * promised {
            return Ok(Some(next));
        }
        step *= 0.4;
    }
    Ok(None)
}

/// The inverse of the curvature as it was seen on the way.
struct Model {
    inverse: Vec<f64>,
    n: usize,
    first: f64,
    fresh: bool,
}

impl Model {
    fn new(n: usize, bounds: &[(f64, f64)]) -> Self {
        let first = FIRST * bounds.iter().map(|b| b.1 - b.0).sum::<f64>() / n.max(1) as f64;
        let mut model = Self { inverse: Vec::new(), n, first, fresh: true };
        model.reset();
        model
    }

    fn reset(&mut self) {
        self.inverse = vec![0.0; self.n * self.n];
        for i in 0..self.n {
            self.inverse[i * self.n + i] = 1.0;
        }
        self.fresh = true;
    }

    /// Direction downhill; numbers at the edge of the box that would leave it stay.
    fn downhill(&self, x: &[f64], slope: &[f64], bounds: &[(f64, f64)]) -> Vec<f64> {
        let held = |k: usize| x[k] <= bounds[k].0 && slope[k] > 0.0 || x[k] >= bounds[k].1 && slope[k] < 0.0;
        let free: Vec<f64> = (0..self.n).map(|k| if held(k) { 0.0 } else { slope[k] }).collect();
        let row = |i: usize| -(0..self.n).map(|j| self.inverse[i * self.n + j] * free[j]).sum::<f64>();
        let mut way: Vec<f64> = (0..self.n).map(|i| if held(i) { 0.0 } else { row(i) }).collect();
        if self.fresh {
            let size = way.iter().map(|v| v * v).sum::<f64>().sqrt().max(1e-300);
            for v in &mut way {
                *v *= self.first / size;
            }
        }
        way
    }

    /// Takes a step and the change of the slope along it into account.
    fn learn(&mut self, from: &[f64], to: &[f64], before: &[f64], after: &[f64]) {
        let n = self.n;
        let s: Vec<f64> = to.iter().zip(from).map(|(a, b)| a - b).collect();
        let y: Vec<f64> = after.iter().zip(before).map(|(a, b)| a - b).collect();
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(x, y)| x * y).sum::<f64>();
        let (sy, yy) = (dot(&s, &y), dot(&y, &y));
        if sy <= 1e-10 * (dot(&s, &s) * yy).sqrt() {
            return;
        }
        if self.fresh {
            self.reset();
            for v in &mut self.inverse {
                *v *= sy / yy;
            }
            self.fresh = false;
        }
        let hy: Vec<f64> = (0..n).map(|i| dot(&self.inverse[i * n..(i + 1) * n], &y)).collect();
        let scale = (1.0 + dot(&y, &hy) / sy) / sy;
        for i in 0..n {
            for j in 0..n {
                self.inverse[i * n + j] += scale * s[i] * s[j] - (hy[i] * s[j] + s[i] * hy[j]) / sy;
            }
        }
    }
}
