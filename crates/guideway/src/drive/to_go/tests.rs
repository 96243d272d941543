use super::march::upwind;
use super::*;
use crate::world::shape::distance;
use crate::world::{Bits, Grid};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use std::collections::BinaryHeap;

fn world(blocked: &Bits, resolution: f64, origin: [f64; 3]) -> World {
    World::from_grid(Grid::new(blocked.clone(), None, resolution, origin).unwrap())
}

fn random(seed: u64, [w, h]: [u32; 2], share: f64) -> Bits {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut blocked = Bits::new(w, h);
    for (y, x) in (0..h).flat_map(|y| (0..w).map(move |x| (y, x))) {
        blocked.set(x, y, rng.random_bool(share));
    }
    blocked
}

/// The fixed point of the scheme by looking at all cells until nothing falls.
fn brute(field: &CostToGo, seeds: &[(usize, f32)]) -> Vec<f32> {
    let (n, stride) = (field.slow.len(), field.frame.stride());
    let mut cost = vec![f32::INFINITY; n];
    for s in seeds {
        cost[s.0] = s.1;
    }
    loop {
        let before = cost.clone();
        for i in (0..n).filter(|&i| field.slow[i].is_finite()) {
            let next = upwind(cost[i - 1].min(cost[i + 1]), cost[i - stride].min(cost[i + stride]), field.slow[i]);
            cost[i] = cost[i].min(next);
        }
        if cost == before {
            return cost;
        }
    }
}

/// Costs by Dijkstra over the cells around each cell, in cells: an upper bound of what fast marching means.
fn octile(field: &CostToGo, goal: usize) -> Vec<f64> {
    let stride = field.frame.stride() as i64;
    let mut cost = vec![f64::INFINITY; field.slow.len()];
    let mut queue = BinaryHeap::from([(std::cmp::Reverse(0_u64), goal)]);
    cost[goal] = 0.0;
    while let Some((std::cmp::Reverse(key), i)) = queue.pop() {
        if key as f64 > 1e6 * cost[i] + 1.0 {
            continue;
        }
        for (dx, dy) in (-1..=1).flat_map(|dy| (-1..=1).map(move |dx| (dx, dy))) {
            let (Some(next), true) = (field.step(i, [dx, dy]), (dx, dy) != (0, 0)) else { continue };
            assert_eq!(next as i64, i as i64 + dy * stride + dx);
            let length = (dx as f64).hypot(dy as f64);
            let total = cost[i] + length * 0.5 * f64::from(field.slow[i] + field.slow[next]);
            if total < cost[next] - 1e-9 {
                cost[next] = total;
                queue.push((std::cmp::Reverse((1e6 * total) as u64), next));
            }
        }
    }
    cost
}

#[test]
fn the_queue_finds_the_fixed_point_of_the_scheme() {
    for seed in 0..30 {
        let world = world(&random(seed, [41, 33], 0.15), 0.5, [0.0; 3]);
        let soft = if seed % 2 == 0 { Soft { clearance: 1.0, weight: 3.0 } } else { Soft::NONE };
        let field = CostToGo::new(&world, [10.2, 8.1], [0.0, 0.2], soft);
        let seeds = seeds(field.frame, &field.slow, field.goal, field.frame.at(field.goal).unwrap());
        for (a, b) in field.cost.iter().zip(brute(&field, &seeds)) {
            assert!(a.is_infinite() && b.is_infinite() || (a - b).abs() <= 1e-4 * b.max(1.0), "{seed}: {a} {b}");
        }
    }
}

#[test]
fn open_ground_costs_its_distance() {
    for yaw in [0.0, 0.7] {
        let world = world(&Bits::new(200, 160), 0.05, [-2.0, 1.0, yaw]);
        let goal = world.cell_to_map([40.3, 70.6]);
        let field = CostToGo::new(&world, goal, [0.1, 0.2], Soft::default());
        for cell in [[0.5, 0.5], [180.2, 20.0], [100.0, 150.0], [45.0, 71.0], [199.0, 70.6]] {
            let p = world.cell_to_map(cell);
            let (cost, true_one) = (field.at(p), distance(p, goal));
            assert!((cost - true_one).abs() < 0.02 * true_one + 0.02, "{cell:?}: {cost} {true_one}");
            assert_eq!(field.way(p).unwrap().len(), 2);
        }
    }
}

#[test]
fn ways_lead_over_free_cells_and_cost_what_the_field_says() {
    let mut reached = 0;
    for seed in 0..40 {
        let mut blocked = random(seed, [60, 50], 0.25);
        for [x, y] in [[3, 3], [55, 45]] {
            blocked.set(x, y, false);
        }
        let world = world(&blocked, 1.0, [0.0; 3]);
        let soft = if seed % 2 == 0 { Soft { clearance: 2.0, weight: 2.0 } } else { Soft::NONE };
        let field = CostToGo::new(&world, [55.5, 45.5], [0.0, 0.3], soft);
        let lattice = octile(&field, field.frame.at([55.5, 45.5]).unwrap());
        let start = field.frame.at([3.5, 3.5]).unwrap();
        assert_eq!(lattice[start].is_finite(), field.cost[start].is_finite(), "{seed}");
        let Some(way) = field.way([3.5, 3.5]) else { continue };
        reached += 1;
        let cost: f64 = way.windows(2).map(|w| field.along(w[0], w[1])).sum();
        let legs: Vec<_> = way.windows(2).map(|w| (w[0], w[1], field.along(w[0], w[1]))).filter(|l| !l.2.is_finite()).collect();
        assert!(legs.is_empty(), "{seed}: {legs:?}");
        assert!(way[0] == [3.5, 3.5] && way[way.len() - 1] == [55.5, 45.5]);
        assert!(cost <= 1.02 * lattice[start] + 1.0 && cost <= 1.1 * field.at([3.5, 3.5]) + 1.0, "{seed}: {cost} {}", lattice[start]);
        assert!(way.windows(2).all(|w| world.segment_free(w[0], w[1], 0.0)), "{seed}");
    }
    assert!(reached > 20, "{reached}");
}

#[test]
fn soft_clearance_keeps_to_the_middle_and_tight_gaps_are_taken_only_where_they_pay() {
    let mut blocked = Bits::new(80, 60);
    // A wall with a gap of 0.5 m on the straight line and one of 1.5 m up.
    for y in (0..60).filter(|y| !(18..23).contains(y) && !(40..55).contains(y)) {
        blocked.set(40, y, true);
    }
    let world = world(&blocked, 0.1, [0.0; 3]);
    let cross = |body, soft| {
        let way = CostToGo::new(&world, [7.0, 2.05], body, soft).way([1.0, 2.05]).unwrap();
        let k = way.windows(2).position(|w| w[0][0] < 4.05 && w[1][0] >= 4.05).unwrap();
        let (a, b) = (way[k], way[k + 1]);
        a[1] + (4.05 - a[0]) / (b[0] - a[0]) * (b[1] - a[1])
    };
    assert!((cross([0.15, 0.2], Soft::NONE) - 2.05).abs() < 0.1);
    assert!((cross([0.15, 0.4], Soft { clearance: 0.1, weight: 1.0 }) - 2.05).abs() < 0.1, "dear, but short");
    assert!((cross([0.3, 0.4], Soft::NONE) - 4.6).abs() < 0.4, "does not fit");
    let middle = cross([0.3, 0.4], Soft { clearance: 0.4, weight: 8.0 });
    assert!((middle - 4.75).abs() < 0.12, "{middle}");
}

#[test]
fn places_without_a_way_cost_infinity() {
    let mut blocked = Bits::new(30, 30);
    (0..30).for_each(|y| blocked.set(15, y, true));
    let world = world(&blocked, 0.1, [0.0; 3]);
    let field = CostToGo::new(&world, [2.5, 1.5], [0.05, 0.1], Soft::default());
    assert!(field.at([0.5, 0.5]).is_infinite() && field.way([0.5, 0.5]).is_none());
    assert!([[-5.0, 0.0], [f64::NAN, 0.0], [1e300, 1.0]].iter().all(|&p| field.at(p).is_infinite() && field.way(p).is_none()));
    let nowhere = CostToGo::new(&world, [9.0, 9.0], [0.05, 0.1], Soft::default());
    assert!(nowhere.at([2.5, 1.5]).is_infinite());
    let inside = CostToGo::new(&world, [1.55, 1.55], [0.05, 0.1], Soft::default());
    assert!(inside.at([1.55, 1.55]) < 0.1);
    assert!(Soft { clearance: -1.0, weight: 1.0 }.validated().is_err() && Soft { clearance: 1.0, weight: f64::NAN }.validated().is_err());
}
