use super::rays::{Rays, Word, append};
use super::*;
use crate::plan::Planner;
use crate::plan::search::Visibility;
use crate::world::{Bits, Footprint, Grid, Shape, World};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::collections::{HashMap, HashSet};
use std::f64::consts::TAU;
use std::sync::Arc;

const ROOM: [(f64, f64, f64); 8] = [
    (1.20, 0.95, 0.8),
    (2.35, 1.55, 0.6),
    (2.10, 3.00, 1.0),
    (3.70, 2.05, 0.9),
    (4.10, 0.60, 0.7),
    (6.50, 1.50, 1.2),
    (7.50, 4.20, 1.0),
    (0.90, 3.90, 0.5),
];

fn ask(world: World, start: Point, goal: Point, radius: f64) -> Query {
    let mut query = Query::new(Arc::new(world), start, goal);
    query.footprint = Footprint::Disc(radius);
    query
}

fn discs(bounds: [f64; 4], list: &[(f64, f64, f64)]) -> World {
    let shapes = list.iter().map(|&(x, y, d)| Shape::disc([x, y], d / 2.0).unwrap()).collect();
    World::from_shapes(bounds, shapes, 0.05).unwrap()
}

fn find(query: &Query, k: usize) -> Vec<Class> {
    let found = classes(query, k, &mut Context::new(0)).unwrap();
    check(query, &found);
    found
}

/// Distinct, sorted, free, from start to goal, as long as they say, the first as short as the exact planner's.
fn check(query: &Query, found: &[Class]) {
    let exact = Visibility::default().plan(query, &mut Context::new(0)).unwrap().cost;
    assert!((found[0].length - exact).abs() < 1e-9 * (1.0 + exact), "{} for {exact}", found[0].length);
    let names: HashSet<&str> = found.iter().map(|c| c.signature.as_str()).collect();
    assert_eq!(names.len(), found.len(), "{names:?}");
    assert!(found.windows(2).all(|w| w[0].length <= w[1].length + 1e-12));
    for class in found {
        assert_eq!((class.points[0], class.points[class.points.len() - 1]), (query.start, query.goal));
        let length: f64 = class.points.windows(2).map(|w| distance(w[0], w[1])).sum();
        assert!(length >= class.length - 1e-9 && length <= class.length * (1.0 + 1e-6) + 1e-9, "{length} for {}", class.length);
        assert!(class.points.windows(2).all(|w| query.world.segment_free(w[0], w[1], query.radius() - 2e-9)));
    }
}

#[test]
fn discs_in_a_row_are_passed_on_either_side() {
    for n in 1..=3 {
        let row: Vec<(f64, f64, f64)> = (0..n).map(|i| (2.0 + 2.5 * f64::from(i), 0.0, 1.0)).collect();
        let query = ask(discs([-2.0, -5.0, 12.0, 5.0], &row), [0.0, 0.1], [2.5 * f64::from(n) + 1.5, 0.1], 0.2);
        let found = find(&query, 64);
        let straight: Vec<&Class> = found.iter().filter(|c| c.points.windows(2).all(|w| w[1][0] >= w[0][0])).collect();
        assert_eq!(straight.len(), 1 << n, "{:?}", found.iter().map(|c| &c.signature).collect::<Vec<_>>());
        // The start and goal lie above the middle: over all of them is shortest, under all the longest of those without a turn back.
        let letters: Vec<String> = (1..=n).map(|i| i.to_string()).collect();
        assert_eq!(found[0].signature, letters.join(" "));
        assert!(straight.iter().any(|c| c.signature.is_empty()));
    }
}

#[test]
fn two_ways_around_one_disc_by_hand() {
    let query = ask(discs([-5.0, -5.0, 5.0, 5.0], &[(0.0, 0.0, 2.0)]), [-3.0, 0.0], [3.0, 0.0], 0.5);
    let found = find(&query, 2);
    let expected = 2.0 * (9.0f64 - 2.25).sqrt() + 1.5 * (std::f64::consts::PI - 2.0 * (1.5f64 / 3.0).acos());
    assert!(found.len() == 2 && found.iter().all(|c| (c.length - expected).abs() < 1e-12), "{found:?}");
}

#[test]
fn a_divider_with_two_doors_gives_two_classes() {
    let mut bits = Bits::new(40, 30);
    for y in 0..30 {
        bits.set(20, y, !(4..8).contains(&y) && !(22..26).contains(&y));
    }
    let world = World::from_grid(Grid::new(bits, None, 0.1, [1.0, -2.0, 0.3]).unwrap());
    let (start, goal) = (world.cell_to_map([5.0, 12.0]), world.cell_to_map([35.0, 12.0]));
    let found = find(&ask(world, start, goal, 0.15), 8);
    assert_eq!(found.len(), 2);
    assert!(found[1].length > found[0].length + 0.1);
}

#[test]
fn the_room_has_its_shortest_path_first() {
    let query = ask(discs([0.0, 0.0, 10.0, 6.0], &ROOM), [0.0, 0.0], [5.0, 3.0], 0.3);
    let found = find(&query, 8);
    for class in &found {
        println!("{:.6} [{}]", class.length, class.signature);
    }
    assert_eq!(found.len(), 8);
    assert!((found[0].length - 6.198).abs() < 0.005);
}

#[test]
fn via_points_join_the_classes_of_the_legs() {
    let mut query = ask(discs([-5.0, -5.0, 5.0, 5.0], &[(0.0, 0.0, 2.0), (3.0, 1.0, 0.6)]), [-3.0, 0.2], [4.5, 0.0], 0.3);
    query.via = vec![[1.8, 0.4]];
    let found = find(&query, 6);
    assert_eq!(found.len(), 6);
    assert!(found.iter().all(|c| c.signature.contains('|') && c.points.contains(&query.via[0])));
}

#[test]
fn no_path_no_time_and_no_way_to_go() {
    let mut bits = Bits::new(9, 9);
    for y in 0..9 {
        bits.set(4, y, true);
    }
    let world = World::from_grid(Grid::new(bits, None, 1.0, [0.0; 3]).unwrap());
    let error = classes(&ask(world, [1.5, 1.5], [7.5, 1.5], 0.3), 4, &mut Context::new(0)).unwrap_err();
    assert!(matches!(&error, PlanError::NoPath(why) if why.proved), "{error}");
    let query = ask(discs([-5.0, -5.0, 5.0, 5.0], &[(0.0, 0.0, 2.0)]), [-3.0, 0.0], [-3.0, 0.0], 0.5);
    let found = find(&query, 4);
    assert_eq!((found.len(), found[0].length), (1, 0.0));
    let mut cancel = |_: &crate::context::Progress| true;
    let cancelled = classes(&query, 4, &mut Context::new(0).with_observer(&mut cancel));
    assert!(matches!(cancelled, Err(PlanError::Cancelled)));
}

/// Shortest lengths of classes over a dense graph of points around the obstacles, brute force: by word, up to `limit`.
fn dense(query: &Query, list: &[(f64, f64, f64)], limit: f64) -> HashMap<Word, f64> {
    let rays = Rays::new(&rays::inside(&query.world), |_| true);
    let mut points = vec![query.start, query.goal];
    for &(x, y, d) in list {
        let r = (d / 2.0 + query.radius()) / (TAU / 120.0).cos();
        points.extend((0..60).map(|i| [x + r * (TAU * f64::from(i) / 60.0).cos(), y + r * (TAU * f64::from(i) / 60.0).sin()]));
    }
    points.retain(|&p| query.world.clearance(p) >= query.radius() - 1e-9 && query.world.contains(p));
    let n = points.len();
    let mut edges: Vec<Vec<(usize, f64, Word)>> = vec![Vec::new(); n];
    for i in 0..n {
        for j in (0..n).filter(|&j| j != i && query.world.segment_free(points[i], points[j], query.radius())) {
            let mut word = Word::new();
            rays.line(points[i], points[j], &mut word);
            edges[i].push((j, distance(points[i], points[j]), word));
        }
    }
    let mut best: HashMap<(usize, Word), f64> = HashMap::new();
    let mut heap = std::collections::BTreeSet::from([(0u64, 0usize, Word::new())]);
    let mut goals = HashMap::new();
    while let Some((bits, at, word)) = heap.pop_first() {
        let g = f64::from_bits(bits);
        if best.get(&(at, word.clone())).is_some_and(|b| *b < g) {
            continue;
        }
        if at == 1 {
            goals.insert(word, g);
            continue;
        }
        for (to, step, crossed) in &edges[at] {
            let mut next = word.clone();
            append(&mut next, crossed);
            let cost = g + step;
            let key = (*to, next);
            if cost + distance(points[*to], query.goal) <= limit && best.get(&key).is_none_or(|b| cost < *b) {
                best.insert(key.clone(), cost);
                heap.insert((cost.to_bits(), key.0, key.1));
            }
        }
    }
    goals
}

#[test]
fn random_discs_against_a_dense_graph() {
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    let (mut compared, mut cases) = (0, 0);
    while cases < 12 {
        let list: Vec<(f64, f64, f64)> =
            (0..3).map(|_| (rng.random_range(1.0..5.0), rng.random_range(1.0..5.0), rng.random_range(0.4..1.6))).collect();
        let query = ask(discs([0.0, 0.0, 6.0, 6.0], &list), [0.3, rng.random_range(0.5..5.5)], [5.7, rng.random_range(0.5..5.5)], 0.2);
        if query.validate().is_err() || Visibility::default().plan(&query, &mut Context::new(0)).is_err() {
            continue;
        }
        cases += 1;
        let found = find(&query, 12);
        let limit = found[0].length * 1.35;
        let brute = dense(&query, &list, limit);
        let by_name: HashMap<&str, f64> = found.iter().map(|c| (c.signature.as_str(), c.length)).collect();
        for (word, length) in &brute {
            let name = word.iter().map(i32::to_string).collect::<Vec<_>>().join(" ");
            let exact = by_name.get(name.as_str()).unwrap_or_else(|| panic!("{name} of length {length} is missing among {by_name:?}"));
            assert!(*exact <= length + 1e-9 && *exact >= length * 0.99 - 1e-3, "{name}: {exact} for {length}");
            compared += 1;
        }
        // And nothing that the graph does not have.
        for class in found.iter().filter(|c| c.length * 1.01 < limit) {
            let rays = Rays::new(&rays::inside(&query.world), |_| true);
            assert!(brute.contains_key(&rays.word(&class.points)), "{} of length {} is not real", class.signature, class.length);
        }
    }
    assert!(compared > 20, "{compared}");
}
