//! Particles: what plain and grouped swarms share.

use super::draw::pair;
use super::record::{first, within};
use super::{Cost, Objective, evaluate};
use crate::context::Context;
use crate::error::PlanError;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

/// A particle: where it is, how it moves, and the best place it has been at.
#[derive(Clone)]
pub(super) struct Particle {
    pub x: Vec<f64>,
    pub v: Vec<f64>,
    pub cost: Cost,
    pub best: Vec<f64>,
    pub best_cost: Cost,
}

/// How strongly a particle keeps its way and is drawn to its own best place and to its guide.
#[derive(Clone, Copy)]
pub(super) struct Pull {
    pub inertia: f64,
    pub own: f64,
    pub guide: f64,
}

impl Pull {
    pub fn check(self) -> Result<Self, PlanError> {
        within("inertia", self.inertia, [0.0, 2.0])?;
        within("cognitive", self.own, [0.0, 10.0])?;
        within("social", self.guide, [0.0, 10.0])?;
        Ok(self)
    }
}

/// Where particles may go to next, not judged yet; the memory is used again.
#[derive(Default)]
pub(super) struct Moves {
    pub xs: Vec<Vec<f64>>,
    vs: Vec<Vec<f64>>,
    used: usize,
}

impl Moves {
    pub fn clear(&mut self) {
        self.used = 0;
    }

    /// The candidates, in order.
    pub fn candidates(&self) -> &[Vec<f64>] {
        &self.xs[..self.used]
    }

    /// Adds the next place of a particle.
    pub fn add(&mut self, p: &Particle, guide: &[f64], pull: Pull, bounds: &Space, rng: &mut ChaCha8Rng) {
        if self.used == self.xs.len() {
            self.xs.push(vec![0.0; p.x.len()]);
            self.vs.push(vec![0.0; p.x.len()]);
        }
        let (x, v) = (&mut self.xs[self.used], &mut self.vs[self.used]);
        self.used += 1;
        for k in 0..p.x.len() {
            let [r1, r2] = pair(rng);
            let (low, high) = bounds.bounds[k];
            let most = bounds.speed * (high - low);
            let pulled = pull.own * r1 * (p.best[k] - p.x[k]) + pull.guide * r2 * (guide[k] - p.x[k]);
            v[k] = (pull.inertia * p.v[k] + pulled).clamp(-most, most);
            x[k] = (p.x[k] + v[k]).clamp(low, high);
            v[k] = x[k] - p.x[k];
        }
    }

    /// Moves a particle to the place that was the `k`-th to be added.
    pub fn take(&mut self, k: usize, p: &mut Particle, cost: Cost) {
        std::mem::swap(&mut p.x, &mut self.xs[k]);
        std::mem::swap(&mut p.v, &mut self.vs[k]);
        p.cost = cost;
        if cost.beats(p.best_cost) {
            p.best.copy_from_slice(&p.x);
            p.best_cost = cost;
        }
    }
}

/// The box and the largest step in it.
pub(super) struct Space<'a> {
    pub bounds: &'a [(f64, f64)],
    /// Share of a side per step.
    pub speed: f64,
}

/// The first particles, judged.
pub(super) fn flock(f: &dyn Objective, count: usize, speed: f64, ctx: &mut Context) -> Result<Vec<Particle>, PlanError> {
    within("speed", speed, [1e-9, 1.0])?;
    let xs = first(f, count, ctx)?;
    let costs = evaluate(f, &xs, ctx)?;
    let particles = xs.into_iter().zip(costs).map(|(x, cost)| {
        let v = f.bounds().iter().map(|b| speed * (b.1 - b.0) * (2.0 * ctx.rng.random::<f64>() - 1.0)).collect();
        Particle { best: x.clone(), x, v, cost, best_cost: cost }
    });
    Ok(particles.collect())
}

/// Positions and their costs.
pub(super) fn positions(particles: Vec<Particle>) -> (Vec<Vec<f64>>, Vec<Cost>) {
    particles.into_iter().map(|p| (p.x, p.cost)).unzip()
}
