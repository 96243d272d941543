//! Optimizers: they minimise a function of real numbers inside a box and know nothing of maps.
//!
//! An optimizer is a plain struct of parameters; it owns its loop: draw, [`evaluate`], keep, tick. All are generational: a batch is judged before it replaces,
//! and random draws are serial, so the result depends on the seed alone, not on the number of threads.

mod breed;
mod cma_es;
mod de;
mod distribution;
mod draw;
mod eigen;
mod firefly;
mod flock;
pub mod functions;
mod grouped_pso;
mod improved_de;
mod l_shade;
mod pso;
mod record;
mod registry;
mod schedule;
mod sparrow;

pub use cma_es::{CmaEs, Restarts};
pub use de::De;
pub use firefly::Firefly;
pub use grouped_pso::GroupedPso;
pub use improved_de::{Form, ImprovedDe, Opposition, Renewal, decay};
pub use l_shade::LShade;
pub use pso::Pso;
pub use registry::{Entry, Parameter, REGISTRY, optimizer};
pub use sparrow::Sparrow;

use crate::context::{Context, Stop};
use crate::error::PlanError;
use rayon::prelude::*;
use std::cmp::Ordering;

/// What a candidate costs; less is better. Ordered by violation (feasible first), then value, then tie.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cost {
    /// How far constraints are broken, any unit, 0 if they hold.
    pub violation: f64,
    /// What is minimised, unit of the objective.
    pub value: f64,
    /// What decides between equal values, e.g. turns.
    pub tie: f64,
}

impl Cost {
    /// Worse than every candidate that was costed.
    pub const WORST: Self = Self { violation: f64::INFINITY, value: f64::INFINITY, tie: f64::INFINITY };

    /// A feasible candidate of that value.
    pub fn of(value: f64) -> Self {
        Self { violation: 0.0, value, tie: 0.0 }
    }

    /// Do all constraints hold?
    pub fn feasible(self) -> bool {
        self.violation == 0.0
    }

    /// Feasible first, then value, then tie.
    pub fn order(self, other: Self) -> Ordering {
        self.violation.total_cmp(&other.violation).then(self.value.total_cmp(&other.value)).then(self.tie.total_cmp(&other.tie))
    }

    /// Is it better than the other?
    pub fn beats(self, other: Self) -> bool {
        self.order(other) == Ordering::Less
    }

    fn valid(self) -> bool {
        self.violation >= 0.0 && [self.violation, self.value, self.tie].iter().all(|v| v.is_finite())
    }
}

/// What is minimised: a function of `D` numbers inside a box.
pub trait Objective: Sync {
    /// Smallest and largest value of each of the `D` numbers.
    fn bounds(&self) -> &[(f64, f64)];

    /// Costs of a batch, one per candidate of `D` numbers. The cost of a candidate depends on nothing but the candidate: batches are cut in pieces.
    /// # Errors
    /// Whatever stops the run. [`PlanError::Cancelled`] ends it as an observer does: the best so far is the result.
    fn costs(&self, xs: &[Vec<f64>]) -> Result<Vec<Cost>, PlanError>;

    /// Known good candidates that the first population shall hold: seeds, a previous population.
    fn hints(&self) -> &[Vec<f64>] {
        &[]
    }

    /// About how long one candidate takes, us; 0 to have whole batches costed by one call of [`Objective::costs`]. Decides what is worth a second thread
    /// and how often clock and observer are asked, never a result.
    fn effort(&self) -> f64 {
        1.0
    }

    /// What observers are shown of a cost.
    fn shown(&self, cost: Cost) -> f64 {
        if cost.feasible() { cost.value } else { f64::INFINITY }
    }
}

/// What an optimizer found.
#[derive(Debug, Clone, PartialEq)]
pub struct Minimum {
    /// The best candidate; empty if none was costed.
    pub best: Vec<f64>,
    /// Its cost; [`Cost::WORST`] if none was costed.
    pub cost: Cost,
    /// The last population.
    pub population: Vec<Vec<f64>>,
    /// Its costs, in the same order.
    pub costs: Vec<Cost>,
    /// (iteration, best cost) at each improvement; iteration 0 is the first population.
    pub history: Vec<(u64, Cost)>,
    /// Iterations done after the first population.
    pub iterations: u64,
    /// Candidates costed.
    pub evaluations: u64,
    /// Why it stopped.
    pub stop: Stop,
}

/// Minimises an objective. All state is local to the call.
pub trait Optimizer: Send + Sync {
    /// Runs until its own rule, the budget or the observer stops it; the budget counts in evaluations are never overshot.
    /// # Errors
    /// [`PlanError::BadParameter`] for parameters or bounds that cannot be, those of [`Objective::costs`].
    fn minimize(&self, f: &dyn Objective, ctx: &mut Context) -> Result<Minimum, PlanError>;
}

/// Batches shorter than that are not worth a second thread, us.
const WORTH: f64 = 150.0;
/// Clock and observer are asked about that often, us.
const ASK: f64 = 3000.0;

/// Costs a batch: the only place where candidates are costed and counted. What is left when the evaluations or the time are spent, or the caller cancels, is
/// not costed but [`Cost::WORST`]; the next [`Context::tick`] then says why.
/// # Errors
/// Those of the objective; [`PlanError::BadParameter`] if it gives too few costs, or costs that are not finite or have a negative violation.
pub fn evaluate(f: &dyn Objective, xs: &[Vec<f64>], ctx: &mut Context) -> Result<Vec<Cost>, PlanError> {
    let left = ctx.budget().evaluations.map_or(u64::MAX, |n| n.saturating_sub(ctx.evaluations()));
    let count = left.min(xs.len() as u64) as usize;
    let threads = if f.effort() * count as f64 > WORTH { ctx.threads() } else { 1 };
    let piece = ((ASK / f.effort()) as usize).clamp(1, xs.len().max(1)).saturating_mul(threads);
    let mut costs = Vec::with_capacity(xs.len());
    for part in xs[..count].chunks(piece) {
        if ctx.poll().is_some() {
            break;
        }
        match piecewise(f, part, threads) {
            Ok(some) => costs.extend(some),
            Err(PlanError::Cancelled) => {
                ctx.cancel();
                break;
            }
            Err(error) => return Err(error),
        }
        ctx.count_evaluations(part.len() as u64);
    }
    costs.resize(xs.len(), Cost::WORST);
    Ok(costs)
}

/// Costs of candidates, in as many pieces as threads: no more of them run at once.
fn piecewise(f: &dyn Objective, xs: &[Vec<f64>], threads: usize) -> Result<Vec<Cost>, PlanError> {
    if threads == 1 {
        return checked(f, xs);
    }
    let parts: Vec<_> = xs.par_chunks(xs.len().div_ceil(threads)).map(|some| checked(f, some)).collect();
    parts.into_iter().collect::<Result<Vec<_>, _>>().map(|some| some.concat())
}

fn checked(f: &dyn Objective, xs: &[Vec<f64>]) -> Result<Vec<Cost>, PlanError> {
    let costs = f.costs(xs)?;
    if costs.len() != xs.len() {
        return Err(PlanError::bad("costs of the objective", costs.len(), format!("one for each of {} candidates", xs.len())));
    }
    match costs.iter().find(|c| !c.valid()) {
        None => Ok(costs),
        Some(bad) => {
            let value = format!("value {}, violation {}, tie {}", bad.value, bad.violation, bad.tie);
            Err(PlanError::bad("cost of the objective", value, "finite numbers, no negative violation"))
        }
    }
}

#[cfg(test)]
mod tests;
