use super::*;
use crate::world::{Bits, Footprint, Grid, Shape, World};
use proptest::prelude::*;
use std::sync::Arc;

fn open_world() -> Arc<World> {
    Arc::new(World::from_grid(Grid::new(Bits::new(12, 12), None, 1.0, [0.0; 3]).unwrap()))
}

fn refined(query: &Query, points: &[Point]) -> Refined {
    BSpline::default().refine(&Path::polyline(points), query, &mut Context::new(0)).unwrap()
}

#[test]
fn all_cells_are_control_points_and_the_curve_follows_the_middle_of_three() {
    let query = Query::new(open_world(), [0.5, 0.5], [8.5, 4.5]);
    let found = refined(&query, &[[0.5, 0.5], [4.5, 4.5], [8.5, 4.5]]);
    assert!(found.unmet.is_empty());
    assert_eq!((found.path.count(), found.path.degree()), (9, 3));
    assert_eq!(found.path.knots()[..6], [0.0, 0.0, 0.0, 0.0, 1.0, 2.0]);
    assert_eq!(found.path.ends(), [query.start, query.goal]);
    // A uniform cubic at the knot of control point i is (before + 4 it + after) / 6.
    let at = found.path.at(3.0, 0)[0].clone();
    assert!((at[0] - (3.5 + 4.0 * 4.5 + 5.5) / 6.0).abs() < 1e-12 && (at[1] - (3.5 + 4.0 * 4.5 + 4.5) / 6.0).abs() < 1e-12);
    assert!(found.path.corners().is_empty());
}

#[test]
fn where_the_curve_would_cut_a_corner_a_cell_counts_twice_or_three_times() {
    let wall = Shape::polygon(vec![[3.0, 0.0], [6.0, 0.0], [6.0, 3.0], [3.0, 3.0]]).unwrap();
    let world = Arc::new(World::from_shapes([0.0, 0.0, 12.0, 12.0], vec![wall], 1.0).unwrap());
    let points = [[2.5, 0.5], [2.5, 3.5], [9.5, 3.5]];
    let mut query = Query::new(Arc::clone(&world), points[0], points[2]);
    // The corner (3, 3) is 0.707 m from the cell; the plain curve comes as near as 0.471 m, the cell counted twice leaves 0.678 m.
    for (radius, times) in [(0.4, 1), (0.48, 2)] {
        query.footprint = Footprint::Disc(radius);
        let found = refined(&query, &points);
        assert_eq!(found.path.points().iter().filter(|p| **p == points[1]).count(), times, "{radius}");
        assert!(found.path.corners().is_empty() && found.unmet.is_empty());
        assert!(found.path.length() < Path::polyline(&points).length());
    }
    // A path that touches the corner itself can only turn in place there.
    let taut = [[2.0, 0.5], [3.0, 3.0], [9.5, 3.0]];
    let found = refined(&Query::new(world, taut[0], taut[2]), &taut);
    let triple = |k: &&[f64]| k[0] == k[2];
    assert_eq!(
        (found.path.knots()[4..found.path.count()].windows(3).filter(triple).count(), found.path.corners().len(), found.unmet.len()),
        (1, 1, 1)
    );
}

#[test]
fn via_points_are_passed_exactly() {
    let mut query = Query::new(open_world(), [0.5, 0.5], [8.5, 0.5]);
    query.via = vec![[4.5, 4.5]];
    let found = refined(&query, &[[0.5, 0.5], [4.5, 4.5], [8.5, 0.5]]);
    assert!(found.path.points().contains(&[4.5, 4.5]) && found.path.project([4.5, 4.5], 0.0, 20.0).1 < 1e-9);
    assert_eq!((found.path.corners().len(), found.unmet.len()), (1, 1));
    query.via = vec![[3.5, 3.5]];
    let found = refined(&query, &[[0.5, 0.5], [5.5, 5.5], [8.5, 0.5]]);
    let (s, miss) = found.path.project([3.5, 3.5], 0.0, 9.0);
    assert!(miss < 1e-9 && found.path.corners().is_empty(), "{miss} at {s}");
}

#[test]
fn short_paths_and_bad_settings() {
    let query = Query::new(open_world(), [0.5, 0.5], [1.5, 0.5]);
    assert!((refined(&query, &[[0.5, 0.5], [1.5, 0.5]]).path.length() - 1.0).abs() < 1e-12);
    let point = Path::polyline(&[[0.5, 0.5]]);
    assert_eq!(BSpline::default().refine(&point, &query, &mut Context::new(0)).unwrap().path, point);
    assert!(BSpline { spacing: 0.0 }.refine(&point, &query, &mut Context::new(0)).is_err());
}

proptest! {
    #![proptest_config(ProptestConfig { rng_seed: proptest::test_runner::RngSeed::Fixed(7), ..ProptestConfig::default() })]

    /// Never longer than its control polygon, whatever counts twice or three times (metrics, pso_aco section 9).
    #[test]
    fn a_spline_is_never_longer_than_its_polygon(points in proptest::collection::vec((-9.0..9.0, -9.0..9.0), 4..30), times in proptest::collection::vec(1u8..4, 30)) {
        let control: Vec<Control> = points.iter().zip(&times).map(|(p, t)| Control { at: [p.0, p.1], times: *t, bent: true }).collect();
        let polygon: f64 = control.windows(2).map(|w| distance(w[0].at, w[1].at)).sum();
        prop_assert!(spline(&control).unwrap().0.length() <= polygon * (1.0 + 1e-9));
    }
}
