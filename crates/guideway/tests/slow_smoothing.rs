//! 100 000 random smoothing jobs without a collision. `cargo test --features slow --test slow_smoothing -- --nocapture`
#![cfg(feature = "slow")]

mod common_refine;

use common_refine::job;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Instant;

const JOBS: u64 = 100_000;

#[test]
fn a_hundred_thousand_jobs_are_free() {
    let (next, started) = (AtomicU64::new(1_000_000), Instant::now());
    let done = AtomicU64::new(0);
    std::thread::scope(|scope| {
        for _ in 0..2 {
            scope.spawn(|| {
                while done.load(Ordering::Relaxed) < JOBS {
                    if job(next.fetch_add(1, Ordering::Relaxed)).is_some() {
                        done.fetch_add(1, Ordering::Relaxed);
                    }
                }
            });
        }
    });
    let tried = next.into_inner() - 1_000_000;
    println!("{} jobs with a path of {tried} tried, {:.0} s on 2 threads", done.into_inner(), started.elapsed().as_secs_f64());
}
