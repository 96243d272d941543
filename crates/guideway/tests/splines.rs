//! Splines as candidates: what is called free is certified, terms of the objective agree with slow ones, via points are passed, planners keep their word.

use guideway::Point;
use guideway::certify;
use guideway::certify::motion::{Asked, motion};
use guideway::context::{Budget, Context};
use guideway::error::PlanError;
use guideway::optimize::Objective;
use guideway::path::Path;
use guideway::plan::swarm::{Curves, Form, Settings};
use guideway::plan::{Solution, planner};
use guideway::query::{Limits, Query};
use guideway::timing::{Bounds, Jerks, SCurve};
use guideway::world::{Bits, Footprint, Grid, Shape, World};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde_json::{Value, json};
use std::sync::Arc;

const METHODS: [&str; 5] = ["de", "improved-de", "firefly", "l-shade", "cma-es"];
const DISCS: [[f64; 3]; 8] = [
    [1.20, 0.95, 0.8],
    [2.35, 1.55, 0.6],
    [2.10, 3.00, 1.0],
    [3.70, 2.05, 0.9],
    [4.10, 0.60, 0.7],
    [6.50, 1.50, 1.2],
    [7.50, 4.20, 1.0],
    [0.90, 3.90, 0.5],
];

/// The room `w0`; with `boxes`, every other disc is a hexagon.
fn room(boxes: bool) -> Query {
    let shapes = DISCS.iter().enumerate().map(|(i, [x, y, d])| {
        let corner = |k: i32| [x + 0.5 * d * f64::from(k).cos(), y + 0.5 * d * f64::from(k).sin()];
        if boxes && i % 2 == 0 { Shape::polygon((0..6).map(corner).collect()).unwrap() } else { Shape::disc([*x, *y], 0.5 * d).unwrap() }
    });
    let world = Arc::new(World::from_shapes([0.0, 0.0, 10.0, 6.0], shapes.collect(), 0.05).unwrap());
    let limits = Limits {
        speed: 2.0,
        acceleration: 5.0,
        deceleration: 5.0,
        jerk: 10.0,
        turn_rate: Some(2.0),
        turn_acceleration: None,
        lateral_acceleration: Some(2.0),
    };
    Query { clearance: 0.3, limits, ..Query::new(world, [0.0, 0.0], [5.0, 3.0]) }
}

fn map(rows: &[&str], yaw: f64) -> Arc<World> {
    let (w, h) = (rows[0].len() as u32, rows.len() as u32);
    let mut blocked = Bits::new(w, h);
    for (i, row) in rows.iter().enumerate() {
        row.bytes().enumerate().for_each(|(x, c)| blocked.set(x as u32, h - 1 - i as u32, c == b'#'));
    }
    Arc::new(World::from_grid(Grid::new(blocked, None, 0.5, [-1.0, 2.0, yaw]).unwrap()))
}

const ROOMS: [&str; 8] =
    ["..............", ".##.....###...", ".##.......#...", "......#.......", "...####...##..", "..........##..", "..#...........", ".............."];

fn on_map(footprint: f64, yaw: f64) -> Query {
    let world = map(&ROOMS, yaw);
    let (start, goal) = (world.cell_to_map([0.5, 0.5]), world.cell_to_map([13.4, 7.3]));
    Query { footprint: Footprint::Disc(footprint), ..Query::new(world, start, goal) }
}

fn solve(name: &str, query: &Query, set: Value, budget: Budget) -> Result<Solution, PlanError> {
    planner(name, set).unwrap().plan(query, &mut Context::new(3).with_budget(budget).unwrap())
}

/// A candidate near an exact route that is a little wider.
fn along(curves: &Curves) -> Vec<f64> {
    let query = curves.query();
    let wider = Query { clearance: query.clearance + 0.05, ..query.clone() };
    curves.fit(&solve("visibility", &wider, json!({}), Budget::default()).unwrap().path.points())
}

/// A third of the draws come from all over the box, the others are near the route.
fn draw(curves: &Curves, along: &[f64], spread: f64, rng: &mut ChaCha8Rng) -> Vec<f64> {
    let spread = if rng.random_bool(0.3) { 1.0 } else { spread * rng.random::<f64>().powi(2) };
    let place = |(b, a): (&(f64, f64), &f64), r: f64| (a + spread * (b.1 - b.0) * (2.0 * r - 1.0)).clamp(b.0, b.1);
    curves.bounds().iter().zip(along).map(|pair| place(pair, rng.random())).collect()
}

#[test]
fn candidates_are_free_exactly_when_the_certificate_says_so() {
    let via = Query { via: vec![[3.0, 4.2], [5.4, 1.2]], ..room(false) };
    let (mut free, mut total) = (0, 0);
    for (k, query) in [room(false), room(true), via, on_map(0.0, 0.0), on_map(0.2, 0.0), on_map(0.1, 0.4)].iter().enumerate() {
        let curves = Curves::new(query, &Settings { points: [5, 5, 9, 20, 20, 20][k], ..Settings::default() }).unwrap();
        let (along, spread) = (along(&curves), if k < 3 { 0.08 } else { 0.02 });
        let mut rng = ChaCha8Rng::seed_from_u64(k as u64);
        let loose = Query { clearance: query.clearance + 1e-6, ..query.clone() };
        let mut here = 0;
        for _ in 0..1700 {
            let x = draw(&curves, &along, spread, &mut rng);
            let (judged, path) = (curves.judge(&x), curves.path(&x).unwrap());
            let ok = certify::collision(&path, if judged.violation == 0.0 { query } else { &loose }, Some(0.1)).ok;
            // Curves next to a cusp are refused though they touch nothing.
            let sharp = judged.violation > 0.0 && curves.curvature(&x) > curves.sharpest();
            assert!(sharp || ok == (judged.violation == 0.0), "{k}: {judged:?} {x:?}");
            here += usize::from(ok);
        }
        assert!(here > 20, "{k}: {here} are free");
        (free, total) = (free + here, total + 1700);
    }
    assert!(total >= 10_000 && free > 500, "{free} of {total}");
}

#[test]
fn the_clearance_of_a_free_curve_is_exact() {
    for (query, points) in [(room(true), 6), (on_map(0.1, 0.4), 20)] {
        let curves = Curves::new(&query, &Settings { points, ..Settings::default() }).unwrap();
        let along = along(&curves);
        let mut rng = ChaCha8Rng::seed_from_u64(5);
        let mut seen = 0;
        for _ in 0..300 {
            let x = draw(&curves, &along, 0.02, &mut rng);
            let (judged, path) = (curves.judge(&x), curves.path(&x).unwrap());
            if judged.violation == 0.0 {
                let sampled = (0..=4000).map(|i| query.world.clearance(path.planar(path.length() * f64::from(i) / 4000.0).point));
                let sampled = sampled.fold(f64::INFINITY, f64::min);
                assert!(judged.clearance <= sampled + 1e-7 && judged.clearance >= sampled - 5e-3, "{} {sampled}", judged.clearance);
                seen += 1;
            }
        }
        assert!(seen > 4, "{seen}");
    }
}

/// The terms of a curve by sampling its path and its seven phases in time.
fn slow(path: &Path, limits: &Limits) -> [f64; 5] {
    let bounds = Bounds { speed: limits.speed, acceleration: limits.acceleration, deceleration: limits.deceleration, jerk: Jerks::all(limits.jerk) };
    let pass = SCurve { distance: path.length(), start: (0.0, 0.0), end: (0.0, 0.0), bounds }.plan().unwrap();
    let n = 20_000;
    let (mut turning, mut excess, mut last, mut before) = (0.0, 0.0, 0.0, 0.0);
    for i in 1..=n {
        let (s, v, ..) = pass.at(pass.duration() * f64::from(i) / f64::from(n));
        let k = path.planar(s).curvature;
        turning += (k * v - last).abs();
        last = k * v;
        let ceiling = (limits.lateral_acceleration.unwrap() / k.abs()).sqrt().min(limits.turn_rate.unwrap() / k.abs());
        excess += (v / ceiling - 1.0).max(0.0) * (s - before);
        before = s;
    }
    let mut literal = 0.0;
    last = 0.0;
    for i in 1..=(10.0 * pass.duration()).ceil() as u64 {
        let (s, v, ..) = pass.at((i as f64 / 10.0).min(pass.duration()));
        let rate = path.planar(s).curvature * v;
        literal += 10.0 * (rate - last).abs();
        last = rate;
    }
    [path.length(), pass.duration(), turning, literal, excess / path.length()]
}

#[test]
fn the_terms_agree_with_slow_ones() {
    let query = room(false);
    for scales in [false, true] {
        let curves = Curves::new(&query, &Settings { points: 5, scales, ..Settings::default() }).unwrap();
        let literal = Curves::new(&query, &Settings { points: 5, scales, objective: Form::Literal, ..Settings::default() }).unwrap();
        let along = along(&curves);
        let mut rng = ChaCha8Rng::seed_from_u64(8);
        let mut seen = 0;
        for _ in 0..120 {
            let x = draw(&curves, &along, 0.05, &mut rng);
            let (judged, other) = (curves.judge(&x), literal.judge(&x));
            if judged.violation > 0.0 {
                continue;
            }
            seen += 1;
            let [length, time, turning, sum, overspeed] = slow(&curves.path(&x).unwrap(), &curves.limits(&x));
            assert!((judged.length / length - 1.0).abs() < 1e-5 && (judged.time / time - 1.0).abs() < 1e-5, "{} {length}", judged.length);
            // Peaks of narrow bends lie between nodes.
            let share = if turning < 20.0 { 0.02 } else { 0.15 };
            assert!((judged.turning - turning).abs() < share * turning + 1e-3, "{} {turning}", judged.turning);
            assert!((other.turning - sum).abs() < share * sum + 1e-2, "{} {sum}", other.turning);
            assert!((judged.overspeed - overspeed).abs() < 0.05 * overspeed + 1e-4, "{} {overspeed}", judged.overspeed);
            let f = 0.4 * length / 16.0 + 0.3 * time / 12.0 + 0.2 * (judged.turning / 40.0).min(1.0) + 0.1 * 0.3 / judged.clearance;
            assert!((judged.value - f - 0.5 * judged.overspeed).abs() < 1e-5);
            let raw = 0.4 * length / 16.0 + 0.3 * time / 12.0 + 0.2 * other.turning + 0.1 / judged.clearance;
            assert!((other.value - raw - 0.5 * judged.overspeed).abs() < 1e-5);
        }
        assert!(seen > 15, "{seen}");
    }
}

#[test]
fn one_smooth_curve_passes_every_via_point() {
    let via: Vec<Point> = vec![[3.0, 4.2], [5.4, 1.2], [5.6, 1.3], [8.8, 5.0]];
    let query = Query { via: via.clone(), ..room(false) };
    let curves = Curves::new(&query, &Settings { points: 4, ..Settings::default() }).unwrap();
    let mut rng = ChaCha8Rng::seed_from_u64(2);
    let x: Vec<f64> = curves.bounds().iter().map(|b| rng.random_range(b.0..b.1)).collect();
    let path = curves.path(&x).unwrap();
    let knots: Vec<f64> = path.knots()[3..path.knots().len() - 3].to_vec();
    for q in via {
        let at = |u: f64| path.at(u, 0)[0].clone();
        let u = knots.iter().copied().min_by(|a, b| gap(&at(*a), q).total_cmp(&gap(&at(*b), q))).unwrap();
        assert!(gap(&at(u), q) < 1e-9, "{q:?}");
        let s = path.length_at(u);
        let [before, after] = [-1e-7, 1e-7].map(|d| path.planar(s + d));
        assert!((before.heading - after.heading).abs() < 1e-3 && (before.curvature - after.curvature).abs() < 1e-2 * (1.0 + after.curvature.abs()));
    }
}

fn gap(p: &[f64], q: Point) -> f64 {
    (p[0] - q[0]).hypot(p[1] - q[1])
}

fn assert_driven(name: &str, query: &Query, solution: &Solution) {
    assert!(certify::collision(&solution.path, query, None).ok, "{name}");
    let moves = solution.trajectory.as_ref().expect("a motion");
    assert_eq!(moves.limits, query.limits);
    let checks = motion(moves, &Asked::default());
    assert!(checks.iter().all(|c| c.ok), "{name}: {checks:?}");
    let terms = &solution.trace["objective"];
    assert_eq!(terms["value"].as_f64().unwrap(), solution.cost, "{name}");
    assert!(solution.trace["convergence"].as_array().is_some_and(|c| !c.is_empty() && c.len() <= 400));
    let population = solution.trace["population"].as_array().unwrap();
    assert!(population.len() <= 8 && population.iter().all(|p| p["paths"].as_array().unwrap().len() <= 40));
    assert_eq!(population[population.len() - 1]["generation"].as_u64(), Some(solution.iterations), "{name}: the last one is shown");
}

#[test]
fn the_room_is_solved_near_the_best_known_value_with_hints() {
    for name in METHODS {
        let query = room(false);
        let found = solve(name, &query, json!({}), Budget::default()).unwrap();
        assert_driven(name, &query, &found);
        assert!(found.trace["encoding"]["followed"].is_null());
        assert!(found.cost < 0.375 && found.cost > 0.35, "{name}: {}", found.cost);
        assert!(found.history.windows(2).all(|w| w[1].1 < w[0].1), "{name}");
        assert!(!found.trace["population"].as_array().unwrap().is_empty(), "{name}");
    }
    for name in ["pso", "grouped-pso", "sparrow"] {
        let query = room(false);
        let found = solve(name, &query, json!({ "encoding": "spline" }), Budget::default()).unwrap();
        assert_driven(name, &query, &found);
        assert!(found.cost < 0.4, "{name}: {}", found.cost);
    }
}

#[test]
fn settings_of_the_source_need_no_hints() {
    for name in ["de", "improved-de", "l-shade"] {
        let query = room(false);
        let found = solve(name, &query, json!({ "preset": "paper" }), Budget { evaluations: Some(8000), ..Budget::default() }).unwrap();
        assert_driven(name, &query, &found);
        assert_eq!((found.evaluations, found.trace["encoding"]["points"].as_u64()), (8000, Some(5)));
    }
}

#[test]
fn via_points_are_no_stops() {
    let query = Query { via: vec![[3.0, 4.2], [5.4, 1.2]], goal: [9.0, 2.0], ..room(false) };
    let found = solve("cma-es", &query, json!({}), Budget::default()).unwrap();
    assert_driven("via", &query, &found);
    assert!(found.trace["encoding"]["followed"].is_null());
    let motion = found.trajectory.unwrap();
    let slowest = (1..200).map(|i| motion.at(motion.duration() * (0.1 + 0.8 * f64::from(i) / 200.0)).speed).fold(f64::INFINITY, f64::min);
    assert!(slowest > 0.2, "{slowest}");
    assert!(found.path.corners().is_empty());
}

#[test]
fn a_corridor_of_one_cell_is_followed() {
    let rows = [
        "..................",
        "#################.",
        "..................",
        ".#################",
        "..................",
        "#################.",
        "..................",
    ];
    let world = map(&rows, 0.0);
    let query = Query::new(Arc::clone(&world), world.cell_to_map([0.5, 0.5]), world.cell_to_map([0.5, 6.5]));
    for footprint in [0.0, 0.2] {
        let query = Query { footprint: Footprint::Disc(footprint), ..query.clone() };
        for name in METHODS {
            let found = solve(name, &query, json!({}), Budget { evaluations: Some(600), ..Budget::default() }).unwrap();
            assert_driven(name, &query, &found);
        }
    }
}

#[test]
fn what_cannot_be_is_one_clear_error() {
    let query = room(false);
    let none = Budget::default();
    let bad = |name: &str, set: Value| match planner(name, set).map(|p| p.plan(&query, &mut Context::new(1))) {
        Err(e) | Ok(Err(e)) => assert!(matches!(e, PlanError::BadParameter { .. }), "{name}: {e}"),
        Ok(Ok(_)) => panic!("{name}: accepted"),
    };
    for name in METHODS {
        for set in [
            json!({ "points": 2 }),
            json!({ "points": 5000 }),
            json!({ "weights": [0.0, 0.0, 0.0, 0.0] }),
            json!({ "weights": [0.4, -0.3, 0.2, 0.1] }),
            json!({ "turn_ref": 0.0 }),
            json!({ "length_ref": -1.0 }),
            json!({ "safe": -0.1 }),
            json!({ "population": 1 }),
            json!({ "nonsense": 1 }),
            json!({ "objective": "best" }),
        ] {
            bad(name, set);
        }
        let inside = Query { start: [1.2, 0.95], ..query.clone() };
        assert!(matches!(solve(name, &inside, json!({}), none), Err(PlanError::StartBlocked { .. })));
        let still = Query { limits: Limits { speed: 0.0, ..query.limits }, ..query.clone() };
        assert!(matches!(solve(name, &still, json!({}), none), Err(PlanError::BadParameter { .. })));
        let spent = solve(name, &query, json!({}), Budget { evaluations: Some(0), ..none });
        assert!(matches!(&spent, Err(PlanError::NoPath(no)) if !no.proved && no.reason.as_ref().is_some_and(|r| r.contains("budget"))));
        let standing = Query { goal: query.start, ..query.clone() };
        let found = solve(name, &standing, json!({}), none).unwrap();
        assert_eq!((found.path.length(), found.cost), (0.0, 0.0));
        assert_eq!(found.trajectory.unwrap().duration(), 0.0);
    }
}
