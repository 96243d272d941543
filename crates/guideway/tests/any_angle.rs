//! Any-angle optima against published lengths and against the planners that must not beat them.

mod moving_ai;

use guideway::Point;
use guideway::context::Context;
use guideway::plan::{Solution, planner};
use guideway::query::Query;
use guideway::world::{Corners, World};
use std::sync::Arc;

fn solve(name: &str, world: &Arc<World>, ends: [Point; 2], corners: Corners) -> Solution {
    let mut query = Query::new(Arc::clone(world), ends[0], ends[1]);
    query.corners = corners;
    planner(name, serde_json::Value::Null).unwrap().plan(&query, &mut Context::new(0)).unwrap()
}

#[test]
fn all_160_arena_optima() {
    let Some(root) = moving_ai::folder() else { return };
    let table = root.parent().unwrap().join("any_angle/derived_arena_anyangle.csv");
    let world = Arc::new(moving_ai::load(&root, "dao/arena").0);
    let height = f64::from(world.grid().unwrap().height());
    let (mut rows, mut worst) = (0, 0.0f64);
    for line in std::fs::read_to_string(table).unwrap().lines().skip(1) {
        let v: Vec<f64> = line.split(',').map(|f| f.trim().parse().unwrap()).collect();
        let [start, goal] = [[v[1] + 0.5, height - v[2] - 0.5], [v[3] + 0.5, height - v[4] - 0.5]];
        let found = solve("visibility", &world, [start, goal], Corners::Touch);
        worst = worst.max((found.cost - v[6]).abs());
        assert!((found.cost - v[6]).abs() < 1e-4, "row {}: {} instead of {}", v[0], found.cost, v[6]);
        rows += 1;
    }
    println!("{rows} rows, largest difference {worst:.1e} (published with 4 digits)");
    assert_eq!(rows, 160);
}

/// exact <= Theta*, Lazy Theta* and A* on thinned rows of every map.
fn order(thin: usize, names: &[&str]) {
    let Some(root) = moving_ai::folder() else { return };
    for map in moving_ai::names(&root) {
        let (world, rows) = moving_ai::load(&root, &map);
        let world = Arc::new(world);
        let grid = world.grid().unwrap();
        let (mut worst, mut count) = (vec![0.0f64; names.len()], 0);
        for row in rows.iter().skip(thin / 2).step_by(thin) {
            if [row.start, row.goal].iter().any(|c| grid.blocked().at(c[0], c[1])) {
                continue;
            }
            count += 1;
            let ends = [grid.center(row.start), grid.center(row.goal)];
            let exact = solve("visibility", &world, ends, Corners::Touch).cost;
            assert!(exact <= row.optimum + 0.01 && exact >= guideway::world::shape::distance(ends[0], ends[1]) - 1e-9);
            for (k, name) in names.iter().enumerate() {
                let other = solve(name, &world, ends, Corners::Touch).cost;
                let gap = if exact > 0.0 { (other - exact) / exact } else { 0.0 };
                assert!(gap >= -1e-9, "{map}: {name} {other} beats the optimum {exact} from {:?} to {:?}", ends[0], ends[1]);
                worst[k] = worst[k].max(gap);
            }
        }
        println!("{map}: {count} rows, largest gaps {names:?} {worst:?}");
    }
}

#[test]
fn nothing_beats_the_optimum_thinned() {
    order(400, &["astar", "theta-star", "lazy-theta-star"]);
}

#[test]
#[cfg(feature = "slow")]
fn nothing_beats_the_optimum() {
    order(25, &["astar", "theta-star", "lazy-theta-star"]);
}
