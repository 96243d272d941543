//! Line-of-sight simplification: fewer way points, never longer (under soft clearance: never dearer), as far from obstacles as the query asks.

use super::chords::polyline;
use super::metric::Metric;
use super::{Refined, Refiner};
use crate::Point;
use crate::context::Context;
use crate::error::PlanError;
use crate::path::Path;
use crate::query::Query;
use crate::world::shape::{cross, distance, dot, sub};
use serde::{Deserialize, Serialize};

/// Drops way points wherever the robot's disc can go straight. Start, goal and via points stay.
///
/// Up to `exact` way points the result is the shortest (then the one with the fewest points) among all sub-sequences of the input: dynamic programming
/// over the lines of sight. Longer inputs are first thinned greedily, each time to the farthest visible point that doubling steps find.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Simplify {
    /// Largest number of way points between two fixed ones for the exact method.
    pub exact: usize,
}

impl Default for Simplify {
    fn default() -> Self {
        Self { exact: 120 }
    }
}

impl Refiner for Simplify {
    fn refine(&self, path: &Path, query: &Query, _ctx: &mut Context) -> Result<Refined, PlanError> {
        let points = self.points(path, query).into_iter().map(|(p, _)| p).collect::<Vec<_>>();
        Ok(Refined { path: Path::polyline(&points), unmet: Vec::new() })
    }
}

impl Simplify {
    /// The way points that stay (m), each with whether it is fixed (start, via, goal).
    pub(super) fn points(self, path: &Path, query: &Query) -> Vec<(Point, bool)> {
        let points = if path.degree() == 1 { path.points() } else { polyline(path, query) };
        let points = with_stops(points, &query.via);
        let fixed: Vec<usize> = (0..points.len()).filter(|&i| points[i].1).collect();
        let mut kept = vec![points[0]];
        for leg in fixed.windows(2) {
            let way: Vec<Point> = points[leg[0]..=leg[1]].iter().map(|p| p.0).collect();
            let way = if way.len() > self.exact { greedy(&way, query) } else { way };
            let way = if way.len() > self.exact { way } else { shortest(&way, query) };
            kept.extend(way[1..].iter().map(|p| (*p, false)));
            if let Some(last) = kept.last_mut() {
                last.1 = true;
            }
        }
        kept
    }
}

/// Marks start, goal and via points as fixed; a via point inside a leg becomes a way point. One that is not on the path is passed over: the path
/// is the planner's promise, not ours.
fn with_stops(points: Vec<Point>, via: &[Point]) -> Vec<(Point, bool)> {
    let mut marked: Vec<(Point, bool)> = points.into_iter().map(|p| (p, false)).collect();
    let mut from = 0;
    for &v in via {
        if let Some(i) = (from..marked.len()).find(|&i| distance(marked[i].0, v) < 1e-9) {
            (marked[i], from) = ((v, true), i);
        } else if let Some(i) = (from..marked.len() - 1).find(|&i| on_leg(v, marked[i].0, marked[i + 1].0)) {
            marked.insert(i + 1, (v, true));
            from = i + 1;
        }
    }
    let last = marked.len() - 1;
    marked[0].1 = true;
    marked[last].1 = true;
    marked
}

fn on_leg(p: Point, a: Point, b: Point) -> bool {
    let (e, v) = (sub(b, a), sub(p, a));
    let l2 = dot(e, e);
    l2 > 0.0 && (0.0..=l2).contains(&dot(v, e)) && cross(e, v).abs() <= 1e-9 * l2.sqrt()
}

/// From each kept point, doubling steps to a far visible one, then halving back. Steps that cost more than the way they replace are none.
fn greedy(way: &[Point], query: &Query) -> Vec<Point> {
    let (radius, metric) = (query.radius(), Metric::of(query));
    let costs = metric.along(way);
    let sees = |i: usize, j: usize| {
        j == i + 1 || (metric.cost(way[i], way[j]) <= costs[j] - costs[i] + 1e-9 && query.world.segment_free(way[i], way[j], radius))
    };
    let (mut kept, mut i) = (vec![way[0]], 0);
    while i + 1 < way.len() {
        let (mut good, mut step) = (i + 1, 2);
        while i + step < way.len() && sees(i, i + step) {
            good = i + step;
            step *= 2;
        }
        let mut bad = (i + step).min(way.len());
        while good + 1 < bad {
            let middle = usize::midpoint(good, bad);
            if sees(i, middle) {
                good = middle;
            } else {
                bad = middle;
            }
        }
        kept.push(way[good]);
        i = good;
    }
    kept
}

/// Shortest (cheapest) sub-sequence whose legs are free; legs of the input count as free. Equal lengths (1e-9) are broken by fewer points.
fn shortest(way: &[Point], query: &Query) -> Vec<Point> {
    let (n, radius, metric) = (way.len(), query.radius(), Metric::of(query));
    let mut best = vec![(f64::INFINITY, usize::MAX, 0); n];
    best[0] = (0.0, 0, 0);
    for j in 1..n {
        for i in 0..j {
            // No metre costs less than 1.
            if best[i].0 + distance(way[i], way[j]) > best[j].0 + 1e-9 {
                continue;
            }
            let (length, hops) = (best[i].0 + metric.cost(way[i], way[j]), best[i].1 + 1);
            let better = length < best[j].0 - 1e-9 || (length <= best[j].0 + 1e-9 && hops < best[j].1);
            if better && (j == i + 1 || query.world.segment_free(way[i], way[j], radius)) {
                best[j] = (length, hops, i);
            }
        }
    }
    let (mut kept, mut i) = (vec![way[n - 1]], n - 1);
    while i > 0 {
        i = best[i].2;
        kept.push(way[i]);
    }
    kept.reverse();
    kept
}
