//! The three products of one query: shortest, safest, least energy, on the two calibrated stand-in scenes and among shapes.

mod stand_ins;

use guideway::certify;
use guideway::context::Context;
use guideway::error::PlanError;
use guideway::plan::{REGISTRY, Solution, planner, score};
use guideway::query::{Material, Query};
use guideway::refine::{Refiner, Simplify, Smooth};
use guideway::world::{Corners, Footprint, Shape, World};
use serde_json::Value;
use stand_ins::{SCENES, least_turns, scene};
use std::sync::Arc;

fn long(mut query: Query) -> Query {
    (query.material, query.corners) = (Material::Long, Corners::Clear);
    query
}

fn solve(name: &str, query: &Query) -> Solution {
    planner(name, Value::Null).unwrap().plan(query, &mut Context::new(0)).unwrap()
}

#[test]
fn the_safest_lattice_optimum_is_the_published_one_and_keeps_half_a_cell() {
    for (text, [diagonal, straight], turns) in [(SCENES[0], [15, 8], 7), (SCENES[1], [10, 18], 13)] {
        let query = long(scene(text));
        assert!((query.radius() - 0.5).abs() < 1e-12, "the marking is half a cell");
        for name in ["dijkstra", "astar", "jump-point"] {
            let found = solve(name, &query);
            assert_eq!(score::counts(&found.cells.unwrap())[..2], [straight, diagonal], "{name}");
            let clear = certify::collision(&found.path, &query, None);
            assert!(clear.ok && (clear.min_clearance - 0.5).abs() < 1e-9, "{name}: {clear:?}");
            assert!(certify::marking(&found.path, &query, None).unwrap().ok);
        }
        let (cells, fewest) = least_turns(text, Corners::Clear);
        assert_eq!((score::counts(&cells), fewest), ([straight, diagonal, turns], turns));
    }
}

#[test]
fn every_planner_and_the_refinements_keep_a_long_load_off_the_obstacles() {
    for text in SCENES {
        let query = long(scene(text));
        for entry in REGISTRY {
            let found = solve(entry.name, &query);
            let smooth = Smooth::default().refine(&found.path, &query, &mut Context::new(0)).unwrap().path;
            let simple = Simplify::default().refine(&found.path, &query, &mut Context::new(0)).unwrap().path;
            for path in [found.path, smooth, simple] {
                let marking = certify::marking(&path, &query, None).unwrap();
                assert!(marking.ok && marking.min_clearance >= 0.5 - 1e-9, "{}: {marking:?}", entry.name);
                assert!(certify::collision(&path, &query, None).ok);
            }
        }
    }
}

#[test]
fn the_marking_never_blocks_a_point_and_gives_way_no_further_than_needed() {
    let mut query = long(scene(SCENES[0]));
    query.start = [0.5, 0.3]; // 0.5 m from the blocked cell on the right, 0.3 m from the border, which is no obstacle
    assert_eq!(query.radius(), 0.5);
    query.start = [0.8, 0.5];
    assert!((query.radius() - 0.2).abs() < 1e-9);
    for name in ["visibility", "theta-star", "jump-point"] {
        let found = solve(name, &query);
        let marking = certify::marking(&found.path, &query, None).unwrap();
        assert!(marking.ok && marking.min_clearance >= 0.2 - 1e-9, "{name}: {marking:?}");
    }
    query.start = [1.5, 2.0]; // touches the blocked cell below
    assert_eq!(query.radius(), 0.0);
    assert!(certify::marking(&solve("visibility", &query).path, &query, None).is_none());
}

#[test]
fn a_checker_that_shares_nothing_sees_a_broken_marking() {
    let (mut shortest, marked) = (scene(SCENES[0]), long(scene(SCENES[0])));
    shortest.material = Material::Standard;
    let touching = solve("visibility", &shortest).path;
    assert!(certify::collision(&touching, &marked, None).ok, "it is free");
    let marking = certify::marking(&touching, &marked, None).unwrap();
    assert!(!marking.ok && marking.min_clearance < 1e-6, "{marking:?}");
}

#[test]
fn the_half_width_of_the_load_blocks_cells_and_counts_for_long_loads_alone() {
    let mut query = scene(SCENES[0]);
    query.half_width = 0.9;
    assert_eq!(query.radius(), 0.0);
    let query = long(query);
    assert_eq!(query.radius(), 0.9);
    assert!(matches!(query.validate(), Err(PlanError::StartBlocked { needed, .. }) if needed == 0.9));
    let mut bad = long(scene(SCENES[0]));
    for width in [-1.0, f64::NAN, 1e7] {
        bad.half_width = width;
        assert!(matches!(bad.validate(), Err(PlanError::BadParameter { .. })));
    }
}

#[test]
fn among_shapes_the_same_promise_holds() {
    let shapes = vec![Shape::disc([3.0, 2.0], 0.5).unwrap(), Shape::polygon(vec![[5.0, 0.0], [6.0, 0.0], [5.5, 2.6]]).unwrap()];
    let world = Arc::new(World::from_shapes([0.0, 0.0, 9.0, 4.0], shapes, 0.2).unwrap());
    let mut query = long(Query::new(world, [1.0, 2.0], [8.0, 1.0]));
    for (half_width, footprint, radius) in [(0.0, 0.0, 0.1), (0.4, 0.0, 0.4), (0.4, 0.2, 0.4), (0.1, 0.3, 0.3)] {
        (query.half_width, query.footprint) = (half_width, Footprint::Disc(footprint));
        assert!((query.radius() - radius).abs() < 1e-12);
        for entry in REGISTRY {
            let found = solve(entry.name, &query);
            let path = Smooth::default().refine(&found.path, &query, &mut Context::new(0)).unwrap().path;
            for path in [&found.path, &path] {
                let least = certify::marking(path, &query, None)
                    .map_or_else(|| certify::collision(path, &query, None).min_clearance + footprint, |m| m.min_clearance);
                assert!(least >= radius - 1e-9, "{}: {least} of {radius}", entry.name);
            }
        }
    }
}
