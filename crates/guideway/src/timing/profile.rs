//! A jerk-limited speed profile under a ceiling, near the time optimum, that never stops on the way.
//!
//! The fastest profile between two troughs (places of zero acceleration) without a ceiling between them is the seven-phase S-curve.
//! So the profile is a chain of S-curves between nodes `(s, v)`, and what has to be found are the nodes. A shortest-path search over
//! a coarse set of nodes finds the chain; a second one, over finer and finer grids around its nodes, polishes it. Every
//! S-curve is checked against the ceiling over its whole course, not at samples.

use super::ceiling::Ceiling;
use super::correction::correct;
use super::scurve::{Bounds, Profile, SCurve, transition};
use crate::error::PlanError;

/// Speeds of the coarse nodes as shares of the envelope.
const LEVELS: [f64; 5] = [1.0, 0.96, 0.9, 0.8, 0.62];
/// Most stations of the coarse search.
const STATIONS: usize = 150;
/// Rounds of polishing, and the factor by which the grid shrinks in each.
const ROUNDS: usize = 8;
const SHRINK: f64 = 0.55;
/// Most nodes of a corrected profile that are polished.
const MOST_NODES: usize = 40;

/// A place of zero acceleration: arc length (m), speed (m/s).
#[derive(Debug, Clone, Copy, PartialEq)]
struct Node {
    s: f64,
    v: f64,
}

/// The chain of S-curves, each with its start (m), from `(0, ends.0)` to `(length, ends.1)` below the ceiling, with zero acceleration at both ends.
/// # Errors
/// [`PlanError::Infeasible`] if the boundary speeds do not fit the ceiling or the length.
pub fn fastest(ceiling: &Ceiling, bounds: &Bounds, ends: (f64, f64)) -> Result<Vec<(f64, Profile)>, PlanError> {
    let (first, last) = (Node { s: 0.0, v: ends.0 }, Node { s: ceiling.length(), v: ends.1 });
    let search = Search { ceiling, bounds };
    // Alone it is the optimum; it also tells when the boundary speeds do not fit the length.
    let whole = search.curve(first, last, bounds.speed).plan()?;
    if ceiling.first_excess(0.0, &whole).is_none() {
        return Ok(vec![(0.0, whole)]);
    }
    let found = search.coarse(first, last).map(|chain| search.settle(chain));
    // Nodes corrected one by one: a bound on what the search may return, and now and then a better start for it.
    let nodes = match correct(ceiling, bounds, ends) {
        Ok(corrected) => corrected,
        Err(error) => return found.ok_or(error),
    };
    let slower = |chain: &Chain| time(chain) > nodes.duration();
    match found {
        Some(chain) if !slower(&chain) => return Ok(chain),
        _ if nodes.nodes.len() > MOST_NODES => return Ok(nodes.chain),
        _ => {}
    }
    let polished = search.settle(nodes.nodes.iter().map(|&(s, v)| Node { s, v }).collect());
    Ok(if slower(&polished) || polished.is_empty() { nodes.chain } else { polished })
}

/// S-curves, each with its start (m).
type Chain = Vec<(f64, Profile)>;

fn time(chain: &[(f64, Profile)]) -> f64 {
    chain.iter().map(|(_, profile)| profile.duration()).sum()
}

struct Search<'a> {
    ceiling: &'a Ceiling,
    bounds: &'a Bounds,
}

impl Search<'_> {
    /// The S-curves between nodes that have been moved to where they serve best.
    fn settle(&self, mut nodes: Vec<Node>) -> Chain {
        let mut grid = (2.0 * self.spacing(self.bounds.speed), 0.1);
        for _ in 0..ROUNDS {
            nodes = self.polish(&nodes, grid);
            grid = (grid.0 * SHRINK, grid.1 * SHRINK);
        }
        nodes.windows(2).filter_map(|w| self.edge(w[0], w[1]).map(|p| (w[0].s, p))).collect()
    }

    fn curve(&self, from: Node, to: Node, speed: f64) -> SCurve {
        SCurve { distance: to.s - from.s, start: (from.v, 0.0), end: (to.v, 0.0), bounds: Bounds { speed, ..*self.bounds } }
    }

    /// The fastest S-curve between two nodes that keeps the ceiling; if the unbounded one does not, one that never exceeds the faster node, or
    /// the lowest ceiling in between.
    fn edge(&self, from: Node, to: Node) -> Option<Profile> {
        let lowest = self.ceiling.lowest(from.s, to.s);
        let faster = from.v.max(to.v);
        let mut failed = f64::INFINITY;
        if lowest < self.bounds.speed {
            let free = self.curve(from, to, self.bounds.speed).between_troughs()?;
            if self.ceiling.allows(from.s, &free) {
                return Some(free);
            }
            failed = free.top_speed();
        }
        let cap = lowest.max(faster).min(self.bounds.speed);
        if cap >= failed {
            return None;
        }
        let capped = self.curve(from, to, cap).between_troughs()?;
        self.ceiling.allows(from.s, &capped).then_some(capped)
    }

    /// Distance that matters when the acceleration changes sign at speed `v`, m.
    fn spacing(&self, v: f64) -> f64 {
        let jerk = self.bounds.jerk.build.min(self.bounds.jerk.release).min(self.bounds.jerk.brake).min(self.bounds.jerk.unbrake);
        let ramp = (self.bounds.acceleration.min(self.bounds.deceleration) / jerk).min((v / jerk).sqrt());
        (0.25 * v * ramp).max(self.ceiling.step())
    }

    /// Highest speed at each cell boundary under the ceiling and the acceleration limits alone: a bound on every profile.
    fn envelope(&self, ends: (f64, f64)) -> Vec<f64> {
        let cells = self.ceiling.cells();
        let n = cells.len();
        let h = self.ceiling.step();
        let mut v: Vec<f64> = (0..=n).map(|k| cells[k.saturating_sub(1)].min(cells[k.min(n - 1)]).min(self.bounds.speed)).collect();
        v[0] = v[0].min(ends.0);
        v[n] = v[n].min(ends.1);
        for k in 1..=n {
            v[k] = v[k].min((v[k - 1] * v[k - 1] + 2.0 * self.bounds.acceleration * h).sqrt());
        }
        for k in (0..n).rev() {
            v[k] = v[k].min((v[k + 1] * v[k + 1] + 2.0 * self.bounds.deceleration * h).sqrt());
        }
        v
    }

    /// Cell boundaries where a node may be of use: where the ceiling binds, and around.
    fn stations(&self, envelope: &[f64]) -> Vec<usize> {
        let cells = self.ceiling.cells();
        let n = cells.len();
        let h = self.ceiling.step();
        let mut near = vec![false; n + 1];
        for k in 1..n {
            let cap = cells[k - 1].min(cells[k]);
            if cap < 0.999 * self.bounds.speed && envelope[k] >= 0.999 * cap {
                let reach = (10.0 * self.spacing(cap) / h).ceil() as usize;
                near[k.saturating_sub(reach).max(1)..(k + reach + 1).min(n)].fill(true);
            }
        }
        let bound = near.iter().filter(|x| **x).count() as f64 / STATIONS as f64;
        let mut chosen = Vec::new();
        let mut credit = f64::INFINITY;
        for k in 1..n {
            let lowest = envelope[k] <= envelope[k - 1] && envelope[k] < envelope[k + 1];
            credit += 1.0;
            if near[k] && (lowest || credit >= (self.spacing(envelope[k]) / h).max(bound)) {
                chosen.push(k);
                credit = 0.0;
            } else if !near[k] {
                credit = f64::INFINITY;
            }
        }
        chosen
    }

    /// The fastest chain over the coarse nodes.
    fn coarse(&self, first: Node, last: Node) -> Option<Vec<Node>> {
        let envelope = self.envelope((first.v, last.v));
        let h = self.ceiling.step();
        let mut nodes = vec![first];
        for k in self.stations(&envelope) {
            nodes.extend(LEVELS.iter().map(|share| Node { s: h * k as f64, v: share * envelope[k] }));
        }
        nodes.push(last);
        // Least time from the start to each cell boundary at envelope speed: a bound for any chain.
        let mut least = vec![0.0; envelope.len()];
        for k in 1..least.len() {
            least[k] = least[k - 1] + 2.0 * h / (envelope[k] + envelope[k - 1]).max(1e-12);
        }
        let bound = |n: &Node| least[((n.s / h).round() as usize).min(least.len() - 1)];
        let mut best = vec![(f64::INFINITY, 0); nodes.len()];
        best[0].0 = 0.0;
        let goal = nodes.len() - 1;
        for i in 0..goal {
            if best[i].0 == f64::INFINITY {
                continue;
            }
            let reach = self.reach(nodes[i]);
            let near = nodes[i + 1..goal].partition_point(|n| n.s <= reach) + i + 1;
            for j in (i + 1..near).chain([goal]) {
                let floor = best[i].0 + bound(&nodes[j]) - bound(&nodes[i]);
                if nodes[j].s <= nodes[i].s || floor >= best[j].0 {
                    continue;
                }
                if let Some(profile) = self.edge(nodes[i], nodes[j]) {
                    let time = best[i].0 + profile.duration();
                    if time < best[j].0 {
                        best[j] = (time, i);
                    }
                }
            }
        }
        if best[goal].0 == f64::INFINITY {
            return None;
        }
        let mut chain = vec![goal];
        while let Some(&i) = chain.last().filter(|i| **i > 0) {
            chain.push(best[i].1);
        }
        Some(chain.into_iter().rev().map(|i| nodes[i]).collect())
    }

    /// Farthest place to which an S-curve from a node can go under the ceiling, m: it leaves full acceleration before that breaks
    /// the ceiling, and then only brakes.
    fn reach(&self, node: Node) -> f64 {
        let Bounds { speed, deceleration, jerk, .. } = *self.bounds;
        let Some(up) = transition((node.v, 0.0).into(), (speed, 0.0).into(), self.bounds) else { return f64::INFINITY };
        let stop = 0.5
            * speed
            * (speed / deceleration + deceleration / jerk.brake + deceleration / jerk.unbrake + 2.0 * (speed / jerk.brake.min(jerk.unbrake)).sqrt());
        let end = node.s + up.at(f64::INFINITY).0;
        let broken = self.ceiling.first_excess(node.s, &up).unwrap_or_else(|| {
            let k = (end / self.ceiling.step()) as usize;
            let next = self.ceiling.cells().iter().skip(k).position(|c| *c < speed);
            next.map_or(f64::INFINITY, |n| self.ceiling.step() * (k + n) as f64)
        });
        broken + stop
    }

    /// The fastest chain with every node on a small grid around its place, or left out.
    fn polish(&self, chain: &[Node], grid: (f64, f64)) -> Vec<Node> {
        let layers: Vec<Vec<Node>> =
            chain.iter().enumerate().map(|(i, n)| if i == 0 || i + 1 == chain.len() { vec![*n] } else { self.around(*n, grid) }).collect();
        let mut best: Vec<Vec<(f64, usize, usize)>> = vec![vec![(0.0, 0, 0)]];
        for i in 1..layers.len() {
            let row = layers[i].iter().map(|to| {
                let mut least = (f64::INFINITY, 0, 0);
                for back in 1..=i.min(2) {
                    for (k, from) in layers[i - back].iter().enumerate() {
                        let before = best[i - back][k].0;
                        // Not even at the speed limit.
                        if from.s >= to.s || before + (to.s - from.s) / self.bounds.speed >= least.0 {
                            continue;
                        }
                        if let Some(time) = self.edge(*from, *to).map(|p| before + p.duration()).filter(|t| *t < least.0) {
                            least = (time, i - back, k);
                        }
                    }
                }
                least
            });
            let row: Vec<_> = row.collect();
            best.push(row);
        }
        let (mut i, mut k) = (layers.len() - 1, 0);
        if best[i][0].0 == f64::INFINITY {
            return chain.to_vec();
        }
        let mut out = vec![layers[i][0]];
        while i > 0 {
            (i, k) = (best[i][k].1, best[i][k].2);
            out.push(layers[i][k]);
        }
        out.reverse();
        out
    }

    fn around(&self, node: Node, (ds, dv): (f64, f64)) -> Vec<Node> {
        let mut out = vec![node];
        for x in [-1.0, 0.0, 1.0] {
            for y in [-1.0, 0.0, 1.0] {
                let s = node.s + x * ds;
                let v = (node.v * (1.0 + y * dv)).min(if s > 0.0 && s < self.ceiling.length() { self.ceiling.at(s) } else { 0.0 });
                let next = Node { s, v };
                if v > 0.0 && !out.contains(&next) {
                    out.push(next);
                }
            }
        }
        out
    }
}
