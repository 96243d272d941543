//! The one mutable argument of every method: seed, budget, progress and cancel.

use crate::error::PlanError;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use serde::{Deserialize, Serialize};
use std::time::{Duration, Instant};

/// How much work a method may do. `None` means no limit of that kind.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Budget {
    /// Iterations of the method's own loop.
    pub iterations: Option<u64>,
    /// Evaluations: candidates costed.
    pub evaluations: Option<u64>,
    /// Wall-clock time, s. Results under this budget depend on the machine.
    pub seconds: Option<f64>,
}

/// Why a method stopped.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Stop {
    /// The method finished by its own rule (for exact searches: proved optimal).
    Converged,
    /// A budget was spent; the best so far is the result.
    Budget,
    /// The caller asked to stop; the best so far is the result.
    Cancelled,
}

/// What an observer sees after an iteration.
#[derive(Debug, Clone, Copy)]
pub struct Progress {
    /// Iterations done.
    pub iteration: u64,
    /// Candidates costed.
    pub evaluations: u64,
    /// Best cost so far (infinite if none).
    pub best: f64,
    /// Share of the budget that is spent, 0 to 1 (`None` without a budget).
    pub share: Option<f64>,
    /// Wall-clock time since the start, s.
    pub seconds: f64,
}

/// Returns true to cancel. Called from the planning thread, at most every few milliseconds.
pub type Observer<'a> = dyn FnMut(&Progress) -> bool + 'a;

/// Seed, budget, progress and cancel of one call.
pub struct Context<'a> {
    /// The only source of randomness of serial code.
    pub rng: ChaCha8Rng,
    seed: u64,
    budget: Budget,
    threads: usize,
    started: Instant,
    iterations: u64,
    evaluations: u64,
    history: Vec<(u64, f64)>,
    best: f64,
    cancelled: bool,
    observer: Option<&'a mut Observer<'a>>,
    observed: Option<Instant>,
}

/// Random numbers of one individual of one iteration: the same for every number of threads.
pub fn stream(seed: u64, iteration: u64, individual: u64) -> ChaCha8Rng {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    // Streams of one seed never meet; stream 0 is the serial one.
    rng.set_stream((iteration << 24 | individual & 0x00ff_ffff) + 1);
    rng
}

impl<'a> Context<'a> {
    /// A context without budget or observer, one thread.
    pub fn new(seed: u64) -> Self {
        Self {
            rng: ChaCha8Rng::seed_from_u64(seed),
            seed,
            budget: Budget::default(),
            threads: 1,
            started: Instant::now(),
            iterations: 0,
            evaluations: 0,
            history: Vec::new(),
            best: f64::INFINITY,
            cancelled: false,
            observer: None,
            observed: None,
        }
    }

    /// Sets the budget.
    /// # Errors
    /// [`PlanError::BadParameter`] if `seconds` is negative or not a number.
    pub fn with_budget(mut self, budget: Budget) -> Result<Self, PlanError> {
        if let Some(s) = budget.seconds
            && !(s >= 0.0 && s.is_finite())
        {
            return Err(PlanError::bad("seconds", s, "a finite number >= 0"));
        }
        self.budget = budget;
        Ok(self)
    }

    /// Sets the number of worker threads (0 and 1 both mean serial). Never changes a result.
    #[must_use]
    pub fn with_threads(mut self, threads: usize) -> Self {
        self.threads = threads.max(1);
        self
    }

    /// Sets the observer; it returns true to cancel.
    #[must_use]
    pub fn with_observer(mut self, observer: &'a mut Observer<'a>) -> Self {
        self.observer = Some(observer);
        self
    }

    /// Ends one iteration of a method's loop: counts it, records an improvement, asks budget and observer.
    /// Use as `if let Some(stop) = ctx.tick(best) { break stop; }`.
    pub fn tick(&mut self, best: f64) -> Option<Stop> {
        self.iterations += 1;
        if best < self.best {
            self.best = best;
            self.history.push((self.iterations, best));
        }
        if self.budget.iterations.is_some_and(|n| self.iterations >= n) || self.budget.evaluations.is_some_and(|n| self.evaluations >= n) {
            return Some(Stop::Budget);
        }
        self.poll()
    }

    /// Asks the clock and the observer only; for exact searches, every few thousand expansions.
    pub fn poll(&mut self) -> Option<Stop> {
        if self.cancelled {
            return Some(Stop::Cancelled);
        }
        let now = Instant::now();
        if self.budget.seconds.is_some_and(|s| (now - self.started).as_secs_f64() >= s) {
            return Some(Stop::Budget);
        }
        if self.observed.is_none_or(|t| now - t >= Duration::from_millis(10)) {
            self.observed = Some(now);
            let progress = self.progress();
            if let Some(observer) = self.observer.as_mut()
                && observer(&progress)
            {
                self.cancelled = true;
                return Some(Stop::Cancelled);
            }
        }
        None
    }

    /// Runs a part of a method that may take no more than that many of the iterations and evaluations that are left.
    pub fn portion<T>(&mut self, iterations: Option<u64>, evaluations: Option<u64>, part: impl FnOnce(&mut Self) -> T) -> T {
        let whole = self.budget;
        let end = |done: u64, more: Option<u64>, most: Option<u64>| match (more, most) {
            (Some(n), Some(most)) => Some(done.saturating_add(n).min(most)),
            (Some(n), None) => Some(done.saturating_add(n)),
            (None, most) => most,
        };
        self.budget.iterations = end(self.iterations, iterations, whole.iterations);
        self.budget.evaluations = end(self.evaluations, evaluations, whole.evaluations);
        let result = part(self);
        self.budget = whole;
        result
    }

    /// Is a budget spent, or has the caller cancelled? Unlike [`Context::poll`] also by counts.
    pub fn spent(&mut self) -> Option<Stop> {
        if self.budget.iterations.is_some_and(|n| self.iterations >= n) || self.budget.evaluations.is_some_and(|n| self.evaluations >= n) {
            return Some(Stop::Budget);
        }
        self.poll()
    }

    /// Has the run end as if the observer had asked for it.
    pub fn cancel(&mut self) {
        self.cancelled = true;
    }

    /// Counts `n` candidates as costed.
    pub fn count_evaluations(&mut self, n: u64) {
        self.evaluations += n;
    }

    fn progress(&self) -> Progress {
        let seconds = self.seconds();
        let shares = [
            self.budget.iterations.map(|n| self.iterations as f64 / n.max(1) as f64),
            self.budget.evaluations.map(|n| self.evaluations as f64 / n.max(1) as f64),
            self.budget.seconds.map(|s| seconds / s.max(1e-9)),
        ];
        let share = shares.into_iter().flatten().reduce(f64::max).map(|s| s.min(1.0));
        Progress { iteration: self.iterations, evaluations: self.evaluations, best: self.best, share, seconds }
    }

    /// Seed of this call; parallel streams derive from it and an index.
    pub fn seed(&self) -> u64 {
        self.seed
    }
    /// The budget of this call.
    pub fn budget(&self) -> Budget {
        self.budget
    }
    /// Worker threads to use, at least 1.
    pub fn threads(&self) -> usize {
        self.threads
    }
    /// Iterations done.
    pub fn iterations(&self) -> u64 {
        self.iterations
    }
    /// Candidates costed.
    pub fn evaluations(&self) -> u64 {
        self.evaluations
    }
    /// Wall-clock time since the start, s.
    pub fn seconds(&self) -> f64 {
        self.started.elapsed().as_secs_f64()
    }
    /// (iteration, best cost) at each improvement; moved out, and a new record begins.
    pub fn take_history(&mut self) -> Vec<(u64, f64)> {
        self.best = f64::INFINITY;
        std::mem::take(&mut self.history)
    }
}
