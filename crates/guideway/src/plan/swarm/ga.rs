//! Genetic algorithm whose chromosomes are lattice paths.
//!
//! Source: settings of the comparison in \[han2024\], after \[holland1975\]. Symbols: `N` paths, `p_c` crossover, `p_m` mutation. Departures, where the source is
//! silent: the first paths are guided walks under random keys; parents are drawn by roulette on the inverse of the cost; they are crossed at a cell that both
//! pass; a mutation puts a guided walk in place of a piece of at most `piece` steps; loops are cut; the best path lives on.

use super::decoding::{Decoding, Judge};
use super::guided_walk::{Gait, Scratch};
use super::run::{self, Found, nothing, standing, trace};
use crate::context::{Context, Stop};
use crate::error::PlanError;
use crate::optimize::Cost;
use crate::plan::legs::Leg;
use crate::plan::score::Score;
use crate::plan::search::{self as exact, Engine};
use crate::plan::{Planner, Preset, Solution};
use crate::query::Query;
use crate::world::Cell;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};

/// Genetic algorithm on lattice paths; `trace` as for [`super::Swarm`].
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Ga {
    /// Settings: ours or those of the source.
    pub preset: Preset,
    /// Paths `N`, 2 to 100000.
    pub individuals: usize,
    /// Iterations (generations).
    pub iterations: u64,
    /// Probability of crossover `p_c`.
    pub crossover: f64,
    /// Probability of mutation `p_m`.
    pub mutation: f64,
    /// Longest piece that a mutation replaces, steps.
    pub piece: usize,
    /// Stops once the best has been the same for that many iterations; 0: never.
    pub patience: u64,
    /// Keys of the walks, 1 to 10000.
    pub keys: usize,
    /// Largest number of steps of a walk, in larger sides of the map; 0: as many as it takes.
    pub walk_limit: f64,
    /// On long legs a key steers several steps.
    pub stretch: bool,
}

impl Default for Ga {
    fn default() -> Self {
        let Decoding { keys, walk_limit, stretch, .. } = Decoding::default();
        let preset = Preset::Default;
        Self {
            preset,
            individuals: 50,
            iterations: 50,
            crossover: 0.8,
            mutation: 0.3,
            piece: 8,
            patience: super::PATIENCE,
            keys,
            walk_limit,
            stretch,
        }
    }
}

impl Ga {
    /// Settings of the comparison in \[han2024\].
    pub fn paper() -> Self {
        let Decoding { keys, walk_limit, stretch, .. } = Decoding::paper();
        Self { preset: Preset::Paper, patience: 0, keys, walk_limit, stretch, ..Self::default() }
    }

    fn check(&self) -> Result<(), PlanError> {
        if !(2..=100_000).contains(&self.individuals) {
            return Err(PlanError::bad("individuals", self.individuals, "2 to 100000"));
        }
        if self.iterations == 0 {
            return Err(PlanError::bad("iterations", 0, "at least 1"));
        }
        if !(2..=10_000).contains(&self.piece) {
            return Err(PlanError::bad("piece", self.piece, "2 to 10000 steps"));
        }
        for (name, p) in [("crossover", self.crossover), ("mutation", self.mutation)] {
            if !(0.0..=1.0).contains(&p) {
                return Err(PlanError::bad(name, p, "a probability, 0 to 1"));
            }
        }
        Ok(())
    }

    fn leg(&self, leg: &Leg, ctx: &mut Context) -> Result<Found, PlanError> {
        let decoding = Decoding { keys: self.keys, walk_limit: self.walk_limit, stretch: self.stretch, ..Decoding::default() };
        let aim = self.preset.aim(leg.query);
        let mut judge = Judge::new(leg, &decoding, aim)?;
        if leg.start == leg.goal {
            return Ok(standing(leg.start, aim));
        }
        let before = ctx.evaluations();
        let probe = judge.probe(ctx);
        if probe.is_none() {
            exact::search(Engine::JumpPoint, leg, ctx)?;
        }
        let mut scratch = leg.lattice.pool().take::<Scratch>();
        let mut breed = Breed { ga: self, judge: &judge, scratch: &mut scratch, paths: Vec::new(), best: None, history: Vec::new() };
        let (iterations, stop) = breed.run(ctx);
        let Breed { mut paths, best, mut history, .. } = breed;
        leg.lattice.pool().give(scratch);
        let evaluations = ctx.evaluations() - before;
        let best = best.map(|b| b.0).or(probe);
        let Some(cells) = best else { return Err(nothing(leg.query, stop, evaluations)) };
        let score = aim.of_cells(&cells);
        if history.is_empty() {
            history.push((0, score.cost));
        }
        paths.dedup_by(|a, b| a.1 == b.1);
        let trace = trace(leg, &history, paths.into_iter().take(8).map(|p| p.0));
        Ok(Found { cells, points: None, score, history, iterations, evaluations, stop, trace })
    }
}

impl Planner for Ga {
    fn plan(&self, query: &Query, ctx: &mut Context) -> Result<Solution, PlanError> {
        self.check()?;
        run::plan(query, ctx, |leg, ctx| self.leg(leg, ctx))
    }
}

/// A path and its worth.
type Individual = (Vec<Cell>, Score);

/// One run on a leg.
struct Breed<'a> {
    ga: &'a Ga,
    judge: &'a Judge<'a>,
    scratch: &'a mut Scratch,
    /// Best first, after each generation.
    paths: Vec<Individual>,
    best: Option<Individual>,
    history: Vec<(u64, f64)>,
}

impl Breed<'_> {
    /// Iterations, and why it stopped.
    fn run(&mut self, ctx: &mut Context) -> (u64, Stop) {
        let before = ctx.evaluations();
        let ends = [self.judge.leg.start, self.judge.leg.goal];
        while self.paths.len() < self.ga.individuals && open(ctx) {
            ctx.count_evaluations(1);
            // A walk that does not arrive is a candidate lost.
            if self.walk(ends, self.judge.gait, &mut ctx.rng) {
                let path = self.scratch.cells.clone();
                self.add(path);
            } else if ctx.evaluations() - before >= 20 * self.ga.individuals as u64 {
                break;
            }
        }
        self.rank(0);
        let (mut iteration, mut improved) = (0, 0);
        let stop = loop {
            iteration += 1;
            if !self.paths.is_empty() {
                self.generation(ctx);
                improved = if self.rank(iteration) { iteration } else { improved };
            }
            let shown = self.best.as_ref().map_or(f64::INFINITY, |b| self.shown(b.1));
            if let Some(stop) = ctx.tick(shown) {
                break stop;
            }
            let idle = self.ga.patience > 0 && iteration - improved >= self.ga.patience;
            if iteration >= self.ga.iterations || idle || self.paths.is_empty() {
                break Stop::Converged;
            }
        };
        (iteration, stop)
    }

    fn shown(&self, score: Score) -> f64 {
        use crate::optimize::Objective;
        self.judge.shown(Cost { violation: 0.0, value: score.cost, tie: 0.0 })
    }

    /// A guided walk under random keys, left in the scratch.
    fn walk(&mut self, ends: [Cell; 2], gait: Gait, rng: &mut ChaCha8Rng) -> bool {
        let keys: Vec<f64> = (0..self.ga.keys).map(|_| 2.0 * rng.random::<f64>() - 1.0).collect();
        self.judge.ground.walk(ends, &keys, gait, self.scratch)
    }

    fn add(&mut self, path: Vec<Cell>) {
        let score = self.judge.aim.of_cells(&path);
        self.paths.push((path, score));
    }

    /// Sorts the paths, best first, and keeps the best ever. Has it changed?
    fn rank(&mut self, iteration: u64) -> bool {
        self.paths.sort_by(|a, b| a.1.order(b.1));
        let Some(first) = self.paths.first() else { return false };
        let old = self.best.as_ref().map_or(Score::WORST, |b| b.1);
        if !first.1.beats(old) {
            return false;
        }
        if first.1.cost < old.cost {
            self.history.push((iteration, first.1.cost));
        }
        self.best = Some(first.clone());
        true
    }

    /// Children take the place of their parents; the best path lives on.
    fn generation(&mut self, ctx: &mut Context) {
        let wheel = Wheel::new(&self.paths);
        let mut parents = std::mem::take(&mut self.paths);
        self.paths.push(parents[0].clone());
        while self.paths.len() < parents.len() && open(ctx) {
            let pair = [wheel.draw(&mut ctx.rng), wheel.draw(&mut ctx.rng)];
            let mut children = pair.map(|i| parents[i].0.clone());
            if ctx.rng.random_bool(self.ga.crossover) {
                cross(&mut children, &mut ctx.rng);
            }
            for child in children {
                if self.paths.len() == parents.len() || !open(ctx) {
                    break;
                }
                let child = self.mutated(child, &mut ctx.rng);
                ctx.count_evaluations(1);
                self.add(child);
            }
        }
        // Where the budget ended the generation early, parents live on.
        let missing = parents.len() - self.paths.len();
        self.paths.extend(parents.drain(1..=missing));
    }

    /// A piece replaced by a guided walk, with the probability of mutation; loops cut.
    fn mutated(&mut self, mut path: Vec<Cell>, rng: &mut ChaCha8Rng) -> Vec<Cell> {
        if path.len() > 2 && rng.random_bool(self.ga.mutation) {
            let from = rng.random_range(0..path.len() - 2);
            let to = rng.random_range(from + 2..=(from + self.ga.piece).min(path.len() - 1));
            let gait = Gait { stride: 1, ..self.judge.gait };
            if path[from] != path[to] && self.walk([path[from], path[to]], gait, rng) {
                path.splice(from..=to, self.scratch.cells.iter().copied());
            }
        }
        self.judge.ground.cut_path(&path, self.scratch);
        path.clear();
        path.extend_from_slice(&self.scratch.cells);
        path
    }
}

/// May more candidates be costed?
fn open(ctx: &mut Context) -> bool {
    ctx.budget().evaluations.is_none_or(|n| ctx.evaluations() < n) && ctx.poll().is_none()
}

/// Swaps the rests of two paths after a cell that both pass, drawn among those between the ends.
fn cross([a, b]: &mut [Vec<Cell>; 2], rng: &mut ChaCha8Rng) {
    let mut places: Vec<(Cell, usize)> = b[1..b.len() - 1].iter().enumerate().map(|(j, &c)| (c, j + 1)).collect();
    places.sort_unstable();
    let inner = 1..a.len().saturating_sub(1);
    let common: Vec<[usize; 2]> = inner.filter_map(|i| places.binary_search_by(|p| p.0.cmp(&a[i])).ok().map(|at| [i, places[at].1])).collect();
    if common.is_empty() {
        return;
    }
    let [i, j] = common[rng.random_range(0..common.len())];
    let rest = a.split_off(i);
    a.extend(b.splice(j.., rest));
}

/// Roulette on the inverse of the cost.
struct Wheel(Vec<f64>);

impl Wheel {
    fn new(paths: &[Individual]) -> Self {
        let mut sum = 0.0;
        let sums = paths.iter().map(|p| {
            sum += 1.0 / p.1.cost;
            sum
        });
        Self(sums.collect())
    }
    fn draw(&self, rng: &mut ChaCha8Rng) -> usize {
        let at = rng.random::<f64>() * self.0.last().copied().unwrap_or(0.0);
        self.0.partition_point(|&s| s <= at).min(self.0.len() - 1)
    }
}
