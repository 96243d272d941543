//! The parts that all colonies share, by hand and against the plain formulas.

use super::crew::{Crew, March};
use super::pheromone::Pheromone;
use super::roads::{Exit, Roads, Streets};
use super::rule::{Ask, Choices, Open, Rule};
use super::seed::along;
use super::*;
use crate::plan::score::Score;
use crate::world::{Bits, Corners, Grid, Lattice, World};
use std::f64::consts::SQRT_2;
use std::sync::Arc;

fn lattice(rows: &[&str]) -> Arc<Lattice> {
    let (w, h) = (rows[0].len() as u32, rows.len() as u32);
    let mut blocked = Bits::new(w, h);
    for (i, row) in rows.iter().enumerate() {
        for (x, c) in row.bytes().enumerate() {
            blocked.set(x as u32, h - 1 - i as u32, c == b'#');
        }
    }
    World::from_grid(Grid::new(blocked, None, 1.0, [0.0; 3]).unwrap()).lattice(0.0)
}

fn rule(alpha: f64, beta: f64, heuristic: Heuristic) -> Rule {
    Rule { alpha, beta, heuristic, greedy: 0.0, uniform: 0.0 }
}

/// All exits of a node, open.
fn open(roads: &Streets, node: u32) -> Vec<Open> {
    let mut exits: Vec<Exit> = Vec::new();
    roads.exits(node, &mut exits);
    exits.into_iter().enumerate().map(|(place, exit)| Open { exit, place, weight: 0.0 }).collect()
}

#[test]
fn ants_choose_by_the_formula() {
    let lattice = lattice(&[".....", ".....", ".....", ".....", "....."]);
    let roads = Streets::new(&lattice, Corners::Touch);
    let (node, goal) = (roads.node([1, 2]), roads.node([4, 4]));
    for heuristic in [Heuristic::Detour, Heuristic::Goal, Heuristic::Step] {
        let mut tau = Pheromone::new(&roads, |_| 1.0, 0.1, [0.01, 10.0]);
        let mut all = open(&roads, node);
        tau.assign(&roads, node, all[6].exit, 3.0);
        tau.assign(&roads, node, all[0].exit, 0.5);
        let choices = Choices::new(&roads, rule(1.5, 2.0, heuristic), goal);
        let weight = |e: &Exit| {
            let rest = roads.distance(e.to, goal);
            let eta = match heuristic {
                Heuristic::Detour => 1.0 / (e.length + rest),
                Heuristic::Goal => 1.0 / rest.max(0.5),
                Heuristic::Step => 1.0 / e.length,
            };
            tau.at(*e).powf(1.5) * eta.powi(2)
        };
        let expected: Vec<f64> = all.iter().map(|o| weight(&o.exit)).collect();
        let sum: f64 = expected.iter().sum();
        let mut counts = vec![0u32; all.len()];
        let mut rng = crate::context::stream(1, 0, 0);
        for _ in 0..80_000 {
            let count = all.len();
            let exit = choices.choose(&roads, &tau, &mut Ask { node, count, open: &mut all, ahead: 99 }, &mut rng);
            counts[all.iter().position(|o| o.exit == exit).unwrap()] += 1;
        }
        for (count, p) in counts.iter().zip(expected.iter().map(|w| w / sum)) {
            let (seen, sigma) = (f64::from(*count) / 80_000.0, (p * (1.0 - p) / 80_000.0).sqrt());
            assert!((seen - p).abs() < 5.0 * sigma + 1e-6, "{heuristic:?}: {seen} instead of {p}");
        }
    }
}

#[test]
fn weights_too_small_for_their_neighbours_are_weighed_among_themselves() {
    let lattice = lattice(&[".....", ".....", "....."]);
    let roads = Streets::new(&lattice, Corners::Touch);
    let (node, goal) = (roads.node([2, 1]), roads.node([4, 1]));
    let tau = Pheromone::new(&roads, |_| 1.0, 0.1, [0.01, 10.0]);
    let choices = Choices::new(&roads, rule(1.0, 100.0, Heuristic::Goal), goal);
    // Only the two ways straight back and the one back and up are left.
    let mut left: Vec<Open> = open(&roads, node).into_iter().filter(|o| roads.cell(o.exit.to)[0] == 1).collect();
    let mut rng = crate::context::stream(2, 0, 0);
    let mut seen = [0; 3];
    for _ in 0..300 {
        let exit = choices.choose(&roads, &tau, &mut Ask { node, count: 8, open: &mut left, ahead: 99 }, &mut rng);
        seen[roads.cell(exit.to)[1] as usize] += 1;
    }
    assert!(seen[1] > 290, "the nearest to the goal of those that are left: {seen:?}");
}

#[test]
fn among_equals_an_ant_goes_straight_on() {
    let lattice = lattice(&["....", "....", "....", "...."]);
    let roads = Streets::new(&lattice, Corners::Touch);
    let (node, goal) = (roads.node([1, 1]), roads.node([3, 3]));
    let tau = Pheromone::new(&roads, |_| 1.0, 0.1, [0.01, 10.0]);
    let choices = Choices::new(&roads, rule(1.0, 0.0, Heuristic::Goal), goal);
    let mut all = open(&roads, node);
    let mut rng = crate::context::stream(3, 0, 0);
    for ahead in 0..8 {
        let exit = choices.choose(&roads, &tau, &mut Ask { node, count: 8, open: &mut all, ahead }, &mut rng);
        assert_eq!(exit.heading, ahead);
    }
}

const POCKET: [&str; 7] = [".........", ".######..", "......#..", "......#..", "......#..", ".######..", "........."];

#[test]
fn ants_back_out_of_dead_ends_and_visit_no_cell_twice() {
    let lattice = lattice(&POCKET);
    let roads = Streets::new(&lattice, Corners::Touch);
    let (start, goal) = (roads.node([4, 3]), roads.node([8, 3]));
    for cut in [false, true] {
        let mut ctx = Context::new(4);
        let crew = Crew::new(&roads, Aim::Shortest, cut, 6 * 81, &ctx);
        let tau = Pheromone::new(&roads, |_| 1.0, 0.1, [0.01, 10.0]);
        let choices = Choices::new(&roads, rule(1.0, 5.0, Heuristic::Goal), goal);
        let trails = crew.generation(&March { ants: 40, from: start, number: 0 }, &tau, &choices, &mut ctx).unwrap();
        assert_eq!(trails.len(), 40, "every ant arrives");
        for trail in &trails {
            let mut nodes = trail.nodes.clone();
            nodes.sort_unstable();
            nodes.dedup();
            assert_eq!(nodes.len(), trail.nodes.len());
            assert_eq!((trail.nodes[0], trail.nodes[trail.nodes.len() - 1]), (start, goal));
            let again = along(&roads, &roads.cells(&trail.nodes), Aim::Shortest).expect("allowed steps");
            assert_eq!(again, *trail);
            assert_eq!(trail.clone().reversed(&roads).reversed(&roads), *trail);
            assert_eq!(trail.clone().reversed(&roads).score, trail.score);
            if cut {
                // No cell is next to a later one but its successor.
                for (i, a) in trail.nodes.iter().enumerate() {
                    let mut exits = Vec::new();
                    roads.exits(*a, &mut exits);
                    assert!(!trail.nodes.iter().skip(i + 2).any(|b| exits.iter().any(|e| e.to == *b)));
                }
            }
        }
        assert_eq!(ctx.evaluations(), 40);
    }
}

#[test]
fn an_ant_without_steps_does_not_arrive() {
    let lattice = lattice(&POCKET);
    let roads = Streets::new(&lattice, Corners::Touch);
    let mut ctx = Context::new(4);
    let crew = Crew::new(&roads, Aim::Shortest, true, 3, &ctx);
    let tau = Pheromone::new(&roads, |_| 1.0, 0.1, [0.01, 10.0]);
    let choices = Choices::new(&roads, rule(1.0, 5.0, Heuristic::Goal), roads.node([8, 3]));
    let trails = crew.generation(&March { ants: 5, from: roads.node([4, 3]), number: 0 }, &tau, &choices, &mut ctx).unwrap();
    assert!(trails.is_empty());
}

#[test]
fn the_bounds_of_max_min_by_hand() {
    let lattice = lattice(&["..."]);
    let roads = Streets::new(&lattice, Corners::Touch);
    let best = along(&roads, &[[0, 0], [1, 0], [2, 0]], Aim::Shortest).unwrap();
    let [least, most] = mmas::bounds(&roads, &best, 0.5, 0.25);
    // Two cells long; p = 0.25^(1/2) = 0.5; half the mean number of exits is 2/3, which is kept from making the bound negative.
    assert!((most - 1.0).abs() < 1e-12 && (least - most).abs() < 1e-12);
    let lattice = self::lattice(&[".....", ".....", "....."]);
    let roads = Streets::new(&lattice, Corners::Touch);
    let best = along(&roads, &[[0, 1], [1, 1], [2, 1], [3, 1], [4, 1]], Aim::Shortest).unwrap();
    let [least, most] = mmas::bounds(&roads, &best, 0.1, 0.05);
    let (average, p) = ((5.0 + 8.0 + 8.0 + 8.0 + 5.0) / 5.0 / 2.0, 0.05f64.powf(0.25));
    assert!((most - 1.0 / 0.4).abs() < 1e-12 && (least - most * (1.0 - p) / ((average - 1.0) * p)).abs() < 1e-12);
}

#[test]
fn local_search_takes_needless_turns_out() {
    let lattice = lattice(&[".....", ".....", ".....", ".....", "....."]);
    let roads = Streets::new(&lattice, Corners::Touch);
    let world = Arc::new(World::from_grid(Grid::new(Bits::new(5, 5), None, 1.0, [0.0; 3]).unwrap()));
    let query = Query::new(world, [0.5, 0.5], [4.5, 2.5]);
    let leg = Leg { query: &query, lattice: &lattice, start: [0, 0], goal: [4, 2], ends: [query.start, query.goal], before: 0.0 };
    let task = Task { leg: &leg, roads: &roads, aim: Aim::Shortest, start: roads.node([0, 0]), goal: roads.node([4, 2]) };
    let stairs = along(&roads, &[[0, 0], [1, 1], [2, 1], [3, 2], [4, 2]], Aim::Shortest).unwrap();
    let better = polish::polish(&task, stairs.clone());
    assert_eq!(stairs.score, Score { cost: 2.0 + 2.0 * SQRT_2, turns: 3 });
    assert_eq!(better.score, Score { cost: 2.0 + 2.0 * SQRT_2, turns: 1 });
}
