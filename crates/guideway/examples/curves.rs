//! Rate of the whole objective over splines in the room `w0`, exact clearance included, how it splits, and the rate of whole runs of optimizers:
//!
//! `cargo run --release --package guideway --example curves`

use guideway::context::{Budget, Context};
use guideway::error::PlanError;
use guideway::plan::planner;
use guideway::plan::swarm::{Curves, Settings};
use guideway::query::{Limits, Query};
use guideway::world::{Footprint, Shape, World};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use std::hint::black_box;
use std::time::Instant;

/// x, y, diameter of the cylinders, m.
const DISCS: [[f64; 3]; 8] = [
    [1.20, 0.95, 0.8],
    [2.35, 1.55, 0.6],
    [2.10, 3.00, 1.0],
    [3.70, 2.05, 0.9],
    [4.10, 0.60, 0.7],
    [6.50, 1.50, 1.2],
    [7.50, 4.20, 1.0],
    [0.90, 3.90, 0.5],
];
const CANDIDATES: usize = 20_000;
const ROUNDS: usize = 9;
const EVALUATIONS: u64 = 20_000;

fn room() -> Result<Query, PlanError> {
    let shapes = DISCS.iter().map(|[x, y, d]| Shape::disc([*x, *y], d / 2.0)).collect::<Result<_, _>>()?;
    let world = World::from_shapes([0.0, 0.0, 10.0, 6.0], shapes, 0.05)?;
    let mut query = Query::new(world.into(), [0.0, 0.0], [5.0, 3.0]);
    (query.footprint, query.clearance) = (Footprint::Disc(0.0), 0.3);
    query.limits = Limits {
        speed: 2.0,
        acceleration: 5.0,
        deceleration: 5.0,
        jerk: 10.0,
        turn_rate: Some(2.0),
        lateral_acceleration: Some(2.0),
        ..Limits::default()
    };
    Ok(query)
}

/// The median over some rounds of the seconds that a call takes.
fn seconds(mut call: impl FnMut()) -> f64 {
    let mut all: Vec<f64> = (0..ROUNDS)
        .map(|_| {
            let from = Instant::now();
            call();
            from.elapsed().as_secs_f64()
        })
        .collect();
    all.sort_by(f64::total_cmp);
    all[ROUNDS / 2]
}

fn rates(name: &str, curves: &Curves, xs: &[Vec<f64>]) {
    let took = seconds(|| {
        for x in xs {
            let _ = black_box(curves.judge(black_box(x)));
        }
    });
    let free = xs.iter().filter(|x| curves.judge(x).cost().feasible()).count();
    let split = curves.split(xs).map(|s| format!("{:.1}", 1e6 * s / xs.len() as f64)).join(", ");
    let count = xs.len() as f64;
    println!("| {name} | {:.0} % | {:.0} | {split} |", 100.0 * free as f64 / count, count / took);
}

fn main() -> Result<(), PlanError> {
    use guideway::optimize::Objective;
    let query = room()?;
    let curves = Curves::new(&query, &Settings::default())?;
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let anywhere: Vec<Vec<f64>> =
        (0..CANDIDATES).map(|_| curves.bounds().iter().map(|(low, high)| rng.random_range(*low..=*high)).collect()).collect();
    let exact = planner("visibility", serde_json::Value::Null)?.plan(&query, &mut Context::new(1))?;
    let good = curves.fit(exact.path.control().as_chunks::<2>().0);
    let near = |x: f64, (low, high): (f64, f64), rng: &mut ChaCha8Rng| (x + 0.02 * (high - low) * rng.random_range(-1.0..1.0)).clamp(low, high);
    let beside: Vec<Vec<f64>> =
        (0..CANDIDATES).map(|_| good.iter().zip(curves.bounds()).map(|(x, range)| near(*x, *range, &mut rng)).collect()).collect();
    println!("| candidates | free | evaluations/s | curve, clearance, length, motion, us |\n|---|---|---|---|");
    rates("all over the room", &curves, &anywhere);
    rates("about the shortest path", &curves, &beside);
    println!("\n| whole runs of {EVALUATIONS} evaluations | evaluations/s |\n|---|---|");
    for name in ["de", "improved-de", "l-shade", "cma-es"] {
        let method = planner(name, serde_json::Value::Null)?;
        let mut costed = 0;
        let took = seconds(|| {
            let mut ctx =
                Context::new(1).with_budget(Budget { evaluations: Some(EVALUATIONS), ..Budget::default() }).unwrap_or_else(|e| panic!("{e}"));
            costed = method.plan(&query, &mut ctx).map_or(0, |found| found.evaluations);
        });
        println!("| `{name}` | {:.0} |", costed as f64 / took);
    }
    Ok(())
}
