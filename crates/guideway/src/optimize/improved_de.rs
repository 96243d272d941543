//! Differential evolution with opposition, a decaying scale, a growing crossover rate and restarts.
//!
//! Source: the method of \[storn1997\] with opposition-based initialisation \[rahnamayan2008\]. Symbols: `NP` population, `g_max` iterations, `F_a, F_b`
//! `scale_range`, `CR_min, CR_max` `crossover_range`, `G_stag` stagnation, `lambda` [`decay`].
//! Departures: two readings of the scale factor behind a switch; restarts on stagnation, not at each failed trial, which would erase what was found;
//! `NP`, `g_max`, `G_stag` are ours.

use super::breed::{Population, opposite};
use super::de::breeding;
use super::draw::{between, unit};
use super::record::{Record, first, within};
use super::schedule::Schedule;
use super::{Minimum, Objective, Optimizer, evaluate};
use crate::context::Context;
use crate::error::PlanError;
use serde::{Deserialize, Serialize};

/// What is reflected through the middle of the box for the first population.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Opposition {
    /// Nothing.
    Off,
    /// Every individual.
    #[default]
    Full,
    /// The best and the worst quarter.
    Quartiles,
}

/// Form of the scale factor.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Form {
    /// `F_b (F_a / F_b)^lambda`: from `F_a` to `F_b`.
    #[default]
    Default,
    /// `F_b 2^lambda`: from `2 F_b` to `F_b`.
    Literal,
}

/// What takes the place of the worst after stagnation.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Renewal {
    /// Their own opposites.
    Opposite,
    /// Random places.
    Random,
    /// One or the other by chance.
    #[default]
    Both,
}

/// Improved differential evolution; every part of it is a switch.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ImprovedDe {
    /// Individuals `NP`, at least 4.
    pub population: usize,
    /// Generations `g_max`, if the budget names neither iterations nor evaluations.
    pub iterations: u64,
    /// Opposition in the first population.
    pub opposition: Opposition,
    /// Form of the scale factor.
    pub form: Form,
    /// Scale factor at first and in the end `F_a, F_b`, above 0 to 2; equal numbers switch the decay off.
    pub scale_range: [f64; 2],
    /// Crossover rate at first and in the end `CR_min, CR_max`, 0 to 1; equal numbers switch the growth off.
    pub crossover_range: [f64; 2],
    /// Generations without improvement `G_stag` after which the worst are renewed; 0: never.
    pub stagnation: u64,
    /// Share of the population that is renewed then, 0 to 1; the best stays.
    pub renewed: f64,
    /// What takes their place.
    pub renewal: Renewal,
    /// Stops once the best has been the same for that many generations; 0: never.
    pub patience: u64,
    /// Stops once the population spans no more than that share of any side of the box; 0: never.
    pub tolerance: f64,
}

impl Default for ImprovedDe {
    fn default() -> Self {
        Self {
            population: 40,
            iterations: 4000,
            opposition: Opposition::Full,
            form: Form::Default,
            scale_range: [0.5, 0.3],
            crossover_range: [0.3, 0.9],
            stagnation: 200,
            renewed: 0.5,
            renewal: Renewal::Both,
            patience: 1000,
            tolerance: 1e-9,
        }
    }
}

/// `lambda` of generation `g` of `last`: 1 in the first, nearly 0 in the last, and near 1 for most of the way between.
pub fn decay(g: u64, last: u64) -> f64 {
    let last = last.max(1);
    let left = (last + 1).saturating_sub(g).max(1);
    (1.0 - last as f64 / left as f64).exp()
}

impl Optimizer for ImprovedDe {
    fn minimize(&self, f: &dyn Objective, ctx: &mut Context) -> Result<Minimum, PlanError> {
        self.check(f)?;
        let last = Schedule::new(self.iterations, ctx).generations(self.population + self.opposed(), self.population);
        let mut record = Record::new(last, self.patience, ctx);
        let mut all = self.begin(f, &mut record, ctx)?;
        let stop = loop {
            let g = record.begin();
            all.vary(self.scale(g, last), self.crossover(g, last), &mut ctx.rng);
            all.select(&mut record, ctx, |_, _, _, _| ())?;
            if let Some(stop) = record.close(all.shrunk(self.tolerance), f, ctx) {
                break stop;
            }
            if self.stagnation > 0 && record.still() > 0 && record.still().is_multiple_of(self.stagnation) {
                self.renew(&mut all, &mut record, ctx)?;
            }
        };
        Ok(record.finish(stop, all.xs, all.costs, ctx))
    }
}

impl ImprovedDe {
    fn check(&self, f: &dyn Objective) -> Result<(), PlanError> {
        breeding(f, self.population, self.iterations, self.tolerance)?;
        self.scale_range.iter().try_for_each(|v| within("scale_range", *v, [1e-9, 2.0]))?;
        self.crossover_range.iter().try_for_each(|v| within("crossover_range", *v, [0.0, 1.0]))?;
        within("renewed", self.renewed, [0.0, 1.0])
    }

    /// Individuals that the opposition adds to the first population.
    fn opposed(&self) -> usize {
        match self.opposition {
            Opposition::Off => 0,
            Opposition::Full => self.population,
            Opposition::Quartiles => 2 * (self.population / 4),
        }
    }

    /// The best of random individuals and their opposites.
    fn begin<'a>(&self, f: &'a dyn Objective, record: &mut Record, ctx: &mut Context) -> Result<Population<'a>, PlanError> {
        let xs = first(f, self.population, ctx)?;
        let mut all = Population::judged(f, xs, record, ctx)?;
        let ranks = all.ranks();
        let quarter = match self.opposition {
            Opposition::Off => return Ok(all),
            Opposition::Full => self.population,
            Opposition::Quartiles => self.population / 4,
        };
        let chosen = (0..self.population).filter(|k| *k < quarter || *k >= self.population - quarter);
        let others = chosen.map(|k| all.opposite(ranks[k])).collect();
        all.join(others, record, ctx)?;
        Ok(all)
    }

    /// Scale factor of generation `g`.
    pub fn scale(&self, g: u64, last: u64) -> f64 {
        let [first, end] = self.scale_range;
        let ratio = if self.form == Form::Literal { 2.0 } else { first / end };
        end * ratio.powf(decay(g, last))
    }

    /// Crossover rate of generation `g`.
    pub fn crossover(&self, g: u64, last: u64) -> f64 {
        let [low, high] = self.crossover_range;
        low + g as f64 / last as f64 * (high - low)
    }

    /// Gives the worst new places.
    fn renew(&self, all: &mut Population, record: &mut Record, ctx: &mut Context) -> Result<(), PlanError> {
        let count = ((self.renewed * self.population as f64) as usize).min(self.population - 1);
        let worst = all.ranks().split_off(self.population - count);
        let bounds = all.f.bounds();
        let mut place = |i: &usize| {
            let reflected = match self.renewal {
                Renewal::Opposite => true,
                Renewal::Random => false,
                Renewal::Both => unit(&mut ctx.rng) < 0.5,
            };
            if reflected { opposite(&all.xs[*i], bounds) } else { bounds.iter().map(|b| between(*b, &mut ctx.rng)).collect() }
        };
        let xs: Vec<Vec<f64>> = worst.iter().map(&mut place).collect();
        let costs = evaluate(all.f, &xs, ctx)?;
        for ((i, x), cost) in worst.into_iter().zip(xs).zip(costs) {
            record.offer(&x, cost);
            (all.xs[i], all.costs[i]) = (x, cost);
        }
        Ok(())
    }
}
