//! The motion of all axes.

use super::{Axis, AxisLimits, AxisState};
use crate::error::PlanError;
use crate::timing::scurve::{Phase, advance};

/// Position, velocity, acceleration and jerk of one axis.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct AxisSample {
    /// Position, m or rad.
    pub position: f64,
    /// Velocity, per s.
    pub velocity: f64,
    /// Acceleration, per s2.
    pub acceleration: f64,
    /// Jerk, per s3.
    pub jerk: f64,
}

/// A stretch of constant jerk.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AxisPiece {
    /// s, > 0.
    pub duration: f64,
    /// Per s3.
    pub jerk: f64,
    /// State where it begins.
    pub start: AxisState,
}

impl AxisPiece {
    /// State `t` seconds after its begin.
    #[inline]
    fn after(&self, t: f64) -> AxisState {
        let AxisState { position, velocity, acceleration } = self.start;
        let (position, velocity, acceleration) = advance((position, velocity, acceleration), self.jerk, t);
        AxisState { position, velocity, acceleration }
    }
}

/// The state after some phases, with the pieces they make. An acceleration that is kept is exactly zero or at its limit where it is
/// so but for rounding.
pub(super) fn flown(start: AxisState, phases: impl Iterator<Item = Phase>, limits: &AxisLimits, mut each: impl FnMut(AxisPiece)) -> AxisState {
    let (mut state, mut strongest) = (start, 0.0f64);
    for Phase { duration, jerk } in phases.filter(|p| p.duration > 0.0) {
        strongest = strongest.max(state.acceleration.abs());
        if jerk == 0.0 {
            let kept = [0.0, limits.acceleration.0, limits.acceleration.1];
            let near = kept.into_iter().find(|a| (a - state.acceleration).abs() <= ROUNDED * strongest);
            state.acceleration = near.unwrap_or(state.acceleration);
        }
        let piece = AxisPiece { duration, jerk, start: state };
        state = piece.after(duration);
        each(piece);
    }
    state
}

/// The motion of one axis.
#[derive(Debug, Clone, PartialEq)]
pub struct AxisMotion {
    /// State at the start.
    pub start: AxisState,
    /// State at its end; for a goal without position that position follows from the motion.
    pub end: AxisState,
    /// Its pieces in order, each from where the one before ends. Each brings its own start, so that a cruise has no acceleration at
    /// all rather than what rounding leaves of it.
    pub pieces: Vec<AxisPiece>,
    /// Its own duration, s.
    pub duration: f64,
}

/// Differences below this share of the largest value are rounding.
const ROUNDED: f64 = 1e-12;

impl AxisMotion {
    pub(super) fn new(axis: &Axis, phases: impl Iterator<Item = Phase>, duration: f64) -> Self {
        let mut pieces = Vec::with_capacity(8);
        let state = flown(axis.start, phases, &axis.limits, |piece| pieces.push(piece));
        let goal = &axis.goal;
        match goal.position {
            Some(wanted) => settle(&mut pieces, wanted - state.position),
            None => settle_velocity(&mut pieces, goal.velocity - state.velocity),
        }
        let reached = pieces.last().map_or(axis.start, |p| p.after(p.duration)).position;
        let end = AxisState { position: goal.position.unwrap_or(reached), velocity: goal.velocity, acceleration: goal.acceleration };
        Self { start: axis.start, end, pieces, duration }
    }

    /// An axis that takes no part: it stays where it is.
    pub(super) fn idle(position: f64) -> Self {
        let rest = AxisState { position, velocity: 0.0, acceleration: 0.0 };
        Self { start: rest, end: rest, pieces: Vec::new(), duration: 0.0 }
    }

    /// State at time `t` (s) from the start on; after its end the axis goes on at its goal velocity.
    pub fn at(&self, t: f64) -> AxisSample {
        let mut left = t.max(0.0);
        if t < self.duration {
            for piece in &self.pieces {
                if left < piece.duration {
                    let AxisState { position, velocity, acceleration } = piece.after(left);
                    return AxisSample { position, velocity, acceleration, jerk: piece.jerk };
                }
                left -= piece.duration;
            }
        }
        let AxisState { position, velocity, acceleration } = self.end;
        let late = (t - self.duration).max(0.0);
        AxisSample { position: position + late * velocity, velocity, acceleration: if late > 0.0 { 0.0 } else { acceleration }, jerk: 0.0 }
    }

    /// The goal is met, to 1e-9 of the way and of the speeds on it.
    fn met(&self, jerk: f64) -> Result<(), String> {
        let last = self.pieces.last().map_or(self.start, |p| p.after(p.duration));
        let mut size = [self.start.position.abs() + self.end.position.abs(), last.velocity.abs(), last.acceleration.abs()];
        for AxisPiece { duration: t, jerk, start: AxisState { velocity, acceleration, .. } } in &self.pieces {
            let (_, v, a) = advance((0.0, velocity.abs(), acceleration.abs()), jerk.abs(), *t);
            size = [size[0] + v * t, size[1].max(v), size[2].max(a)];
        }
        size[1] = size[1].max(size[2] * size[2] / jerk);
        let end = &self.end;
        let off = [last.position - end.position, last.velocity - end.velocity, last.acceleration - end.acceleration];
        for (what, (off, size)) in ["position", "velocity", "acceleration"].into_iter().zip(off.into_iter().zip(size)) {
            // A NaN is not met either.
            if off.is_nan() || off.abs() > 1e-9 * size + 1e-15 {
                return Err(format!("the {what} at the end is off by {off:e}"));
            }
        }
        Ok(())
    }
}

/// Makes good for what rounding has moved the end: a long cruise multiplies the rounding of its velocity, so that is where it belongs.
fn settle(pieces: &mut [AxisPiece], off: f64) {
    let cruises = pieces.iter().enumerate().filter(|(_, p)| p.jerk == 0.0 && p.start.acceleration == 0.0);
    let Some(longest) = cruises.max_by(|(_, p), (_, q)| p.duration.total_cmp(&q.duration)).map(|(i, _)| i) else { return };
    let fastest = pieces.iter().fold(0.0, |v: f64, p| v.max(p.start.velocity.abs()));
    let change = off / pieces[longest].duration;
    if change.abs() <= ROUNDED * fastest {
        pieces[longest].start.velocity += change;
        pieces[longest + 1..].iter_mut().for_each(|p| p.start.position += off);
    }
}

/// The same for a goal without position: the longest hold of an acceleration takes what rounding has moved the velocity.
fn settle_velocity(pieces: &mut [AxisPiece], off: f64) {
    let holds = pieces.iter().enumerate().filter(|(_, p)| p.jerk == 0.0);
    let Some(longest) = holds.max_by(|(_, p), (_, q)| p.duration.total_cmp(&q.duration)).map(|(i, _)| i) else { return };
    let strongest = pieces.iter().fold(0.0, |a: f64, p| a.max(p.start.acceleration.abs()));
    let change = off / pieces[longest].duration;
    if change.abs() <= ROUNDED * strongest {
        pieces[longest].start.acceleration += change;
        let mut position = pieces[longest].after(pieces[longest].duration).position;
        for piece in &mut pieces[longest + 1..] {
            piece.start = AxisState { position, velocity: piece.start.velocity + off, ..piece.start };
            position = piece.after(piece.duration).position;
        }
    }
}

/// The motion of several axes.
#[derive(Debug, Clone, PartialEq)]
pub struct Motion {
    /// One motion per axis.
    pub axes: Vec<AxisMotion>,
    /// The longest of their durations, s.
    pub duration: f64,
    /// All axes move on one straight line.
    pub straight: bool,
}

impl Motion {
    /// # Errors
    /// [`PlanError::CertificateFailed`] if an axis misses its goal.
    pub(super) fn new(axes: Vec<AxisMotion>, asked: &[Axis], straight: bool) -> Result<Self, PlanError> {
        for (i, (axis, asked)) in axes.iter().zip(asked).enumerate() {
            axis.met(asked.limits.jerk)
                .map_err(|detail| PlanError::CertificateFailed { stage: "point-to-point motion", detail: format!("axis {i}: {detail}") })?;
        }
        let duration = axes.iter().fold(0.0, |longest: f64, a| longest.max(a.duration));
        Ok(Self { axes, duration, straight })
    }

    /// State of every axis at time `t` (s), clamped to the motion.
    pub fn at(&self, t: f64) -> Vec<AxisSample> {
        let t = t.clamp(0.0, self.duration);
        self.axes.iter().map(|axis| axis.at(t)).collect()
    }
}
