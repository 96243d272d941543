//! Point and segment queries against brute force over all cells.

use crate::brute::{Draw, PLACES, point_free, segment_to_square, signed, squares, world};
use guideway::world::shape;
use proptest::prelude::*;

#[test]
fn clearance_is_exact() {
    let mut draw = Draw::new(1);
    for case in 0..60 {
        let (w, h) = (1 + draw.below(80), 1 + draw.below(40));
        let share = [0.0, 0.02, 0.3, 0.9, 1.0][case % 5];
        let bits = draw.bits(w, h, share);
        let (resolution, origin) = PLACES[case % 3];
        let world = world(&bits, resolution, origin);
        let grid = world.grid().expect("a grid");
        for i in 0..1700 {
            if i == 850 {
                // From here on queries find the field.
                assert_eq!(world.clearance_field().width(), w);
            }
            let mut q = [draw.unit() * f64::from(w), draw.unit() * f64::from(h)];
            match i % 5 {
                1 => q[0] = q[0].round(),
                2 => q = [q[0].round(), q[1].round()],
                3 => q = [q[0] * 2.0 - f64::from(w) / 2.0, q[1] * 2.0],
                _ => {}
            }
            let (ours, truth) = (world.clearance(grid.to_map(q)) / resolution, signed(&bits, q));
            assert!(ours == truth || (ours - truth).abs() < 1e-9, "case {case}: {q:?} {ours} {truth}");
            let near = world.clearance_within(grid.to_map(q), 2.0 * resolution) / resolution;
            assert!(if truth < 1.999 { (near - truth).abs() < 1e-9 } else { near >= 1.998 }, "case {case}: {q:?} {near} {truth}");
        }
    }
}

#[test]
fn capsules_are_exact() {
    let mut draw = Draw::new(2);
    let (mut free, mut hit) = (0, 0);
    for case in 0..400 {
        let (w, h) = (1 + draw.below(70), 1 + draw.below(30));
        let share = 0.02 + 0.1 * draw.unit();
        let bits = draw.bits(w, h, share);
        let all = squares(&bits, true);
        let (resolution, origin) = PLACES[case % 3];
        let world = world(&bits, resolution, origin);
        let grid = world.grid().expect("a grid");
        for i in 0..100 {
            let snap = [1e9, 1.0, 2.0, 8.0][i % 4];
            let a = [draw.unit() * f64::from(w), draw.unit() * f64::from(h)].map(|v| if snap < 1e8 { (v * snap).round() / snap } else { v });
            let reach = 10.0 * draw.unit();
            let b = [a[0] + reach * (draw.unit() - 0.5), a[1] + reach * (draw.unit() - 0.5)];
            let mut b =
                [b[0].clamp(0.0, f64::from(w)), b[1].clamp(0.0, f64::from(h))].map(|v| if snap < 1e8 { (v * snap).round() / snap } else { v });
            if i % 7 == 0 {
                b[i % 2] = a[i % 2];
            }
            let truth = all.iter().map(|&s| segment_to_square(a, b, s)).fold(f64::INFINITY, f64::min);
            // Radii beside the exact distance, on either side, and at it (touching).
            for (radius, expected) in [(truth, true), (truth + 1e-6, false), (truth - 1e-6, true)] {
                let radius = if radius.is_finite() { radius } else { 3.0 };
                if radius * resolution < 1e-7 {
                    continue;
                }
                let ours = world.segment_free(grid.to_map(a), grid.to_map(b), radius * resolution);
                assert_eq!(ours, expected || all.is_empty(), "case {case}: {a:?} {b:?} radius {radius}");
                if ours { free += 1 } else { hit += 1 }
            }
        }
    }
    assert!(free > 20_000 && hit > 10_000, "{free} {hit}");
}

#[test]
fn point_segments_are_exact() {
    let mut draw = Draw::new(3);
    let (mut free, mut hit) = (0, 0);
    for case in 0..600 {
        let (w, h) = (1 + draw.below(8), 1 + draw.below(8));
        let share = 0.1 + 0.4 * draw.unit();
        let bits = draw.bits(w, h, share);
        let (resolution, origin) = PLACES[case % 3];
        let world = world(&bits, resolution, origin);
        let grid = world.grid().expect("a grid");
        for i in 0..60 {
            let snap = [1.0, 2.0, 3.0, 7.0][i % 4];
            let mut pick = || [f64::from(draw.below(w * snap as u32 + 1)) / snap, f64::from(draw.below(h * snap as u32 + 1)) / snap];
            let (a, b) = (pick(), pick());
            let ours = world.segment_free(grid.to_map(a), grid.to_map(b), 0.0);
            assert_eq!(ours, point_free(&bits, a, b), "case {case}: {a:?} {b:?}");
            if ours { free += 1 } else { hit += 1 }
        }
    }
    assert!(free > 5_000 && hit > 5_000, "{free} {hit}");
}

proptest! {
    #[test]
    fn segments_are_as_wide_as_their_narrowest_point(seed in 0u64..1_000_000, radius in 0.05f64..2.0, yaw in -3.0f64..3.0) {
        let mut draw = Draw::new(seed);
        let bits = draw.bits(40, 30, 0.03);
        let world = world(&bits, 0.5, [3.0, 4.0, yaw]);
        let grid = world.grid().expect("a grid");
        let a = grid.to_map([40.0 * draw.unit(), 30.0 * draw.unit()]);
        let b = grid.to_map([40.0 * draw.unit(), 30.0 * draw.unit()]);
        let n = 400;
        let least = (0..=n).map(|i| f64::from(i) / f64::from(n)).map(|t| world.clearance([a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])]));
        let least = least.fold(f64::INFINITY, f64::min);
        let step = shape::distance(a, b) / f64::from(n);
        if world.segment_free(a, b, radius) {
            prop_assert!(least >= radius - 2e-9);
        } else {
            prop_assert!(least <= radius + step);
        }
        prop_assert_eq!(world.segment_free(a, b, radius), world.segment_free(b, a, radius));
    }
}
