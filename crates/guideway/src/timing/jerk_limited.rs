//! Timing of whole paths: turns in place where the heading jumps, a profile under the speed ceiling everywhere else.

use super::ceiling::Ceiling;
use super::correction::{Corrected, correct};
use super::method::{Method, Step, steps};
use super::scurve::{Bounds, Profile};
use super::trajectory::{Piece, Trajectory};
use super::turn::{SAME_HEADING, turn_time};
use super::{Timing, TimingOptions};
use crate::context::{Context, Stop};
use crate::error::PlanError;
use crate::path::Path;
use crate::query::Limits;
use crate::world::shape::wrap;

/// Times a path with limited jerk; the fields are those of [`TimingOptions`].
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct JerkLimited {
    /// Heading before the motion, rad; a turn in place leads to that of the path.
    pub start_yaw: Option<f64>,
    /// Heading after the motion, rad.
    pub goal_yaw: Option<f64>,
    /// Speed at the start, m/s.
    pub start_speed: f64,
    /// Speed at the end, m/s.
    pub end_speed: f64,
    /// How the speed is found.
    pub method: Method,
}

impl Timing for JerkLimited {
    fn time(&self, path: &Path, limits: &Limits, ctx: &mut Context) -> Result<Trajectory, PlanError> {
        let Self { start_yaw, goal_yaw, start_speed, end_speed, method } = *self;
        time(path, limits, &TimingOptions { start_yaw, goal_yaw, start_speed, end_speed, method, clearance_ceiling: None }, ctx)
    }
}

/// The motion along a planar path: at rest at both ends unless `options` say otherwise, stops only where the heading jumps.
///
/// Speed, acceleration, deceleration, jerk, lateral acceleration and turn rate keep their limits everywhere, not only at samples (the trapezoid has no limit of
/// jerk). Turns in place use 1 rad/s and 2 rad/s2 where the limits name nothing ([`super::DEFAULT_TURN_RATE`], [`super::DEFAULT_TURN_ACCELERATION`]).
/// # Errors
/// [`PlanError::BadParameter`] for bad limits or options, [`PlanError::Infeasible`] if boundary speeds do not fit, [`PlanError::Cancelled`].
pub fn time(path: &Path, limits: &Limits, options: &TimingOptions, ctx: &mut Context) -> Result<Trajectory, PlanError> {
    let bounds = Bounds::from(limits);
    compose(path, limits, options, ctx, &mut |from, ceiling, ends| options.method.stretch(from, &ceiling, &bounds, ends))
}

/// The loop on the speed of one stretch of a path.
#[derive(Debug, Clone)]
pub struct Loop {
    /// Arc length where the stretch begins, m.
    pub from: f64,
    /// Its ceiling.
    pub ceiling: Ceiling,
    /// What the loop made of it.
    pub corrected: Corrected,
}

/// The motion of [`Method::Iascv`] along a path, and the loop of each of its stretches between stops.
/// # Errors
/// As [`time`].
pub fn corrected(path: &Path, limits: &Limits, options: &TimingOptions, ctx: &mut Context) -> Result<(Trajectory, Vec<Loop>), PlanError> {
    let bounds = Bounds::from(limits);
    let mut loops = Vec::new();
    let trajectory = compose(path, limits, options, ctx, &mut |from, ceiling, ends| {
        let corrected = correct(&ceiling, &bounds, ends)?;
        let all = corrected.chain.iter().flat_map(|(s, profile)| steps(from + s, profile)).collect();
        loops.push(Loop { from, ceiling, corrected });
        Ok(all)
    })?;
    Ok((trajectory, loops))
}

/// Puts one stretch between stops into time: from its start (m) under its ceiling between its end speeds (m/s).
type Stretch<'a> = &'a mut dyn FnMut(f64, Ceiling, (f64, f64)) -> Result<Vec<Step>, PlanError>;

fn compose(path: &Path, limits: &Limits, options: &TimingOptions, ctx: &mut Context, stretch: Stretch) -> Result<Trajectory, PlanError> {
    let limits = limits.validated()?;
    options.validate(&limits)?;
    if path.dimension() != 2 {
        return Err(PlanError::bad("path.dimension", path.dimension(), "2: a planar path"));
    }
    let length = path.length();
    let mut out = Composer { limits, t: 0.0, pieces: Vec::new() };
    if length <= 0.0 {
        let turn = options.start_yaw.zip(options.goal_yaw);
        out.turn(0.0, turn.map_or(0.0, |(from, _)| from), turn.map_or(0.0, |(_, to)| to));
        return Ok(Trajectory { path: path.clone(), pieces: out.pieces, limits });
    }
    let corners = path.corners();
    let stops: Vec<f64> = std::iter::once(0.0).chain(corners.iter().map(|c| c.s)).chain([length]).collect();
    let (heading, last) = (path.planar(0.0).heading, path.planar(length).heading);
    let (start_yaw, goal_yaw) = (options.start_yaw.unwrap_or(heading), options.goal_yaw.unwrap_or(last));
    let turns_while_moving = options.start_speed > 0.0 && wrap(heading - start_yaw).abs() > SAME_HEADING
        || options.end_speed > 0.0 && wrap(goal_yaw - last).abs() > SAME_HEADING;
    if turns_while_moving {
        return Err(PlanError::Infeasible { reason: "a turn in place at an end where the speed is not zero".into(), best_end_speed: Some(0.0) });
    }
    out.turn(0.0, start_yaw, heading);
    for (i, pair) in stops.windows(2).enumerate() {
        if ctx.poll() == Some(Stop::Cancelled) {
            return Err(PlanError::Cancelled);
        }
        let ends = (if i == 0 { options.start_speed } else { 0.0 }, if i == corners.len() { options.end_speed } else { 0.0 });
        let extra = options.clearance_ceiling.map(|f| f as &dyn Fn(f64) -> f64);
        let ceiling = Ceiling::of_path(path, (pair[0], pair[1]), &limits, extra);
        require_passable(&ceiling, pair[0])?;
        out.along(&stretch(pair[0], ceiling, ends)?);
        if let Some(corner) = corners.get(i) {
            out.turn(corner.s, corner.heading_in, corner.heading_out);
        }
    }
    out.turn(length, last, goal_yaw);
    Ok(Trajectory { path: path.clone(), pieces: out.pieces, limits })
}

/// The motion along a path without corners that a chain of profiles, each with its start (m), describes.
pub fn composed(path: &Path, chain: &[(f64, Profile)], limits: &Limits) -> Trajectory {
    let mut out = Composer { limits: *limits, t: 0.0, pieces: Vec::new() };
    for (from, profile) in chain {
        out.along(&steps(*from, profile));
    }
    Trajectory { path: path.clone(), pieces: out.pieces, limits: *limits }
}

/// A ceiling of (nearly) zero is a cusp of the path, a heading or option that cannot be driven through.
fn require_passable(ceiling: &Ceiling, from: f64) -> Result<(), PlanError> {
    let slowest = |c: &f64| c.is_nan() || *c <= 1e-6;
    match ceiling.cells().iter().position(slowest) {
        None => Ok(()),
        Some(i) => {
            let s = from + ceiling.step() * (i as f64 + 0.5);
            let reason = format!("the speed ceiling falls to zero at arc length {s:.3} m (a cusp of the path, or no clearance there)");
            Err(PlanError::Infeasible { reason, best_end_speed: None })
        }
    }
}

/// Pieces in time order.
struct Composer {
    limits: Limits,
    t: f64,
    pieces: Vec<Piece>,
}

impl Composer {
    fn turn(&mut self, s: f64, from: f64, to: f64) {
        let turn = wrap(to - from);
        if turn.abs() > SAME_HEADING {
            let duration = turn_time(turn, &self.limits);
            self.pieces.push(Piece::Turn { turn, t: self.t, duration, s, from });
            self.t += duration;
        }
    }

    fn along(&mut self, steps: &[Step]) {
        for &Step { s, speed, acceleration, jerk, duration } in steps {
            self.pieces.push(Piece::Along { t: self.t, s, speed, acceleration, jerk, duration });
            self.t += duration;
        }
    }
}
