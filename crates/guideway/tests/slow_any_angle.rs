#![cfg(feature = "slow")]
//! Nothing beats the exact any-angle optimum on any `map_server` map, with a point and with discs.

mod ros_maps;

use guideway::Point;
use guideway::context::Context;
use guideway::plan::planner;
use guideway::plan::search::reference;
use guideway::query::Query;
use guideway::world::{Footprint, World};
use std::sync::Arc;

/// Some free points for the disc, spread over the map; the same every time.
fn free_points(world: &World, radius: f64, count: usize) -> Vec<Point> {
    let [w, h] = world.cells();
    let mut found = Vec::new();
    for i in 0..20_000u32 {
        // A low-discrepancy sequence: multiples of the powers of the plastic number.
        let p = [0.754_877_666_246_693, 0.569_840_290_998_053].map(|a: f64| (0.5 + a * f64::from(i)).fract());
        let at = world.cell_to_map([p[0] * f64::from(w), p[1] * f64::from(h)]);
        if world.clearance(at) >= radius + 1e-6 {
            found.push(at);
            if found.len() == count {
                break;
            }
        }
    }
    found
}

#[test]
fn every_map_server_map() {
    let (mut solved, mut refused) = (0, 0);
    for yaml in ros_maps::files() {
        let Some(world) = ros_maps::load(&yaml) else { continue };
        let world = Arc::new(world);
        for radius in [0.0, 0.15, 0.3] {
            let points = free_points(&world, radius, 4);
            for pair in points.windows(2) {
                let mut query = Query::new(Arc::clone(&world), pair[0], pair[1]);
                query.footprint = Footprint::Disc(radius);
                match planner("visibility", serde_json::Value::Null).unwrap().plan(&query, &mut Context::new(0)) {
                    Ok(found) => {
                        let points = found.path.points();
                        let length: f64 = points.windows(2).map(|w| (w[1][0] - w[0][0]).hypot(w[1][1] - w[0][1])).sum();
                        assert!(length >= found.cost * (1.0 - 1e-12) && length <= found.cost * (1.0 + 1e-6), "{}", yaml.display());
                        assert!(points.windows(2).all(|w| world.segment_free(w[0], w[1], (radius - 2e-9).max(0.0))), "{} {pair:?}", yaml.display());
                        let truth = reference(&query, found.cost, None, &mut Context::new(0)).unwrap();
                        assert!(truth.proved);
                        if let Some(grid) = truth.grid_optimum {
                            assert!(grid >= found.cost * (1.0 - 1e-9), "{} {pair:?}: lattice {grid} beats {}", yaml.display(), found.cost);
                        }
                        solved += 1;
                    }
                    Err(e) => {
                        assert_eq!(e.name(), "NoPath", "{} {pair:?}", yaml.display());
                        refused += 1;
                    }
                }
            }
        }
        println!("{}: {solved} solved, {refused} without a path so far", yaml.display());
    }
}
