//! Tours: in which order to pass several places between the start and the goal.
//!
//! Source: \[held1962\] for the exact order of up to [`EXACT`] places; \[held1971\] for the bound beyond, where the order comes from insertion and exchanges.
//! What a leg costs is the exact any-angle distance for the robot's disc, so a tour is as exact as its legs.

use super::search::{ExactLeg, Route, explain};
use crate::context::Context;
use crate::error::PlanError;
use crate::query::Query;

/// Most places whose best order is found by dynamic programming.
pub const EXACT: usize = 15;
/// Most places of a tour.
pub const MOST: usize = 200;
/// Rounds of the ascent of the bound.
const ROUNDS: usize = 300;

/// An order of the via points of a query.
#[derive(Debug, Clone, PartialEq)]
pub struct Tour {
    /// Indices into `query.via`, in the order in which they are passed.
    pub order: Vec<usize>,
    /// Exact length of the tour, m.
    pub length: f64,
    /// Proved lower bound on the length of any order, m; the length itself where the order is proved best.
    pub bound: f64,
    /// Exact distances between start, via points as given and goal, m.
    pub costs: Vec<Vec<f64>>,
}

/// The best order of a query's via points between its start and its goal: proved up to [`EXACT`] of them, beyond with a bound.
/// # Errors
/// Those of [`Query::validate`]; [`PlanError::BadParameter`] for more than [`MOST`] via points; [`PlanError::NoPath`] if a place cannot be reached;
/// [`PlanError::Cancelled`].
pub fn tour(query: &Query, ctx: &mut Context) -> Result<Tour, PlanError> {
    query.validate()?;
    if query.via.len() > MOST {
        return Err(PlanError::bad("via", format!("{} points", query.via.len()), format!("at most {MOST} points in the best order")));
    }
    let costs = distances(query, ctx)?;
    let proved = query.via.len() <= EXACT;
    let order = if proved { held_karp(&costs) } else { improved(&costs, inserted(&costs)) };
    let length = length(&costs, &order);
    let bound = if proved { length } else { ascent(&costs, length).min(length) };
    Ok(Tour { order, length, bound, costs })
}

/// The query with its via points in the order of a tour.
pub fn ordered(query: &Query, tour: &Tour) -> Query {
    Query { via: tour.order.iter().map(|i| query.via[*i]).collect(), ..query.clone() }
}

/// Exact distances between all stops.
fn distances(query: &Query, ctx: &mut Context) -> Result<Vec<Vec<f64>>, PlanError> {
    let stops = query.stops();
    let n = stops.len();
    let mut costs = vec![vec![0.0; n]; n];
    let mut leg = ExactLeg::new(query);
    for (i, j) in (0..n).flat_map(|i| (i + 1..n).map(move |j| (i, j))) {
        if ctx.poll().is_some() {
            return Err(PlanError::Cancelled);
        }
        let cost = match leg.solve([stops[i], stops[j]], ctx) {
            Route::Path { length, .. } => length,
            Route::Nothing => {
                let alone = Query { start: stops[i], goal: stops[j], via: Vec::new(), ..query.clone() };
                return Err(PlanError::NoPath(Box::new(explain(&alone, ctx))));
            }
            Route::Stopped { .. } => return Err(PlanError::Cancelled),
        };
        (costs[i][j], costs[j][i]) = (cost, cost);
    }
    Ok(costs)
}

/// Length of an order, start and goal at its ends.
fn length(costs: &[Vec<f64>], order: &[usize]) -> f64 {
    route(costs, order).windows(2).map(|w| costs[w[0]][w[1]]).sum()
}

/// An order as rows of the matrix, with both ends.
fn route(costs: &[Vec<f64>], order: &[usize]) -> Vec<usize> {
    std::iter::once(0).chain(order.iter().map(|i| i + 1)).chain([costs.len() - 1]).collect()
}

/// The best order by dynamic programming over sets.
fn held_karp(costs: &[Vec<f64>]) -> Vec<usize> {
    let (n, goal) = (costs.len() - 2, costs.len() - 1);
    if n == 0 {
        return Vec::new();
    }
    // best[set * n + last]: from the start through the set, ending at `last`.
    let mut best = vec![f64::INFINITY; n << n];
    for i in 0..n {
        best[(1 << i) * n + i] = costs[0][i + 1];
    }
    for set in 1_usize..1 << n {
        for last in (0..n).filter(|i| set >> i & 1 == 1) {
            let so_far = best[set * n + last];
            for next in (0..n).filter(|i| set >> i & 1 == 0) {
                let to = &mut best[(set | 1 << next) * n + next];
                *to = to.min(so_far + costs[last + 1][next + 1]);
            }
        }
    }
    let mut set = (1 << n) - 1;
    let mut order = vec![least(0..n, |i| best[set * n + i] + costs[i + 1][goal])];
    while order.len() < n {
        let after = order[order.len() - 1];
        set &= !(1 << after);
        order.push(least((0..n).filter(|i| set >> i & 1 == 1), |i| best[set * n + i] + costs[i + 1][after + 1]));
    }
    order.reverse();
    order
}

/// The first of least value; 0 of none.
fn least(all: impl Iterator<Item = usize>, value: impl Fn(usize) -> f64) -> usize {
    all.min_by(|a, b| value(*a).total_cmp(&value(*b))).unwrap_or(0)
}

/// An order by inserting the farthest place where it costs least.
fn inserted(costs: &[Vec<f64>]) -> Vec<usize> {
    let n = costs.len() - 2;
    let (mut order, mut rest): (Vec<usize>, Vec<usize>) = (Vec::new(), (0..n).collect());
    while !rest.is_empty() {
        let on = route(costs, &order);
        let apart = |i: &usize| on.iter().map(|k| costs[i + 1][*k]).fold(f64::INFINITY, f64::min);
        let k = least(0..rest.len(), |k| -apart(&rest[k]));
        let place = rest.remove(k);
        let extra = |at: usize| costs[on[at]][place + 1] + costs[place + 1][on[at + 1]] - costs[on[at]][on[at + 1]];
        order.insert(least(0..on.len() - 1, extra), place);
    }
    order
}

/// Exchanges until none helps: stretches reversed, and stretches of up to three moved.
fn improved(costs: &[Vec<f64>], mut order: Vec<usize>) -> Vec<usize> {
    let n = order.len();
    let mut now = length(costs, &order);
    loop {
        let before = now;
        for (i, j) in (0..n).flat_map(|i| (i + 1..n).map(move |j| (i, j))) {
            order[i..=j].reverse();
            let new = length(costs, &order);
            if new < now - 1e-9 {
                now = new;
            } else {
                order[i..=j].reverse();
            }
        }
        for (size, from, to) in (1..=3.min(n)).flat_map(|s| (0..=n - s).flat_map(move |i| (0..=n - s).map(move |j| (s, i, j)))) {
            let mut moved = order.clone();
            let part: Vec<usize> = moved.drain(from..from + size).collect();
            moved.splice(to..to, part);
            let new = length(costs, &moved);
            if new < now - 1e-9 {
                (order, now) = (moved, new);
            }
        }
        if now >= before - 1e-9 {
            return order;
        }
    }
}

/// A lower bound on every order: the least spanning tree under prices of the places that make it path-like, by subgradient ascent towards `goal_length`.
fn ascent(costs: &[Vec<f64>], goal_length: f64) -> f64 {
    let n = costs.len();
    let wanted = |i: usize| if i == 0 || i == n - 1 { 1.0 } else { 2.0 };
    let (mut prices, mut best, mut share) = (vec![0.0; n], 0.0_f64, 1.0);
    for round in 0..ROUNDS {
        let (tree, degrees) = spanning(costs, &prices);
        let bound = tree - (0..n).map(|i| wanted(i) * prices[i]).sum::<f64>();
        best = best.max(bound);
        let off: f64 = (0..n).map(|i| (degrees[i] - wanted(i)).powi(2)).sum();
        if off == 0.0 {
            break;
        }
        if round % 30 == 29 {
            share *= 0.6;
        }
        let step = share * (goal_length - bound).max(0.0) / off;
        (0..n).for_each(|i| prices[i] += step * (degrees[i] - wanted(i)));
    }
    best
}

/// Cost and degrees of the least spanning tree (Prim) with a price for each end of an edge.
fn spanning(costs: &[Vec<f64>], prices: &[f64]) -> (f64, Vec<f64>) {
    let n = costs.len();
    let edge = |i: usize, j: usize| costs[i][j] + prices[i] + prices[j];
    let (mut degrees, mut total) = (vec![0.0; n], 0.0);
    let mut nearest: Vec<(f64, usize)> = (0..n).map(|i| (edge(0, i), 0)).collect();
    let mut open: Vec<usize> = (1..n).collect();
    while !open.is_empty() {
        let k = least(0..open.len(), |k| nearest[open[k]].0);
        let i = open.swap_remove(k);
        total += nearest[i].0;
        degrees[i] += 1.0;
        degrees[nearest[i].1] += 1.0;
        for &j in &open {
            if edge(i, j) < nearest[j].0 {
                nearest[j] = (edge(i, j), i);
            }
        }
    }
    (total, degrees)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Point;
    use crate::world::{Footprint, Shape, World};
    use rand::RngExt;
    use rand_chacha::ChaCha8Rng;
    use rand_chacha::rand_core::SeedableRng;
    use std::sync::Arc;

    fn query(seed: u64, n: usize) -> Query {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let wall = |x: f64, y: [f64; 2]| Shape::polygon(vec![[x, y[0]], [x + 0.3, y[0]], [x + 0.3, y[1]], [x, y[1]]]).unwrap();
        let world = Arc::new(World::from_shapes([0.0, 0.0, 12.0, 9.0], vec![wall(4.0, [0.0, 6.5]), wall(8.0, [2.5, 9.0])], 0.1).unwrap());
        let mut place = || -> Point {
            loop {
                let p = [rng.random_range(0.5..11.5), rng.random_range(0.5..8.5)];
                if world.fits(p, 0.3) {
                    return p;
                }
            }
        };
        let (start, goal, via) = (place(), place(), (0..n).map(|_| place()).collect());
        Query { via, footprint: Footprint::Disc(0.3), ..Query::new(world, start, goal) }
    }

    fn permutations(n: usize) -> Vec<Vec<usize>> {
        if n == 0 {
            return vec![Vec::new()];
        }
        let shorter = permutations(n - 1);
        shorter.iter().flat_map(|p| (0..n).map(|at| [&p[..at], &[n - 1], &p[at..]].concat())).collect()
    }

    #[test]
    fn the_order_is_the_best_of_all() {
        for seed in 0..12 {
            let query = query(seed, seed as usize % 7);
            let found = tour(&query, &mut Context::new(0)).unwrap();
            let best = permutations(query.via.len()).iter().map(|p| length(&found.costs, p)).fold(f64::INFINITY, f64::min);
            assert!((found.length - best).abs() < 1e-9 && found.bound == found.length, "{seed}: {} {best}", found.length);
            let path =
                super::super::planner("visibility", serde_json::Value::Null).unwrap().plan(&ordered(&query, &found), &mut Context::new(0)).unwrap();
            assert!((path.cost - found.length).abs() < 1e-6);
        }
    }

    #[test]
    fn larger_tours_are_good_and_bounded() {
        for seed in 0..6 {
            let query = query(100 + seed, 12);
            let exact = tour(&query, &mut Context::new(0)).unwrap();
            let rough = improved(&exact.costs, inserted(&exact.costs));
            let (long, bound) = (length(&exact.costs, &rough), ascent(&exact.costs, exact.length));
            assert!(bound <= exact.length + 1e-9 && bound > 0.9 * exact.length, "{seed}: {bound} {}", exact.length);
            assert!(long < 1.1 * exact.length, "{seed}: {long} {}", exact.length);
        }
        let many = tour(&query(7, 40), &mut Context::new(0)).unwrap();
        let mut all = many.order.clone();
        all.sort_unstable();
        assert!(all == (0..40).collect::<Vec<_>>() && many.bound <= many.length && many.bound > 0.9 * many.length, "{} {}", many.bound, many.length);
        assert!(matches!(tour(&query(7, MOST + 1), &mut Context::new(0)), Err(PlanError::BadParameter { .. })));
    }

    #[test]
    fn a_place_that_cannot_be_reached_is_told() {
        let mut query = query(1, 2);
        let fence = Shape::polygon(vec![[5.0, -1.0], [5.5, -1.0], [5.5, 10.0], [5.0, 10.0]]).unwrap();
        query.world = Arc::new(query.world.extended([fence]));
        (query.start, query.goal, query.via) = ([1.0, 1.0], [2.0, 2.0], vec![[7.0, 1.0], [2.0, 1.0]]);
        assert!(matches!(tour(&query, &mut Context::new(0)), Err(PlanError::NoPath(_))));
    }
}
