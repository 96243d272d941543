//! How candidates of an optimizer become lattice paths, and what those cost.

use super::guided_walk::{Gait, Ground, Scratch};
use super::{prune, way_points};
use crate::context::Context;
use crate::error::PlanError;
use crate::optimize::{Cost, Objective};
use crate::plan::legs::Leg;
use crate::plan::score::{Aim, Score};
use crate::world::Cell;
use serde::{Deserialize, Serialize};
use std::time::Instant;

/// What a candidate's numbers mean.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Encoding {
    /// Turns of a guided walk.
    #[default]
    Walk,
    /// Points joined by straight lines.
    WayPoints,
    /// Control points of a spline: a continuous planner, not one on the lattice; the other fields of [`Decoding`] mean nothing then.
    Spline,
}

/// From a candidate to a path. Parameters that all swarm planners share.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
#[expect(clippy::struct_excessive_bools, reason = "independent switches, one for each ablation")]
pub struct Decoding {
    /// What the numbers mean.
    pub encoding: Encoding,
    /// Keys `D` of a walk, 1 to 10000.
    pub keys: usize,
    /// Points `K` of the other encoding, 1 to 1000.
    pub points: usize,
    /// Largest number of steps of a walk, in larger sides of the map; 0: as many as it takes, so that a walk finds a path wherever there is one.
    pub walk_limit: f64,
    /// On long legs a key steers several steps, so that the keys reach from start to goal; otherwise one, and keys come again.
    pub stretch: bool,
    /// Cut loops of a walk.
    pub cut: bool,
    /// The walk straight at the goal (all keys 0) is in the first population.
    pub straight: bool,
    /// Any-angle path: drops way points that the robot can pass by in a straight line. Such a path has no cells.
    pub prune: bool,
}

impl Default for Decoding {
    fn default() -> Self {
        Self { encoding: Encoding::Walk, keys: 40, points: 6, walk_limit: 0.0, stretch: true, cut: true, straight: true, prune: false }
    }
}

impl Decoding {
    /// As the comparison has it: walks of at most 6 sides, a step per key, nothing given.
    pub fn paper() -> Self {
        Self { walk_limit: 6.0, stretch: false, straight: false, ..Self::default() }
    }

    fn check(&self) -> Result<(), PlanError> {
        if !(1..=10_000).contains(&self.keys) {
            return Err(PlanError::bad("keys", self.keys, "1 to 10000"));
        }
        if !(1..=1000).contains(&self.points) {
            return Err(PlanError::bad("points", self.points, "1 to 1000"));
        }
        if !(self.walk_limit >= 0.0 && self.walk_limit.is_finite()) {
            return Err(PlanError::bad("walk_limit", self.walk_limit, "a number of sides, 0 for no limit"));
        }
        Ok(())
    }

    /// How walks go on a leg.
    pub(super) fn gait(&self, leg: &Leg) -> Gait {
        let side = f64::from(leg.lattice.width().max(leg.lattice.height()));
        let limit = if self.walk_limit == 0.0 { u64::MAX } else { (self.walk_limit * side) as u64 };
        let steps = leg.start[0].abs_diff(leg.goal[0]).max(leg.start[1].abs_diff(leg.goal[1]));
        // A walk round obstacles takes more steps than the straight one.
        let stride = if self.stretch { (steps + steps / 4).div_ceil(self.keys as u32).max(1) } else { 1 };
        Gait { limit, stride, cut: self.cut }
    }
}

/// The cost of candidates on a leg.
pub(super) struct Judge<'a> {
    pub leg: &'a Leg<'a>,
    pub ground: Ground<'a>,
    pub aim: Aim,
    pub gait: Gait,
    decoding: &'a Decoding,
    bounds: Vec<(f64, f64)>,
    hints: Vec<Vec<f64>>,
    effort: f64,
}

/// What a step through an obstacle costs in the way point encoding, cells.
const CROSSING: f64 = 100.0;

impl<'a> Judge<'a> {
    pub fn new(leg: &'a Leg<'a>, decoding: &'a Decoding, aim: Aim) -> Result<Self, PlanError> {
        decoding.check()?;
        let walk = decoding.encoding == Encoding::Walk;
        let size = if walk { decoding.keys } else { 2 * decoding.points };
        let hints = if walk && decoding.straight { vec![vec![0.0; size]] } else { Vec::new() };
        let ground = Ground::new(leg.lattice, leg.query.corners);
        Ok(Self { leg, ground, aim, gait: decoding.gait(leg), decoding, bounds: vec![(-1.0, 1.0); size], hints, effort: 1.0 })
    }

    /// The walk straight at the goal, if it arrives; its time tells what a candidate takes.
    pub fn probe(&mut self, ctx: &mut Context) -> Option<Vec<Cell>> {
        let mut scratch = self.leg.lattice.pool().take::<Scratch>();
        let begun = Instant::now();
        let arrived = self.ground.walk([self.leg.start, self.leg.goal], &[0.0], self.gait, &mut scratch);
        self.effort = begun.elapsed().as_secs_f64() * 1e6;
        ctx.count_evaluations(1);
        let cells = arrived.then(|| scratch.cells.clone());
        self.leg.lattice.pool().give(scratch);
        cells
    }

    /// The cells of a candidate's path, if it is one.
    pub fn decode(&self, x: &[f64]) -> Option<Vec<Cell>> {
        let mut scratch = self.leg.lattice.pool().take::<Scratch>();
        let cells = self.draw(x, &mut scratch).feasible().then(|| scratch.cells.clone());
        self.leg.lattice.pool().give(scratch);
        cells
    }

    /// Way points of the any-angle path along those cells, and its worth.
    pub fn pruned(&self, cells: &[Cell]) -> (Vec<Cell>, Score) {
        let points = prune::pull(self.leg, cells);
        let score = self.aim.score(prune::length(&points), points.len().saturating_sub(2) as u32);
        (points, score)
    }

    /// Leaves a candidate's path in the scratch and gives back its cost.
    fn draw(&self, x: &[f64], scratch: &mut Scratch) -> Cost {
        let ends = [self.leg.start, self.leg.goal];
        let side = f64::from(self.leg.lattice.width().max(self.leg.lattice.height()));
        let broken = match self.decoding.encoding {
            Encoding::Walk => u64::from(!self.ground.walk(ends, x, self.gait, scratch)),
            Encoding::WayPoints | Encoding::Spline => way_points::draw(&self.ground, ends, x, scratch),
        };
        match self.decoding.encoding {
            _ if broken == 0 => self.worth(&scratch.cells),
            Encoding::Walk => Cost { violation: 1.0, value: 10.0 * side, tie: 0.0 },
            Encoding::WayPoints | Encoding::Spline => {
                let crossings = broken as f64;
                Cost { violation: crossings, value: self.aim.of_cells(&scratch.cells).cost + CROSSING * crossings, tie: 0.0 }
            }
        }
    }

    /// Cost of a path.
    pub fn worth(&self, cells: &[Cell]) -> Cost {
        let score = if self.decoding.prune { self.pruned(cells).1 } else { self.aim.of_cells(cells) };
        Cost { violation: 0.0, value: score.cost, tie: f64::from(score.turns) }
    }
}

impl Objective for Judge<'_> {
    fn bounds(&self) -> &[(f64, f64)] {
        &self.bounds
    }

    fn costs(&self, xs: &[Vec<f64>]) -> Result<Vec<Cost>, PlanError> {
        let mut scratch = self.leg.lattice.pool().take::<Scratch>();
        let costs = xs.iter().map(|x| self.draw(x, &mut scratch)).collect();
        self.leg.lattice.pool().give(scratch);
        Ok(costs)
    }

    fn hints(&self) -> &[Vec<f64>] {
        &self.hints
    }

    fn effort(&self) -> f64 {
        self.effort
    }

    /// Length of the route up to the goal of this leg, m (or its energy in cells of travel, in m).
    fn shown(&self, cost: Cost) -> f64 {
        if cost.feasible() { self.leg.before + cost.value * self.leg.lattice.resolution() } else { f64::INFINITY }
    }
}
