//! Particle swarm: every particle is drawn to the best place it has been at and to the best place of all.
//!
//! Source: \[kennedy1995\], with the inertia weight of \[shi1998\]; settings of the comparison in \[han2024\]. Symbols: `NP` particles, `t_max` iterations,
//! `omega` inertia, `c1` cognitive, `c2` social. Departures: `c1 = c2 = 1.5`, a limit on the speed and places kept inside the box, all of which the
//! comparison leaves open; the best place of all changes between iterations only.

use super::flock::{Moves, Pull, Space, flock, positions};
use super::record::{Record, check};
use super::{Minimum, Objective, Optimizer, evaluate};
use crate::context::Context;
use crate::error::PlanError;
use serde::{Deserialize, Serialize};

/// Particle swarm.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Pso {
    /// Particles `NP`, at least 2.
    pub particles: usize,
    /// Iterations `t_max`.
    pub iterations: u64,
    /// Inertia `omega`, 0 to 2.
    pub inertia: f64,
    /// Pull of the particle's own best place `c1`, 0 to 10.
    pub cognitive: f64,
    /// Pull of the best place of all `c2`, 0 to 10.
    pub social: f64,
    /// Largest step in each number, share of its range.
    pub speed: f64,
    /// Stops once the best has been the same for that many iterations; 0: never.
    pub patience: u64,
}

impl Default for Pso {
    fn default() -> Self {
        Self { particles: 50, iterations: 50, inertia: 0.5, cognitive: 1.5, social: 1.5, speed: 0.2, patience: 0 }
    }
}

impl Optimizer for Pso {
    fn minimize(&self, f: &dyn Objective, ctx: &mut Context) -> Result<Minimum, PlanError> {
        check(f, "particles", self.particles, self.iterations)?;
        let pull = Pull { inertia: self.inertia, own: self.cognitive, guide: self.social }.check()?;
        let mut record = Record::new(self.iterations, self.patience, ctx);
        let mut particles = flock(f, self.particles, self.speed, ctx)?;
        for p in &particles {
            record.offer(&p.x, p.cost);
        }
        let space = Space { bounds: f.bounds(), speed: self.speed };
        let mut moves = Moves::default();
        let stop = loop {
            record.begin();
            moves.clear();
            for p in &particles {
                let guide = if record.best.is_empty() { &p.best } else { &record.best };
                moves.add(p, guide, pull, &space, &mut ctx.rng); // (1), (2)
            }
            let costs = evaluate(f, moves.candidates(), ctx)?;
            for (k, (p, cost)) in particles.iter_mut().zip(costs).enumerate() {
                moves.take(k, p, cost);
                record.offer(&p.x, cost);
            }
            if let Some(stop) = record.tick(f, ctx) {
                break stop;
            }
        };
        let (xs, costs) = positions(particles);
        Ok(record.finish(stop, xs, costs, ctx))
    }
}
