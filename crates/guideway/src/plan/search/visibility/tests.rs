use super::*;
use crate::Point;
use crate::world::shape::distance;
use crate::world::{Bits, Footprint, Grid, Shape, World};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::sync::Arc;

fn disc_query(world: World, start: Point, goal: Point, radius: f64) -> Query {
    let mut query = Query::new(Arc::new(world), start, goal);
    query.footprint = Footprint::Disc(radius);
    query
}

fn discs(bounds: [f64; 4], list: &[(f64, f64, f64)]) -> World {
    let shapes = list.iter().map(|&(x, y, d)| Shape::disc([x, y], d / 2.0).unwrap()).collect();
    World::from_shapes(bounds, shapes, 0.05).unwrap()
}

fn solve(query: &Query) -> Solution {
    Visibility::default().plan(query, &mut Context::new(0)).unwrap()
}

/// Every segment free, ends right, polyline longer than the exact length by less than 1e-6.
fn certify(query: &Query, found: &Solution) {
    let points = found.path.points();
    assert_eq!((points[0], points[points.len() - 1]), (query.start, query.goal));
    let length: f64 = points.windows(2).map(|w| distance(w[0], w[1])).sum();
    assert!(length >= found.cost * (1.0 - 1e-12) && length <= found.cost * (1.0 + 1e-6), "{length} for {}", found.cost);
    for w in points.windows(2) {
        assert!(query.world.segment_free(w[0], w[1], query.radius() - 2e-9), "{w:?}");
    }
}

#[test]
fn one_disc_by_hand() {
    let query = disc_query(discs([-5.0, -5.0, 5.0, 5.0], &[(0.0, 0.0, 2.0)]), [-3.0, 0.0], [3.0, 0.0], 0.5);
    let found = solve(&query);
    // Tangents of length sqrt(9 - 1.5^2) and the arc between them.
    let expected = 2.0 * (9.0f64 - 2.25).sqrt() + 1.5 * (std::f64::consts::PI - 2.0 * (1.5f64 / 3.0).acos());
    assert!((found.cost - expected).abs() < 1e-12, "{} instead of {expected}", found.cost);
    certify(&query, &found);
}

#[test]
fn one_square_by_hand() {
    let mut bits = Bits::new(9, 9);
    bits.set(4, 4, true);
    let world = World::from_grid(Grid::new(bits, None, 1.0, [0.0; 3]).unwrap());
    let query = disc_query(world, [1.5, 4.5], [7.5, 4.5], 0.75);
    let found = solve(&query);
    // Around two corners at (4, 5) and (5, 5) with radius 0.75: tangent, arc, straight 1, arc, tangent.
    let (dx, dy) = (2.5f64, 0.5f64);
    let d = dx.hypot(dy);
    let tangent = (d * d - 0.75f64 * 0.75).sqrt();
    let direction = dy.atan2(dx) + (0.75 / d).asin();
    let expected = 2.0 * tangent + 2.0 * 0.75 * direction + 1.0;
    assert!((found.cost - expected).abs() < 1e-12, "{} instead of {expected}", found.cost);
    certify(&query, &found);
}

#[test]
fn room_and_workshop_of_the_test_worlds() {
    let room = [
        (1.20, 0.95, 0.8),
        (2.35, 1.55, 0.6),
        (2.10, 3.00, 1.0),
        (3.70, 2.05, 0.9),
        (4.10, 0.60, 0.7),
        (6.50, 1.50, 1.2),
        (7.50, 4.20, 1.0),
        (0.90, 3.90, 0.5),
    ];
    let query = disc_query(discs([0.0, 0.0, 10.0, 6.0], &room), [0.0, 0.0], [5.0, 3.0], 0.3);
    let found = solve(&query);
    println!("room {:.9} m", found.cost);
    assert!((found.cost - 6.198).abs() < 0.005, "{}", found.cost);
    certify(&query, &found);
    let workshop = [
        (2.79, 0.92, 0.84),
        (7.31, 4.55, 0.71),
        (10.46, 7.74, 0.94),
        (5.44, 3.40, 1.07),
        (7.82, 6.73, 1.14),
        (9.29, 6.05, 0.87),
        (1.44, 0.97, 0.67),
        (2.92, 2.37, 0.53),
    ];
    let query = disc_query(discs([0.0, 0.0, 14.0, 10.0], &workshop), [0.0, 0.0], [12.5, 8.2], 0.3);
    let found = solve(&query);
    println!("workshop {:.9} m", found.cost);
    assert!((found.cost - 15.305).abs() < 0.005, "{}", found.cost);
    certify(&query, &found);
}

fn random_grid(rng: &mut ChaCha8Rng) -> World {
    let (w, h) = (rng.random_range(4..14), rng.random_range(4..14));
    let density = rng.random_range(0.05..0.3);
    let mut bits = Bits::new(w, h);
    for y in 0..h {
        for x in 0..w {
            bits.set(x, y, rng.random_bool(density));
        }
    }
    let yaw = if rng.random_bool(0.5) { 0.0 } else { rng.random_range(-3.0..3.0) };
    World::from_grid(Grid::new(bits, None, 0.5, [rng.random_range(-3.0..3.0), 1.0, yaw]).unwrap())
}

fn random_shapes(rng: &mut ChaCha8Rng) -> Vec<Shape> {
    let mut shapes = Vec::new();
    for _ in 0..rng.random_range(1..7) {
        let c = [rng.random_range(0.5..5.5), rng.random_range(0.5..5.5)];
        let r = rng.random_range(0.05..0.9);
        if rng.random_bool(0.5) {
            shapes.push(Shape::disc(c, r).unwrap());
        } else {
            let first: f64 = rng.random_range(0.0..1.0);
            let n = rng.random_range(3..6);
            let corner = |i: usize| (first + i as f64) / n as f64 * std::f64::consts::TAU;
            shapes.push(Shape::polygon((0..n).map(|i| [c[0] + r * corner(i).cos(), c[1] + r * corner(i).sin()]).collect()).unwrap());
        }
    }
    shapes
}

fn free_point(rng: &mut ChaCha8Rng, world: &World, radius: f64) -> Option<Point> {
    let [w, h] = world.cells();
    (0..60)
        .map(|_| world.cell_to_map([rng.random::<f64>() * f64::from(w), rng.random::<f64>() * f64::from(h)]))
        .find(|&p| world.clearance(p) >= radius)
}

/// Corners of all blocked cells and polygons with radius 0, and discs.
fn round_things(world: &World) -> Vec<(Point, f64)> {
    let mut things = Vec::new();
    if let Some(grid) = world.grid() {
        for y in 0..=grid.height() {
            for x in 0..=grid.width() {
                let blocked = |x: u32, y: u32| x < grid.width() && y < grid.height() && grid.blocked().at(x, y);
                if [(0, 0), (1, 0), (0, 1), (1, 1)].iter().any(|&(i, j)| x >= i && y >= j && blocked(x - i, y - j)) {
                    things.push((grid.to_map([f64::from(x), f64::from(y)]), 0.0));
                }
            }
        }
    }
    for shape in world.shapes() {
        match shape {
            Shape::Disc { center, radius } => things.push((*center, *radius)),
            Shape::Polygon { points } => things.extend(points.iter().map(|&p| (p, 0.0))),
        }
    }
    things
}

/// Brute force: all points of a ring just outside every inflated corner and disc, joined wherever the straight way is free. Never below the optimum, and
/// near it. Knows nothing of arcs, tangents or convex corners.
fn dense(query: &Query, step: f64) -> f64 {
    let mut points = vec![query.start, query.goal];
    for (center, radius) in round_things(&query.world) {
        let count = if radius + query.radius() == 0.0 { 1 } else { (std::f64::consts::TAU / step).ceil() as u32 };
        let outside = (radius + query.radius()) / (step / 2.0).cos();
        points.extend((0..count).map(|i| circles::on(center, outside, step * f64::from(i))));
    }
    points.retain(|&p| query.world.clearance(p) >= query.radius() - 1e-9 && query.world.contains(p));
    let n = points.len();
    let (mut d, mut done) = (vec![f64::INFINITY; n], vec![false; n]);
    d[0] = 0.0;
    while let Some(i) = (0..n).filter(|&i| !done[i] && d[i].is_finite()).min_by(|&a, &b| d[a].total_cmp(&d[b])) {
        if i == 1 {
            return d[1];
        }
        done[i] = true;
        for j in 0..n {
            let g = d[i] + distance(points[i], points[j]);
            if !done[j] && g < d[j] && query.world.segment_free(points[i], points[j], query.radius()) {
                d[j] = g;
            }
        }
    }
    f64::INFINITY
}

/// A budget of time that is spent at once gives the lattice path with a proved bound, or an honest error; cancelling is heard.
#[test]
fn a_spent_budget_is_told() {
    let mut bits = Bits::new(60, 60);
    for y in 5..60 {
        bits.set(30, y, true);
    }
    let world = World::from_grid(Grid::new(bits, None, 0.1, [0.0; 3]).unwrap());
    let query = disc_query(world, [1.0, 5.0], [5.0, 5.0], 0.2);
    let exact = solve(&query).cost;
    let budget = crate::context::Budget { seconds: Some(0.0), ..Default::default() };
    match Visibility::default().plan(&query, &mut Context::new(0).with_budget(budget).unwrap()) {
        Ok(found) => {
            let bound = found.trace["lower_bound"].as_f64().unwrap();
            assert!(found.stop == Stop::Budget && found.cost >= exact - 1e-9 && bound <= exact && bound >= distance(query.start, query.goal) - 1e-9);
        }
        Err(PlanError::NoPath(why)) => assert!(!why.proved && why.reason.is_some()),
        Err(other) => panic!("{other}"),
    }
    let mut cancel = |_: &crate::context::Progress| true;
    let error = Visibility::default().plan(&query, &mut Context::new(0).with_observer(&mut cancel)).err();
    assert!(matches!(error, Some(PlanError::Cancelled)));
}

#[test]
fn via_points_are_passed_in_order() {
    let mut query = disc_query(discs([-5.0, -5.0, 5.0, 5.0], &[(0.0, 0.0, 2.0)]), [-3.0, 0.0], [3.0, 0.0], 0.5);
    query.via = vec![[0.0, 3.0], [0.0, -3.0]];
    let found = solve(&query);
    certify(&query, &found);
    let points = found.path.points();
    let place = |p: Point| points.iter().position(|&q| q == p).unwrap();
    assert!(place([0.0, 3.0]) < place([0.0, -3.0]));
    let legs = [[query.start, query.via[0]], [query.via[0], query.via[1]], [query.via[1], query.goal]];
    let sum: f64 = legs.into_iter().map(|ends| shortest(&query, ends).unwrap()).sum();
    assert!((sum - found.cost).abs() < 1e-12);
}

#[test]
fn never_above_and_hardly_below_a_dense_graph() {
    let mut rng = ChaCha8Rng::seed_from_u64(11);
    let (mut solved, mut unsolved) = (0, 0);
    for i in 0..240 {
        let world = match i % 3 {
            0 => random_grid(&mut rng),
            1 => World::from_shapes([0.0, 0.0, 6.0, 6.0], random_shapes(&mut rng), 0.1).unwrap(),
            _ => random_grid(&mut rng).with_shapes(random_shapes(&mut rng)),
        };
        let radius = if i % 12 == 1 { 0.0 } else { rng.random_range(0.02..0.7) };
        let (Some(start), Some(goal)) = (free_point(&mut rng, &world, radius), free_point(&mut rng, &world, radius)) else { continue };
        let query = disc_query(world, start, goal, radius);
        let upper = dense(&query, 0.12);
        match Visibility::default().plan(&query, &mut Context::new(0)) {
            Ok(found) => {
                certify(&query, &found);
                assert!(found.cost <= upper + 1e-9, "case {i}: {} is above {upper}", found.cost);
                assert!(upper.is_infinite() || found.cost >= upper * (1.0 - 0.01) - 0.01, "case {i}: {} is far below {upper}", found.cost);
                for name in ["theta-star", "lazy-theta-star", "astar"] {
                    if let Ok(other) = crate::plan::planner(name, serde_json::Value::Null).unwrap().plan(&query, &mut Context::new(0)) {
                        assert!(other.cost >= found.cost * (1.0 - 1e-9), "case {i}: {name} {} beats {}", other.cost, found.cost);
                    }
                }
                let back = shortest(&query, [goal, start]).unwrap();
                assert!((back - found.cost).abs() < 1e-9 * (1.0 + back), "case {i}: {back} backwards, {} forwards", found.cost);
                solved += 1;
            }
            Err(e) => {
                assert!(upper.is_infinite(), "case {i}: {e}, but there is a path of {upper}");
                unsolved += 1;
            }
        }
    }
    println!("{solved} solved, {unsolved} without a path");
    assert!(solved > 100 && unsolved > 10);
}

/// A point on the border of the map whose own cell is free.
fn border_point(rng: &mut ChaCha8Rng, world: &World) -> Option<Point> {
    let [w, h] = world.cells().map(f64::from);
    (0..60)
        .map(|_| {
            let t = rng.random::<f64>();
            let t = if rng.random_bool(0.5) { t } else { (t * 8.0).round() / 8.0 };
            let q = [[t * w, 0.0], [t * w, h], [0.0, t * h], [w, t * h]][rng.random_range(0..4)];
            world.cell_to_map(q)
        })
        .find(|&p| world.fits(p, 0.0))
}

/// No planner slips between a blocked cell and the border, and the optimum for a point is that of the whole visibility graph, on the border too.
#[test]
fn the_border_is_no_way_past_blocked_cells() {
    let mut rng = ChaCha8Rng::seed_from_u64(12);
    let (mut solved, mut unsolved) = (0, 0);
    for case in 0..300 {
        let (w, h) = (rng.random_range(2..9), rng.random_range(2..9));
        let mut bits = Bits::new(w, h);
        for (x, y) in (0..h).flat_map(|y| (0..w).map(move |x| (x, y))) {
            let rim = x == 0 || y == 0 || x + 1 == w || y + 1 == h;
            bits.set(x, y, rng.random_bool(if rim { 0.4 } else { 0.45 }));
        }
        let world = World::from_grid(Grid::new(bits, None, 1.0, [0.0; 3]).unwrap());
        let (Some(start), Some(goal)) = (border_point(&mut rng, &world), border_point(&mut rng, &world)) else { continue };
        let mut query = disc_query(world, start, goal, 0.0);
        // A corner of the graph may be bent around from any side.
        query.corners = crate::world::Corners::Squeeze;
        let truth = dense(&query, 0.12);
        let found = Visibility::default().plan(&query, &mut Context::new(0)).ok();
        let cost = found.as_ref().map_or(f64::INFINITY, |s| s.cost);
        assert!(cost == truth || (cost - truth).abs() < 1e-9, "case {case}: {cost} instead of {truth}");
        query.corners = crate::world::Corners::Touch;
        let exact = Visibility::default().plan(&query, &mut Context::new(0)).map_or(f64::INFINITY, |s| s.cost);
        for name in ["theta-star", "lazy-theta-star", "astar"] {
            if let Ok(other) = crate::plan::planner(name, serde_json::Value::Null).unwrap().plan(&query, &mut Context::new(0)) {
                assert!(other.cost >= exact * (1.0 - 1e-9), "case {case}: {name} {} beats {exact}", other.cost);
                assert!(crate::certify::collision(&other.path, &query, Some(0.05)).ok, "case {case}: {name}");
            }
        }
        if cost.is_finite() { solved += 1 } else { unsolved += 1 }
    }
    println!("{solved} solved, {unsolved} without a path");
    assert!(solved > 100 && unsolved > 20);
}
