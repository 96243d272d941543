//! Times the cost-to-go of a map of 512 x 512 cells: `cargo run --release --example cost_to_go`.

use guideway::drive::CostToGo;
use guideway::query::Soft;
use guideway::world::{Bits, Grid, World};
use std::time::Instant;

fn main() -> Result<(), guideway::error::PlanError> {
    let mut blocked = Bits::new(512, 512);
    for (k, x) in (0..).zip((64..512).step_by(64)) {
        let gap = if k % 2 == 0 { 20..40 } else { 470..490 };
        (0..512).filter(|y| !gap.contains(y)).for_each(|y| blocked.set(x, y, true));
    }
    let world = World::from_grid(Grid::new(blocked, None, 0.05, [0.0; 3])?);
    world.clearance_field();
    let mut seconds: Vec<f64> = (0..50)
        .map(|_| {
            let started = Instant::now();
            let field = CostToGo::new(&world, [25.0, 25.0], [0.2, 0.3], Soft::default());
            assert!(field.way([0.5, 0.5]).is_some());
            started.elapsed().as_secs_f64()
        })
        .collect();
    seconds.sort_by(f64::total_cmp);
    println!("median {:.4} s, slowest {:.4} s", seconds[25], seconds[49]);
    Ok(())
}
