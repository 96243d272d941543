//! Times of the distance transform and of point and segment queries: `cargo run --release --example distance_speed`.

use guideway::certify::collision;
use guideway::path::Path;
use guideway::query::Query;
use guideway::world::{Bits, Footprint, Grid, World, distance_transform, distances};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use std::hint::black_box;
use std::sync::Arc;
use std::time::Instant;

fn unit(rng: &mut ChaCha8Rng) -> f64 {
    (rng.next_u64() >> 11) as f64 / (1u64 << 53) as f64
}

fn random(side: u32, share: f64, seed: u64) -> Bits {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut bits = Bits::new(side, side);
    for y in 0..side {
        for x in 0..side {
            if unit(&mut rng) < share {
                bits.set(x, y, true);
            }
        }
    }
    bits
}

/// Least seconds of `n` calls: other work on the machine only ever adds.
fn least(n: usize, mut call: impl FnMut()) -> f64 {
    let times: Vec<f64> = (0..n)
        .map(|_| {
            let start = Instant::now();
            call();
            start.elapsed().as_secs_f64()
        })
        .collect();
    times.into_iter().fold(f64::INFINITY, f64::min)
}

fn main() {
    println!("{:>6} {:>9} {:>14} {:>14} {:>14}", "side", "blocked", "distances ms", "field ms", "clearance ms");
    for side in [1024, 4000] {
        for share in [0.2, 0.01, 0.0001] {
            let bits = random(side, share, 1);
            let n = if side > 2000 { 3 } else { 15 };
            let plain = least(n, || drop(black_box(distances(&bits))));
            let field = least(n, || drop(black_box(distance_transform(&bits))));
            let grid = Grid::new(bits.clone(), None, 0.05, [0.0; 3]).expect("a valid grid");
            let mut worlds: Vec<_> = (0..n).map(|_| World::from_grid(grid.clone())).collect();
            let clear = least(n, || drop(black_box(worlds.pop().map(|w| w.clearance_field()))));
            println!("{side:>6} {share:>9} {:>14.2} {:>14.2} {:>14.2}", plain * 1e3, field * 1e3, clear * 1e3);
        }
    }
    println!("\n{:>9} {:>14} {:>14} {:>14} {:>14} {:>14}", "blocked", "clearance ns", "after field", "fits 0.3 ns", "segment ns", "point seg. ns");
    for share in [0.2, 0.01, 0.0001] {
        queries(share);
    }
    println!();
    checker();
}

/// The checker on a walk of about 100 m over a map of 0.03 m cells.
fn checker() {
    let world = Arc::new(World::from_grid(Grid::new(random(2000, 0.0005, 4), None, 0.03, [0.0; 3]).expect("a valid grid")));
    let points: Vec<[f64; 2]> = (0..=25).map(|i| [2.0 + 2.2 * f64::from(i), 20.0 + 3.3 * f64::from(i % 2)]).collect();
    for footprint in [Footprint::Disc(0.0), Footprint::Disc(0.3), Footprint::Box([0.6, 0.4])] {
        let path = Path::polyline(&points);
        let query = Query { footprint, ..Query::new(Arc::clone(&world), points[0], points[25]) };
        let seconds = least(15, || {
            black_box(collision(&path, &query, Some(0.01)));
        });
        let found = collision(&path, &query, Some(0.01));
        println!("{:?}: {:.1} m, {} samples, ok {}: {:.2} ms", query.footprint, path.length(), found.samples, found.ok, seconds * 1e3);
    }
}

fn queries(share: f64) {
    let side = 1024;
    let world = World::from_grid(Grid::new(random(side, share, 2), None, 0.05, [0.0; 3]).expect("a valid grid"));
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    let length = f64::from(side) * 0.05;
    let points: Vec<[f64; 2]> = (0..100_000).map(|_| [length * unit(&mut rng), length * unit(&mut rng)]).collect();
    let nanos = |call: &dyn Fn([f64; 2]) -> bool| {
        let hits = std::cell::Cell::new(0u32);
        let seconds = least(25, || points.iter().for_each(|&p| hits.set(hits.get() + u32::from(call(p)))));
        black_box(hits.get());
        seconds * 1e9 / points.len() as f64
    };
    let cold = nanos(&|p| world.clearance(p) > 0.3);
    black_box(world.clearance_field());
    let warm = nanos(&|p| world.clearance(p) > 0.3);
    let fits = nanos(&|p| world.fits(p, 0.3));
    let capsule = nanos(&|p| world.segment_free(p, [p[0] + 0.31, p[1] + 0.17], 0.3));
    let point = nanos(&|p| world.segment_free(p, [p[0] + 0.31, p[1] + 0.17], 0.0));
    println!("{share:>9} {cold:>14.0} {warm:>14.0} {fits:>14.0} {capsule:>14.0} {point:>14.0}");
}
