//! The speed of a candidate: overspeed regions of its first pass, their correction by nodes, and the motion in the end.

use crate::context::Context;
use crate::error::PlanError;
use crate::path::Path;
use crate::plan::swarm::Curves;
use crate::query::Limits;
use crate::timing::{Bounds, Ceiling, Corrected, Method, Region, SpeedTrace, TimingOptions, Trajectory, correct, fastest, first_pass, regions, time};

/// Where a candidate is too fast, and what came of its correction.
pub(super) struct Speed {
    /// Overspeed regions of the first pass.
    pub found: Vec<Region>,
    /// What remains after correction.
    pub remaining: Vec<Region>,
    /// Nodes of the corrected profile, passes of the correction.
    pub nodes: usize,
    pub passes: u32,
}

/// Looks at the speed along a candidate (lines 3 to 11 of the loop).
pub(super) fn look(curves: &Curves, x: &[f64]) -> Result<Speed, PlanError> {
    let (path, limits) = (curves.path(x)?, curves.limits(x));
    let ceiling = Ceiling::of_path(&path, (0.0, path.length()), &limits, None);
    if let Ok(Corrected { nodes, passes, before, after, .. }) = correct(&ceiling, &Bounds::from(&limits), (0.0, 0.0)) {
        return Ok(Speed { found: before, remaining: after, nodes: nodes.len(), passes });
    }
    // A cusp of the curve: no node helps.
    let found = regions(&[(0.0, first_pass(path.length(), &limits)?)], &ceiling);
    Ok(Speed { remaining: found.clone(), found, nodes: 0, passes: 0 })
}

/// The motion of a candidate along its path, and its speed before and after for pictures.
pub(super) fn motion(curves: &Curves, x: &[f64], method: Method, ctx: &mut Context) -> Result<(Path, Trajectory, SpeedTrace), PlanError> {
    let (query, path, limits) = (curves.query(), curves.path(x)?, curves.limits(x));
    let options = TimingOptions { start_yaw: query.start_yaw, goal_yaw: query.goal_yaw, method, ..TimingOptions::default() };
    let trajectory = time(&path, &limits, &options, ctx)?;
    let trace = seen(&path, &limits, method)?;
    Ok((path, trajectory, trace))
}

fn seen(path: &Path, limits: &Limits, method: Method) -> Result<SpeedTrace, PlanError> {
    let ceiling = Ceiling::of_path(path, (0.0, path.length()), limits, None);
    let bounds = Bounds::from(limits);
    let after = if method == Method::Iascv { correct(&ceiling, &bounds, (0.0, 0.0))?.chain } else { fastest(&ceiling, &bounds, (0.0, 0.0))? };
    let mut trace = SpeedTrace::default();
    trace.add(0.0, 1.0, &ceiling, [&[(0.0, first_pass(path.length(), limits)?)], &after]);
    Ok(trace)
}
