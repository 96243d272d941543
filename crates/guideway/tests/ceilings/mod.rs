//! Random ceilings for tests of speed profiles.

use guideway::timing::Ceiling;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

/// A random ceiling: dips of random place, width and depth, some of them with a flat ground.
pub fn dips(rng: &mut ChaCha8Rng, length: f64, top: f64) -> impl Fn(f64) -> f64 + use<> {
    let count = rng.random_range(1..6);
    let dips: Vec<[f64; 4]> = (0..count)
        .map(|_| {
            let flat = if rng.random::<f64>() < 0.3 { rng.random::<f64>() } else { 0.0 };
            [length * rng.random::<f64>(), 0.05 + 0.8 * rng.random::<f64>(), 0.15 + 0.8 * rng.random::<f64>(), flat]
        })
        .collect();
    move |s: f64| dips.iter().map(|[c, w, v, f]| top * v * (1.0 + (((s - c).abs() - f).max(0.0) / w).powi(2)).sqrt()).fold(top, f64::min)
}

/// A function of the arc length as a ceiling of `count` cells.
pub fn cells(ceiling: &dyn Fn(f64) -> f64, length: f64, top: f64, count: u32) -> Ceiling {
    let n = f64::from(count);
    let lowest = |i: u32| [0.0, 0.5, 1.0].map(|x| ceiling(length * (f64::from(i) + x) / n)).into_iter().fold(top, f64::min);
    Ceiling::from_cells(length, (0..count).map(lowest).collect())
}
