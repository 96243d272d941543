use super::*;
use crate::Point;
use crate::path::measure;
use crate::world::shape::distance;
use crate::world::{Bits, Footprint, Grid, Shape, World};
use std::sync::Arc;

fn grid(rows: &[&str]) -> Arc<World> {
    let (w, h) = (rows[0].len() as u32, rows.len() as u32);
    let mut blocked = Bits::new(w, h);
    for (y, row) in rows.iter().rev().enumerate() {
        for (x, c) in row.bytes().enumerate() {
            blocked.set(x as u32, y as u32, c == b'#');
        }
    }
    Arc::new(World::from_grid(Grid::new(blocked, None, 1.0, [0.0; 3]).unwrap()))
}

const BLOCK: [&str; 6] = ["..........", "..........", "....##....", "....##....", "....##....", "....##...."];

fn query(world: &Arc<World>, points: &[Point]) -> Query {
    Query::new(Arc::clone(world), points[0], points[points.len() - 1])
}

fn smooth(smooth: Smooth, query: &Query, points: &[Point]) -> Refined {
    let refined = smooth.refine(&Path::polyline(points), query, &mut Context::new(0)).unwrap();
    let length = refined.path.length();
    for i in 0..=2000 {
        let p = refined.path.planar(length * f64::from(i) / 2000.0).point;
        assert!(query.world.clearance(p) >= query.radius() - 1e-9, "{p:?} is {} m from an obstacle", query.world.clearance(p));
    }
    for w in polyline(&refined.path, query).windows(2) {
        assert!(query.world.segment_free(w[0], w[1], query.radius()));
    }
    assert_eq!(refined.path.ends(), [query.start, query.goal]);
    refined
}

#[test]
fn a_taut_corner_gets_one_wide_bend_on_the_free_side() {
    let world = grid(&BLOCK);
    let raw = [[1.0, 0.5], [4.0, 4.0], [6.0, 4.0], [9.0, 0.5]];
    let refined = smooth(Smooth::default(), &query(&world, &raw), &raw);
    let m = measure(&refined.path, &world, 0.0);
    assert!(refined.unmet.is_empty(), "{:?}", refined.unmet);
    assert_eq!((m.turns, refined.path.degree()), (1, 3));
    assert!(m.max_curvature.unwrap() < 0.6 && m.min_clearance.unwrap() > 0.0, "{m:?}");
    assert!(m.length < 1.03 * Path::polyline(&raw).length());
    // Symmetric, and straight up to the bend.
    let length = refined.path.length();
    for i in 0..50 {
        let s = length * f64::from(i) / 100.0;
        let (a, b) = (refined.path.planar(s), refined.path.planar(length - s));
        assert!((a.point[0] + b.point[0] - 10.0).abs() < 1e-6 && (a.point[1] - b.point[1]).abs() < 1e-6 && (a.curvature - b.curvature).abs() < 1e-6);
    }
    assert!(refined.path.planar(0.2 * length).curvature.abs() < 1e-9);
}

#[test]
fn curvature_is_continuous_and_never_changes_sign_around_one_corner() {
    let world = grid(&["..........", "..........", "......####", "......####", "......####", "......####"]);
    let raw = [[2.0, 0.5], [6.0, 4.0], [9.5, 4.2]];
    let path = smooth(Smooth::default(), &query(&world, &raw), &raw).path;
    let length = path.length();
    for s in path.joints() {
        let jump = path.planar((s + 1e-7).min(length)).curvature - path.planar((s - 1e-7).max(0.0)).curvature;
        assert!(jump.abs() < 1e-4, "curvature jumps by {jump} at {s}");
    }
    assert!((0..=1000).all(|i| path.planar(length * f64::from(i) / 1000.0).curvature <= 1e-9), "a wiggle");
}

#[test]
fn corners_of_a_lattice_path_are_cut_not_circled() {
    let world = grid(&BLOCK);
    let raw = [[0.5, 0.5], [0.5, 5.5], [9.5, 5.5]];
    let mut stairs = vec![[0.5, 0.5]];
    stairs.extend((1..=5).map(|y| [0.5, f64::from(y) + 0.5]));
    stairs.extend((1..=9).map(|x| [f64::from(x) + 0.5, 5.5]));
    let refined = smooth(Smooth::default(), &query(&world, &raw), &stairs);
    assert!(refined.path.length() < Path::polyline(&raw).length() - 0.5);
    assert!(refined.unmet.is_empty());
}

#[test]
fn a_gap_of_no_width_keeps_its_corner_and_says_so() {
    // The only way is between two blocks one robot apart, with a corner on either side.
    let world = grid(&["..........", "....##....", "....##....", "..........", "......##..", "......##..", ".........."]);
    let raw = [[0.5, 6.5], [4.0, 4.0], [8.0, 3.0], [9.5, 0.5]];
    let mut tight = query(&world, &raw);
    let refined = smooth(Smooth::default(), &tight, &raw);
    assert!(refined.unmet.is_empty(), "{:?}", refined.unmet);
    tight.footprint = Footprint::Disc(0.5);
    let raw = [[0.5, 3.5], [5.0, 3.5], [9.5, 3.5]];
    tight.start = raw[0];
    tight.goal = raw[2];
    let straight = smooth(Smooth::default(), &tight, &raw);
    assert!((straight.path.length() - 9.0).abs() < 1e-9 && straight.unmet.is_empty());
    // A bend of 90 degrees in a corridor as wide as the robot has no room at all.
    let walls = grid(&["####.", "####.", "####.", ".....", "####."]);
    let raw = [[0.5, 1.5], [4.5, 1.5], [4.5, 4.5]];
    let mut corridor = query(&walls, &raw);
    corridor.footprint = Footprint::Disc(0.5);
    corridor.via = vec![raw[1]];
    let refined = smooth(Smooth::default(), &corridor, &raw);
    assert_eq!(refined.path.corners().len(), 1, "{:?}", refined.unmet);
    assert!(refined.unmet[0].contains("no room for a bend at via point (4.500, 1.500): turn in place by 90.0 degrees"), "{:?}", refined.unmet);
}

#[test]
fn via_points_stay_on_the_path() {
    let world = Arc::new(World::from_shapes([0.0, 0.0, 20.0, 20.0], vec![], 0.1).unwrap());
    for raw in [
        vec![[1.0, 1.0], [10.0, 2.0], [12.0, 15.0]],
        vec![[1.0, 1.0], [5.0, 5.0], [9.0, 9.0], [12.0, 2.0]],
        vec![[1.0, 1.0], [8.0, 3.0], [9.0, 9.0], [2.0, 14.0]],
    ] {
        let mut query = query(&world, &raw);
        query.via = raw[1..raw.len() - 1].to_vec();
        let refined = smooth(Smooth::default(), &query, &raw);
        for via in &query.via {
            assert!(refined.path.project(*via, 0.0, 100.0).1.abs() < 1e-9, "{via:?}");
        }
        assert!(refined.path.corners().is_empty(), "{:?}", refined.unmet);
    }
}

#[test]
fn a_curvature_limit_is_met_where_there_is_room() {
    let world = grid(&BLOCK);
    let raw = [[1.0, 0.5], [4.0, 4.0], [6.0, 4.0], [9.0, 0.5]];
    let loose = smooth(Smooth { max_curvature: Some(0.9), ..Smooth::default() }, &query(&world, &raw), &raw);
    assert!(loose.unmet.is_empty(), "{:?}", loose.unmet);
    assert!(measure(&loose.path, &world, 0.0).max_curvature.unwrap() <= 0.9);
    let tight = smooth(Smooth { max_curvature: Some(0.05), ..Smooth::default() }, &query(&world, &raw), &raw);
    assert!(tight.unmet.iter().any(|u| u.contains("above 0.05 1/m")), "{:?}", tight.unmet);
    let bad = Smooth { max_curvature: Some(-1.0), ..Smooth::default() }.refine(&Path::polyline(&raw), &query(&world, &raw), &mut Context::new(0));
    assert_eq!(bad.unwrap_err().name(), "BadParameter");
}

#[test]
fn robots_with_a_radius_go_around_discs() {
    let disc = Shape::disc([5.0, 5.0], 1.0).unwrap();
    let world = Arc::new(World::from_shapes([0.0, 0.0, 10.0, 10.0], vec![disc], 0.05).unwrap());
    // A taut way: circumscribed chain around the inflated disc, from (0.5, 5) to (9.5, 5).
    let (r, n) = (1.3, 24);
    let touch = (r / 4.5f64).acos();
    let step = (std::f64::consts::PI - 2.0 * touch) / f64::from(n);
    let around = |k: f64| {
        let a = std::f64::consts::PI - touch - k * step;
        [5.0 + r / (step / 2.0).cos() * a.cos(), 5.0 + r / (step / 2.0).cos() * a.sin()]
    };
    let mut raw = vec![[0.5, 5.0]];
    raw.extend((0..n).map(|k| around(f64::from(k) + 0.5)));
    raw.push([9.5, 5.0]);
    let mut query = query(&world, &raw);
    (query.footprint, query.clearance) = (Footprint::Disc(0.2), 0.1);
    let refined = smooth(Smooth::default(), &query, &raw);
    assert!(refined.unmet.is_empty(), "{:?}", refined.unmet);
    let m = measure(&refined.path, &world, 0.3);
    assert_eq!(m.turns, 1);
    assert!(m.max_curvature.unwrap() < 1.0 / r + 0.02 && m.length < 1.02 * Path::polyline(&raw).length(), "{m:?}");
}

#[test]
fn degenerate_inputs_come_back_calm() {
    let world = grid(&BLOCK);
    let here = [[1.0, 1.0], [1.0, 1.0]];
    assert_eq!(smooth(Smooth::default(), &query(&world, &here), &here).path.length(), 0.0);
    let line = [[1.0, 1.0], [2.0, 1.0], [3.0, 1.0]];
    let refined = smooth(Smooth::default(), &query(&world, &line), &line);
    assert!((refined.path.length() - 2.0).abs() < 1e-12);
    let back = [[1.0, 1.0], [3.0, 1.0], [1.5, 1.0]];
    let mut spur = query(&world, &back);
    spur.via = vec![back[1]];
    // There is room to turn round in a loop through the via point.
    let spur = smooth(Smooth::default(), &spur, &back);
    assert!(spur.path.corners().is_empty() && spur.unmet.is_empty(), "{:?}", spur.unmet);
    assert!(spur.path.project(back[1], 0.0, 10.0).1.abs() < 1e-9);
    // A smooth path can be smoothed again.
    let raw = [[1.0, 0.5], [4.0, 4.0], [6.0, 4.0], [9.0, 0.5]];
    let query = query(&world, &raw);
    let once = smooth(Smooth::default(), &query, &raw);
    let twice = Smooth::default().refine(&once.path, &query, &mut Context::new(0)).unwrap();
    assert!(twice.path.length() < 1.02 * once.path.length() && twice.unmet.is_empty(), "{:?}", twice.unmet);
}

#[test]
fn simplify_keeps_clearance_stops_and_never_lengthens() {
    let world = grid(&BLOCK);
    let stairs: Vec<Point> =
        [[0.5, 0.5], [1.5, 1.5], [2.5, 2.5], [3.5, 3.5], [3.5, 4.5], [4.5, 4.5], [5.5, 4.5], [6.5, 4.5], [6.5, 3.5], [7.5, 2.5], [9.5, 0.5]].into();
    for (radius, exact) in [(0.0, 120), (0.5, 120), (0.0, 4)] {
        let mut query = query(&world, &stairs);
        query.footprint = Footprint::Disc(radius);
        let out = Simplify { exact }.refine(&Path::polyline(&stairs), &query, &mut Context::new(0)).unwrap().path;
        let points = out.points();
        assert!(points.len() <= 7 && out.length() <= Path::polyline(&stairs).length() + 1e-9, "{points:?}");
        assert!(points.windows(2).all(|w| query.world.segment_free(w[0], w[1], radius)));
        query.via = vec![[5.0, 4.5], [7.5, 2.5]];
        let out = Simplify { exact }.refine(&Path::polyline(&stairs), &query, &mut Context::new(0)).unwrap().path;
        assert!(query.via.iter().all(|v| out.points().iter().any(|p| distance(*p, *v) < 1e-9)), "{:?}", out.points());
    }
}
