//! Time of the exact any-angle planner for a disc on the `map_server` maps:
//! `cargo run --release -p guideway --example any_angle_disc [RADIUS [MAP ...]]`.

#[path = "../tests/ros_maps/mod.rs"]
mod ros_maps;

use guideway::Point;
use guideway::context::Context;
use guideway::plan::planner;
use guideway::query::Query;
use guideway::world::{Footprint, World};
use std::sync::Arc;
use std::time::Instant;

/// The first free points for the disc from two opposite corners, and from the other two.
fn far_points(world: &World, radius: f64) -> Vec<[Point; 2]> {
    let [w, h] = world.cells();
    let search = |flip: [bool; 2]| {
        (0..w.max(h)).step_by(4).find_map(|d| {
            (0..=d).step_by(4).find_map(|i| {
                let cell = [i.min(w - 1), (d - i).min(h - 1)];
                let at = [0, 1].map(|k| if flip[k] { [w, h][k] - 1 - cell[k] } else { cell[k] });
                let p = world.cell_to_map([f64::from(at[0]) + 0.5, f64::from(at[1]) + 0.5]);
                (world.clearance(p) >= radius).then_some(p)
            })
        })
    };
    let pairs = [[[false, false], [true, true]], [[true, false], [false, true]]];
    pairs.iter().filter_map(|pair| Some([search(pair[0])?, search(pair[1])?])).collect()
}

fn main() {
    let wanted: Vec<String> = std::env::args().skip(1).collect();
    let radius: f64 = wanted.first().and_then(|r| r.parse().ok()).unwrap_or(0.3);
    for yaml in ros_maps::files() {
        let name = yaml.to_string_lossy().into_owned();
        if wanted.len() > 1 && !wanted[1..].iter().any(|w| name.contains(w)) {
            continue;
        }
        let Some(world) = ros_maps::load(&yaml) else { continue };
        let world = Arc::new(world);
        for ends in far_points(&world, radius) {
            let mut query = Query::new(Arc::clone(&world), ends[0], ends[1]);
            query.footprint = Footprint::Disc(radius);
            for name in ["visibility", "lazy-theta-star"] {
                let t = Instant::now();
                let found = planner(name, serde_json::Value::Null).expect("a registered planner").plan(&query, &mut Context::new(0));
                let ms = t.elapsed().as_secs_f64() * 1e3;
                let result =
                    found.map_or_else(|e| e.to_string(), |s| format!("{:.6} m, {} expansions, {} points", s.cost, s.iterations, s.path.count()));
                println!("{} {:?} {:?} {name}: {ms:.1} ms, {result}", yaml.display(), world.cells(), ends);
            }
        }
    }
}
