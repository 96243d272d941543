//! A generation of ants: all walk on the same pheromone, each with random numbers of its own, on as many threads as there are.

use super::pheromone::Pheromone;
use super::roads::Roads;
use super::rule::Choices;
use super::walk::{Legs, Trail};
use super::workers::Workers;
use crate::context::{Context, Stop, stream};
use crate::plan::score::Aim;
use rand_chacha::ChaCha8Rng;
use std::ops::Range;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, OnceLock};

/// Nodes that may be looked at between two questions whether to go on.
const PATIENCE: usize = 1 << 21;

/// Steps that every leash allows.
const SHORTEST_LEASH: usize = 256;

/// What all walks of a colony have in common.
pub(in crate::plan) struct Crew<'a, R> {
    pub roads: &'a R,
    pub aim: Aim,
    /// Cut loops out of finished walks?
    pub cut: bool,
    /// Largest number of steps, those back included.
    pub steps: usize,
    /// That number without a leash.
    most: usize,
    legs: Mutex<Vec<Legs>>,
    workers: Option<Workers>,
}

/// One march of a generation.
pub(in crate::plan) struct March {
    pub ants: usize,
    pub from: u32,
    /// Number of the generation, different in every march of a call.
    pub number: u64,
}

impl<'a, R: Roads> Crew<'a, R> {
    /// Ants for a graph; `steps` is the largest number of steps of one ant.
    pub fn new(roads: &'a R, aim: Aim, cut: bool, steps: usize, ctx: &Context) -> Self {
        Self { roads, aim, cut, steps, most: steps, legs: Mutex::default(), workers: Workers::new(ctx.threads() - 1) }
    }

    /// Sends the ants out; `walk` is what one of them does. Results are in the order of the ants, whatever the number of threads.
    pub fn march<T: Send + Sync>(
        &self,
        march: &March,
        ctx: &mut Context,
        walk: impl Fn(usize, &mut Legs, &mut ChaCha8Rng) -> T + Sync,
    ) -> Result<Vec<T>, Stop> {
        let chunk = (PATIENCE / self.roads.nodes().max(1)).max(1 + self.others()).min(march.ants.max(1));
        let seed = ctx.seed();
        let one = |ant: usize, legs: &mut Legs| {
            legs.set_out(march.from);
            walk(ant, legs, &mut stream(seed, march.number, ant as u64))
        };
        let mut done = Vec::with_capacity(march.ants);
        for first in (0..march.ants).step_by(chunk) {
            if first > 0
                && let Some(stop) = ctx.poll()
            {
                return Err(stop);
            }
            self.together(first..(first + chunk).min(march.ants), &one, &mut done);
        }
        ctx.count_evaluations(march.ants as u64);
        Ok(done)
    }

    /// Threads besides this one.
    fn others(&self) -> usize {
        self.workers.as_ref().map_or(0, Workers::count)
    }

    /// Walks of some ants, in their order. This thread does not wait for the others to wake up: whoever is free takes the next ant.
    fn together<T: Send + Sync>(&self, ants: Range<usize>, one: &(impl Fn(usize, &mut Legs) -> T + Sync), done: &mut Vec<T>) {
        let Some(workers) = &self.workers else {
            let mut legs = self.borrow();
            done.extend(ants.map(|ant| one(ant, &mut legs)));
            self.give_back(legs);
            return;
        };
        let (next, places) = (AtomicUsize::new(0), ants.clone().map(|_| OnceLock::new()).collect::<Vec<_>>());
        workers.together(|| {
            let mut legs = self.borrow();
            loop {
                let k = next.fetch_add(1, Ordering::Relaxed);
                let Some(place) = places.get(k) else { break };
                // Nobody else has this place.
                let _ = place.set(one(ants.start + k, &mut legs));
            }
            self.give_back(legs);
        });
        done.extend(places.into_iter().filter_map(OnceLock::into_inner));
    }

    fn borrow(&self) -> Legs {
        let free = self.legs.lock().ok().and_then(|mut legs| legs.pop());
        free.unwrap_or_else(|| Legs::new(self.roads))
    }

    fn give_back(&self, legs: Legs) {
        if let Ok(mut free) = self.legs.lock() {
            free.push(legs);
        }
    }

    /// Ants that took `leash` times the steps of the best trail so far do not come home with a better one; 0: they may.
    pub fn keep_on_leash(&mut self, best: Option<&Trail>, leash: f64) {
        if let Some(best) = best.filter(|_| leash > 0.0) {
            self.steps = self.most.min(SHORTEST_LEASH.max((leash * best.exits.len() as f64) as usize));
        }
    }

    /// The plain walk: by the rule, back out of dead ends, until the target, the start again, or the last step.
    pub fn walk(&self, tau: &Pheromone, choices: &Choices, legs: &mut Legs, rng: &mut ChaCha8Rng) -> Option<Trail> {
        for _ in 0..self.steps {
            if legs.here() == choices.target() {
                return Some(legs.trail(self.roads, self.cut, self.aim));
            }
            if !legs.step(self.roads, tau, choices, |_| false, rng) && !legs.roll_back() {
                return None;
            }
        }
        (legs.here() == choices.target()).then(|| legs.trail(self.roads, self.cut, self.aim))
    }

    /// Adds pheromone along a trail.
    pub fn mark(&self, tau: &mut Pheromone, trail: &Trail, amount: f64) {
        for (exit, from) in trail.exits.iter().zip(&trail.nodes) {
            tau.deposit(self.roads, *from, *exit, amount);
        }
    }

    /// Adds pheromone along many trails.
    pub fn mark_all<'t>(&self, tau: &mut Pheromone, trails: impl Iterator<Item = (&'t Trail, f64)>) {
        for (trail, amount) in trails {
            for (exit, from) in trail.exits.iter().zip(&trail.nodes) {
                tau.gather(self.roads, *from, *exit, amount);
            }
        }
        tau.settle(self.roads);
    }

    /// A generation of plain walks; ants that did not arrive are left out.
    pub fn generation(&self, march: &March, tau: &Pheromone, choices: &Choices, ctx: &mut Context) -> Result<Vec<Trail>, Stop> {
        let trails = self.march(march, ctx, |_, legs, rng| self.walk(tau, choices, legs, rng))?;
        Ok(trails.into_iter().flatten().collect())
    }
}

/// The better of two trails; the first of equals.
pub(in crate::plan) fn better(best: Option<Trail>, next: Option<&Trail>) -> Option<Trail> {
    match (best, next) {
        (Some(best), Some(next)) => Some(if next.score.beats(best.score) { next.clone() } else { best }),
        (None, next) => next.cloned(),
        (best, None) => best,
    }
}

/// The best trail of a generation, the first of equals.
pub(in crate::plan) fn best_of(trails: &[Trail]) -> Option<&Trail> {
    trails.iter().reduce(|a, b| if b.score.beats(a.score) { b } else { a })
}
