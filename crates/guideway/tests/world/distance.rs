//! Distance transforms against brute force.

use crate::brute::Draw;
use guideway::world::{Bits, Grid, Shape, World, distance_transform, distances};

/// Degenerate, sparse and dense sets of every shape.
fn cases() -> Vec<Bits> {
    let mut draw = Draw::new(5);
    let sizes = [(1, 1), (1, 90), (90, 1), (64, 3), (65, 7), (128, 40), (300, 20), (20, 300), (191, 60), (5, 5)];
    let mut all = Vec::new();
    for (w, h) in sizes {
        for share in [0.0, 0.0005, 0.003, 0.02, 0.2, 0.7, 1.0] {
            let mut bits = Bits::new(w, h);
            for (x, y) in (0..h).flat_map(|y| (0..w).map(move |x| (x, y))) {
                bits.set(x, y, draw.unit() < share);
            }
            if bits.is_empty() && share > 0.0 {
                bits.set(draw.below(w), draw.below(h), true);
            }
            all.push(bits);
        }
        // Everything in one corner, and a dense left half beside an open right half.
        for (x, y) in [(0, 0), (w - 1, 0), (0, h - 1), (w - 1, h - 1)] {
            let mut bits = Bits::new(w, h);
            bits.set(x, y, true);
            all.push(bits);
        }
        let mut half = Bits::new(w, h);
        for (x, y) in (0..h).flat_map(|y| (0..w.div_ceil(2)).map(move |x| (x, y))) {
            half.set(x, y, draw.unit() < 0.3);
        }
        all.push(half);
    }
    all
}

fn set_cells(bits: &Bits) -> Vec<[i64; 2]> {
    let all = (0..bits.height()).flat_map(|y| (0..bits.width()).map(move |x| (x, y)));
    all.filter(|&(x, y)| bits.at(x, y)).map(|(x, y)| [i64::from(x), i64::from(y)]).collect()
}

#[test]
fn transform_is_exact() {
    for bits in cases() {
        let set = set_cells(&bits);
        let (field, plain) = (distance_transform(&bits).expect("a valid size"), distances(&bits).expect("a valid size"));
        for (x, y) in (0..bits.height()).flat_map(|y| (0..bits.width()).map(move |x| (x, y))) {
            let square = |c: [i64; 2]| (c[0] - i64::from(x)).pow(2) + (c[1] - i64::from(y)).pow(2);
            let truth = set.iter().map(|&c| square(c)).min();
            let label = format!("{} x {} with {} set, cell {x}, {y}", bits.width(), bits.height(), set.len());
            assert_eq!(field.squared([x, y]).map(i64::from), truth, "{label}");
            assert_eq!(plain[(y * bits.width() + x) as usize], truth.map_or(f64::INFINITY, |d| (d as f64).sqrt()), "{label}");
            assert_eq!(field.distance([x, y]), plain[(y * bits.width() + x) as usize], "{label}");
            let nearest = field.nearest([x, y]);
            assert_eq!(nearest.map(|c| square(c.map(i64::from))), truth, "{label}");
            assert!(nearest.is_none_or(|[i, j]| bits.at(i, j)), "{label}");
        }
    }
}

#[test]
fn clearance_field_is_the_clearance_of_cell_centres() {
    for (i, bits) in cases().into_iter().enumerate() {
        let grid = Grid::new(bits, None, 0.05, [3.0, -1.0, if i % 2 == 0 { 0.0 } else { 0.4 }]).expect("a valid grid");
        let world = World::from_grid(grid);
        let field = world.clearance_field();
        let grid = world.grid().expect("a grid");
        for (x, y) in (0..grid.height()).flat_map(|y| (0..grid.width()).map(move |x| (x, y))) {
            let (ours, truth) = (field.at([x, y]), world.clearance(grid.center([x, y])));
            if grid.blocked().at(x, y) {
                assert!(ours == -0.025 && truth <= ours + 1e-12);
            } else {
                assert!(ours == truth || (ours - truth).abs() < 1e-12, "case {i}: {x}, {y}: {ours} {truth}");
            }
        }
    }
}

#[test]
fn clearance_field_of_shapes() {
    let mut draw = Draw::new(6);
    let shapes = (0..60).map(|i| {
        let c = [20.0 * draw.unit(), 10.0 * draw.unit()];
        if i % 2 == 0 { Shape::disc(c, 0.5 * draw.unit()) } else { Shape::polygon(vec![c, [c[0] + 1.0, c[1] + 0.2], [c[0] + 0.3, c[1] + 0.7]]) }
    });
    let shapes = shapes.collect::<Result<Vec<_>, _>>().expect("valid shapes");
    let world = World::from_shapes([0.0, 0.0, 20.0, 10.0], shapes, 0.07).expect("a valid world");
    let field = world.clearance_field();
    assert_eq!([field.width(), field.height()], [286, 143]);
    for (x, y) in (0..143).flat_map(|y| (0..286).map(move |x| (x, y))) {
        assert_eq!(field.at([x, y]), world.clearance(world.cell_to_map([f64::from(x) + 0.5, f64::from(y) + 0.5])));
    }
}

#[test]
fn absurd_sides_are_refused() {
    let long = Bits::new(65_001, 1);
    assert!(distance_transform(&long).is_err() && distances(&long).is_err());
    assert!(Grid::new(long, None, 1.0, [0.0; 3]).is_err());
}

#[test]
fn far_corners_of_the_largest_maps() {
    for (w, h) in [(30_000, 2), (65_000, 2), (2, 65_000), (9_000, 700)] {
        let mut bits = Bits::new(w, h);
        bits.set(0, 0, true);
        let field = distance_transform(&bits).expect("a valid size");
        assert_eq!(field.squared([w - 1, h - 1]), Some((w - 1).pow(2) + (h - 1).pow(2)));
        let world = World::from_grid(Grid::new(bits, None, 1.0, [0.0; 3]).expect("a valid grid"));
        let exact = (f64::from(w) - 1.5).hypot(f64::from(h) - 1.5);
        assert!((world.clearance_field().at([w - 1, h - 1]) - exact).abs() < 1e-9);
    }
}

#[test]
fn flags_pack_to_bits() {
    let mut draw = Draw::new(7);
    for (w, h) in [(1, 1), (63, 3), (64, 3), (65, 2), (200, 5)] {
        let flags: Vec<bool> = (0..w * h).map(|_| draw.unit() < 0.4).collect();
        let bits = Bits::from_flags(w, h, &flags);
        assert!(flags.iter().enumerate().all(|(i, &on)| bits.at(i as u32 % w, i as u32 / w) == on));
        assert_eq!(bits.count(), flags.iter().filter(|&&on| on).count() as u64);
    }
}
