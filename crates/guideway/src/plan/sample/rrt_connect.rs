//! RRT-Connect: two trees that grow towards each other.
//!
//! Source: \[kuffner2000\]. Departures: exact tests of edges; a step that is not free is tried again at half its length; the path is shortened.

use super::run::{EDGES, Found, Leg, plan};
use super::shortcut::{length, shorten};
use super::tree::Tree;
use crate::Point;
use crate::context::{Context, Stop};
use crate::error::PlanError;
use crate::plan::{Planner, Preset, Solution};
use crate::query::Query;
use crate::world::shape::distance;
use serde::{Deserialize, Serialize};

/// A path by RRT-Connect: the first one found.
///
/// `trace.tree` has the edges of both trees, [x, y, x of the parent, y of the parent] in m, 3000 a leg at most.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct RrtConnect {
    /// Settings: ours or those of the source.
    pub preset: Preset,
    /// Longest edge, m; `None`: a tenth of the diagonal of the world.
    pub step: Option<f64>,
    /// Samples per leg after which it gives up.
    pub patience: u64,
    /// How often a step that is not free is halved and tried again, 0 to 20.
    pub halvings: u32,
    /// Shortcuts that are tried on the path; 0: it stays as it was found.
    pub shortcuts: u32,
}

impl Default for RrtConnect {
    fn default() -> Self {
        Self { preset: Preset::Default, step: None, patience: 200_000, halvings: 3, shortcuts: 200 }
    }
}

impl RrtConnect {
    /// As in \[kuffner2000\].
    pub fn paper() -> Self {
        Self { preset: Preset::Paper, halvings: 0, shortcuts: 0, ..Self::default() }
    }

    fn leg(self, leg: &mut Leg, ctx: &mut Context) -> Result<Found, PlanError> {
        let mut trees = leg.ends.map(Tree::new);
        for turn in 0..self.patience {
            let a = (turn % 2) as usize;
            if let Some(q) = leg.ground.random(&mut ctx.rng)
                && let Some((grown, p, _)) = extend(&mut trees[a], q, leg)
                && let Some(met) = connect(&mut trees[1 - a], p, leg)
            {
                let ends = if a == 0 { [grown, met] } else { [met, grown] };
                let found = joined(&trees, ends);
                let points = shorten(&found, self.shortcuts, &mut leg.ground, &mut ctx.rng);
                leg.tick(length(&points), ctx)?;
                let edges = trees.iter().flat_map(|t| t.edges(EDGES / 2)).collect();
                return Ok(Found { points, stop: Stop::Converged, edges });
            }
            if let Some(stop) = leg.tick(f64::INFINITY, ctx)? {
                return Err(leg.nothing(stop, ctx));
            }
        }
        Err(leg.nothing(Stop::Converged, ctx))
    }
}

impl Planner for RrtConnect {
    fn plan(&self, query: &Query, ctx: &mut Context) -> Result<Solution, PlanError> {
        super::check("rrt-connect", self.step, &[("patience", self.patience as f64, [1.0, 1e15]), super::halvings(self.halvings)])?;
        plan(query, ctx, (self.step, self.halvings), |leg, ctx| self.leg(leg, ctx))
    }
}

/// One step of a tree towards `q`; the new node, where it lies, and is that `q`?
fn extend(tree: &mut Tree, q: Point, leg: &mut Leg) -> Option<(usize, Point, bool)> {
    let near = tree.near.nearest(q);
    let (p, reached) = leg.ground.steer(tree.point(near), q)?;
    Some((tree.add(p, near), p, reached))
}

/// Steps of a tree towards `q` until it is there; that node, or `None` if something is in the way.
fn connect(tree: &mut Tree, q: Point, leg: &mut Leg) -> Option<usize> {
    let near = tree.near.nearest(q);
    if tree.point(near) == q {
        return Some(near);
    }
    let mut last = f64::INFINITY;
    loop {
        let (node, p, reached) = extend(tree, q, leg)?;
        if reached {
            return Some(node);
        }
        // Steps that are halved over and over get nowhere.
        let left = distance(p, q);
        if left > last - 0.6 * leg.ground.step {
            return None;
        }
        last = left;
    }
}

/// From the root of the first tree over both nodes, which lie at one place, to the root of the second.
fn joined(trees: &[Tree; 2], [first, second]: [usize; 2]) -> Vec<Point> {
    let mut points = trees[0].way(first);
    points.extend(trees[1].way(second).into_iter().rev().skip(1));
    points
}
