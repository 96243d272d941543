//! Smoothing on random maps: anchored, finite, free of collision under an independent sampler.

mod common_refine;

use common_refine::job;

#[test]
fn random_jobs_are_free() {
    let mut done = Vec::new();
    for seed in 0..300 {
        done.extend(job(seed));
    }
    let bends: usize = done.iter().map(|o| o.bends).sum();
    let corners: usize = done.iter().map(|o| o.corners).sum();
    let gap = done.iter().filter(|o| o.raw > 0.0).map(|o| o.smooth / o.raw - 1.0).sum::<f64>() / done.len() as f64;
    println!("{} jobs, {bends} raw bends, {corners} corners kept, mean gap {gap:.5}", done.len());
    assert!(done.len() > 200 && gap < 0.02);
    assert!(corners * 5 < bends, "most corners must become bends");
}
