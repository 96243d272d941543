//! RRT* with any sampler: a tree that hangs its nodes below better parents as it grows.

use super::informed_rrt_star::Ellipse;
use super::run::{EDGES, Found, Leg, plan};
use super::shortcut::{length, shorten};
use super::tree::Tree;
use crate::Point;
use crate::context::{Context, Stop};
use crate::error::PlanError;
use crate::plan::{Preset, Solution};
use crate::query::Query;
use crate::world::shape::distance;
use rand::RngExt;
use serde::{Deserialize, Serialize};
use std::collections::VecDeque;
use std::f64::consts::PI;

/// Parameters of RRT* with any sampler.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Star {
    /// Settings: ours or those of the source.
    pub preset: Preset,
    /// Longest edge, m; `None`: a tenth of the diagonal of the world.
    pub step: Option<f64>,
    /// Samples per leg, if the budget does not end it.
    pub samples: u64,
    /// Samples per leg without a path after which it gives up.
    pub patience: u64,
    /// Share of samples at the goal until it is reached, 0 to 1.
    pub goal_bias: f64,
    /// Radius of rewiring, times the least that is proved to lead to the optimum.
    pub rewire: f64,
    /// How often a step that is not free is halved and tried again, 0 to 20.
    pub halvings: u32,
    /// Shortcuts that are tried on each better path; 0: paths are those of the tree.
    pub shortcuts: u32,
}

impl Default for Star {
    fn default() -> Self {
        Self { preset: Preset::Default, step: None, samples: 2000, patience: 200_000, goal_bias: 0.05, rewire: 1.1, halvings: 3, shortcuts: 100 }
    }
}

impl Star {
    /// As in \[karaman2011\] and \[gammell2014\].
    pub fn paper() -> Self {
        Self { preset: Preset::Paper, halvings: 0, shortcuts: 0, ..Self::default() }
    }

    /// Plans; `informed` samples only where a shorter path may run.
    pub(super) fn solve(&self, informed: bool, query: &Query, ctx: &mut Context) -> Result<Solution, PlanError> {
        self.check(if informed { "informed-rrt-star" } else { "rrt-star" })?;
        plan(query, ctx, (self.step, self.halvings), |leg, ctx| self.leg(informed, leg, ctx))
    }

    fn check(&self, planner: &str) -> Result<(), PlanError> {
        let named = [
            ("samples", self.samples as f64, [1.0, 1e15]),
            ("patience", self.patience as f64, [1.0, 1e15]),
            ("goal_bias", self.goal_bias, [0.0, 1.0]),
            ("rewire", self.rewire, [1e-3, 1e3]),
            super::halvings(self.halvings),
        ];
        super::check(planner, self.step, &named)
    }

    fn leg(&self, informed: bool, leg: &mut Leg, ctx: &mut Context) -> Result<Found, PlanError> {
        let mut growth = Growth::new(leg, informed, self.rewire);
        let mut samples = 0;
        let stop = loop {
            samples += 1;
            if let Some(q) = self.sample(&mut growth, leg, ctx) {
                growth.grow(q, leg);
                growth.improve(self.shortcuts, leg, ctx);
            }
            let stop = leg.tick(growth.best, ctx)?;
            if let Some(stop) = stop {
                break stop;
            }
            let done =
                if growth.best.is_finite() { samples >= self.samples || growth.best <= growth.ellipse.least() } else { samples >= self.patience };
            if done {
                break Stop::Converged;
            }
        };
        if growth.path.is_empty() { Err(leg.nothing(stop, ctx)) } else { Ok(Found { stop, edges: growth.tree.edges(EDGES), points: growth.path }) }
    }

    /// The next sample: a point of the best path that is not in the tree yet, the goal now and then until there is a path, else a random point.
    fn sample(&self, growth: &mut Growth, leg: &Leg, ctx: &mut Context) -> Option<Point> {
        if let Some(p) = growth.waiting.pop_front() {
            return Some(p);
        }
        if growth.goal.is_none() && ctx.rng.random_bool(self.goal_bias) {
            return Some(leg.ends[1]);
        }
        if growth.informed && growth.ellipse.area(growth.best) < leg.ground.area() {
            return leg.ground.drawn(|| growth.ellipse.draw(growth.best, &mut ctx.rng));
        }
        leg.ground.random(&mut ctx.rng)
    }
}

/// The tree as it grows.
struct Growth {
    tree: Tree,
    ends: [Point; 2],
    ellipse: Ellipse,
    /// Samples come from the ellipse.
    informed: bool,
    /// Radius of rewiring at n nodes: this times sqrt(area ln n / n), with the area that samples come from, at least the free part of it.
    gamma: f64,
    /// The node at the goal.
    goal: Option<usize>,
    /// Best path and its length, m.
    path: Vec<Point>,
    best: f64,
    /// Length of the tree's own path when it was last shortened, m.
    seen: f64,
    /// Points of the best path that are to be put into the tree.
    waiting: VecDeque<Point>,
    near: Vec<usize>,
}

impl Growth {
    fn new(leg: &Leg, informed: bool, rewire: f64) -> Self {
        // [karaman2011], theorem 38, in the plane: (2 (1 + 1/2))^(1/2) (area / pi)^(1/2).
        let gamma = rewire * (3.0 / PI).sqrt();
        let (tree, ellipse) = (Tree::new(leg.ends[0]), Ellipse::new(leg.ends));
        let (path, waiting, near) = (Vec::new(), VecDeque::new(), Vec::new());
        Self { tree, ends: leg.ends, ellipse, informed, gamma, goal: None, path, best: f64::INFINITY, seen: f64::INFINITY, waiting, near }
    }

    /// One sample: a new node at the end of a step towards it, below the best parent around, and a better parent for its neighbours.
    fn grow(&mut self, q: Point, leg: &mut Leg) {
        let nearest = self.tree.near.nearest(q);
        let Some((p, _)) = leg.ground.steer(self.tree.point(nearest), q) else { return };
        // No path over p can be shorter than the best.
        if distance(self.ends[0], p) + distance(p, self.ends[1]) >= self.best {
            return;
        }
        let n = (self.tree.len() + 1) as f64;
        let area = if self.informed { leg.ground.area().min(self.ellipse.area(self.best)) } else { leg.ground.area() };
        let radius = (self.gamma * (area * n.ln() / n).sqrt()).min(leg.ground.step);
        let mut near = std::mem::take(&mut self.near);
        self.tree.near.within(p, radius, &mut near);
        near.sort_unstable();
        let parent = self.parent(p, nearest, &near, leg);
        let new = self.tree.add(p, parent);
        self.rewire(new, &near, leg);
        self.near = near;
        if p == self.ends[1] {
            self.goal = Some(new);
        } else if self.goal.is_none() && distance(p, self.ends[1]) <= leg.ground.step && leg.ground.free(p, self.ends[1]) {
            self.goal = Some(self.tree.add(self.ends[1], new));
        }
    }

    /// The node around `p` over which the way to it is shortest; the way from `nearest` is free.
    fn parent(&self, p: Point, nearest: usize, near: &[usize], leg: &mut Leg) -> usize {
        let over = |node: usize| self.tree.cost(node) + distance(self.tree.point(node), p);
        let known = over(nearest);
        let mut better: Vec<(f64, usize)> = near.iter().map(|&node| (over(node), node)).filter(|b| b.0 < known).collect();
        better.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        better.iter().find(|b| leg.ground.free(self.tree.point(b.1), p)).map_or(nearest, |b| b.1)
    }

    /// Hangs neighbours below the new node where that shortens their way.
    fn rewire(&mut self, new: usize, near: &[usize], leg: &mut Leg) {
        let (p, cost) = (self.tree.point(new), self.tree.cost(new));
        for &node in near {
            let q = self.tree.point(node);
            if cost + distance(p, q) < self.tree.cost(node) - 1e-12 && leg.ground.free(p, q) {
                self.tree.hang(node, new);
            }
        }
    }

    /// Takes over a better path of the tree, shortened where it is better by a thousandth.
    fn improve(&mut self, shortcuts: u32, leg: &mut Leg, ctx: &mut Context) {
        let Some(cost) = self.goal.map(|goal| self.tree.cost(goal)) else { return };
        let (better, much) = (cost < self.best, shortcuts > 0 && cost < self.seen * 0.999);
        if !better && !much {
            return;
        }
        let mut points = self.goal.map(|goal| self.tree.way(goal)).unwrap_or_default();
        if much {
            self.seen = cost;
            points = shorten(&points, shortcuts, &mut leg.ground, &mut ctx.rng);
        }
        let length = length(&points);
        if length < self.best {
            self.best = length;
            self.waiting = if much { points[1..].iter().copied().collect() } else { VecDeque::new() };
            self.path = points;
        }
    }
}
