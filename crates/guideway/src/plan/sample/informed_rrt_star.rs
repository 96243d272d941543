//! Informed RRT*: RRT* that, once it has a path, samples only the ellipse in which a shorter one may run.
//!
//! Source: \[gammell2014\]. Departures: those of RRT*; the ellipse is used once it is smaller than the world.

use super::star::Star;
use crate::Point;
use crate::context::Context;
use crate::error::PlanError;
use crate::plan::{Planner, Solution};
use crate::query::Query;
use crate::world::shape::distance;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};
use std::f64::consts::{PI, TAU};

/// A short path by Informed RRT*.
///
/// `trace.tree` has edges of the tree, [x, y, x of the parent, y of the parent] in m, 3000 a leg at most.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct InformedRrtStar(pub Star);

impl InformedRrtStar {
    /// As in the source.
    pub fn paper() -> Self {
        Self(Star::paper())
    }
}

impl Planner for InformedRrtStar {
    fn plan(&self, query: &Query, ctx: &mut Context) -> Result<Solution, PlanError> {
        self.0.solve(true, query, ctx)
    }
}

/// Ellipses with the ends of a leg as foci: a path of length `c` stays in that of diameter `c`.
pub(super) struct Ellipse {
    ends: [Point; 2],
    least: f64,
}

impl Ellipse {
    pub fn new(ends: [Point; 2]) -> Self {
        Self { ends, least: distance(ends[0], ends[1]) }
    }

    /// Length of the straight line, m.
    pub fn least(&self) -> f64 {
        self.least
    }

    /// The half axes at diameter `c`, m.
    fn axes(&self, c: f64) -> [f64; 2] {
        [0.5 * c, 0.5 * (c * c - self.least * self.least).max(0.0).sqrt()]
    }

    /// Area at diameter `c`, m2.
    pub fn area(&self, c: f64) -> f64 {
        let [a, b] = self.axes(c);
        PI * a * b
    }

    /// A point, uniformly from the ellipse of diameter `c`.
    pub fn draw(&self, c: f64, rng: &mut ChaCha8Rng) -> Point {
        let [a, b] = self.axes(c);
        let (r, turn) = (rng.random::<f64>().sqrt(), TAU * rng.random::<f64>());
        let (x, y) = (a * r * turn.cos(), b * r * turn.sin());
        let [from, to] = self.ends;
        let u = if self.least > 0.0 { [(to[0] - from[0]) / self.least, (to[1] - from[1]) / self.least] } else { [1.0, 0.0] };
        [f64::midpoint(from[0], to[0]) + u[0] * x - u[1] * y, f64::midpoint(from[1], to[1]) + u[1] * x + u[0] * y]
    }
}
