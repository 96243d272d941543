use super::*;
use crate::world::{Bits, Grid, Loop, Mover};
use proptest::prelude::*;

fn shapes() -> World {
    let polygon = Shape::polygon(vec![[1.0, -2.0], [1.4, -2.0], [1.2, 1.0]]).unwrap();
    World::from_shapes([-5.0, -5.0, 5.0, 5.0], vec![polygon, Shape::disc([-1.0, 1.0], 0.3).unwrap()], 0.1).unwrap()
}

fn grid() -> World {
    let mut blocked = Bits::new(20, 20);
    for (x, y) in [(5, 5), (6, 5), (12, 9), (3, 15)] {
        blocked.set(x, y, true);
    }
    World::from_grid(Grid::new(blocked, None, 0.5, [-5.0, -5.0, 0.3]).unwrap())
}

/// Smallest distance by dense sampling, to static obstacles and to the mover.
fn brute(world: &World, outline: &Outline, leg: &Leg, mover: &Mover) -> [f64; 2] {
    let other = Outline::of(&mover.shape);
    let cells: Vec<Outline> = world.grid().map_or(Vec::new(), |g| {
        let all = (0..g.width()).flat_map(|x| (0..g.height()).map(move |y| (x, y)));
        all.filter(|(x, y)| g.blocked().at(*x, *y))
            .map(|(x, y)| {
                let (x, y) = (f64::from(x), f64::from(y));
                let corner = |dx: f64, dy: f64| g.to_map([x + dx, y + dy]);
                Outline { points: vec![corner(0.0, 0.0), corner(1.0, 0.0), corner(1.0, 1.0), corner(0.0, 1.0)], radius: 0.0 }
            })
            .collect()
    });
    let fixed: Vec<Outline> = cells.into_iter().chain(world.shapes().iter().map(of_shape)).collect();
    (0..=2000).fold([f64::INFINITY; 2], |best, i| {
        let t = leg.t + leg.duration * f64::from(i) / 2000.0;
        let here = outline.at(leg.at(t));
        let p = mover.at(t).0;
        let still = fixed.iter().map(|o| here.gap(o)).fold(f64::INFINITY, f64::min);
        [best[0].min(still), best[1].min(here.gap(&other.at([p[0], p[1], 0.0])))]
    })
}

proptest! {
    #[test]
    fn the_judge_finds_what_dense_sampling_finds(
        x in -4.0..4.0_f64, y in -4.0..4.0_f64, yaw in -3.0..3.0_f64, v in 0.0..3.0_f64, w in -3.0..3.0_f64,
        mx in -4.0..4.0_f64, my in -4.0..4.0_f64, fast in 0.0..4.0_f64, kind in 0..3_usize, cells in any::<bool>(),
    ) {
        let footprint = [Footprint::Disc(0.3), Footprint::Box([0.9, 0.4]), Footprint::Polygon(vec![[-0.3, -0.2], [0.5, 0.0], [-0.3, 0.2]])][kind].clone();
        let world = if cells { grid() } else { shapes() };
        let track = vec![[0.0, mx, my], [1.0, mx + fast, my - 0.5 * fast]];
        let mover = Mover { shape: Footprint::Box([0.6, 0.3]), track, repeat: Loop::Shuttle, phase: 0.0, appears: None };
        let leg = Leg { t: 0.0, duration: 1.0, pose: [x, y, yaw], v, w };
        let expected = brute(&world, &Outline::of(&footprint), &leg, &mover);
        let mut judge = Judge::new(&world, &footprint);
        let hit = judge.watch(&leg, &Stage::new(std::slice::from_ref(&mover)));
        let touches = expected.iter().any(|d| *d < 0.0);
        let border = matches!(hit, Some((With::Border, _)));
        prop_assert!(border || hit.is_some() == touches || expected.iter().any(|d| d.abs() < 2e-3), "{:?} {:?}", hit, expected);
        if hit.is_none() {
            prop_assert!((judge.still - expected[0]).abs() < 3e-3 && (judge.moving - expected[1]).abs() < 3e-3, "{} {} {:?}", judge.still, judge.moving, expected);
        }
    }
}

#[test]
fn nothing_tunnels_through_a_thin_wall_in_one_step() {
    let wall = Shape::polygon(vec![[0.0, -1.0], [1e-4, -1.0], [1e-4, 1.0], [0.0, 1.0]]).unwrap();
    let world = World::from_shapes([-5.0, -5.0, 5.0, 5.0], vec![wall], 0.1).unwrap();
    let mut judge = Judge::new(&world, &Footprint::Disc(0.0));
    let hit = judge.watch(&Leg { t: 2.0, duration: 0.5, pose: [-1.0, 0.0, 0.0], v: 10.0, w: 0.0 }, &Stage::new(&[]));
    let (with, t) = hit.unwrap();
    assert!(with == With::Static && (t - 2.1).abs() < 1e-4, "{t}");
}

#[test]
fn a_leg_ends_where_the_plant_ended() {
    let to = arc([1.0, 2.0, 0.5], 1.3, -0.7, 0.02);
    let leg = Leg::between(0.0, 0.02, [1.0, 2.0, 0.5], to);
    let end = leg.at(0.02);
    assert!((leg.v - 1.3).abs() < 1e-9 && (leg.w + 0.7).abs() < 1e-9 && (0..3).all(|k| (end[k] - to[k]).abs() < 1e-12));
}
