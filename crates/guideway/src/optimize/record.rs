//! What every optimizer's loop keeps: the best so far, its history, and when to stop.

use super::{Cost, Minimum, Objective};
use crate::context::{Context, Stop};
use crate::error::PlanError;
use rand::RngExt;

/// Most numbers that a population may hold.
const MOST: usize = 100_000_000;

/// The best so far and how it came.
pub(super) struct Record {
    pub best: Vec<f64>,
    pub cost: Cost,
    history: Vec<(u64, Cost)>,
    iterations: u64,
    improved: u64,
    before: u64,
    limits: [u64; 2],
}

impl Record {
    /// Stops after `most` iterations, or once the best has been the same for `patience` of them (0: never).
    pub fn new(most: u64, patience: u64, ctx: &Context) -> Self {
        let limits = [most, if patience == 0 { u64::MAX } else { patience }];
        Self { best: Vec::new(), cost: Cost::WORST, history: Vec::new(), iterations: 0, improved: 0, before: ctx.evaluations(), limits }
    }

    /// Keeps a candidate if it is the best so far.
    pub fn offer(&mut self, x: &[f64], cost: Cost) {
        if !cost.beats(self.cost) {
            return;
        }
        self.best.clear();
        self.best.extend_from_slice(x);
        (self.cost, self.improved) = (cost, self.iterations);
        match self.history.last_mut() {
            Some(last) if last.0 == self.iterations => last.1 = cost,
            _ => self.history.push((self.iterations, cost)),
        }
    }

    /// Iterations since the best changed.
    pub fn still(&self) -> u64 {
        self.iterations - self.improved
    }

    /// Iterations begun.
    pub fn iterations(&self) -> u64 {
        self.iterations
    }

    /// Begins an iteration; improvements belong to it.
    pub fn begin(&mut self) -> u64 {
        self.iterations += 1;
        self.iterations
    }

    /// Ends an iteration.
    pub fn tick(&self, f: &dyn Objective, ctx: &mut Context) -> Option<Stop> {
        let own = self.iterations >= self.limits[0] || self.still() >= self.limits[1];
        ctx.tick(f.shown(self.cost)).or_else(|| own.then_some(Stop::Converged))
    }

    /// Ends an iteration of a method that also stops once its population has shrunk to a point.
    pub fn close(&self, shrunk: bool, f: &dyn Objective, ctx: &mut Context) -> Option<Stop> {
        self.tick(f, ctx).or_else(|| shrunk.then_some(Stop::Converged))
    }

    pub fn finish(self, stop: Stop, population: Vec<Vec<f64>>, costs: Vec<Cost>, ctx: &Context) -> Minimum {
        let evaluations = ctx.evaluations() - self.before;
        Minimum { best: self.best, cost: self.cost, population, costs, history: self.history, iterations: self.iterations, evaluations, stop }
    }
}

/// Checks the box and the number of candidates.
pub(super) fn check(f: &dyn Objective, name: &str, count: usize, iterations: u64) -> Result<(), PlanError> {
    let bounds = f.bounds();
    if let Some((k, (low, high))) = bounds.iter().enumerate().find(|(_, (low, high))| !(low < high && (high - low).is_finite())) {
        return Err(PlanError::bad(format!("bounds[{k}]"), format!("({low}, {high})"), "finite numbers, the smaller one first"));
    }
    if bounds.is_empty() {
        return Err(PlanError::bad("bounds", "none", "one pair for each number, at least one"));
    }
    if count < 2 || count.saturating_mul(bounds.len()) > MOST {
        return Err(PlanError::bad(name, count, format!("2 to {}", MOST / bounds.len())));
    }
    if iterations == 0 {
        return Err(PlanError::bad("iterations", 0, "at least 1"));
    }
    Ok(())
}

/// Checks that a number lies in a closed range.
pub(super) fn within(name: &str, value: f64, [low, high]: [f64; 2]) -> Result<(), PlanError> {
    if (low..=high).contains(&value) { Ok(()) } else { Err(PlanError::bad(name, value, format!("{low} to {high}"))) }
}

/// The first population: hints first, inside the box, then uniform draws.
pub(super) fn first(f: &dyn Objective, count: usize, ctx: &mut Context) -> Result<Vec<Vec<f64>>, PlanError> {
    let bounds = f.bounds();
    let mut xs = Vec::with_capacity(count);
    for hint in f.hints().iter().take(count) {
        if hint.len() != bounds.len() || hint.iter().any(|v| !v.is_finite()) {
            return Err(PlanError::bad("hints", format!("{} numbers", hint.len()), format!("{} finite numbers", bounds.len())));
        }
        xs.push(hint.iter().zip(bounds).map(|(v, b)| v.clamp(b.0, b.1)).collect());
    }
    while xs.len() < count {
        xs.push(bounds.iter().map(|b| b.0 + (b.1 - b.0) * ctx.rng.random::<f64>()).collect());
    }
    Ok(xs)
}
