//! Mean time of the exact any-angle planner per map: `cargo run --release -p guideway --example any_angle [MAP ...]`.

#[path = "../tests/moving_ai/mod.rs"]
mod moving_ai;

use guideway::Point;
use guideway::context::Context;
use guideway::plan::planner;
use guideway::query::Query;
use guideway::world::{Bits, Grid, World};
use std::sync::Arc;
use std::time::Instant;

fn mean_ms(world: &Arc<World>, ends: &[[Point; 2]], name: &str) -> f64 {
    let planner = planner(name, serde_json::Value::Null).expect("a registered planner");
    let _lattice = world.lattice(0.0);
    let t = Instant::now();
    for pair in ends {
        let found = planner.plan(&Query::new(Arc::clone(world), pair[0], pair[1]), &mut Context::new(0));
        assert!(found.is_ok_and(|s| s.cost >= 0.0));
    }
    t.elapsed().as_secs_f64() * 1e3 / ends.len().max(1) as f64
}

/// A random map with 20 % blocked cells and a free corner at both ends.
fn random(size: u32) -> World {
    let mut state = 7u64;
    let mut blocked = Bits::new(size, size);
    for y in 0..size {
        for x in 0..size {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            blocked.set(x, y, (state >> 33).is_multiple_of(5) && x + y > 8 && x + y < 2 * size - 8);
        }
    }
    World::from_grid(Grid::new(blocked, None, 1.0, [0.0; 3]).expect("a valid grid"))
}

fn main() {
    let wanted: Vec<String> = std::env::args().skip(1).collect();
    let names = ["visibility", "theta-star", "lazy-theta-star"];
    if let Some(root) = moving_ai::folder() {
        for map in moving_ai::names(&root) {
            if !wanted.is_empty() && !wanted.iter().any(|w| map.contains(w)) {
                continue;
            }
            let (world, rows) = moving_ai::load(&root, &map);
            let world = Arc::new(world);
            let grid = world.grid().expect("a grid");
            let free = |c: [u32; 2]| !grid.blocked().at(c[0], c[1]);
            let step = (rows.len() / 50).max(1);
            let ends: Vec<_> =
                rows.iter().step_by(step).filter(|r| free(r.start) && free(r.goal)).map(|r| [grid.center(r.start), grid.center(r.goal)]).collect();
            let times: Vec<String> = names.iter().map(|n| format!("{n} {:.3}", mean_ms(&world, &ends, n))).collect();
            let lattice = rows.iter().map(|r| r.optimum).sum::<f64>() / rows.len().max(1) as f64;
            println!("{map:28} {} queries (mean 8-connected length of all {lattice:.0}), mean ms: {}", ends.len(), times.join(", "));
        }
    }
    if wanted.is_empty() || wanted.iter().any(|w| w == "big") {
        let world = Arc::new(random(4000));
        let ends = [[0.5, 0.5], [3999.5, 3999.5]];
        println!("random 4000 x 4000, 20 % blocked, corner to corner, ms: visibility {:.0}", mean_ms(&world, &[ends], "visibility"));
    }
}
