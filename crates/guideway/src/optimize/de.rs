//! Differential evolution: differences of individuals are the steps of others.
//!
//! Source: \[storn1997\], rand/1/bin. Symbols: `NP` population, `g_max` iterations, `F` scale, `CR` crossover. Departures: all trials of a generation are
//! built from the old population; a number outside the box is drawn anew.

use super::breed::Population;
use super::record::{Record, check, first, within};
use super::schedule::Schedule;
use super::{Minimum, Objective, Optimizer};
use crate::context::Context;
use crate::error::PlanError;
use serde::{Deserialize, Serialize};

/// Differential evolution.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct De {
    /// Individuals `NP`, at least 4.
    pub population: usize,
    /// Generations `g_max`, if the budget names neither iterations nor evaluations.
    pub iterations: u64,
    /// Scale factor `F`, 0 to 2.
    pub scale: f64,
    /// Crossover rate `CR`, 0 to 1.
    pub crossover: f64,
    /// Stops once the best has been the same for that many generations; 0: never.
    pub patience: u64,
    /// Stops once the population spans no more than that share of any side of the box; 0: never.
    pub tolerance: f64,
}

impl Default for De {
    fn default() -> Self {
        Self { population: 40, iterations: 4000, scale: 0.6, crossover: 0.8, patience: 0, tolerance: 0.0 }
    }
}

impl Optimizer for De {
    fn minimize(&self, f: &dyn Objective, ctx: &mut Context) -> Result<Minimum, PlanError> {
        breeding(f, self.population, self.iterations, self.tolerance)?;
        within("scale", self.scale, [0.0, 2.0])?;
        within("crossover", self.crossover, [0.0, 1.0])?;
        let last = Schedule::new(self.iterations, ctx).generations(self.population, self.population);
        let mut record = Record::new(last, self.patience, ctx);
        let xs = first(f, self.population, ctx)?;
        let mut all = Population::judged(f, xs, &mut record, ctx)?;
        let stop = loop {
            record.begin();
            all.vary(self.scale, self.crossover, &mut ctx.rng);
            all.select(&mut record, ctx, |_, _, _, _| ())?;
            if let Some(stop) = record.close(all.shrunk(self.tolerance), f, ctx) {
                break stop;
            }
        };
        Ok(record.finish(stop, all.xs, all.costs, ctx))
    }
}

/// Checks what the methods of differential evolution share.
pub(super) fn breeding(f: &dyn Objective, population: usize, iterations: u64, tolerance: f64) -> Result<(), PlanError> {
    check(f, "population", population, iterations)?;
    if population < 4 {
        return Err(PlanError::bad("population", population, "at least 4"));
    }
    within("tolerance", tolerance, [0.0, 1.0])
}
