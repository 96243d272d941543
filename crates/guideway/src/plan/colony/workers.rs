//! Threads beside the calling one. Generations follow each other within a fraction of a millisecond, and waking a sleeping thread takes a good part of that:
//! whoever has nothing to do looks out for the next generation for a moment before it sleeps.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};
use std::time::{Duration, Instant};

/// The longest time that an idle thread looks out for work.
const MOMENT: Duration = Duration::from_micros(500);

/// Looks between two glances at the clock; in between, others that want the processor get it.
const LOOKS: u32 = 64;

/// Some threads that work together with the calling one.
pub(super) struct Workers {
    pool: rayon::ThreadPool,
    /// Number of the last work.
    number: Arc<AtomicU64>,
}

impl Workers {
    /// That many threads; none if the system refuses them.
    pub fn new(count: usize) -> Option<Self> {
        let pool = (count > 0).then(|| rayon::ThreadPoolBuilder::new().num_threads(count).build().ok()).flatten()?;
        Some(Self { pool, number: Arc::default() })
    }

    /// Threads besides the calling one.
    pub fn count(&self) -> usize {
        self.pool.current_num_threads()
    }

    /// Does a work here and on all threads, and comes back when all have done it.
    pub fn together(&self, work: impl Fn() + Sync) {
        let left = AtomicUsize::new(self.count());
        self.pool.in_place_scope(|scope| {
            for _ in 0..self.count() {
                scope.spawn(|_| {
                    work();
                    left.fetch_sub(1, Ordering::Release);
                });
            }
            self.call();
            work();
            look_out(|| left.load(Ordering::Acquire) == 0);
        });
        self.stay_awake();
    }

    /// Ends the looking out.
    fn call(&self) {
        self.number.fetch_add(1, Ordering::Release);
    }

    /// Lets all threads look out for the next work.
    fn stay_awake(&self) {
        for _ in 0..self.count() {
            let (number, now) = (Arc::clone(&self.number), self.number.load(Ordering::Acquire));
            self.pool.spawn(move || look_out(|| number.load(Ordering::Acquire) != now));
        }
    }
}

impl Drop for Workers {
    fn drop(&mut self) {
        self.call();
    }
}

/// Waits for something that comes soon, but no longer than [`MOMENT`].
fn look_out(mut come: impl FnMut() -> bool) {
    let begun = Instant::now();
    while begun.elapsed() < MOMENT {
        for _ in 0..LOOKS {
            if come() {
                return;
            }
            std::hint::spin_loop();
        }
        std::thread::yield_now();
    }
}
