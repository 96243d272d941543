//! Mean time of a grid query: scenario rows thinned to about 150 a map, and a large random map. `cargo bench --bench grid [-- NAME ...]`

#[path = "../tests/moving_ai/mod.rs"]
mod moving_ai;

use guideway::plan::search::{every_cell, shortest_cells};
use guideway::world::{Bits, Cell, Corners, Grid, World};
use moving_ai::Row;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::hint::black_box;
use std::time::Instant;

/// Seconds a query over all rows, best of `rounds` passes each; the first pass is shown apart. Prints one table row.
fn measure(name: &str, world: &World, rows: &[Row], rounds: u32) {
    let free = world.grid().map(|g| g.blocked().clone());
    let t = Instant::now();
    let fresh = free.and_then(|b| Grid::new(b, None, 1.0, [0.0; 3]).ok()).map(World::from_grid);
    let load = fresh.map(|w| (w.lattice(0.0).rows().len(), w.lattice(0.0).columns().len()));
    let load_time = t.elapsed().as_secs_f64();
    black_box(load);
    for corners in [Corners::Clear, Corners::Touch, Corners::Squeeze] {
        let lattice = world.lattice(0.0);
        let (mut first, mut expansions, mut out) = (0.0, 0, Vec::<Cell>::new());
        let mut best = vec![f64::INFINITY; rows.len()];
        for round in 0..rounds {
            expansions = 0;
            for (row, best) in rows.iter().zip(&mut best) {
                let t = Instant::now();
                if let Some(steps) = shortest_cells(&lattice, row.start, row.goal, corners, &mut out) {
                    expansions += steps.expansions;
                    assert!(row.optimum == 0.0 || corners != Corners::Clear || (steps.length() - row.optimum).abs() < 0.01, "{name}");
                    black_box(every_cell(&out));
                }
                let seconds = t.elapsed().as_secs_f64();
                *best = best.min(seconds);
                if round == 0 {
                    first += seconds / rows.len() as f64;
                }
            }
        }
        let best = best.iter().sum::<f64>() / rows.len() as f64;
        println!(
            "| {name} | {corners:?} | {} | {:.1} | {:.2} | {:.2} | {:.0} |",
            rows.len(),
            load_time * 1e6,
            first * 1e6,
            best * 1e6,
            expansions as f64 / rows.len() as f64
        );
    }
}

fn random(side: u32) -> (World, Vec<Row>) {
    let mut rng = ChaCha8Rng::seed_from_u64(4000);
    let mut bits = Bits::new(side, side);
    for y in 0..side {
        for x in 0..side {
            bits.set(x, y, rng.random_bool(0.2));
        }
    }
    let mut cell = || [rng.random_range(0..side), rng.random_range(0..side)];
    let rows = (0..16).map(|_| Row { start: cell(), goal: cell(), optimum: 0.0 }).collect();
    (World::from_grid(Grid::new(bits, None, 1.0, [0.0; 3]).expect("a valid grid")), rows)
}

fn main() {
    let wanted: Vec<String> = std::env::args().skip(1).filter(|a| !a.starts_with('-')).collect();
    let chosen = |name: &str| wanted.is_empty() || wanted.iter().any(|w| name.contains(w.as_str()));
    println!("| map | corners | rows | load us | first pass us | best pass us | expansions |\n|---|---|---|---|---|---|---|");
    if let Some(root) = moving_ai::folder() {
        for name in moving_ai::names(&root).iter().filter(|n| chosen(n)) {
            let (world, rows) = moving_ai::load(&root, name);
            let step = (rows.len() / 150).max(1);
            measure(name, &world, &rows.into_iter().step_by(step).collect::<Vec<_>>(), 5);
        }
    }
    if chosen("random4000") {
        let (world, rows) = random(4000);
        measure("random4000", &world, &rows, 2);
    }
}
