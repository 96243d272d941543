//! Fireflies: each flies towards all that are brighter, less the farther they are, with a random step that fades.
//!
//! Source: \[yang2009\]. Symbols: `NP` population, `beta0` attractiveness, `alpha0` step, `gamma` absorption; the box is scaled to a unit cube.
//! Departures: `gamma` and the fading of the step are ours; a generation flies by the old places and is judged as one batch; places are kept inside the box.

use super::breed::Population;
use super::draw::pair;
use super::record::{Record, check, first, within};
use super::schedule::Schedule;
use super::{Minimum, Objective, Optimizer, evaluate};
use crate::context::Context;
use crate::error::PlanError;
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};

/// Firefly algorithm.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Firefly {
    /// Fireflies `NP`, at least 2.
    pub population: usize,
    /// Generations, if the budget names neither iterations nor evaluations.
    pub iterations: u64,
    /// Attractiveness at no distance `beta0`, 0 to 2.
    pub attractiveness: f64,
    /// Absorption `gamma`, per square of the side of the unit cube, 0 to 1000.
    pub absorption: f64,
    /// Random step at first `alpha0`, share of each side of the box, 0 to 1.
    pub step: f64,
    /// Factor of the random step per generation, 0 to 1.
    pub fading: f64,
    /// Stops once the best has been the same for that many generations; 0: never.
    pub patience: u64,
}

impl Default for Firefly {
    fn default() -> Self {
        Self { population: 40, iterations: 4000, attractiveness: 0.9, absorption: 1.0, step: 0.3, fading: 0.97, patience: 0 }
    }
}

impl Optimizer for Firefly {
    fn minimize(&self, f: &dyn Objective, ctx: &mut Context) -> Result<Minimum, PlanError> {
        check(f, "population", self.population, self.iterations)?;
        within("attractiveness", self.attractiveness, [0.0, 2.0])?;
        within("absorption", self.absorption, [0.0, 1000.0])?;
        within("step", self.step, [0.0, 1.0])?;
        within("fading", self.fading, [0.0, 1.0])?;
        let last = Schedule::new(self.iterations, ctx).generations(self.population, self.population);
        let mut record = Record::new(last, self.patience, ctx);
        let xs = first(f, self.population, ctx)?;
        let mut all = Population::judged(f, xs, &mut record, ctx)?;
        let (mut units, mut step) = (vec![Vec::new(); self.population], self.step);
        let stop = loop {
            record.begin();
            step *= self.fading; // alpha_t
            self.fly(&mut all, &mut units, step, &mut ctx.rng);
            all.costs = evaluate(f, &all.xs, ctx)?;
            all.xs.iter().zip(&all.costs).for_each(|(x, cost)| record.offer(x, *cost));
            if let Some(stop) = record.tick(f, ctx) {
                break stop;
            }
        };
        Ok(record.finish(stop, all.xs, all.costs, ctx))
    }
}

impl Firefly {
    /// Moves all by the old places, which `units` holds in the unit cube.
    fn fly(&self, all: &mut Population, units: &mut [Vec<f64>], step: f64, rng: &mut ChaCha8Rng) {
        let bounds = all.f.bounds();
        for (unit, x) in units.iter_mut().zip(&all.xs) {
            unit.clear();
            unit.extend(x.iter().zip(bounds).map(|(v, (low, high))| (v - low) / (high - low)));
        }
        let mut place = Vec::with_capacity(bounds.len());
        for (i, x) in all.xs.iter_mut().enumerate() {
            place.clone_from(&units[i]);
            let mut moved = false;
            for (_, other) in units.iter().enumerate().filter(|(j, _)| all.costs[*j].beats(all.costs[i])) {
                self.approach(&mut place, other, step, rng);
                moved = true;
            }
            if moved {
                x.iter_mut().zip(&place).zip(bounds).for_each(|((v, u), (low, high))| *v = (low + u * (high - low)).clamp(*low, *high));
            }
        }
    }

    fn approach(&self, place: &mut [f64], other: &[f64], step: f64, rng: &mut ChaCha8Rng) {
        let square: f64 = place.iter().zip(other).map(|(a, b)| (a - b) * (a - b)).sum();
        let pull = self.attractiveness * (-self.absorption * square).exp();
        for (mine, theirs) in place.chunks_mut(2).zip(other.chunks(2)) {
            let noise = pair(rng);
            for ((v, o), u) in mine.iter_mut().zip(theirs).zip(noise) {
                *v = (*v + pull * (o - *v) + step * (u - 0.5)).clamp(0.0, 1.0);
            }
        }
    }
}
