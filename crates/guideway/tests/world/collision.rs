//! The collision checker against brute force.

use crate::brute::{Draw, PLACES, pinched, point_free, segment_to_square, squares};
use guideway::Point;
use guideway::certify::collision;
use guideway::path::Path;
use guideway::query::Query;
use guideway::world::{Bits, Corners, Footprint, Shape, World, shape};
use std::sync::Arc;

fn query(world: World, footprint: Footprint, clearance: f64) -> Query {
    Query { footprint, clearance, ..Query::new(Arc::new(world), [0.0; 2], [0.0; 2]) }
}

/// A walk of a few straight legs on the map, grid frame, cells.
fn walk(draw: &mut Draw, bits: &Bits, legs: u32, reach: f64, snap: Option<f64>) -> Vec<Point> {
    let (w, h) = (f64::from(bits.width()), f64::from(bits.height()));
    let round = |v: f64| snap.map_or(v, |s| (v * s).round() / s);
    let mut points = vec![[round(w * draw.unit()), round(h * draw.unit())]];
    for _ in 0..legs {
        let p = points[points.len() - 1];
        points.push([round((p[0] + reach * (draw.unit() - 0.5)).clamp(0.0, w)), round((p[1] + reach * (draw.unit() - 0.5)).clamp(0.0, h))]);
    }
    points
}

#[test]
fn polylines_of_a_disc_are_judged_exactly() {
    let mut draw = Draw::new(11);
    let (mut good, mut bad) = (0, 0);
    for case in 0..300 {
        let (w, h) = (5 + draw.below(40), 5 + draw.below(30));
        let share = 0.1 * draw.unit();
        let bits = draw.bits(w, h, share);
        let all = squares(&bits, true);
        let points = walk(&mut draw, &bits, 4, 8.0, None);
        let truth = points.windows(2).flat_map(|e| all.iter().map(|&s| segment_to_square(e[0], e[1], s))).fold(f64::INFINITY, f64::min);
        if truth < 0.02 || truth.is_infinite() {
            continue;
        }
        let (resolution, origin) = PLACES[case % 3];
        for (extra, expected) in [(0.0, true), (-1e-6, true), (1e-6, false), (0.3, false)] {
            let world = crate::brute::world(&bits, resolution, origin);
            let path = Path::polyline(&points.iter().map(|&q| world.cell_to_map(q)).collect::<Vec<_>>());
            let radius = truth * resolution * draw.unit();
            let query = query(world, Footprint::Disc(radius), truth * resolution - radius + extra * resolution);
            let found = collision(&path, &query, None);
            assert_eq!(found.ok, expected, "case {case}: {found:?}, needed {} of {}", query.radius(), truth * resolution);
            assert!((found.min_clearance + radius - truth * resolution).abs() < found.step / 50.0, "case {case}: {found:?} {}", truth * resolution);
            assert!((query.world.clearance(found.worst) - radius - found.min_clearance).abs() < found.step);
            if found.ok { good += 1 } else { bad += 1 }
        }
    }
    assert!(good > 100 && bad > 100, "{good} {bad}");
}

#[test]
fn polylines_of_a_point_are_judged_exactly() {
    let mut draw = Draw::new(12);
    let (mut good, mut bad, mut pinches) = (0, 0, 0);
    for case in 0..1500 {
        let (w, h) = (2 + draw.below(6), 2 + draw.below(6));
        let share = 0.1 + 0.3 * draw.unit();
        let bits = draw.bits(w, h, share);
        let points = walk(&mut draw, &bits, 2, 6.0, Some([1.0, 2.0, 3.0][case % 3]));
        if points[0] == points[1] || points[1] == points[2] {
            continue;
        }
        let free = points.windows(2).all(|e| point_free(&bits, e[0], e[1]));
        // A bend in a pinched corner may lead from one side to the other: told by hand, below.
        if pinched(&bits, points[1][0], points[1][1]) {
            pinches += 1;
            continue;
        }
        let (resolution, origin) = PLACES[case % 3];
        let world = crate::brute::world(&bits, resolution, origin);
        let path = Path::polyline(&points.iter().map(|&q| world.cell_to_map(q)).collect::<Vec<_>>());
        let found = collision(&path, &query(world, Footprint::default(), 0.0), Some(resolution * [0.013, 0.25, 0.5][case % 3]));
        assert_eq!(found.ok, free, "case {case}: {points:?} {found:?}");
        if free { good += 1 } else { bad += 1 }
    }
    assert!(good > 200 && bad > 200 && pinches > 5, "{good} {bad} {pinches}");
}

#[test]
fn bends_in_a_pinched_corner() {
    let mut bits = Bits::new(4, 4);
    bits.set(1, 2, true);
    bits.set(2, 1, true);
    let judge = |to: Point, corners| {
        let path = Path::polyline(&[[1.0, 1.5], [2.0, 2.0], to]);
        let query = Query { corners, ..query(crate::brute::world(&bits, 1.0, [0.0; 3]), Footprint::default(), 0.0) };
        collision(&path, &query, Some(0.01)).ok
    };
    assert!(judge([1.5, 1.0], Corners::Touch) && judge([2.0, 1.0], Corners::Touch));
    assert!(!judge([3.0, 2.5], Corners::Touch) && !judge([2.0, 3.0], Corners::Touch) && !judge([3.0, 3.0], Corners::Clear));
    assert!(judge([3.0, 2.5], Corners::Squeeze));
}

/// Smallest distance of footprint points from obstacles, by dense samples of the border.
fn border_gap(world: &World, footprint: &Footprint, pose: [f64; 3]) -> f64 {
    let corners = footprint.at(pose).expect("corners");
    let n = corners.len();
    let edges = (0..n).flat_map(|i| {
        let (a, b) = (corners[i], corners[(i + 1) % n]);
        (0..16).map(move |k| f64::from(k) / 16.0).map(move |t| [a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])])
    });
    edges.map(|p| world.clearance(p)).fold(world.clearance([pose[0], pose[1]]), f64::min)
}

#[test]
fn boxes_and_polygons_keep_their_heading() {
    let mut draw = Draw::new(13);
    let (mut good, mut bad) = (0, 0);
    for case in 0..200 {
        let bits = draw.bits(60, 60, 0.004);
        let (resolution, origin) = PLACES[case % 3];
        let world = crate::brute::world(&bits, resolution, origin);
        let footprint = match case % 2 {
            0 => Footprint::Box([4.0 * resolution, 2.0 * resolution]),
            _ => Footprint::Polygon(vec![[-resolution, -resolution], [3.0 * resolution, 0.0], [-resolution, resolution]]),
        };
        let inner = [10.0, 40.0].map(|x| [x + 8.0 * draw.unit(), 5.0 + 50.0 * draw.unit()]);
        let ends = inner.map(|q| world.cell_to_map(q));
        let path = Path::polyline(&ends);
        let heading = (ends[1][1] - ends[0][1]).atan2(ends[1][0] - ends[0][0]);
        let n = 200;
        let poses = (0..=n).map(|i| f64::from(i) / f64::from(n));
        let poses = poses.map(|t| [ends[0][0] + t * (ends[1][0] - ends[0][0]), ends[0][1] + t * (ends[1][1] - ends[0][1]), heading]);
        let truth = poses.map(|pose| border_gap(&world, &footprint, pose)).fold(f64::INFINITY, f64::min);
        // Dense samples overestimate by no more than this.
        let fuzz = 0.5 * shape::distance(ends[0], ends[1]) / f64::from(n) + 0.13 * resolution;
        let circumscribed = footprint.circumscribed();
        let query = query(world, footprint, 0.02 * resolution);
        let found = collision(&path, &query, None);
        if truth > fuzz + query.clearance {
            assert!(found.ok && (found.min_clearance - truth).abs() < fuzz, "case {case}: {found:?} {truth}");
            good += 1;
        } else if truth < query.clearance {
            assert!(!found.ok, "case {case}: {found:?} {truth}");
            bad += 1;
        }
        // The judgement is finer than that of the circumscribed disc, never coarser.
        let round = collision(&path, &Query { footprint: Footprint::Disc(circumscribed), ..query.clone() }, None);
        assert!(round.min_clearance <= found.min_clearance + 1e-9);
        // Turning round in place at an end needs the disc.
        let turned = collision(&path, &Query { start_yaw: Some(heading + 2.0), ..query.clone() }, None);
        let disc = query.world.clearance(ends[0]) - circumscribed;
        assert_eq!(turned.ok, found.ok && disc >= query.clearance - 1e-9);
    }
    assert!(good > 30 && bad > 30, "{good} {bad}");
}

#[test]
fn curves_are_followed() {
    let mut draw = Draw::new(14);
    let (mut good, mut bad) = (0, 0);
    for case in 0..200 {
        let bits = draw.bits(50, 50, 0.01);
        let (resolution, origin) = PLACES[case % 3];
        let world = crate::brute::world(&bits, resolution, origin);
        let control: Vec<Point> = walk(&mut draw, &bits, 6, 20.0, None).into_iter().map(|q| world.cell_to_map(q)).collect();
        let knots = [0.0; 3].into_iter().chain((0..=4).map(f64::from)).chain([4.0; 3]).collect();
        let path = Path::new(3, 2, knots, control.into_iter().flatten().collect()).expect("a valid spline");
        let n = 4_000;
        let at = |i: i32| path.planar(path.length() * f64::from(i) / f64::from(n)).point;
        let truth = (0..=n).map(|i| world.clearance(at(i))).fold(f64::INFINITY, f64::min);
        if truth < 0.02 * resolution {
            continue;
        }
        let fuzz = path.length() / f64::from(n);
        let mut query = query(world, Footprint::Disc(0.5 * truth), 0.5 * truth - fuzz);
        let found = collision(&path, &query, None);
        assert!(found.ok && (found.min_clearance - 0.5 * truth).abs() < fuzz, "case {case}: {found:?} {truth}");
        query.clearance += 2.0 * fuzz;
        let found = collision(&path, &query, Some(0.2 * resolution));
        assert!(!found.ok, "case {case}: {found:?} {truth}");
        good += 1;
        bad += 1;
    }
    assert!(good > 50 && bad > 50, "{good} {bad}");
}

#[test]
fn shapes_count_and_may_be_touched() {
    let shapes =
        vec![Shape::disc([2.0, 2.0], 1.0).expect("a disc"), Shape::polygon(vec![[4.0, 0.0], [6.0, 0.0], [6.0, 2.0], [4.0, 2.0]]).expect("a square")];
    let world = World::from_shapes([0.0, 0.0, 10.0, 5.0], shapes, 0.05).expect("a world");
    let mut query = query(world, Footprint::default(), 0.0);
    let judge = |points: &[Point], query: &Query| collision(&Path::polyline(points), query, None);
    // Along the tangent of the disc and the top of the square.
    assert!(judge(&[[0.0, 3.0], [5.0, 3.0]], &query).ok && judge(&[[3.0, 3.5], [3.0, 2.0], [8.0, 2.0]], &query).ok);
    // Through both.
    assert!(!judge(&[[0.0, 2.0], [3.5, 2.0]], &query).ok && !judge(&[[3.5, 1.0], [7.0, 1.0]], &query).ok);
    assert!((judge(&[[3.5, 1.0], [7.0, 1.0]], &query).min_clearance + 1.0).abs() < 1e-6);
    // A disc may use its own radius and not more.
    query.footprint = Footprint::Disc(0.5);
    assert!(judge(&[[0.0, 3.5], [8.0, 3.5]], &query).ok);
    let close = judge(&[[0.0, 3.4], [8.0, 3.4]], &query);
    assert!(!close.ok && (close.min_clearance + 0.1).abs() < 1e-6 && (close.worst[0] - 2.0).abs() < 0.01);
    // The border stops the reference point alone.
    assert!(judge(&[[7.0, 5.0], [10.0, 5.0]], &query).ok && !judge(&[[7.0, 4.9], [10.1, 4.9]], &query).ok);
    let nothing = World::from_shapes([0.0, 0.0, 1.0, 1.0], Vec::new(), 0.1).expect("a world");
    let found = judge(&[[0.0, 0.0], [1.0, 1.0]], &self::query(nothing, Footprint::Disc(3.0), 1.0));
    assert!(found.ok && found.min_clearance == f64::INFINITY);
}
