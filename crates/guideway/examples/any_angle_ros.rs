//! Times of the any-angle planners, of `explain` and of homotopy classes on `map_server` maps:
//! `cargo run --release -p guideway --example any_angle_ros RADIUS PLANNER[,PLANNER...] [MAP ...]` (`explain` and `classes` count as planners).

#[path = "../tests/ros_maps/mod.rs"]
mod ros_maps;

use guideway::Point;
use guideway::context::Context;
use guideway::plan::{homotopy, planner, search};
use guideway::query::Query;
use guideway::world::{Bits, Footprint, Lattice, World};
use std::sync::Arc;
use std::time::Instant;

/// Three pairs of far ends in the largest connected part of the lattice: first and last cell, and two that a fixed stride picks.
fn ends(lattice: &Lattice) -> Vec<[Point; 2]> {
    let (w, h) = (lattice.width(), lattice.height());
    let (mut seen, mut largest) = (Bits::new(w, h), Vec::new());
    for first in (0..h).flat_map(|y| (0..w).map(move |x| [x, y])) {
        let mut part = Vec::new();
        let mut todo = vec![first];
        while let Some(c) = todo.pop() {
            if lattice.free().at(c[0], c[1]) && !seen.at(c[0], c[1]) {
                seen.set(c[0], c[1], true);
                part.push(c);
                let (x, y) = (c[0], c[1]);
                todo.extend([[x.wrapping_sub(1), y], [x + 1, y], [x, y.wrapping_sub(1)], [x, y + 1]].into_iter().filter(|n| n[0] < w && n[1] < h));
            }
        }
        if part.len() > largest.len() {
            largest = part;
        }
    }
    largest.sort_unstable();
    let n = largest.len();
    let pairs = if n == 0 { vec![] } else { vec![(0, n - 1), (n / 7, 5 * n / 7), (3 * n / 11, 10 * n / 11)] };
    pairs.into_iter().map(|(a, b)| [largest[a], largest[b]].map(|c| lattice.center(c))).collect()
}

fn measure(world: &Arc<World>, radius: f64, name: &str) {
    for pair in ends(&world.lattice(radius)) {
        let mut query = Query::new(Arc::clone(world), pair[0], pair[1]);
        query.footprint = Footprint::Disc(radius);
        let t = Instant::now();
        if name == "explain" {
            let why = search::explain(&query, &mut Context::new(0));
            println!("    explain {:.3} s, widest {:?}", t.elapsed().as_secs_f64(), why.widest);
            continue;
        }
        if name == "classes" {
            let found = homotopy::classes(&query, 8, &mut Context::new(0)).map(|c| c.iter().map(|c| c.length).collect::<Vec<_>>());
            println!("    classes {:.3} s, {found:.3?}", t.elapsed().as_secs_f64());
            continue;
        }
        let planner = planner(name, serde_json::Value::Null).expect("a registered planner");
        match planner.plan(&query, &mut Context::new(0)) {
            Ok(found) => println!("    {name} {:.3} s, {:.6} m, {} expansions", t.elapsed().as_secs_f64(), found.cost, found.iterations),
            Err(error) => println!("    {name} {:.3} s, {error}", t.elapsed().as_secs_f64()),
        }
    }
}

fn main() {
    let mut args = std::env::args().skip(1);
    let radius = args.next().and_then(|r| r.parse().ok()).unwrap_or(0.3);
    let names = args.next().unwrap_or_else(|| "visibility,theta-star,lazy-theta-star,explain".into());
    let wanted: Vec<String> = args.collect();
    for file in ros_maps::files() {
        if !wanted.is_empty() && !wanted.iter().any(|w| file.to_string_lossy().contains(w.as_str())) {
            continue;
        }
        if let Some(world) = ros_maps::load(&file) {
            let world = Arc::new(world);
            let _field = world.clearance_field();
            println!("{} {:?}, {radius} m", file.file_stem().unwrap_or_default().to_string_lossy(), world.cells());
            names.split(',').for_each(|name| measure(&world, radius, name));
        }
    }
}
