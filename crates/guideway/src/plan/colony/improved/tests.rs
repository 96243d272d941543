use super::super::roads::Streets;
use super::super::rule::Heuristic;
use super::cone::Cone;
use super::deadlock::sweep;
use super::labour::{Role, Signs, change, convert, roles, statistics};
use super::*;
use crate::world::{Bits, Corners, Grid, World};
use proptest::prelude::*;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use std::collections::BTreeSet;
use std::sync::Arc;

fn world(rows: &[&str]) -> Arc<World> {
    let (w, h) = (rows[0].len() as u32, rows.len() as u32);
    let mut blocked = Bits::new(w, h);
    for (i, row) in rows.iter().enumerate() {
        for (x, c) in row.bytes().enumerate() {
            blocked.set(x as u32, h - 1 - i as u32, c == b'#');
        }
    }
    Arc::new(World::from_grid(Grid::new(blocked, None, 1.0, [0.0; 3]).unwrap()))
}

#[test]
fn the_printed_cone_is_weakest_along_the_line_and_the_corrected_one_strongest() {
    let world = world(&["....................."; 21]);
    let lattice = world.lattice(0.0);
    let roads = Streets::new(&lattice, Corners::Touch);
    let [literal, corrected] = [Reading::Literal, Reading::Corrected].map(|r| Cone::new(&roads, r, [roads.node([0, 0]), roads.node([20, 20])], 21.0));
    let at = |cone: &Cone, cell| cone.strength(roads.position(roads.node(cell)));
    // On the diagonal only the distance to the goal is left of the printed form; in the far corner 0.09 * 20 / 21 comes on top.
    assert!((at(&literal, [17, 16]) - (0.09 / 21.0 + 1.0 / 5.0)).abs() < 1e-12);
    assert!((at(&literal, [10, 10]) - 1.0 / 200f64.sqrt()).abs() < 1e-12);
    assert!((at(&literal, [20, 0]) - (1.8 / 21.0 + 1.0 / 20.0)).abs() < 1e-12);
    // h = 10 sqrt(2) in the corner: 1 - 20 / 21 is left.
    assert!((at(&corrected, [10, 10]) - (0.09 + 1.0 / 200f64.sqrt())).abs() < 1e-12);
    assert!((at(&corrected, [20, 0]) - (0.09 / 21.0 + 1.0 / 20.0)).abs() < 1e-12);
    // Infinite at the goal as printed.
    assert!((at(&literal, [20, 20]) - 1.0).abs() < 1e-12 && (at(&corrected, [20, 20]) - 1.09).abs() < 1e-12);
    // At equal distance from the goal: line against edge.
    assert!(at(&literal, [6, 20]) > at(&literal, [10, 10]) && at(&corrected, [6, 20]) < at(&corrected, [10, 10]));
}

#[test]
fn the_exponents_end_where_the_source_says() {
    let method = ImprovedAco::paper();
    let near = |rule: Rule, alpha: f64, beta: f64| (rule.alpha - alpha).abs() < 1e-12 && (rule.beta - beta).abs() < 1e-12;
    assert!(near(method.rule(0.0), 1.2, 2.5) && near(method.rule(1.0), 3.8, 5.2));
    // alpha_0 + 5.2 (n/N)^2 / 2 and beta_0 + 5.4 (n/N)^2 / 2
    assert!(near(method.rule(0.4), 1.2 + 5.2 * 0.08, 2.5 + 5.4 * 0.08));
    assert!(near(ImprovedAco { o2: false, ..method }.rule(0.4), 1.0, 5.0));
}

#[test]
fn the_probability_of_a_change_grows_with_time_and_with_variety() {
    assert_eq!(change(0.0, 30.0, 3.0), 0.0);
    assert!((change(0.5, 30.0, 0.0) - 0.2).abs() < 1e-12, "0.25 / (0.25 + 1)");
    assert!((change(0.3, 10.0, 7.0) - 0.5).abs() < 1e-12, "the threshold is 0.3");
    assert!((change(1.0, 10.0, 40.0) - 1.0 / 1.01).abs() < 1e-12, "the threshold is at least 0.1");
    assert_eq!(change(0.0, 0.0, 0.0), 0.0);
}

#[test]
fn deviations_are_squared_and_ants_given_up_count_with_the_mean() {
    // As printed they are summed, which is always zero.
    assert_eq!(statistics(&[2.0, 4.0, 6.0], 3), [4.0, (8.0f64 / 3.0).sqrt()]);
    assert_eq!(statistics(&[2.0, 4.0, 6.0], 4), [4.0, 2f64.sqrt()]);
    assert_eq!(statistics(&[], 4), [0.0; 2]);
}

#[test]
fn soldiers_become_kings_but_not_all_at_once() {
    let signs = Signs { progress: 1.0, mean: 10.0, deviation: 10.0, entropy: 0.5 };
    let kings = |roles: &[Role]| roles.iter().filter(|r| **r == Role::King).count();
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let mut ants = roles(50);
    assert_eq!(kings(&ants), 5);
    convert(&mut ants, Conversion::Stimulus, &signs, &mut rng);
    assert_eq!(kings(&ants), 14, "45 soldiers, at most 9 conversions");
    let mut ants = roles(50);
    convert(&mut ants, Conversion::Rate, &signs, &mut rng);
    assert_eq!(kings(&ants), 14);
    convert(&mut ants, Conversion::Entropy, &signs, &mut rng);
    assert_eq!(kings(&ants), 27, "half of 45 soldiers are left, rounded");
    let mut ants = roles(50);
    convert(&mut ants, Conversion::Stimulus, &Signs { progress: 0.0, ..signs }, &mut rng);
    assert_eq!(kings(&ants), 5, "no stimulus, no conversion");
    let plain = Rule { alpha: 1.2, beta: 5.0, heuristic: Heuristic::Goal, greedy: 0.0, uniform: 0.0 };
    assert_eq!((Role::Soldier.rule(plain).alpha, Role::Soldier.rule(plain).uniform, Role::King.rule(plain).greedy), (0.6, 0.2, 0.7));
}

#[test]
fn a_dead_end_is_marked_back_to_its_mouth_within_the_window() {
    let rows = ["#########", ".......##", "#######.#", "........."];
    let world = world(&rows);
    let lattice = world.lattice(0.0);
    let roads = Streets::new(&lattice, Corners::Clear);
    let node = |x, y| roads.node([x, y]);
    let mut window = Vec::new();
    // The upper corridor ends at x = 6: diagonals are not allowed under this rule. Seen from there, the window reaches down to x = 4.
    roads.around(node(6, 2), &mut window);
    assert!(window.contains(&node(4, 2)) && !window.contains(&node(3, 2)) && window.contains(&node(7, 1)) && !window.contains(&node(7, 2)));
    let mut found = sweep(&roads, &window, [node(0, 2), node(8, 0)], |_| false, &mut BTreeSet::new());
    found.sort_unstable();
    // The pocket at (7, 1) goes as well; what lies on the lower road has two exits.
    assert_eq!(found, [node(7, 1), node(4, 2), node(5, 2), node(6, 2)]);
    let found = sweep(&roads, &window, [node(6, 2), node(8, 0)], |_| false, &mut BTreeSet::new());
    assert_eq!(found, [node(7, 1)], "the ends of the way stay, and with them what leads to them");
}

#[test]
fn all_six_off_is_the_ant_system() {
    let world = world(&["....#...", ".##...#.", "..#.#.#.", "#...#...", "..#...#.", "........"]);
    let query = Query::new(world, [0.5, 0.5], [7.5, 5.5]);
    let off = ImprovedAco { o1: false, o2: false, o3: false, o4: false, o5: false, o6: false, ..ImprovedAco::paper() };
    for seed in 0..5 {
        let [a, b]: [Solution; 2] = [&off as &dyn Planner, &super::super::Aco::paper()].map(|p| p.plan(&query, &mut Context::new(seed)).unwrap());
        assert_eq!((a.path, a.history, a.evaluations), (b.path, b.history, b.evaluations));
        assert_eq!(a.trace["legs"][0]["pheromone"], b.trace["legs"][0]["pheromone"]);
    }
}

#[test]
fn smoothing_is_reported_with_the_length_before_and_after() {
    let world = world(&["........"; 6]);
    let query = Query::new(world, [0.5, 0.5], [7.5, 3.5]);
    let method = ImprovedAco::paper();
    let solution = method.plan(&query, &mut Context::new(3)).unwrap();
    let smoothed = &solution.trace["legs"][0]["smoothed"];
    assert!((smoothed["length"].as_f64().unwrap() - 58f64.sqrt()).abs() < 1e-6, "{smoothed}");
    assert!((solution.cost - (4.0 + 3.0 * std::f64::consts::SQRT_2)).abs() < 1e-9, "the lattice path is what is returned");
    let without = ImprovedAco { o5: false, ..method }.plan(&query, &mut Context::new(3)).unwrap();
    assert!(without.trace["legs"][0]["smoothed"].is_null());
    assert_eq!(without.path, solution.path);
}

#[test]
fn parameters_out_of_range_are_refused() {
    let query = Query::new(world(&["..."]), [0.5, 0.5], [2.5, 0.5]);
    let good = ImprovedAco::default();
    for bad in [
        ImprovedAco { ants: 0, ..good },
        ImprovedAco { alpha_range: [1.0, f64::NAN], ..good },
        ImprovedAco { beta_range: [-1.0, 2.0], ..good },
        ImprovedAco { evaporation: 1.0, ..good },
        ImprovedAco { cone: 0.0, ..good },
        ImprovedAco { least: 20.0, ..good },
        ImprovedAco { best_probability: 0.0, ..good },
        ImprovedAco { max_curvature: -0.1, ..good },
        ImprovedAco { restart: f64::NAN, ..good },
    ] {
        assert!(matches!(bad.plan(&query, &mut Context::new(1)), Err(PlanError::BadParameter { .. })), "{bad:?}");
    }
    assert!(good.plan(&query, &mut Context::new(1)).is_ok());
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 256, failure_persistence: None, ..ProptestConfig::default() })]
    /// Cells that lead nowhere are on no simple way: without them the optimum is the same.
    #[test]
    fn the_tabu_table_never_cuts_the_map(cells in proptest::collection::vec(0u8..100, 14 * 11), density in 20u8..65, corners in 0usize..3, order in any::<u64>()) {
        let mut blocked = Bits::new(14, 11);
        for (i, c) in cells.iter().enumerate().take(14 * 11 - 1).skip(1) {
            blocked.set(i as u32 % 14, i as u32 / 14, *c < density);
        }
        let corners = [Corners::Touch, Corners::Clear, Corners::Squeeze][corners];
        let world = World::from_grid(Grid::new(blocked, None, 1.0, [0.0; 3]).unwrap());
        let lattice = world.lattice(0.0);
        let roads = Streets::new(&lattice, corners);
        let (mut found, mut window, mut at) = (BTreeSet::new(), Vec::new(), order);
        for _ in 0..60 {
            at = at.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            roads.around((at >> 33) as u32 % (14 * 11), &mut window);
            sweep(&roads, &window, [0, 14 * 11 - 1], |_| false, &mut found);
        }
        prop_assert_eq!(steps(&roads, &[]), steps(&roads, &found.into_iter().collect::<Vec<_>>()));
    }
}

/// Length of the shortest way from the first node to the last past closed nodes, by relaxation until nothing changes.
fn steps(roads: &Streets, closed: &[u32]) -> Option<u64> {
    let last = roads.nodes() - 1;
    let mut far = vec![f64::INFINITY; last + 1];
    far[0] = 0.0;
    loop {
        let mut changed = false;
        for node in 0..=last {
            if far[node].is_finite() && !closed.contains(&(node as u32)) {
                let here = far[node];
                roads.visit(node as u32, |exit| {
                    if !closed.contains(&exit.to) && here + exit.length < far[exit.to as usize] - 1e-9 {
                        (far[exit.to as usize], changed) = (here + exit.length, true);
                    }
                });
            }
        }
        if !changed {
            return far[last].is_finite().then(|| (far[last] * 1e6).round() as u64);
        }
    }
}
