//! The speed of a candidate: overspeed regions of its first pass, their correction by nodes, and the motion in the end.

use crate::context::Context;
use crate::error::PlanError;
use crate::path::Path;
use crate::plan::swarm::Curves;
use crate::query::{Limits, Query};
use crate::timing::{
    Bounds, Ceiling, Corrected, Method, Region, SpeedTrace, TimingOptions, Trajectory, composed, correct, fastest, first_pass, regions, time,
};

/// A ceiling as low as that is a cusp, m/s.
const CUSP: f64 = 1e-6;

/// The path of a candidate with its limits and speed ceiling.
pub(super) struct Track {
    x: Vec<f64>,
    pub path: Path,
    limits: Limits,
    ceiling: Ceiling,
}

/// Where a candidate is too fast, and what came of its correction.
#[derive(Debug, Clone)]
pub(super) struct Speed {
    /// Overspeed regions of the first pass.
    pub found: Vec<Region>,
    /// What remains after correction.
    pub remaining: Vec<Region>,
    /// Nodes of the corrected profile, passes of the correction.
    pub nodes: usize,
    pub passes: u32,
}

impl Track {
    pub fn new(curves: &Curves, x: &[f64]) -> Result<Self, PlanError> {
        let (path, limits) = (curves.path(x)?, curves.limits(x));
        let ceiling = Ceiling::of_path(&path, (0.0, path.length()), &limits, None);
        Ok(Self { x: x.to_vec(), path, limits, ceiling })
    }

    /// Is it that of this candidate?
    pub fn is_of(&self, x: &[f64]) -> bool {
        self.x == x
    }

    /// Looks at the speed (lines 3 to 11 of the loop).
    pub fn look(&self) -> Result<Speed, PlanError> {
        if let Ok(Corrected { nodes, passes, before, after, .. }) = correct(&self.ceiling, &Bounds::from(&self.limits), (0.0, 0.0)) {
            return Ok(Speed { found: before, remaining: after, nodes: nodes.len(), passes });
        }
        // A cusp of the curve: no node helps.
        let found = regions(&[(0.0, first_pass(self.path.length(), &self.limits)?)], &self.ceiling);
        Ok(Speed { remaining: found.clone(), found, nodes: 0, passes: 0 })
    }

    /// The motion, and its speed before and after for pictures.
    pub fn motion(&self, query: &Query, method: Method, ctx: &mut Context) -> Result<(Trajectory, SpeedTrace), PlanError> {
        let Self { path, limits, ceiling, .. } = self;
        let bounds = Bounds::from(limits);
        let passable = ceiling.cells().iter().all(|c| *c > CUSP);
        let after = match method {
            _ if !passable => Vec::new(),
            Method::Iascv => correct(ceiling, &bounds, (0.0, 0.0))?.chain,
            Method::TimeOptimal | Method::Trapezoid => fastest(ceiling, &bounds, (0.0, 0.0))?,
        };
        let plain = query.start_yaw.is_none() && query.goal_yaw.is_none() && method != Method::Trapezoid && path.corners().is_empty();
        let trajectory = if plain && passable {
            composed(path, &after, limits)
        } else {
            let options = TimingOptions { start_yaw: query.start_yaw, goal_yaw: query.goal_yaw, method, ..TimingOptions::default() };
            time(path, limits, &options, ctx)?
        };
        let mut trace = SpeedTrace::default();
        trace.add(0.0, 1.0, ceiling, [&[(0.0, first_pass(path.length(), limits)?)], &after]);
        Ok((trajectory, trace))
    }
}
