use super::brute::{Map, WAYS};
use guideway::certify;
use guideway::context::{Budget, Context, Progress, Stop};
use guideway::error::PlanError;
use guideway::path::Path;
use guideway::plan::front::Alternative;
use guideway::plan::score::Aim;
use guideway::plan::search::{Effort, Pareto, lexicographic, pareto};
use guideway::query::Query;
use guideway::world::{Bits, Corners, Footprint, Grid, Shape, World};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::sync::Arc;

fn query(map: &Map, corners: Corners) -> Query {
    let [w, h] = map.size();
    let world = Arc::new(World::from_grid(Grid::new(map.blocked(), None, 1.0, [0.0; 3]).unwrap()));
    Query { corners, ..Query::new(world, [0.5, 0.5], [f64::from(w) - 0.5, f64::from(h) - 0.5]) }
}

fn solve(query: &Query) -> Result<Pareto, PlanError> {
    pareto(query, Effort::default(), &mut Context::new(0))
}

fn random(rng: &mut ChaCha8Rng, w: usize, h: usize, density: f64) -> Map {
    let mut free: Vec<Vec<bool>> = (0..h).map(|_| (0..w).map(|_| !rng.random_bool(density)).collect()).collect();
    (free[0][0], free[h - 1][w - 1]) = (true, true);
    Map { free }
}

/// Every simple path, one by one.
struct Walk<'a> {
    map: &'a Map,
    corners: Corners,
    squares: Vec<Shape>,
    cells: Vec<[i64; 2]>,
    /// (length, turns, clearance)
    found: Vec<(f64, u32, f64)>,
}

impl Walk<'_> {
    fn go(&mut self, heading: usize, worth: (f64, u32, f64)) {
        let at = self.cells[self.cells.len() - 1];
        let [w, h] = self.map.size();
        if at == [i64::from(w) - 1, i64::from(h) - 1] {
            self.found.push(worth);
            return;
        }
        for (k, &[dx, dy]) in WAYS.iter().enumerate() {
            let to = [at[0] + dx, at[1] + dy];
            if self.map.step(at, [dx, dy], self.corners) && !self.cells.contains(&to) {
                let middle = |c: [i64; 2]| c.map(|v| v as f64 + 0.5);
                let near = self.squares.iter().map(|s| s.segment_distance(middle(at), middle(to))).fold(worth.2, f64::min);
                self.cells.push(to);
                self.go(k, (worth.0 + ((dx * dx + dy * dy) as f64).sqrt(), worth.1 + u32::from(heading < 8 && heading != k), near));
                self.cells.pop();
            }
        }
    }
}

fn every_path(map: &Map, corners: Corners) -> Vec<(f64, u32, f64)> {
    let mut squares = Vec::new();
    for (y, x) in (0..map.free.len()).flat_map(|y| (0..map.free[0].len()).map(move |x| (y, x))) {
        if !map.free[y][x] {
            let (u, v) = (x as f64, y as f64);
            squares.push(Shape::polygon(vec![[u, v], [u + 1.0, v], [u + 1.0, v + 1.0], [u, v + 1.0]]).unwrap());
        }
    }
    let mut walk = Walk { map, corners, squares, cells: vec![[0, 0]], found: Vec::new() };
    walk.go(8, (0.0, 0, f64::INFINITY));
    walk.found
}

const SLACK: f64 = 1e-9;

fn covers(a: (f64, u32, f64), b: (f64, u32, f64)) -> bool {
    a.0 <= b.0 + SLACK && a.1 <= b.1 && a.2 >= b.2 - SLACK
}

fn worth(a: &Alternative) -> (f64, u32, f64) {
    (a.length, a.turns, a.clearance)
}

#[test]
fn the_set_is_that_of_all_simple_paths_of_small_maps() {
    let mut rng = ChaCha8Rng::seed_from_u64(41);
    let (mut several, mut sizes) = (0, 0);
    for round in 0..72u32 {
        let (w, h) = if round % 3 == 0 { (6, 3) } else { (4, 4) };
        let map = random(&mut rng, w, h, 0.2 + f64::from(round % 4) * 0.06);
        let corners = [Corners::Touch, Corners::Clear, Corners::Squeeze][round as usize % 3];
        let all = every_path(&map, corners);
        let Ok(found) = solve(&query(&map, corners)) else {
            assert!(all.is_empty(), "{corners:?} {:?}", map.free);
            continue;
        };
        assert!(found.complete && found.stop == Stop::Converged);
        let set: Vec<_> = found.front.alternatives().iter().map(worth).collect();
        for path in &all {
            assert!(set.iter().any(|s| covers(*s, *path)), "{path:?} is missing in {set:?} of {:?}", map.free);
        }
        for (i, s) in set.iter().enumerate() {
            assert!(all.iter().any(|p| covers(*p, *s)), "{s:?} is no path of {:?}", map.free);
            assert!(set.iter().enumerate().all(|(k, o)| k == i || !covers(*o, *s)), "{s:?} is covered in {set:?}");
        }
        several += u32::from(set.len() > 1);
        sizes += set.len();
    }
    assert!(several > 10 && sizes > 50, "{several} sets of more than one, {sizes} alternatives");
}

/// Certified by the independent checker, of the clearance that it says, steps to neighbours.
fn certify_all(query: &Query, found: &Pareto) {
    let lattice = query.world.lattice(query.radius());
    for one in found.front.alternatives() {
        let mut points = vec![query.start];
        points.extend(one.cells.iter().map(|&c| lattice.center(c)));
        points.push(query.goal);
        let checked = certify::collision(&Path::polyline(&points), query, None);
        assert!(checked.ok, "collision at {:?}", checked.worst);
        let least = points.windows(2).map(|p| query.world.segment_clearance(p[0], p[1])).fold(f64::INFINITY, f64::min).max(0.0);
        assert!(least == one.clearance || (least - one.clearance).abs() < 1e-8, "{least} for {}", one.clearance);
        assert_eq!(Alternative::new(one.cells.clone(), one.clearance), *one);
    }
}

#[test]
fn alternatives_are_free_and_hold_the_optima() {
    let mut rng = ChaCha8Rng::seed_from_u64(42);
    for round in 0..40u32 {
        let map = random(&mut rng, 24, 21, 0.05 + f64::from(round % 5) * 0.06);
        let mut query = query(&map, if round % 2 == 0 { Corners::Touch } else { Corners::Clear });
        query.footprint = Footprint::Disc(f64::from(round % 3) * 0.2);
        let Ok(found) = solve(&query) else { continue };
        certify_all(&query, &found);
        let set = found.front.alternatives();
        assert!(found.complete && set.iter().enumerate().all(|(i, a)| set.iter().enumerate().all(|(k, b)| i == k || !b.covers(a))));
        let lattice = query.world.lattice(query.radius());
        let best = |aim| lexicographic(&lattice, [[0, 0], [23, 20]], query.corners, aim, &mut || false).unwrap().unwrap().score;
        let (shortest, energy) = (best(Aim::Shortest), best(Aim::LeastEnergy));
        assert_eq!((set[0].length, set[0].turns), (shortest.cost, shortest.turns));
        let least = set.iter().map(Alternative::energy).fold(f64::INFINITY, f64::min);
        assert!((least - energy.cost).abs() < 1e-9, "{least} for {}", energy.cost);
    }
}

#[test]
fn among_shapes_too() {
    let shapes = vec![Shape::disc([3.0, 2.1], 0.4).unwrap(), Shape::polygon(vec![[4.5, 0.4], [5.0, 0.5], [4.7, 1.2]]).unwrap()];
    let world = Arc::new(World::from_shapes([0.0, 0.0, 6.0, 4.0], shapes, 0.2).unwrap());
    let mut query = Query::new(world, [0.5, 2.1], [5.5, 2.3]);
    query.footprint = Footprint::Disc(0.15);
    let found = solve(&query).unwrap();
    assert!(found.complete && found.front.len() > 3, "{}", found.front.len());
    certify_all(&query, &found);
}

#[test]
fn start_at_the_goal_no_path_via_points_and_an_open_map() {
    let map = Map::parse("..#.\n..#.\n..#.");
    let mut one = query(&map, Corners::Touch);
    assert!(matches!(solve(&one), Err(PlanError::NoPath(no)) if no.proved));
    one.goal = [0.6, 0.5];
    let found = solve(&one).unwrap();
    assert!(found.complete && found.front.len() == 1 && found.front.alternatives()[0].cells == [[0, 0]]);
    one.via = vec![[1.5, 0.5]];
    assert!(matches!(solve(&one), Err(PlanError::BadParameter { .. })));
    let open = World::from_grid(Grid::new(Bits::new(9, 5), None, 1.0, [0.0; 3]).unwrap());
    let found = solve(&Query::new(Arc::new(open), [0.5, 0.5], [8.5, 4.5])).unwrap();
    assert_eq!(found.front.alternatives().iter().map(worth).collect::<Vec<_>>(), [(4.0 + 4.0 * 2f64.sqrt(), 1, f64::INFINITY)]);
}

#[test]
fn time_effort_and_cancel_are_honest() {
    let mut rng = ChaCha8Rng::seed_from_u64(43);
    let query = query(&random(&mut rng, 60, 60, 0.04), Corners::Touch);
    let whole = solve(&query).unwrap();
    assert!(whole.complete && whole.front.len() > 5, "{} alternatives", whole.front.len());
    let few = pareto(&query, Effort { searches: 2, ..Effort::default() }, &mut Context::new(0)).unwrap();
    assert!(!few.complete && few.searches == 2 && few.stop == Stop::Budget, "{} searches, {} alternatives", few.searches, few.front.len());
    assert!(few.front.len() < whole.front.len(), "{} of {} alternatives", few.front.len(), whole.front.len());
    assert!(few.front.alternatives().iter().all(|a| whole.front.alternatives().iter().any(|b| b.covers(a))));
    certify_all(&query, &few);
    let none = pareto(&query, Effort::default(), &mut Context::new(0).with_budget(Budget { seconds: Some(0.0), ..Budget::default() }).unwrap());
    assert!(matches!(none, Err(PlanError::NoPath(no)) if !no.proved));
    let mut cancel = |_: &Progress| true;
    assert!(matches!(pareto(&query, Effort::default(), &mut Context::new(0).with_observer(&mut cancel)), Err(PlanError::Cancelled)));
}
