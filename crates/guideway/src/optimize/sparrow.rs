//! Sparrow search: producers, followers and scouts.
//!
//! Source: \[xue2020\], settings of the comparison in \[han2024\]. Symbols: `NP` sparrows, `PD` producers (share `producers`), `SD` scouts (share `scouts`),
//! `ST` safety, `R2` alarm, `t_max` iterations. Departures: a place is left only for a better one; a batch of producers, then followers, then scouts is judged
//! before the next is drawn; places are kept inside the box.
//!
//! The rule for producers multiplies their numbers by something between 0 and 1: it pulls towards 0, wherever the minimum is. So the method looks better than
//! it is on functions whose minimum is at 0 (a test shows how much) and, on lattices, on maps where straight to the goal is a good answer.

use super::draw::normals;
use super::record::{Record, check, first, within};
use super::{Cost, Minimum, Objective, Optimizer, evaluate};
use crate::context::Context;
use crate::error::PlanError;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};

/// Sparrow search.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Sparrow {
    /// Sparrows `NP`, at least 2.
    pub sparrows: usize,
    /// Iterations `t_max`.
    pub iterations: u64,
    /// Share of producers `PD / NP`, 0 to 1; at least one sparrow is one.
    pub producers: f64,
    /// Share of scouts `SD / NP`, 0 to 1.
    pub scouts: f64,
    /// Safety `ST`, 0 to 1: producers wander while the alarm is below it.
    pub safety: f64,
    /// Stops once the best has been the same for that many iterations; 0: never.
    pub patience: u64,
}

impl Default for Sparrow {
    fn default() -> Self {
        Self { sparrows: 50, iterations: 50, producers: 0.3, scouts: 0.2, safety: 0.8, patience: 0 }
    }
}

impl Optimizer for Sparrow {
    fn minimize(&self, f: &dyn Objective, ctx: &mut Context) -> Result<Minimum, PlanError> {
        check(f, "sparrows", self.sparrows, self.iterations)?;
        for (name, share) in [("producers", self.producers), ("scouts", self.scouts), ("safety", self.safety)] {
            within(name, share, [0.0, 1.0])?;
        }
        let mut record = Record::new(self.iterations, self.patience, ctx);
        let xs = first(f, self.sparrows, ctx)?;
        let costs = evaluate(f, &xs, ctx)?;
        let mut flock = Flock { f, sparrows: xs.into_iter().zip(costs).collect() };
        flock.sparrows.iter().for_each(|s| record.offer(&s.0, s.1));
        let stop = loop {
            record.begin();
            self.iterate(&mut flock, ctx)?;
            flock.sparrows.iter().for_each(|s| record.offer(&s.0, s.1));
            if let Some(stop) = record.tick(f, ctx) {
                break stop;
            }
        };
        let (xs, costs) = flock.sparrows.into_iter().unzip();
        Ok(record.finish(stop, xs, costs, ctx))
    }
}

impl Sparrow {
    fn iterate(&self, flock: &mut Flock, ctx: &mut Context) -> Result<(), PlanError> {
        let (count, most) = (self.sparrows, self.iterations as f64);
        flock.sparrows.sort_by(|a, b| a.1.order(b.1));
        let worst = flock.sparrows[count - 1].0.clone();
        let producers = ((self.producers * count as f64).round() as usize).clamp(1, count);
        let alarm: f64 = ctx.rng.random(); // R2
        flock.renew((0..producers).collect(), ctx, |i, x, rng| {
            if alarm < self.safety {
                let shrink = (-((i + 1) as f64) / ((1.0 - rng.random::<f64>()) * most)).exp();
                for v in x {
                    *v *= shrink;
                }
            } else {
                let step = normal(rng);
                for v in x {
                    *v += step;
                }
            }
        })?;
        let leader = flock.best(producers).0.clone(); // x_P
        flock.renew(
            (producers..count).collect(),
            ctx,
            |i, x, rng| {
                if 2 * (i + 1) > count { flee(i + 1, x, &worst, rng) } else { join(x, &leader, rng) }
            },
        )?;
        let best = flock.best(count).clone();
        let worst = flock.sparrows.iter().fold(&best, |a, b| if a.1.beats(b.1) { b } else { a }).clone();
        let old: Vec<Cost> = flock.sparrows.iter().map(|s| s.1).collect();
        let scouts = drawn(count, (self.scouts * count as f64).round() as usize, &mut ctx.rng);
        flock.renew(
            scouts,
            ctx,
            |i, x, rng| {
                if best.1.beats(old[i]) { approach(x, &best.0, rng) } else { shy(x, old[i].value - worst.1.value, &worst.0, rng) }
            },
        )
    }
}

/// Places and costs.
struct Flock<'a> {
    f: &'a dyn Objective,
    sparrows: Vec<(Vec<f64>, Cost)>,
}

impl Flock<'_> {
    /// Draws new places for some, `rule(index, place, rng)`, and keeps those that are better.
    fn renew(&mut self, some: Vec<usize>, ctx: &mut Context, mut rule: impl FnMut(usize, &mut [f64], &mut ChaCha8Rng)) -> Result<(), PlanError> {
        let mut xs = Vec::with_capacity(some.len());
        for &i in &some {
            let mut x = self.sparrows[i].0.clone();
            rule(i, &mut x, &mut ctx.rng);
            for ((v, old), (low, high)) in x.iter_mut().zip(&self.sparrows[i].0).zip(self.f.bounds()) {
                *v = if v.is_nan() { *old } else { v.clamp(*low, *high) };
            }
            xs.push(x);
        }
        let costs = evaluate(self.f, &xs, ctx)?;
        for ((i, x), cost) in some.into_iter().zip(xs).zip(costs) {
            if cost.beats(self.sparrows[i].1) {
                self.sparrows[i] = (x, cost);
            }
        }
        Ok(())
    }

    /// The best of the first few.
    fn best(&self, count: usize) -> &(Vec<f64>, Cost) {
        self.sparrows[..count].iter().fold(&self.sparrows[0], |a, b| if b.1.beats(a.1) { b } else { a })
    }
}

/// The hungrier half of the followers fly elsewhere; `rank` counts from 1.
fn flee(rank: usize, x: &mut [f64], worst: &[f64], rng: &mut ChaCha8Rng) {
    let (factor, square) = (normal(rng), (rank * rank) as f64);
    x.iter_mut().zip(worst).for_each(|(v, w)| *v = factor * ((w - *v) / square).exp());
}

/// The others forage around the best producer: the same step in every number.
fn join(x: &mut [f64], leader: &[f64], rng: &mut ChaCha8Rng) {
    let signed = x.iter().zip(leader).map(|(v, l)| if rng.random_bool(0.5) { (v - l).abs() } else { -(v - l).abs() });
    let step = signed.sum::<f64>() / x.len() as f64;
    x.iter_mut().zip(leader).for_each(|(v, l)| *v = l + step);
}

/// A scout at the edge of the flock moves to its middle.
fn approach(x: &mut [f64], best: &[f64], rng: &mut ChaCha8Rng) {
    let factor = normal(rng);
    x.iter_mut().zip(best).for_each(|(v, b)| *v = b + factor * (*v - b).abs());
}

/// A scout in its middle moves relative to the worst, which costs `-lead` more.
fn shy(x: &mut [f64], lead: f64, worst: &[f64], rng: &mut ChaCha8Rng) {
    let factor = 2.0 * rng.random::<f64>() - 1.0;
    x.iter_mut().zip(worst).for_each(|(v, w)| *v += factor * (*v - w).abs() / (lead + 1e-50));
}

/// `some` of the numbers below `count`, in ascending order.
fn drawn(count: usize, some: usize, rng: &mut ChaCha8Rng) -> Vec<usize> {
    let mut all: Vec<usize> = (0..count).collect();
    for k in 0..some {
        all.swap(k, rng.random_range(k..count));
    }
    all.truncate(some);
    all.sort_unstable();
    all
}

/// A normal deviate, mean 0, variance 1.
fn normal(rng: &mut ChaCha8Rng) -> f64 {
    normals(rng)[0]
}
