//! The lattice of a robot with a size against brute-force geometry: every step it allows is safe, and on grids every safe step is allowed.

use guideway::Point;
use guideway::world::{Bits, Corners, Grid, Lattice, Shape, World};
use rand::{Rng, RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

fn squares(blocked: &Bits) -> Vec<Shape> {
    let mut out = Vec::new();
    for y in 0..blocked.height() {
        for x in (0..blocked.width()).filter(|x| blocked.at(*x, y)) {
            let (u, v) = (f64::from(x), f64::from(y));
            out.push(Shape::polygon(vec![[u, v], [u + 1.0, v], [u + 1.0, v + 1.0], [u, v + 1.0]]).unwrap());
        }
    }
    out
}

/// Distance from the segment to the nearest obstacle.
fn gap(obstacles: &[Shape], a: Point, b: Point) -> f64 {
    obstacles.iter().map(|s| s.segment_distance(a, b)).fold(f64::INFINITY, f64::min)
}

fn random(rng: &mut impl Rng) -> (Bits, f64) {
    let (w, h) = (rng.random_range(1..12), rng.random_range(1..12));
    let density = rng.random_range(0.0..0.3);
    let mut bits = Bits::new(w, h);
    for y in 0..h {
        for x in 0..w {
            bits.set(x, y, rng.random_bool(density));
        }
    }
    // Round radii hit ties between rules.
    let radius = if rng.random_bool(0.5) { f64::from(rng.random_range(1..8)) * 0.5 } else { rng.random_range(0.01..3.0) };
    (bits, if rng.random_bool(0.2) { radius * std::f64::consts::SQRT_2 } else { radius })
}

/// All pairs of a cell and a direction that stays on the map.
fn steps(lattice: &Lattice, mut judge: impl FnMut([u32; 2], i64, i64, Point, Point)) {
    let (w, h) = (i64::from(lattice.width()), i64::from(lattice.height()));
    for (y, x) in (0..h).flat_map(|y| (0..w).map(move |x| (y, x))) {
        for (dx, dy) in [(1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0), (-1, -1), (0, -1), (1, -1)] {
            if (0..w).contains(&(x + dx)) && (0..h).contains(&(y + dy)) {
                let from = [x as u32, y as u32];
                judge(from, dx, dy, lattice.center(from), lattice.center([(x + dx) as u32, (y + dy) as u32]));
            }
        }
    }
}

#[test]
fn on_grids_the_steps_allowed_are_exactly_the_safe_ones() {
    let mut rng = ChaCha8Rng::seed_from_u64(21);
    let (mut safe, mut tight) = (0, 0);
    for _ in 0..400 {
        let (bits, radius) = random(&mut rng);
        let obstacles = squares(&bits);
        let world = World::from_grid(Grid::new(bits, None, 1.0, [0.0; 3]).unwrap());
        let lattice = world.lattice(radius);
        steps(&lattice, |from, dx, dy, a, b| {
            let allowed = lattice.free().at(from[0], from[1]) && lattice.step_free(from, dx, dy, Corners::Squeeze);
            let room = gap(&obstacles, a, b);
            assert!(!allowed || room >= radius - 1e-8, "{from:?} {dx} {dy}: {room} < {radius}");
            assert!(allowed || room <= radius + 1e-8, "{from:?} {dx} {dy} is refused at {room}, radius {radius}");
            safe += usize::from(allowed);
            tight += usize::from(!allowed);
            // The rule clear needs no corner bits.
            let (x, y) = (i64::from(from[0]), i64::from(from[1]));
            let beside = lattice.is_free(x + dx, y) && lattice.is_free(x, y + dy) && lattice.is_free(x + dx, y + dy);
            if dx != 0 && dy != 0 && beside && lattice.free().at(from[0], from[1]) {
                assert!(allowed);
            }
        });
    }
    assert!(safe > 1000 && tight > 1000);
}

#[test]
fn among_shapes_every_step_allowed_is_safe() {
    let mut rng = ChaCha8Rng::seed_from_u64(22);
    let mut safe = 0;
    for round in 0..150 {
        let mut point = || [rng.random_range(0.0..8.0), rng.random_range(0.0..6.0)];
        let mut shapes = vec![Shape::disc(point(), 0.7).unwrap()];
        shapes.extend(Shape::polygon(vec![point(), point(), point()]));
        let radius = f64::from(round % 5) * 0.2;
        let world = World::from_shapes([0.0, 0.0, 8.0, 6.0], shapes.clone(), 0.35).unwrap();
        let lattice = world.lattice(radius);
        steps(&lattice, |from, dx, dy, a, b| {
            if lattice.free().at(from[0], from[1]) && lattice.step_free(from, dx, dy, Corners::Squeeze) {
                assert!(gap(&shapes, a, b) >= radius - 1e-8);
                assert!(world.contains(a) && world.contains(b));
                safe += 1;
            }
        });
    }
    assert!(safe > 10_000);
}

#[test]
fn shapes_on_a_grid_close_cells_too() {
    let world = World::from_grid(Grid::new(Bits::new(10, 10), None, 1.0, [0.0; 3]).unwrap()).with_shapes(vec![Shape::disc([5.0, 5.0], 1.0).unwrap()]);
    let lattice = world.lattice(0.5);
    assert!(!lattice.free().at(4, 4) && lattice.free().at(1, 1));
    assert!(!lattice.plain(Corners::Clear));
}
