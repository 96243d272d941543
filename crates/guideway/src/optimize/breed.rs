//! What the methods of differential evolution share: the population, trials and selection one to one.

use super::draw::{Chance, between, index};
use super::record::Record;
use super::{Cost, Objective, evaluate};
use crate::context::Context;
use crate::error::PlanError;
use rand_chacha::ChaCha8Rng;
use std::cmp::Ordering;

/// Individuals and their costs; trials, whose memory is used again.
pub(super) struct Population<'a> {
    pub f: &'a dyn Objective,
    pub xs: Vec<Vec<f64>>,
    pub costs: Vec<Cost>,
    pub trials: Vec<Vec<f64>>,
}

impl<'a> Population<'a> {
    /// Judges a first population.
    pub fn judged(f: &'a dyn Objective, xs: Vec<Vec<f64>>, record: &mut Record, ctx: &mut Context) -> Result<Self, PlanError> {
        let costs = evaluate(f, &xs, ctx)?;
        xs.iter().zip(&costs).for_each(|(x, cost)| record.offer(x, *cost));
        Ok(Self { f, trials: xs.clone(), xs, costs })
    }

    /// Judges others, adds them, and keeps the best.
    pub fn join(&mut self, xs: Vec<Vec<f64>>, record: &mut Record, ctx: &mut Context) -> Result<(), PlanError> {
        let kept = self.xs.len();
        let others = Self::judged(self.f, xs, record, ctx)?;
        self.xs.extend(others.xs);
        self.costs.extend(others.costs);
        let order = self.ranks();
        self.xs = order.iter().take(kept).map(|&i| std::mem::take(&mut self.xs[i])).collect();
        self.costs = order.iter().take(kept).map(|&i| self.costs[i]).collect();
        Ok(())
    }

    /// Indices, best first.
    pub fn ranks(&self) -> Vec<usize> {
        let mut order: Vec<usize> = (0..self.costs.len()).collect();
        order.sort_by(|&a, &b| self.costs[a].order(self.costs[b]));
        order
    }

    /// A trial for each by a random base and one scaled difference, crossed number by number.
    pub fn vary(&mut self, scale: f64, rate: f64, rng: &mut ChaCha8Rng) {
        let (bounds, rate) = (self.f.bounds(), Chance::new(rate));
        for (i, trial) in self.trials.iter_mut().enumerate() {
            let [a, b, c] = others(i, self.xs.len(), rng).map(|k| self.xs[k].as_slice());
            trial.copy_from_slice(&self.xs[i]);
            let forced = index(bounds.len(), rng);
            for k in 0..trial.len() {
                if rate.hit(rng) || k == forced {
                    trial[k] = inside(a[k] + scale * (b[k] - c[k]), bounds[k], rng);
                }
            }
        }
    }

    /// Judges the trials; each takes the place of its parent unless it is worse. Tells `won(i, parent's cost, trial's cost)` before that of those that do.
    pub fn select(&mut self, record: &mut Record, ctx: &mut Context, mut won: impl FnMut(usize, &[f64], Cost, Cost)) -> Result<(), PlanError> {
        let costs = evaluate(self.f, &self.trials[..self.xs.len()], ctx)?;
        for (i, cost) in costs.into_iter().enumerate() {
            let order = cost.order(self.costs[i]);
            if order == Ordering::Greater || cost == Cost::WORST {
                continue;
            }
            if order == Ordering::Less {
                won(i, &self.xs[i], self.costs[i], cost);
                record.offer(&self.trials[i], cost);
            }
            std::mem::swap(&mut self.xs[i], &mut self.trials[i]);
            self.costs[i] = cost;
        }
        Ok(())
    }

    /// Has the population shrunk to a point, `tolerance` of each side of the box?
    pub fn shrunk(&self, tolerance: f64) -> bool {
        let near = |(k, b): (usize, &(f64, f64))| self.xs.iter().all(|x| (x[k] - self.xs[0][k]).abs() <= tolerance * (b.1 - b.0));
        tolerance > 0.0 && self.f.bounds().iter().enumerate().all(near)
    }

    /// The same place seen through the middle of the box.
    pub fn opposite(&self, i: usize) -> Vec<f64> {
        opposite(&self.xs[i], self.f.bounds())
    }
}

/// A place seen through the middle of the box.
pub(super) fn opposite(x: &[f64], bounds: &[(f64, f64)]) -> Vec<f64> {
    x.iter().zip(bounds).map(|(v, (low, high))| (low + (high - v)).clamp(*low, *high)).collect()
}

/// The number, or a random one between the bounds if it lies outside.
pub(super) fn inside(v: f64, bounds: (f64, f64), rng: &mut ChaCha8Rng) -> f64 {
    if v >= bounds.0 && v <= bounds.1 { v } else { between(bounds, rng) }
}

/// Three different indices below `count`, none of them `i`; `count` is at least 4.
fn others(i: usize, count: usize, rng: &mut ChaCha8Rng) -> [usize; 3] {
    let mut draw = |taken: [usize; 3]| loop {
        let k = index(count, rng);
        if !taken.contains(&k) {
            return k;
        }
    };
    let a = draw([i; 3]);
    let b = draw([i, a, a]);
    [a, b, draw([i, a, b])]
}
