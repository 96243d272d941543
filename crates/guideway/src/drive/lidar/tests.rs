use super::*;
use crate::world::{Bits, Footprint, Grid, Shape};
use proptest::prelude::*;
use std::f64::consts::{PI, TAU};

fn ideal() -> Lidar {
    Lidar { noise: 0.0, ..Lidar::default() }
}

fn scan(lidar: Lidar, world: &World, movers: &[(Outline, Point)], pose: [f64; 3]) -> Scan {
    lidar.scan(world, movers, (pose, 0.0), &mut Lidar::random(1))
}

/// Marches along a ray until it is inside something: right to the length of a step.
fn march(world: &World, movers: &[(Outline, Point)], pose: [f64; 3], angle: f64, range: f64) -> f64 {
    let (s, c) = (pose[2] + angle).sin_cos();
    let steps = (range / 1e-3) as u32;
    let at = |i: u32| 1e-3 * f64::from(i);
    let solid = |t: f64| {
        let p = [pose[0] + t * c, pose[1] + t * s];
        let blocked = world.grid().and_then(|g| Some(g.blocked().at_or_zero(i64::from(g.cell_at(p)?[0]), i64::from(g.cell_at(p)?[1]))));
        let mover = |(o, q): &(Outline, Point)| o.distance([p[0] - q[0], p[1] - q[1]]) <= 0.0;
        blocked == Some(true) || world.shapes().iter().any(|s| s.distance(p) <= 0.0) || movers.iter().any(mover)
    };
    (0..=steps).map(at).find(|t| solid(*t)).unwrap_or(f64::INFINITY)
}

fn cluttered() -> (World, Vec<(Outline, Point)>) {
    let mut bits = Bits::new(40, 30);
    for (x, y) in [(3, 4), (3, 5), (20, 2), (21, 2), (30, 25), (12, 20), (39, 0), (0, 29)] {
        bits.set(x, y, true);
    }
    let grid = Grid::new(bits, None, 0.1, [-2.0, -1.0, 0.3]).unwrap();
    let shapes = vec![
        Shape::disc([1.0, 0.8], 0.3).unwrap(),
        Shape::disc([-0.5, 1.2], 0.075).unwrap(),
        Shape::polygon(vec![[0.2, -0.6], [0.9, -0.5], [0.5, 0.1]]).unwrap(),
    ];
    let movers = vec![
        (Outline::of(&Footprint::Box([0.4, 0.3])), [-1.0, 0.2]),
        (Outline { points: vec![[0.0, 0.0], [0.3, 0.0], [0.1, 0.2]], radius: 0.15 }, [0.2, 1.7]),
        (Outline::of(&Footprint::Disc(0.2)), [1.4, -0.2]),
    ];
    (World::from_grid(grid).with_shapes(shapes), movers)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(60))]
    #[test]
    fn every_ray_ends_at_the_first_solid_point(x in -2.0..1.8_f64, y in -1.0..2.4_f64, yaw in -7.0..7.0_f64, view in 0.3..TAU) {
        let (world, movers) = cluttered();
        let lidar = Lidar { beams: 23, field_of_view: view, range: 3.0, ..ideal() };
        let seen = scan(lidar, &world, &movers, [x, y, yaw]);
        for (i, r) in seen.ranges.iter().enumerate() {
            let angle = seen.first + seen.step * i as f64;
            let slow = march(&world, &movers, [x, y, yaw], angle, 3.0);
            // A ray that only grazes something may be told either way within a step.
            let grazes = (0..2).any(|k| {
                let off = march(&world, &movers, [x, y, yaw], angle + [1e-3, -1e-3][k], 3.0);
                (off - r).abs() < 0.02 || (off.is_infinite() && r.is_infinite())
            });
            prop_assert!((slow - r).abs() < 0.0015 || (slow.is_infinite() && (r.is_infinite() || *r > 2.998)) || grazes, "ray {i}: {r}, marched {slow}");
        }
    }
}

#[test]
fn rays_lie_as_documented() {
    let (first, step) = ideal().rays();
    assert!((step - TAU / 360.0).abs() < 1e-12 && (first + 359.0 * PI / 360.0).abs() < 1e-12);
    let half = Lidar { beams: 721, field_of_view: PI, ..ideal() };
    let (first, step) = half.rays();
    assert!((first + PI / 2.0).abs() < 1e-12 && (first + 720.0 * step - PI / 2.0).abs() < 1e-12);
    assert_eq!(Lidar { beams: 1, ..half }.rays().0, 0.0);
}

#[test]
fn inside_something_every_range_is_zero_and_nothing_is_infinite() {
    let world = World::from_shapes([-5.0, -5.0, 5.0, 5.0], Vec::new(), 0.05).unwrap();
    for shape in [Footprint::Disc(0.5), Footprint::Box([1.0, 1.0])] {
        let on = scan(ideal(), &world, &[(Outline::of(&shape), [0.1, 0.1])], [0.0; 3]);
        assert!(on.ranges.iter().all(|r| *r == 0.0));
    }
    assert!(scan(ideal(), &world, &[], [0.0; 3]).ranges.iter().all(|r| r.is_infinite()));
}

#[test]
fn noise_has_its_size_never_goes_below_zero_and_comes_from_the_seed() {
    let wall = Shape::polygon(vec![[2.0, -50.0], [3.0, -50.0], [3.0, 50.0], [2.0, 50.0]]).unwrap();
    let world = World::from_shapes([-60.0, -60.0, 60.0, 60.0], vec![wall], 0.05).unwrap();
    let lidar = Lidar { beams: 10_001, field_of_view: 1.0, noise: 0.02, ..Lidar::default() };
    let (noisy, exact) = (scan(lidar, &world, &[], [0.0; 3]), scan(Lidar { noise: 0.0, ..lidar }, &world, &[], [0.0; 3]));
    let errors: Vec<f64> = noisy.ranges.iter().zip(&exact.ranges).map(|(a, b)| a - b).collect();
    let mean = errors.iter().sum::<f64>() / 10_001.0;
    let deviation = (errors.iter().map(|e| e * e).sum::<f64>() / 10_001.0).sqrt();
    assert!(mean.abs() < 1e-3 && (deviation / 0.02 - 1.0).abs() < 0.03, "{mean} {deviation}");
    assert_eq!(noisy, scan(lidar, &world, &[], [0.0; 3]));
    assert_ne!(noisy, lidar.scan(&world, &[], ([0.0; 3], 0.0), &mut Lidar::random(2)));
    let near = Lidar { noise: 1.0, ..lidar }.scan(&world, &[], ([1.99, 0.0, 0.0], 0.0), &mut Lidar::random(1));
    assert!(near.ranges.iter().all(|r| *r >= 0.0));
}

#[test]
fn bad_values_are_refused_by_name() {
    let d = Lidar::default();
    let bad = [
        ("beams", Lidar { beams: 0, ..d }),
        ("field_of_view", Lidar { field_of_view: 6.4, ..d }),
        ("range", Lidar { range: f64::NAN, ..d }),
        ("noise", Lidar { noise: -0.1, ..d }),
        ("rate", Lidar { rate: 0.0, ..d }),
    ];
    for (key, lidar) in bad {
        assert!(matches!(lidar.validated(), Err(PlanError::BadParameter { name, .. }) if name == format!("lidar.{key}")));
    }
    assert!(Lidar { field_of_view: 6.284, ..d }.validated().is_ok());
}
