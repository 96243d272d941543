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
    let [done, bends, corners, gaps] = [const { AtomicU64::new(0) }; 4];
    std::thread::scope(|scope| {
        for _ in 0..2 {
            scope.spawn(|| {
                while done.load(Ordering::Relaxed) < JOBS {
                    if let Some(outcome) = job(next.fetch_add(1, Ordering::Relaxed)) {
                        done.fetch_add(1, Ordering::Relaxed);
                        bends.fetch_add(outcome.bends as u64, Ordering::Relaxed);
                        corners.fetch_add(outcome.corners as u64, Ordering::Relaxed);
                        let gap = 1e6 * (outcome.smooth / outcome.raw - 1.0).max(0.0);
                        gaps.fetch_add(gap as u64, Ordering::Relaxed);
                    }
                }
            });
        }
    });
    let tried = next.into_inner() - 1_000_000;
    let done = done.into_inner();
    println!("{done} jobs with a path of {tried} tried, {:.0} s on 2 threads", started.elapsed().as_secs_f64());
    println!(
        "{} raw bends, {} corners kept, mean lengthening {:.4}",
        bends.into_inner(),
        corners.into_inner(),
        gaps.into_inner() as f64 / 1e6 / done as f64
    );
}
