//! How long a run is, so that what changes along it ends with it.

use crate::context::Context;

/// What the budget leaves, else the method's own number of iterations.
pub(super) struct Schedule {
    iterations: u64,
    /// Evaluations before the run, and what is left for it.
    evaluations: Option<(u64, u64)>,
}

impl Schedule {
    /// `own` iterations, if the budget names neither iterations nor evaluations.
    pub fn new(own: u64, ctx: &Context) -> Self {
        let budget = ctx.budget();
        let evaluations = budget.evaluations.map(|n| (ctx.evaluations(), n.saturating_sub(ctx.evaluations())));
        let otherwise = if evaluations.is_some() { u64::MAX } else { own };
        Self { iterations: budget.iterations.map_or(otherwise, |n| n.saturating_sub(ctx.iterations())), evaluations }
    }

    /// Evaluations that are left for the run, if the budget counts them.
    pub fn evaluations(&self) -> Option<u64> {
        self.evaluations.map(|(_, left)| left)
    }

    /// Iterations, at least 1, if the first population takes `first` evaluations and every iteration `each`.
    pub fn generations(&self, first: usize, each: usize) -> u64 {
        let by = self.evaluations.map_or(u64::MAX, |(_, left)| left.saturating_sub(first as u64).div_ceil(each as u64));
        by.min(self.iterations).max(1)
    }

    /// Share of the run that is done, 0 to 1, after that many iterations.
    pub fn share(&self, iterations: u64, ctx: &Context) -> f64 {
        let spent = self.evaluations.map_or(0.0, |(before, left)| (ctx.evaluations() - before) as f64 / left.max(1) as f64);
        spent.max(iterations as f64 / self.iterations.max(1) as f64).min(1.0)
    }
}
