//! Covariance matrix adaptation: a normal distribution that learns the shape of the function, started again with other populations.
//!
//! Source: \[hansen2016\] for one run, \[auger2005\] and \[hansen2009\] for the restarts. Symbols: `lambda` population, `sigma` step, `m` mean. The box is
//! scaled to a unit cube. Departures: the function goes on outside the box as if its sides were mirrors, and the distribution is held not to outgrow the
//! box; a run ends when its last places are equally good, when it has shrunk to a point, or when its covariance is degenerate; without a hint a run begins
//! at a random place.

use super::distribution::{Distribution, Rates};
use super::record::{Record, check, first, within};
use super::schedule::Schedule;
use super::{Cost, Minimum, Objective, Optimizer, evaluate};
use crate::context::{Context, Stop};
use crate::error::PlanError;
use rand::RngExt;
use serde::{Deserialize, Serialize};
use std::collections::VecDeque;

/// What follows when a run has ended before the budget.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Restarts {
    /// Nothing.
    Off,
    /// Runs with ever more individuals.
    Ipop,
    /// Runs with ever more individuals, and short ones with few in between.
    #[default]
    Bipop,
}

/// Covariance matrix adaptation evolution strategy.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct CmaEs {
    /// Individuals `lambda` of the first run, at least 4; 0: 4 and 3 times the logarithm of the number of numbers.
    pub population: usize,
    /// Generations of all runs, if the budget names neither iterations nor evaluations.
    pub iterations: u64,
    /// Step `sigma` at first, share of each side of the box, above 0 to 2.
    pub step: f64,
    /// Step of the first run if there are hints, share of each side of the box.
    pub hint_step: f64,
    /// Restarts.
    pub restarts: Restarts,
    /// Factor of the population from large run to large run, 1 to 10.
    pub growth: f64,
    /// The worse half of a generation counts too, against its directions.
    pub active: bool,
    /// Ends a run once it spans no more than that share of any side of the box, 0 to 1.
    pub tolerance: f64,
    /// Stops once the best has been the same for that many generations; 0: never.
    pub patience: u64,
}

impl Default for CmaEs {
    fn default() -> Self {
        Self {
            population: 0,
            iterations: 4000,
            step: 0.3,
            hint_step: 0.05,
            restarts: Restarts::Bipop,
            growth: 2.0,
            active: true,
            tolerance: 1e-12,
            patience: 0,
        }
    }
}

impl Optimizer for CmaEs {
    fn minimize(&self, f: &dyn Objective, ctx: &mut Context) -> Result<Minimum, PlanError> {
        let population = self.check(f)?;
        let last = Schedule::new(self.iterations, ctx).generations(0, 4);
        let mut search = Search { method: self, f, record: Record::new(last, self.patience, ctx), xs: Vec::new(), costs: Vec::new() };
        let mut plan = Plan { base: population, large: 0, spent: [0; 2] };
        let hints = f.hints().len();
        let mut next = Next { population, step: if hints > 0 { self.hint_step } else { self.step }, most: u64::MAX, small: false };
        loop {
            let before = ctx.evaluations();
            if let Some(stop) = search.run(&next, ctx)? {
                return Ok(search.record.finish(stop, search.xs, search.costs, ctx));
            }
            plan.spent[usize::from(next.small)] += ctx.evaluations() - before;
            next = plan.next(self, ctx);
        }
    }
}

impl CmaEs {
    /// Checks the parameters; gives back the size of the population.
    fn check(&self, f: &dyn Objective) -> Result<usize, PlanError> {
        let population = if self.population == 0 { 4 + (3.0 * (f.bounds().len().max(1) as f64).ln()) as usize } else { self.population };
        check(f, "population", population, self.iterations)?;
        check(f, "numbers of the objective", f.bounds().len().max(2), 1)?;
        if population < 4 {
            return Err(PlanError::bad("population", population, "0 or at least 4"));
        }
        within("step", self.step, [1e-9, 2.0])?;
        within("hint_step", self.hint_step, [1e-9, 2.0])?;
        within("growth", self.growth, [1.0, 10.0])?;
        within("tolerance", self.tolerance, [0.0, 1.0])?;
        Ok(population)
    }
}

/// The next run.
struct Next {
    population: usize,
    step: f64,
    /// Evaluations that it may take.
    most: u64,
    small: bool,
}

/// Which runs there have been.
struct Plan {
    base: usize,
    /// Large runs.
    large: i32,
    /// Evaluations of large and small runs.
    spent: [u64; 2],
}

impl Plan {
    /// The next run: large, or small if those have had less.
    fn next(&mut self, method: &CmaEs, ctx: &mut Context) -> Next {
        let largest = self.base as f64 * method.growth.powi(self.large);
        if method.restarts == Restarts::Bipop && self.large > 0 && self.spent[1] < self.spent[0] {
            let [u, w] = [ctx.rng.random::<f64>(), ctx.rng.random::<f64>()];
            let population = self.base as f64 * (0.5 * largest / self.base as f64).max(1.0).powf(u * u);
            return Next { population: population as usize, step: method.step * 10f64.powf(-2.0 * w), most: self.spent[0] / 2, small: true };
        }
        self.large += 1;
        let population = self.base as f64 * method.growth.powi(self.large);
        Next { population: population.min(1e6) as usize, step: method.step, most: u64::MAX, small: false }
    }
}

/// All runs.
struct Search<'a> {
    method: &'a CmaEs,
    f: &'a dyn Objective,
    record: Record,
    xs: Vec<Vec<f64>>,
    costs: Vec<Cost>,
}

impl Search<'_> {
    /// One run; `Some` if it was the last.
    fn run(&mut self, next: &Next, ctx: &mut Context) -> Result<Option<Stop>, PlanError> {
        let (bounds, count, before) = (self.f.bounds(), next.population, ctx.evaluations());
        let mut units = vec![vec![0.0; bounds.len()]; count];
        self.xs.clone_from(&units);
        let mut distribution = self.begin(next, ctx)?;
        let mut lately = VecDeque::new();
        let window = 10 + (30 * bounds.len()).div_ceil(count);
        loop {
            self.record.begin();
            for (unit, x) in units.iter_mut().zip(&mut self.xs) {
                distribution.draw(unit, &mut ctx.rng);
                place(unit, x, bounds);
            }
            self.costs = evaluate(self.f, &self.xs, ctx)?;
            self.xs.iter().zip(&self.costs).for_each(|(x, cost)| self.record.offer(x, *cost));
            if let Some(stop) = self.record.tick(self.f, ctx) {
                return Ok(Some(stop));
            }
            let mut order: Vec<usize> = (0..count).collect();
            order.sort_by(|&a, &b| self.costs[a].order(self.costs[b]));
            distribution.learn(&order.iter().map(|&i| units[i].as_slice()).collect::<Vec<_>>());
            distribution.hold(1.0);
            lately.push_back(self.costs[order[0]]);
            if lately.len() > window {
                lately.pop_front();
            }
            let flat = lately.len() == window && level(lately.iter().copied().chain([self.costs[order[count / 2]]]));
            let over = ctx.evaluations() - before >= next.most;
            if flat || over || distribution.reach() < self.method.tolerance || distribution.degenerate() {
                return Ok((self.method.restarts == Restarts::Off).then_some(Stop::Converged));
            }
        }
    }

    /// The distribution of a run: the first one at the best hint, the others anywhere.
    fn begin(&mut self, next: &Next, ctx: &mut Context) -> Result<Distribution, PlanError> {
        let bounds = self.f.bounds();
        let hints = if self.record.iterations() == 0 { first(self.f, self.f.hints().len(), ctx)? } else { Vec::new() };
        let costs = evaluate(self.f, &hints, ctx)?;
        hints.iter().zip(&costs).for_each(|(x, cost)| self.record.offer(x, *cost));
        let best = hints.iter().zip(&costs).min_by(|a, b| a.1.order(*b.1));
        let mean = match best {
            Some((x, _)) => x.iter().zip(bounds).map(|(v, (low, high))| (v - low) / (high - low)).collect(),
            None => bounds.iter().map(|_| ctx.rng.random()).collect(),
        };
        Ok(Distribution::new(mean, next.step, Rates::new(bounds.len(), next.population, self.method.active)))
    }
}

/// Where in the box a place is that is mirrored at the sides of the unit cube.
fn place(unit: &[f64], x: &mut [f64], bounds: &[(f64, f64)]) {
    for ((u, v), (low, high)) in unit.iter().zip(x).zip(bounds) {
        let turned = if (0.0..=1.0).contains(u) { *u } else { 1.0 - (u.rem_euclid(2.0) - 1.0).abs() };
        *v = (low + turned * (high - low)).clamp(*low, *high);
    }
}

/// Are all costs equal but for rounding?
fn level(costs: impl Iterator<Item = Cost>) -> bool {
    let (mut low, mut high) = (Cost::WORST, Cost::of(f64::NEG_INFINITY));
    for cost in costs {
        low = if cost.beats(low) { cost } else { low };
        high = if high.beats(cost) { cost } else { high };
    }
    let near = |a: f64, b: f64| (a - b).abs() <= 1e-12 * a.abs().max(b.abs()).max(1e-300);
    near(low.violation, high.violation) && near(low.value, high.value)
}
