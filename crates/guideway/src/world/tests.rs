use super::*;
use proptest::prelude::*;

fn scattered(share: f64, seed: u64, origin: [f64; 3]) -> World {
    use rand_chacha::rand_core::{Rng, SeedableRng};
    let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(seed);
    let mut bits = Bits::new(40, 30);
    for (x, y) in (0..30).flat_map(|y| (0..40).map(move |x| (x, y))) {
        bits.set(x, y, f64::from(rng.next_u32()) < share * f64::from(u32::MAX));
    }
    World::from_grid(Grid::new(bits, None, 0.1, origin).unwrap())
}

/// Distance of a convex body from every blocked square, one by one.
fn brute(world: &World, corners: &[Point]) -> f64 {
    let grid = world.grid().unwrap();
    let q: Vec<Point> = corners.iter().map(|p| grid.to_cells(*p)).collect();
    let cells = (0..grid.height()).flat_map(|y| (0..grid.width()).map(move |x| [x, y]));
    let squares = cells.filter(|c| grid.blocked().at(c[0], c[1])).map(|c| c.map(f64::from));
    let square = |[x, y]: Point| vec![[x, y], [x + 1.0, y], [x + 1.0, y + 1.0], [x, y + 1.0]];
    squares.map(|s| shape::convex_distance(&q, &square(s))).fold(f64::INFINITY, f64::min) * grid.resolution()
}

fn footprints() -> impl Strategy<Value = Footprint> {
    prop_oneof![
        (0.05..0.6_f64, 0.05..0.6_f64).prop_map(|(l, w)| Footprint::Box([l, w])),
        Just(Footprint::Polygon(vec![[-0.2, -0.1], [0.3, -0.05], [0.1, 0.25], [-0.1, 0.2]])),
    ]
}

proptest! {
    #[test]
    fn poses_are_judged_exactly(seed in 0u64..10_000, footprint in footprints(), x in 0.7..3.3_f64, y in 0.7..2.3_f64, yaw in -4.0..4.0_f64, turned in -1.0..1.0_f64) {
        let world = scattered(0.02, seed, [1.0, -2.0, turned]);
        let p = world.cell_to_map([10.0 * x, 10.0 * y]);
        let pose = [p[0], p[1], yaw];
        let truth = brute(&world, &footprint.at(pose).unwrap());
        if truth > 1e-6 && truth.is_finite() {
            prop_assert!(world.pose_free(&footprint, pose, 0.0));
            prop_assert!(world.pose_free(&footprint, pose, truth - 1e-7));
            prop_assert!(world.pose_free(&footprint, pose, truth));
            prop_assert!(!world.pose_free(&footprint, pose, truth + 1e-7));
        } else if truth < -1e-6 {
            prop_assert!(!world.pose_free(&footprint, pose, 0.0) && !world.pose_free(&footprint, pose, 0.1));
        }
    }

    #[test]
    fn turns_are_judged_on_the_safe_side(seed in 0u64..10_000, footprint in footprints(), x in 0.7..3.3_f64, y in 0.7..2.3_f64, yaw in -3.0..3.0_f64, turn in -6.0..6.0_f64) {
        let world = scattered(0.01, seed, [0.0; 3]);
        let p = world.cell_to_map([10.0 * x, 10.0 * y]);
        let n = 600;
        let poses = (0..=n).map(|i| [p[0], p[1], yaw + turn * f64::from(i) / f64::from(n)]);
        let truth = poses.map(|pose| brute(&world, &footprint.at(pose).unwrap())).fold(f64::INFINITY, f64::min);
        // The true minimum is lower than that of the samples by no more than half a step of the farthest corner.
        let fuzz = 0.5 * turn.abs() / f64::from(n) * footprint.circumscribed();
        let free = world.sweep_free(&footprint, p, [yaw, turn], 0.05);
        if truth - fuzz > 0.05 + 2e-6 {
            prop_assert!(free);
        } else if truth < 0.05 - 1e-8 {
            prop_assert!(!free);
        }
    }

    #[test]
    fn segment_clearance_is_exact(seed in 0u64..10_000, a in prop::array::uniform2(0.0..3.0_f64), b in prop::array::uniform2(0.0..3.0_f64), turned in -1.0..1.0_f64) {
        let world = scattered(0.02, seed, [1.0, -2.0, turned]);
        let (a, b) = (world.cell_to_map(a.map(|v| 10.0 * v)), world.cell_to_map(b.map(|v| 10.0 * v)));
        let (ours, truth) = (world.segment_clearance(a, b), brute(&world, &[a, b]));
        if truth > 1e-9 {
            prop_assert!(ours == truth || (ours - truth).abs() < 1e-9, "{} {}", ours, truth);
        } else {
            prop_assert!(ours <= 1e-9);
        }
    }

    #[test]
    fn bodies_are_as_far_apart_as_their_borders(x in -3.0..3.0_f64, y in -3.0..3.0_f64, yaw in -3.0..3.0_f64) {
        let body = Footprint::Box([1.0, 0.4]).at([x, y, yaw]).unwrap();
        let other = [[-0.5, -0.5], [0.8, -0.2], [0.0, 0.9]];
        let dense = |p: &[Point]| (0..p.len()).flat_map(|i| {
            let (a, b) = (p[i], p[(i + 1) % p.len()]);
            (0..100).map(f64::from).map(move |k| [a[0] + k / 100.0 * (b[0] - a[0]), a[1] + k / 100.0 * (b[1] - a[1])])
        }).collect::<Vec<_>>();
        let (border, rim) = (dense(&body), dense(&other));
        let truth = border.iter().flat_map(|p| rim.iter().map(move |q| shape::distance(*p, *q))).fold(f64::INFINITY, f64::min);
        let ours = shape::convex_distance(&body, &other);
        let overlap = |p: &[Point], q: &[Point]| q.iter().any(|c| Shape::Polygon { points: p.to_vec() }.distance(*c) < 0.0);
        if ours > 0.0 {
            prop_assert!((ours - truth).abs() < 0.012 && !overlap(&body, &rim) && !overlap(&other, &border));
        } else {
            prop_assert!(truth < 0.012 || overlap(&body, &rim) || overlap(&other, &border));
        }
        prop_assert_eq!(ours, shape::convex_distance(&other, &body));
    }

    #[test]
    fn movers_are_never_nearer_than_their_least_distance(phase in -20.0..20.0_f64, t0 in 0.0..20.0_f64, dt in 0.0..25.0_f64, kind in 0..3_usize, p in prop::array::uniform2(-3.0..3.0_f64)) {
        let track = vec![[0.0, -1.0, 0.0], [1.0, 1.0, 0.5], [4.0, 1.0, 2.0], [7.5, -2.0, 1.0]];
        let mut mover = Mover::new(Footprint::Box([0.4, 0.2]), track).unwrap();
        (mover.phase, mover.repeat) = (phase, [Loop::Once, Loop::Cycle, Loop::Shuttle][kind]);
        let least = mover.least_distance(p, t0, t0 + dt);
        let n = 2000;
        let sampled = (0..=n).map(|i| mover.distance(p, t0 + dt * f64::from(i) / f64::from(n))).fold(f64::INFINITY, f64::min);
        prop_assert!(least <= sampled + 1e-9 && least >= sampled - mover.top_speed() * dt / f64::from(n), "{} {}", least, sampled);
    }
}

#[test]
fn poses_touch_walls() {
    let mut bits = Bits::new(10, 10);
    (0..10).for_each(|x| bits.set(x, 0, true));
    let world = World::from_grid(Grid::new(bits, None, 0.1, [0.0; 3]).unwrap()).with_shapes(vec![Shape::disc([0.5, 0.9], 0.1).unwrap()]);
    let robot = Footprint::Box([0.4, 0.2]);
    assert!(world.pose_free(&robot, [0.5, 0.2, 0.0], 0.0) && !world.pose_free(&robot, [0.5, 0.199, 0.0], 0.0));
    assert!(!world.pose_free(&robot, [0.5, 0.2, 0.1], 0.0) && world.pose_free(&robot, [0.5, 0.3, 0.0], 0.1));
    assert!(world.pose_free(&robot, [0.5, 0.7, 0.0], 0.0) && !world.pose_free(&robot, [0.5, 0.701, 0.0], 0.0));
    // Half a turn needs the circumscribed disc, a small one less.
    assert!(world.sweep_free(&robot, [0.5, 0.4,], [0.0, 7.0], 0.0));
    assert!(!world.sweep_free(&robot, [0.5, 0.3], [0.0, 3.0], 0.0) && world.sweep_free(&robot, [0.5, 0.3], [0.0, 0.2], 0.0));
    // A footprint may hang over the border, its reference point may not.
    assert!(world.pose_free(&robot, [0.0, 0.5, 0.0], 0.0) && !world.pose_free(&robot, [-0.01, 0.5, 0.0], 0.0));
    assert!(!world.pose_free(&robot, [0.5, 0.5, f64::NAN], 0.0) && !world.sweep_free(&robot, [0.5, 0.5], [0.0, f64::NAN], 0.0));
}

#[test]
fn what_is_not_a_number_fits_nowhere() {
    let on_shapes = World::from_shapes([0.0, 0.0, 1.0, 1.0], vec![Shape::disc([0.5, 0.5], 0.1).unwrap()], 0.1).unwrap();
    for world in [scattered(0.1, 1, [0.0; 3]), scattered(0.0, 1, [0.0; 3]), on_shapes] {
        for p in [[f64::NAN, 0.0], [0.0, f64::INFINITY], [f64::NEG_INFINITY, f64::NAN]] {
            assert!(world.clearance(p).is_nan() && !world.fits(p, 0.0) && !world.fits(p, 0.1) && !world.contains(p));
            assert!(!world.segment_free(p, [0.0; 2], 0.0) && !world.segment_free([0.0; 2], p, 0.1) && world.segment_clearance(p, [0.0; 2]).is_nan());
        }
        assert!(world.clearance([1e300, -1e300]) >= 1e200 && !world.segment_free([1e300, 0.0], [0.0; 2], 0.1));
    }
}

#[test]
fn shapes_and_movers_are_checked() {
    let track = |rows: &[[f64; 3]]| Mover::new(Footprint::Disc(0.3), rows.to_vec());
    assert!(track(&[[0.0, 1.0, 1.0]]).is_ok() && track(&[[0.0, 1.0, 1.0], [1.0, 2.0, 1.0]]).is_ok());
    for bad in [&[][..], &[[1.0, 0.0, 0.0]], &[[0.0, f64::NAN, 0.0]], &[[0.0; 3], [0.0, 1.0, 1.0]], &[[0.0; 3], [f64::INFINITY, 1.0, 1.0]]] {
        assert!(track(bad).is_err(), "{bad:?}");
    }
    let mover = track(&[[0.0; 3]]).unwrap();
    for bad in [
        Mover { phase: f64::NAN, ..mover.clone() },
        Mover { appears: Some(Appears::Within(-1.0)), ..mover.clone() },
        Mover { shape: Footprint::Disc(-1.0), ..mover.clone() },
        Mover { track: Vec::new(), ..mover.clone() },
    ] {
        assert!(bad.at(1.0).0.iter().all(|v| v.is_finite()));
        let world = scattered(0.1, 1, [0.0; 3]).with_movers(vec![bad.clone()]);
        assert!(bad.validated().is_err() && world.validated().is_err());
    }
    let clockwise = Shape::Polygon { points: vec![[0.0, 0.0], [0.0, 1.0], [1.0, 0.0]] };
    let world = World::from_shapes([0.0, 0.0, 2.0, 2.0], vec![clockwise], 0.1).unwrap().validated().unwrap();
    assert!(world.clearance([0.2, 0.2]) < 0.0);
    let bow = Shape::Polygon { points: vec![[0.0, 0.0], [1.0, 1.0], [1.0, 0.0], [0.0, 1.0]] };
    assert!(World::from_shapes([0.0, 0.0, 2.0, 2.0], vec![bow], 0.1).unwrap().validated().is_err());
    assert!((mover.gap(&Footprint::Disc(0.2), [1.0, 0.0, 0.0], 5.0) - 0.5).abs() < 1e-12);
    assert!((mover.gap(&Footprint::Box([1.0, 1.0]), [1.0, 0.0, 0.0], 5.0) - 0.2).abs() < 1e-12);
}

#[test]
fn a_segment_through_a_polygon_is_not_free() {
    let square = Shape::polygon(vec![[1.0, 1.0], [2.0, 1.0], [2.0, 2.0], [1.0, 2.0]]).unwrap();
    assert!((square.segment_distance([0.0, 1.5], [3.0, 1.5]) + 0.5).abs() < 1e-12);
    assert!((square.segment_distance([0.5, 1.0], [2.5, 2.0]) + 0.5).abs() < 1e-12);
    assert_eq!(square.segment_distance([0.0, 2.0], [3.0, 2.0]), 0.0);
    assert!((square.segment_distance([0.0, 2.5], [3.0, 2.5]) - 0.5).abs() < 1e-12);
    let world = World::from_shapes([0.0, 0.0, 3.0, 3.0], vec![square], 0.1).unwrap();
    assert!(!world.segment_free([0.0, 1.5], [3.0, 1.5], 0.0) && world.segment_free([0.0, 2.0], [3.0, 2.0], 0.0));
    assert!(world.segment_free([0.0, 2.5], [3.0, 2.5], 0.5) && !world.segment_free([0.0, 2.49], [3.0, 2.49], 0.5));
}

#[test]
fn unseen_cells_are_counted() {
    let mut unknown = Bits::new(4, 5);
    unknown.set(1, 1, true);
    let world = World::from_grid(Grid::new(unknown.clone(), Some(unknown), 1.0, [0.0; 3]).unwrap());
    assert_eq!(world.unknown_share(), 0.05);
    assert_eq!(scattered(0.1, 1, [0.0; 3]).unknown_share(), 0.0);
    assert!(Grid::new(Bits::new(4, 5), Some(Bits::new(5, 4)), 1.0, [0.0; 3]).is_err());
}

#[test]
fn a_point_does_not_slip_past_blocked_cells_on_the_border() {
    let mut bits = Bits::new(5, 3);
    for y in 0..3 {
        bits.set(2, y, true);
    }
    let world = World::from_grid(Grid::new(bits, None, 0.5, [0.0; 3]).unwrap());
    let with_shape = World::from_grid(world.grid().unwrap().clone()).with_shapes(vec![Shape::disc([-3.0, 0.0], 0.1).unwrap()]);
    for world in [&world, &with_shape] {
        for y in [0.0, 1.5] {
            assert!(!world.segment_free([0.2, y], [2.2, y], 0.0) && !world.segment_free([2.2, y], [0.2, y], 0.0));
            assert!(world.segment_free([0.2, y], [1.0, y], 0.0) && world.segment_free([1.5, y], [2.5, y], 0.0));
            assert!(!world.segment_free([1.1, y], [1.2, y], 0.0) && !world.segment_free([1.2, y], [1.2, y], 0.0));
            assert!(!world.fits([1.25, y], 0.0) && world.fits([0.25, y], 0.0));
        }
        assert!(world.segment_free([0.0, 0.0], [0.0, 1.5], 0.0) && world.segment_free([2.5, 0.0], [2.5, 1.5], 0.0));
    }
}

#[test]
fn cells_with_room_are_those_whose_value_says_so() {
    for (seed, side) in [(1, 0.1), (2, 0.05)] {
        let mut bits = Bits::new(130, 70);
        for k in 0..40u32 {
            bits.set(k * 37 % 130, (k * k + seed) % 70, true);
        }
        let world = World::from_grid(Grid::new(bits, None, side, [0.0; 3]).unwrap());
        let field = world.clearance_field();
        // Values themselves are the hard thresholds.
        let mut thresholds: Vec<f64> = field.values().into_iter().step_by(97).collect();
        thresholds.extend([-1.0, 0.0, 1e-9, 0.3, 0.3 - TOUCH, 5.0, 1e6]);
        for t in thresholds {
            let room = field.at_least(t);
            assert!((0..70).all(|y| (0..130).all(|x| room.at(x, y) == (field.at([x, y]) >= t))), "{t}");
        }
    }
}
