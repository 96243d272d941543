//! Differential evolution that learns its parameters from what succeeded, with an archive and a population that shrinks.
//!
//! Source: \[tanabe2014\]. Symbols: `N_init` population, `N_min` least, `H` memory, `p` elite, `r_arc` archive, `M_F, M_CR` means in the memory, `S_F, S_CR`
//! what succeeded in a generation. Departures: the share of the budget that is spent stands for the share of the evaluations; the first population is
//! random places and their opposites (`opposition`); a first population that the budget is too small for is smaller; improvements are weighed by their
//! violation while that is what improves.

use super::breed::{Population, opposite};
use super::de::breeding;
use super::draw::{Chance, index, normals};
use super::improved_de::decay;
use super::record::{Record, first, within};
use super::schedule::Schedule;
use super::{Cost, Minimum, Objective, Optimizer};
use crate::context::Context;
use crate::error::PlanError;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// Success-history adaptive differential evolution with linear population reduction.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct LShade {
    /// Individuals at first `N_init`, at least 4; 0: 18 for each number as in the source, at most a 150th of the evaluations.
    pub population: usize,
    /// Individuals in the end `N_min`, at least 4 (4 in the source).
    pub least: usize,
    /// Generations, if the budget names neither iterations nor evaluations.
    pub iterations: u64,
    /// Entries of the memory `H`, at least 1.
    pub memory: usize,
    /// Share of the population `p` whose members guide, above 0 to 1.
    pub elite: f64,
    /// Size of the archive `r_arc` of beaten parents, in populations, 0 to 10.
    pub archive: f64,
    /// The first population is random places and their opposites.
    pub opposition: bool,
    /// The mean of `F` falls from 0.5 to 0.3 as in the improved method in one entry of the memory.
    pub prior: bool,
    /// Stops once the best has been the same for that many generations; 0: never.
    pub patience: u64,
    /// Stops once the population spans no more than that share of any side of the box; 0: never.
    pub tolerance: f64,
}

impl Default for LShade {
    fn default() -> Self {
        Self {
            population: 0,
            least: 12,
            iterations: 4000,
            memory: 6,
            elite: 0.11,
            archive: 2.6,
            opposition: true,
            prior: false,
            patience: 0,
            tolerance: 1e-12,
        }
    }
}

/// Generations of the first size that a budget shall at least pay for.
const GENERATIONS: u64 = 150;

impl Optimizer for LShade {
    fn minimize(&self, f: &dyn Objective, ctx: &mut Context) -> Result<Minimum, PlanError> {
        let schedule = Schedule::new(self.iterations, ctx);
        let count = self.check(f, &schedule)?;
        let mut record = Record::new(schedule.generations(count, self.least), self.patience, ctx);
        let xs = self.begin(f, count, ctx)?;
        let all = Population::judged(f, xs, &mut record, ctx)?;
        let memory = vec![Means { scale: 0.5, rate: Some(0.5) }; self.memory];
        let mut run = Run { method: self, all, memory, next: 0, archive: Vec::new(), tried: Vec::new(), first: count };
        let stop = loop {
            let share = schedule.share(record.begin() - 1, ctx);
            run.vary(share, &mut ctx.rng);
            run.select(&mut record, ctx)?;
            if let Some(stop) = record.close(run.all.shrunk(self.tolerance), f, ctx) {
                break stop;
            }
            run.reduce(schedule.share(record.iterations(), ctx), &mut ctx.rng);
        };
        Ok(record.finish(stop, run.all.xs, run.all.costs, ctx))
    }
}

impl LShade {
    /// Checks the parameters; gives back the size of the first population.
    fn check(&self, f: &dyn Objective, schedule: &Schedule) -> Result<usize, PlanError> {
        let affordable = schedule.evaluations().map_or(u64::MAX, |n| n / GENERATIONS).try_into().unwrap_or(usize::MAX);
        let count = if self.population == 0 { (18 * f.bounds().len()).min(affordable).max(self.least) } else { self.population };
        breeding(f, count, self.iterations, self.tolerance)?;
        if !(4..=count).contains(&self.least) {
            return Err(PlanError::bad("least", self.least, format!("4 to {count}, the population")));
        }
        if !(1..=1000).contains(&self.memory) {
            return Err(PlanError::bad("memory", self.memory, "1 to 1000"));
        }
        within("elite", self.elite, [1e-9, 1.0])?;
        within("archive", self.archive, [0.0, 10.0])?;
        Ok(count)
    }

    /// Hints, random places, and the opposites of all.
    fn begin(&self, f: &dyn Objective, count: usize, ctx: &mut Context) -> Result<Vec<Vec<f64>>, PlanError> {
        if !self.opposition {
            return first(f, count, ctx);
        }
        let drawn = f.hints().len().clamp(count.div_ceil(2), count);
        let mut xs = first(f, drawn, ctx)?;
        for i in 0..count - drawn {
            xs.push(opposite(&xs[i], f.bounds()));
        }
        Ok(xs)
    }
}

/// Means of an entry of the memory; no rate: crossover takes one number only.
#[derive(Clone, Copy)]
struct Means {
    scale: f64,
    rate: Option<f64>,
}

/// One run.
struct Run<'a> {
    method: &'a LShade,
    all: Population<'a>,
    memory: Vec<Means>,
    /// The entry that is learnt next.
    next: usize,
    archive: Vec<Vec<f64>>,
    /// Scale and rate of each trial.
    tried: Vec<[f64; 2]>,
    first: usize,
}

impl Run<'_> {
    /// A trial for each: from the parent towards one of the elite, and a difference to one of the population or the archive.
    fn vary(&mut self, share: f64, rng: &mut ChaCha8Rng) {
        let (count, bounds) = (self.all.xs.len(), self.all.f.bounds());
        let ranks = self.all.ranks();
        let elite = ((self.method.elite * count as f64).round() as usize).clamp(2, count);
        self.tried.clear();
        for i in 0..count {
            let [scale, rate] = self.drawn(share, rng);
            self.tried.push([scale, rate]);
            let guide = ranks[index(elite, rng)];
            let one = another(count, [i, i], rng);
            let two = another(count + self.archive.len(), [i, one], rng);
            let (x, best, a) = (&self.all.xs[i], &self.all.xs[guide], &self.all.xs[one]);
            let b = if two < count { &self.all.xs[two] } else { &self.archive[two - count] };
            let trial = &mut self.all.trials[i];
            trial.copy_from_slice(x);
            let (rate, forced) = (Chance::new(rate), index(bounds.len(), rng));
            for k in 0..trial.len() {
                if rate.hit(rng) || k == forced {
                    let v = x[k] + scale * (best[k] - x[k] + a[k] - b[k]);
                    trial[k] = halfway(v, x[k], bounds[k]);
                }
            }
        }
    }

    /// Scale and rate from an entry of the memory.
    fn drawn(&self, share: f64, rng: &mut ChaCha8Rng) -> [f64; 2] {
        let entry = index(self.memory.len() + usize::from(self.method.prior), rng);
        let means = self.memory.get(entry).copied().unwrap_or_else(|| Means { scale: prior(share), rate: Some(0.3 + 0.6 * share) });
        let scale = loop {
            let drawn = means.scale + 0.1 * (PI * (rng.random::<f64>() - 0.5)).tan(); // Cauchy
            if drawn > 0.0 {
                break drawn.min(1.0);
            }
        };
        [scale, means.rate.map_or(0.0, |mean| (mean + 0.1 * normals(rng)[0]).clamp(0.0, 1.0))]
    }

    /// Selects, keeps beaten parents, and learns from the trials that were better.
    fn select(&mut self, record: &mut Record, ctx: &mut Context) -> Result<(), PlanError> {
        let mut won: Vec<(f64, [f64; 2])> = Vec::new();
        let (archive, tried) = (&mut self.archive, &self.tried);
        self.all.select(record, ctx, |i, parent, before, after| {
            archive.push(parent.to_vec());
            won.push((gain(before, after), tried[i]));
        })?;
        self.trim(&mut ctx.rng);
        if !won.is_empty() {
            let rate = self.memory[self.next].rate;
            self.memory[self.next] = learnt(&won, rate);
            self.next = (self.next + 1) % self.memory.len();
        }
        Ok(())
    }

    /// Takes the worst out: from the first size to the least in step with the budget.
    fn reduce(&mut self, share: f64, rng: &mut ChaCha8Rng) {
        let span = (self.first - self.method.least) as f64;
        let count = (self.first as f64 - span * share).round() as usize;
        if count >= self.all.xs.len() {
            return;
        }
        let mut gone = self.all.ranks().split_off(count);
        gone.sort_unstable();
        for i in gone.into_iter().rev() {
            self.all.xs.remove(i);
            self.all.costs.remove(i);
        }
        self.trim(rng);
    }

    /// Takes random members out of the archive until it fits.
    fn trim(&mut self, rng: &mut ChaCha8Rng) {
        let most = (self.method.archive * self.all.xs.len() as f64).round() as usize;
        while self.archive.len() > most {
            let gone = index(self.archive.len(), rng);
            self.archive.swap_remove(gone);
        }
    }
}

/// Mean scale of the improved method at that share of the run.
fn prior(share: f64) -> f64 {
    const STEPS: u64 = 1000;
    0.3 * (0.5f64 / 0.3).powf(decay(1 + (share * (STEPS - 1) as f64) as u64, STEPS))
}

/// How much better a trial was, in what it was better.
fn gain(before: Cost, after: Cost) -> f64 {
    if before.violation > after.violation { before.violation - after.violation } else { before.value - after.value }
}

/// Weighted Lehmer means of what succeeded.
fn learnt(won: &[(f64, [f64; 2])], before: Option<f64>) -> Means {
    let total: f64 = won.iter().map(|w| w.0).sum();
    let weigh = |w: f64| if total > 0.0 && total.is_finite() { w / total } else { 1.0 / won.len() as f64 };
    let mean = |k: usize| {
        let [one, two] = won.iter().fold([0.0; 2], |s, (w, v)| [s[0] + weigh(*w) * v[k], s[1] + weigh(*w) * v[k] * v[k]]);
        if one > 0.0 { two / one } else { 0.0 }
    };
    let none = won.iter().all(|w| w.1[1] == 0.0);
    Means { scale: mean(0), rate: if none || before.is_none() { None } else { Some(mean(1)) } }
}

/// The number, or, if it lies outside, the middle between the bound that it broke and where it came from.
fn halfway(v: f64, from: f64, (low, high): (f64, f64)) -> f64 {
    if v < low {
        f64::midpoint(low, from)
    } else if v > high {
        f64::midpoint(high, from)
    } else {
        v
    }
}

/// An index below `count` that is none of the two; `count` is at least 3.
fn another(count: usize, taken: [usize; 2], rng: &mut ChaCha8Rng) -> usize {
    loop {
        let k = index(count, rng);
        if !taken.contains(&k) {
            return k;
        }
    }
}
