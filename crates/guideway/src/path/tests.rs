use super::*;
use crate::world::shape::{distance, wrap};
use crate::world::{Bits, Grid, World};
use proptest::prelude::*;

/// A grid of 1 m cells.
fn grid(rows: &[&str]) -> World {
    let (w, h) = (rows[0].len() as u32, rows.len() as u32);
    let mut blocked = Bits::new(w, h);
    for (y, row) in rows.iter().rev().enumerate() {
        for (x, c) in row.bytes().enumerate() {
            blocked.set(x as u32, y as u32, c == b'#');
        }
    }
    World::from_grid(Grid::new(blocked, None, 1.0, [0.0; 3]).unwrap())
}

/// `n` cells of travel with `turns` turns of 45 degrees, alternating, spread evenly.
fn zigzag(n: usize, turns: usize) -> Path {
    let mut points = vec![[0.5, 0.5]];
    let mut turned = 0;
    for i in 0..n {
        if turned < turns && i * turns >= n * turned && i > 0 {
            turned += 1;
        }
        let heading = if turned % 2 == 1 { std::f64::consts::FRAC_PI_4 } else { 0.0 };
        let [x, y] = points[i];
        points.push([x + heading.cos(), y + heading.sin()]);
    }
    Path::polyline(&points)
}

#[test]
fn measures_of_hand_made_paths() {
    let free = World::from_shapes([0.0, 0.0, 100.0, 100.0], vec![], 1.0).unwrap();
    for (turns, expected) in [(3, 0.97), (20, 0.82)] {
        let m = measure(&zigzag(28, turns), &free, 0.0);
        assert_eq!(m.turns, turns);
        assert!((m.smoothness - expected).abs() < 0.005, "{}", m.smoothness);
        assert!((m.total_turning - turns as f64 * std::f64::consts::FRAC_PI_4).abs() < 1e-9);
        assert!((m.length - 28.0).abs() < 1e-9 && (m.energy - (28.0 + 0.5 * turns as f64)).abs() < 1e-9);
        assert_eq!((m.max_curvature, m.min_clearance), (None, None));
    }
    let straight = measure(&Path::polyline(&[[0.0, 0.0], [9.0, 0.0]]), &free, 0.0);
    assert_eq!((straight.turns, straight.smoothness, straight.max_curvature), (0, 1.0, Some(0.0)));
    let back = measure(&Path::polyline(&(0..9).map(|i| [f64::from(i % 2), 0.0]).collect::<Vec<_>>()), &free, 0.0);
    assert!((back.smoothness - 1.0 / 8.0).abs() < 1e-12, "{}", back.smoothness); // the last window does not turn
}

#[test]
fn measures_of_curves() {
    let world = grid(&["......", "......", "..#...", "......"]);
    let path = Path::polyline(&[[0.5, 0.6], [5.5, 0.6]]);
    assert!((measure(&path, &world, 0.25).min_clearance.unwrap() - 0.15).abs() < 1e-12);
    let through = Path::polyline(&[[0.5, 1.4], [5.5, 1.4]]);
    assert!((measure(&through, &world, 0.0).min_clearance.unwrap() + 0.4).abs() < 1e-9);
    let corner = Path::polyline(&[[1.0, 0.5], [3.7, 0.5], [3.7, 3.0]]); // passes the corner (3, 1) at 0.7 right and 0.5 below
    assert!((measure(&corner, &world, 0.0).min_clearance.unwrap() - 0.5).abs() < 1e-12);
    let m = measure(&quarter(), &world, 0.0);
    assert_eq!(m.turns, 1);
    assert!((m.total_turning - std::f64::consts::FRAC_PI_2).abs() < 1e-9);
    let dense = (0..=20000).map(|i| quarter().planar(quarter().length() * f64::from(i) / 20000.0).curvature).fold(0.0, f64::max);
    assert!((m.max_curvature.unwrap() - dense).abs() < 1e-7, "{:?} {dense}", m.max_curvature);
    // Two bends with about 4 m of straight travel between them are two turns in cells of 1 m, one turn in cells of 5 m.
    let rows = [[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [2.0, 1.0], [2.0, 2.0], [2.0, 5.0], [2.0, 6.0], [3.0, 6.0], [4.0, 6.0]];
    let bends = Path::new(3, 2, [vec![0.0; 4], (1..=5).map(f64::from).collect(), vec![6.0; 4]].concat(), rows.concat()).unwrap();
    for (cell, turns) in [(1.0, 2), (5.0, 1)] {
        let free = World::from_shapes([0.0, 0.0, 100.0, 100.0], vec![], cell).unwrap();
        assert_eq!(measure(&bends, &free, 0.0).turns, turns, "cells of {cell} m");
    }
}

/// Clamped uniform knots.
fn knots(degree: usize, n: usize) -> Vec<f64> {
    (0..=n + degree).map(|i| (i.clamp(degree, n) - degree) as f64).collect()
}

fn spline(degree: usize, points: &[[f64; 2]]) -> Path {
    Path::new(degree, 2, knots(degree, points.len()), points.concat()).unwrap()
}

/// Cubic Bezier quarter of the unit circle (the classical approximation, radial error 2.7e-4).
fn quarter() -> Path {
    let k = 0.552_284_749_830_793_4;
    spline(3, &[[1.0, 0.0], [1.0, k], [k, 1.0], [0.0, 1.0]])
}

#[test]
fn lengths_of_known_curves() {
    assert_eq!(Path::polyline(&[[0.0, 0.0], [3.0, 4.0], [3.0, 10.0]]).length(), 11.0);
    assert!((spline(3, &[[0.0, 0.0], [1.0, 1.0], [2.0, 2.0], [5.0, 5.0]]).length() - 50f64.sqrt()).abs() < 1e-12);
    // y = x^2 on [0, 1]: sqrt(5)/2 + asinh(2)/4
    let parabola = spline(2, &[[0.0, 0.0], [0.5, 0.0], [1.0, 1.0]]);
    assert!((parabola.length() - (5f64.sqrt() / 2.0 + 2f64.asinh() / 4.0)).abs() < 1e-10, "{}", parabola.length());
    assert!((quarter().length() - std::f64::consts::FRAC_PI_2).abs() < 3e-4);
    // A cusp: x = t^2, y = t^3 on [-1, 1] has length 2 (13 sqrt(13) - 8) / 27.
    let cusp =
        Path::new(3, 2, vec![-1.0, -1.0, -1.0, -1.0, 1.0, 1.0, 1.0, 1.0], vec![1.0, -1.0, -1.0 / 3.0, 1.0, -1.0 / 3.0, -1.0, 1.0, 1.0]).unwrap();
    assert!((cusp.length() - 2.0 * (13.0 * 13f64.sqrt() - 8.0) / 27.0).abs() < 1e-6, "{}", cusp.length());
}

#[test]
fn degenerate_paths_are_calm() {
    for path in [Path::polyline(&[]), Path::polyline(&[[1.0, 2.0]]), Path::polyline(&[[1.0, 2.0], [1.0, 2.0]]), spline(3, &[[1.0, 2.0]; 5])] {
        assert_eq!(path.length(), 0.0);
        assert_eq!(path.eval(0.5, 3)[0], path.point(0));
        assert_eq!(path.planar(1.0).point, path.point(0));
        assert!(path.corners().is_empty());
        assert_eq!(path.project([4.0, 6.0], 0.0, 1.0).0, 0.0);
    }
    let same_knots = Path::new(1, 2, vec![0.0; 4], vec![0.0, 0.0, 1.0, 0.0]).unwrap();
    assert!(same_knots.at(0.0, 2)[0][0].is_finite() && same_knots.length() == 0.0);
    // Repeated control points at the ends: the heading is that of the curve a little inside.
    let path = spline(3, &[[0.0, 0.0], [0.0, 0.0], [1.0, 1.0], [2.0, 2.0], [2.0, 2.0]]);
    for s in [0.0, path.length()] {
        assert!((path.planar(s).heading - std::f64::consts::FRAC_PI_4).abs() < 1e-6, "{:?}", path.planar(s));
    }
}

#[test]
fn corners_of_a_polyline_turn_in_place() {
    let path = Path::polyline(&[[0.0, 0.0], [2.0, 0.0], [3.0, 0.0], [3.0, 1.0], [2.0, 1.0]]);
    let corners = path.corners();
    assert_eq!(corners.iter().map(|c| c.s).collect::<Vec<_>>(), [3.0, 4.0]);
    assert!(corners.iter().all(|c| (c.turn() - std::f64::consts::FRAC_PI_2).abs() < 1e-15));
    let at = path.planar(3.0);
    assert_eq!((at.point, at.curvature), ([3.0, 0.0], 0.0));
    assert!((at.heading - std::f64::consts::FRAC_PI_2).abs() < 1e-15);
    assert!(quarter().corners().is_empty());
}

#[test]
fn files_round_trip_and_are_checked() {
    let path = quarter();
    let text = serde_json::to_string(&path).unwrap();
    assert!(text.starts_with(r#"{"degree":3,"knots":[0.0,0.0,0.0,0.0,1.0"#) && text.contains(r#""control_points":[[1.0,0.0],"#));
    assert_eq!(serde_json::from_str::<Path>(&text).unwrap(), path);
    for bad in [
        r#"{"degree":3,"knots":[0,1],"control_points":[[0,0],[1,1]]}"#,
        r#"{"degree":1,"knots":[0,0,1,1],"control_points":[[0,0],[1]]}"#,
        r#"{"degree":1,"knots":[0,0,1,1],"control_points":[]}"#,
    ] {
        assert!(serde_json::from_str::<Path>(bad).is_err(), "{bad}");
    }
}

#[test]
fn projection_finds_the_side_and_never_goes_back() {
    let path = Path::polyline(&[[0.0, 0.0], [4.0, 0.0], [4.0, 4.0]]);
    assert_eq!(path.project([1.0, 0.5], 0.0, 10.0), (1.0, 0.5));
    assert_eq!(path.project([1.0, -0.5], 0.0, 10.0), (1.0, -0.5));
    assert_eq!(path.project([1.0, 0.5], 2.0, 1.0).0, 2.0);
    let circle = quarter();
    let (s, d) = circle.project([0.5f64.sqrt() * 0.9, 0.5f64.sqrt() * 0.9], 0.0, 9.0);
    assert!((s - circle.length() / 2.0).abs() < 1e-9 && (d - 0.1).abs() < 3e-4, "{s} {d}");
}

fn any_spline() -> impl Strategy<Value = Path> {
    (1usize..=5, proptest::collection::vec([-10.0..10.0f64, -10.0..10.0f64], 7..14), 0usize..3).prop_map(|(degree, points, repeats)| {
        let mut u = knots(degree, points.len());
        let inner = degree + 1..points.len();
        for k in inner.clone().take(repeats.min(degree.saturating_sub(1))) {
            u[k] = u[inner.start]; // a repeated inner knot
        }
        Path::new(degree, 2, u, points.concat()).unwrap()
    })
}

/// Length by brute force, `n` chords a knot span.
fn chord_length(path: &Path, n: usize) -> f64 {
    let (a, b) = (path.knots()[0], path.knots()[path.knots().len() - 1]);
    let n = n * (b - a) as usize;
    let at = |i: usize| path.at(a + (b - a) * i as f64 / n as f64, 0).remove(0);
    (0..n).map(|i| (at(i), at(i + 1))).map(|(p, q)| (q[0] - p[0]).hypot(q[1] - p[1])).sum()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn never_longer_than_its_polygon_and_as_long_as_its_chords(path in any_spline()) {
        let polygon: f64 = path.points().windows(2).map(|w| distance(w[0], w[1])).sum();
        prop_assert!(path.length() <= polygon * (1.0 + 1e-12));
        let chords = chord_length(&path, 400);
        prop_assert!(chords <= path.length() * (1.0 + 1e-9));
        prop_assert!(path.length() - chords < 1e-3 * chords);
    }

    #[test]
    fn arc_length_inverts(path in any_spline(), share in 0.0..1.0f64) {
        let (a, b) = (path.knots()[0], path.knots()[path.knots().len() - 1]);
        let u = a + share * (b - a);
        let s = path.length_at(u);
        prop_assert!(distance(path.planar(s).point, [path.at(u, 0)[0][0], path.at(u, 0)[0][1]]) < 1e-9);
        let (s0, s1) = (path.length() * share, (path.length() * share + 1e-3).min(path.length()));
        let chord = distance(path.planar(s0).point, path.planar(s1).point);
        prop_assert!(chord <= s1 - s0 + 1e-10);
    }

    #[test]
    fn derivatives_match_differences(path in any_spline(), share in 0.02..0.98f64) {
        prop_assume!(path.degree() >= 4); // third derivative continuous across knots
        let s = share * path.length();
        prop_assume!(path.planar(s).curvature.abs() < 3.0);
        let h = 1e-5;
        let rows = path.eval(s, 3);
        let (before, after) = (path.eval(s - h, 3), path.eval(s + h, 3));
        let size = 1.0 + rows.iter().flatten().map(|v| v.abs()).fold(0.0, f64::max);
        prop_assume!(size < 30.0 && path.knots().windows(2).filter(|w| w[0] == w[1]).count() == 2 * path.degree());
        for k in 0..3 {
            for d in 0..2 {
                let difference = (after[k][d] - before[k][d]) / (2.0 * h);
                prop_assert!((difference - rows[k + 1][d]).abs() < 1e-4 * size * size, "order {} {} {}", k + 1, difference, rows[k + 1][d]);
            }
        }
        prop_assert!((rows[1][0].hypot(rows[1][1]) - 1.0).abs() < 1e-12);
        let place = path.planar(s);
        prop_assert!(wrap(place.heading - rows[1][1].atan2(rows[1][0])).abs() < 1e-12);
        prop_assert!((place.curvature - (rows[1][0] * rows[2][1] - rows[1][1] * rows[2][0])).abs() < 1e-9 * size);
    }

    #[test]
    fn pieces_stay_in_their_hulls(path in any_spline(), share in 0.0..1.0f64) {
        for piece in path.beziers() {
            let u = piece.u[0] + share * (piece.u[1] - piece.u[0]);
            let at = path.at(u, 0).remove(0);
            // Inside the hull: no line of any direction separates the point from all control points.
            for i in 0..32 {
                let (s, c) = (f64::from(i) * 0.1).sin_cos();
                let reach = |p: &[f64]| c * p[0] + s * p[1];
                let (low, high) = piece.points.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), p| (l.min(reach(p)), h.max(reach(p))));
                prop_assert!(reach(&at) >= low - 1e-9 && reach(&at) <= high + 1e-9);
            }
            let [left, right] = piece.halves();
            prop_assert!(distance(left.ends()[1], right.ends()[0]) < 1e-12);
            prop_assert!(left.polygon_length() + right.polygon_length() <= piece.polygon_length() + 1e-9);
        }
    }

    #[test]
    fn chords_stay_close(path in any_spline(), tolerance in 0.001..0.5f64) {
        let at: Vec<f64> = path.sample_chords(tolerance);
        for w in at.windows(2) {
            let point = |u: f64| { let r = path.at(u, 0).remove(0); [r[0], r[1]] };
            for i in 1..8 {
                let u = w[0] + (w[1] - w[0]) * f64::from(i) / 8.0;
                let d = crate::world::shape::point_segment(point(u), point(w[0]), point(w[1]));
                prop_assert!(d <= tolerance + 1e-9, "{d}");
            }
        }
    }
}
