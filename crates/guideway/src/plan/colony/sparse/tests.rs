use super::corners::{Corners, GOAL, START};
use super::*;
use crate::certify;
use crate::context::Budget;
use crate::plan::search::Visibility;
use crate::plan::{Planner, planner};
use crate::world::{Bits, Corners as Rule, Footprint, Grid, Shape, World};
use std::sync::Arc;

/// A random map; both end cells free.
fn noise(seed: u64, [w, h]: [u32; 2], percent: u64) -> Bits {
    let mut state = seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) + 1;
    let mut next = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        state >> 33
    };
    let mut bits = Bits::new(w, h);
    for y in 0..h {
        for x in 0..w {
            bits.set(x, y, next() % 100 < percent);
        }
    }
    bits.set(0, 0, false);
    bits.set(w - 1, h - 1, false);
    bits
}

fn world(blocked: Bits) -> Arc<World> {
    Arc::new(World::from_grid(Grid::new(blocked, None, 1.0, [0.0; 3]).unwrap()))
}

fn across(world: &Arc<World>, at: f64) -> Query {
    let [w, h] = world.cells().map(f64::from);
    Query::new(Arc::clone(world), [at, at], [w - at, h - at])
}

/// Shortest way over the graph, by relaxation until nothing changes.
fn shortest(roads: &Corners) -> f64 {
    use crate::plan::colony::roads::Roads;
    let mut far = vec![f64::INFINITY; roads.nodes()];
    far[START as usize] = 0.0;
    let mut queue = std::collections::VecDeque::from([START]);
    while let Some(node) = queue.pop_front() {
        for exit in roads.of(node) {
            let length = far[node as usize] + exit.length;
            if length < far[exit.to as usize] {
                far[exit.to as usize] = length;
                queue.push_back(exit.to);
            }
        }
    }
    far[GOAL as usize]
}

#[test]
fn the_graph_holds_an_optimal_path_and_every_edge_is_free() {
    use crate::plan::colony::roads::Roads;
    let mut solved = 0;
    for seed in 0..240u64 {
        let size = [3 + (seed % 17) as u32, 2 + (seed % 23) as u32];
        let world = world(noise(seed, size, 5 + seed % 45));
        let mut query = across(&world, [0.5, 0.25, 0.9, 0.3137][seed as usize % 4]);
        if seed % 3 == 0 {
            query.corners = Rule::Squeeze;
        }
        let ground = Ground::new(&query, &world.lattice(0.0));
        let roads = Corners::new(ground.free(), ground.squeeze, [query.start, query.goal], 0.0, |a, b| ground.sees(&query, a, b));
        for node in 0..roads.nodes() as u32 {
            for exit in roads.of(node) {
                let (a, b) = (roads.position(node), roads.position(exit.to));
                assert!(ground.sees(&query, a, b), "seed {seed}: {a:?} does not see {b:?}");
                assert!(roads.of(exit.to).any(|e| e.to == node && e.slot == roads.back(node, exit)), "seed {seed}: {a:?} {b:?}");
            }
        }
        match Visibility::default().plan(&query, &mut Context::new(0)) {
            Ok(exact) => {
                assert!((shortest(&roads) - exact.cost).abs() < 1e-9 * (1.0 + exact.cost), "seed {seed}: {} for {}", shortest(&roads), exact.cost);
                solved += 1;
            }
            Err(_) => assert!(shortest(&roads).is_infinite(), "seed {seed}: {}", shortest(&roads)),
        }
    }
    assert!(solved > 100, "{solved} maps have a way");
}

fn colony(parameters: &Value) -> Box<dyn Planner> {
    named("bidirectional-aco", parameters)
}

fn named(name: &str, parameters: &Value) -> Box<dyn Planner> {
    let mut all = json!({ "graph": "corners" });
    all.as_object_mut().unwrap().extend(parameters.as_object().unwrap().clone());
    planner(name, all).unwrap()
}

#[test]
fn ways_are_free_never_below_the_optimum_and_near_it() {
    let (mut walked, mut count) = (0, 0);
    for seed in 0..60u64 {
        let world = world(noise(seed, [40, 30], 10 + seed % 25));
        let mut query = across(&world, 0.5);
        if seed % 2 == 1 {
            query.footprint = Footprint::Disc(0.2 + 0.01 * seed as f64);
        }
        let method = named(["bidirectional-aco", "improved-aco"][seed as usize / 2 % 2], &json!({ "seeding": "off" }));
        let (Ok(exact), Ok(found)) = (Visibility::default().plan(&query, &mut Context::new(0)), method.plan(&query, &mut Context::new(seed))) else {
            continue;
        };
        assert!(certify::collision(&found.path, &query, None).ok, "seed {seed}");
        assert!((found.path.length() - found.cost).abs() < 1e-9 * found.cost && found.cells.is_none());
        let gap = found.cost / exact.cost - 1.0;
        assert!(gap > -1e-9, "seed {seed}: {} below {}", found.cost, exact.cost);
        // A point finds the optimum; a robot loses a little where ways are tight.
        let corners = found.trace["legs"][0]["graph"] == "corners";
        let allowed = if query.radius() == 0.0 { 0.001 } else { 0.05 };
        assert!(!corners || gap < allowed, "seed {seed}: {gap} above");
        walked += usize::from(!corners);
        count += 1;
    }
    assert!(count > 30 && 10 * walked < count, "{count} ways, {walked} on the lattice");
}

#[test]
fn threads_and_seeds_and_budgets() {
    let world = world(noise(3, [60, 60], 20));
    let query = across(&world, 0.5);
    for (name, parameters) in [("bidirectional-aco", json!({})), ("bidirectional-aco", json!({ "learning": false })), ("improved-aco", json!({}))] {
        let run = |threads| named(name, &parameters).plan(&query, &mut Context::new(5).with_threads(threads)).unwrap();
        let (a, b) = (run(1), run(2));
        assert_eq!((a.path, a.cost.to_bits(), a.iterations, a.evaluations), (b.path, b.cost.to_bits(), b.iterations, b.evaluations));
    }
    let mut few = Context::new(1).with_budget(Budget { iterations: Some(2), ..Budget::default() }).unwrap();
    let found = colony(&json!({})).plan(&query, &mut few).unwrap();
    assert_eq!((found.stop, found.iterations), (Stop::Budget, 2));
    let mut cancel = |_: &crate::context::Progress| true;
    let result = colony(&json!({})).plan(&query, &mut Context::new(1).with_observer(&mut cancel));
    assert!(matches!(result, Err(PlanError::Cancelled)) || result.is_ok_and(|s| s.stop == Stop::Cancelled));
}

#[test]
fn odd_maps() {
    let plan = |query: &Query| colony(&json!({ "ants": 10 })).plan(query, &mut Context::new(1));
    let one = world(Bits::new(1, 1));
    assert!((plan(&Query::new(Arc::clone(&one), [0.2, 0.2], [0.8, 0.9])).unwrap().cost - 0.6f64.hypot(0.7)).abs() < 1e-12);
    assert_eq!(plan(&Query::new(one, [0.2, 0.2], [0.2, 0.2])).unwrap().cost, 0.0);
    let corridor = world(Bits::new(200, 1));
    assert!((plan(&Query::new(corridor, [0.0, 0.0], [199.9, 1.0])).unwrap().cost - 199.9f64.hypot(1.0)).abs() < 1e-9);
    let large = world(Bits::new(2000, 2000));
    assert!((plan(&across(&large, 0.5)).unwrap().cost - 1999.0 * 2f64.sqrt()).abs() < 1e-9);
    // Start and goal on walls and on corners of blocked cells.
    let mut bits = Bits::new(9, 7);
    (1..6).for_each(|y| bits.set(4, y, true));
    let wall = world(bits);
    for (start, goal) in [([4.0, 3.0], [5.0, 3.0]), ([4.0, 1.0], [5.0, 6.0]), ([2.0, 3.0], [7.0, 4.0]), ([0.0, 0.0], [9.0, 7.0])] {
        let query = Query::new(Arc::clone(&wall), start, goal);
        match (Visibility::default().plan(&query, &mut Context::new(0)), plan(&query)) {
            (Ok(exact), Ok(found)) => {
                assert!(certify::collision(&found.path, &query, None).ok, "{start:?} {goal:?}");
                assert!((found.cost - exact.cost).abs() < 1e-9, "{start:?} {goal:?}: {} for {}", found.cost, exact.cost);
            }
            (Err(a), Err(b)) => assert_eq!(a.name(), b.name()),
            (a, b) => panic!("{start:?} {goal:?}: {:?} {:?}", a.map(|s| s.cost), b.map(|s| s.cost)),
        }
    }
}

#[test]
fn tight_ways_of_robots_are_walked_on_the_lattice() {
    let mut bits = Bits::new(12, 9);
    (0..12).filter(|x| *x != 6).for_each(|x| (3..6).for_each(|y| bits.set(x, y, true)));
    let mut query = Query::new(world(bits), [1.5, 1.5], [10.5, 7.5]);
    query.footprint = Footprint::Disc(0.5);
    let found = colony(&json!({})).plan(&query, &mut Context::new(1)).unwrap();
    assert_eq!(found.trace["legs"][0]["graph"], "lattice");
    assert!(certify::collision(&found.path, &query, None).ok);
}

#[test]
fn shapes_and_via_points() {
    let shapes = vec![Shape::disc([2.0, 1.0], 0.6).unwrap(), Shape::polygon(vec![[3.0, 1.4], [4.0, 1.5], [3.4, 2.6]]).unwrap()];
    let scene = Arc::new(World::from_shapes([0.0, 0.0, 6.0, 3.0], shapes, 0.05).unwrap());
    let mut query = Query::new(scene, [0.2, 0.9], [5.7, 1.6]);
    query.footprint = Footprint::Disc(0.15);
    query.clearance = 0.05;
    query.via = vec![[2.0, 2.5], [4.5, 2.5]];
    let exact = Visibility::default().plan(&query, &mut Context::new(0)).unwrap();
    let found = colony(&json!({})).plan(&query, &mut Context::new(1)).unwrap();
    assert!(certify::collision(&found.path, &query, None).ok);
    assert!(found.cost >= exact.cost * (1.0 - 1e-9) && found.cost < exact.cost * 1.02, "{} for {}", found.cost, exact.cost);
}
