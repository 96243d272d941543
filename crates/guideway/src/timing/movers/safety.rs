//! Whether a motion keeps its distance to movers, and whether it can be broken off.

use super::Among;
use crate::Point;
use crate::error::PlanError;
use crate::path::Path;
use crate::query::Limits;
use crate::timing::Piece;
use crate::timing::scurve::{Bounds, State1, advance, transition};
use crate::world::{Appears, Mover};

/// Intervals shorter than this are not halved again, s: what is not proved by then counts as too near.
const MOMENT: f64 = 1e-4;
/// Spacing of the states from which a brake is tried, s, and the places looked at along a brake.
const BRAKES: (f64, usize) = (0.05, 4);

/// Spacing of the places (m) and moments (s) that are looked at for a place that is never free.
const PLACES: f64 = 0.05;
const MOMENTS: f64 = 0.1;

/// The judge of motions.
pub(super) struct Safety<'a> {
    pub path: &'a Path,
    pub limits: Limits,
    pub around: Among<'a>,
}

/// Where and when a motion is too near to a mover.
#[derive(Debug, Clone, Copy)]
pub(super) struct Meeting {
    mover: usize,
    s: f64,
    t: f64,
}

/// Arc length (m), speed (m/s), acceleration (m/s2).
type Kinetic = (f64, f64, f64);

/// State `x` seconds after the start of pieces whose own times begin anywhere.
pub(super) fn state(pieces: &[Piece], x: f64) -> Kinetic {
    let Some(first) = pieces.first() else { return (0.0, 0.0, 0.0) };
    let t = first.start() + x;
    match &pieces[pieces.partition_point(|p| p.start() <= t).saturating_sub(1)] {
        Piece::Along { t: from, s, speed, acceleration, jerk, duration } => {
            advance((*s, *speed, *acceleration), *jerk, (t - from).clamp(0.0, *duration))
        }
        Piece::Turn { s, .. } => (*s, 0.0, 0.0),
    }
}

/// Total time of pieces, s.
pub(super) fn duration(pieces: &[Piece]) -> f64 {
    pieces.first().zip(pieces.last()).map_or(0.0, |(a, b)| b.start() + b.duration() - a.start())
}

impl Safety<'_> {
    fn point(&self, s: f64) -> Point {
        self.path.planar(s.clamp(0.0, self.path.length())).point
    }

    /// The mover that comes too near to a point at rest between two times (s), if any; `reach` (m) more is kept.
    fn nearby(&self, p: Point, (t0, t1): (f64, f64), reach: f64) -> Option<usize> {
        let near = |mover: &Mover| match mover.appears {
            Some(Appears::At(from)) if t1 < from => false,
            Some(Appears::At(from)) => mover.least_distance(p, t0.max(from), t1) < self.around.radius + reach,
            _ => mover.least_distance(p, t0, t1) < self.around.radius + reach,
        };
        self.around.movers.iter().position(near)
    }

    /// Whether a robot at rest at `s` (m) is left alone between two times (s).
    pub fn rests(&self, s: f64, span: (f64, f64)) -> bool {
        self.nearby(self.point(s), span, 0.0).is_none()
    }

    /// A place on the path that is never free at the moments looked at until the horizon (s): no motion passes it.
    pub fn closed(&self, horizon: f64) -> Option<Meeting> {
        let places = (self.path.length() / PLACES).ceil().max(1.0) as usize;
        let moments = (horizon / MOMENTS).ceil() as usize;
        (0..=places).find_map(|k| {
            let s = self.path.length() * k as f64 / places as f64;
            let p = self.point(s);
            // Half a step apart from a moment, a mover is nearer by no more than its way since.
            let taken = |k: usize| self.nearby(p, (MOMENTS * k as f64, MOMENTS * k as f64), -0.5 * MOMENTS * self.top_speed());
            let mover = taken(0)?;
            (1..=moments).all(|k| taken(k).is_some()).then_some(Meeting { mover, s, t: horizon })
        })
    }

    fn top_speed(&self) -> f64 {
        self.around.movers.iter().map(Mover::top_speed).fold(0.0, f64::max)
    }

    /// Where pieces that begin at time `start` (s) first fail, `None` if nowhere.
    pub fn meeting(&self, pieces: &[Piece], start: f64) -> Option<Meeting> {
        let total = duration(pieces);
        // Most motions that fail do so at one of a few instants.
        let n = 8;
        let instants = (0..=n).map(|k| total * f64::from(k) / f64::from(n));
        let quick = instants.into_iter().find_map(|x| {
            let s = state(pieces, x).0;
            self.nearby(self.point(s), (start + x, start + x), 0.0).map(|mover| Meeting { mover, s, t: start + x })
        });
        quick.or_else(|| self.too_near(pieces, start, (0.0, total))).or_else(|| self.stranded(pieces, start, total))
    }

    /// By halves: the middle of an interval, the motion around it, and the course of every mover.
    fn too_near(&self, pieces: &[Piece], start: f64, (from, to): (f64, f64)) -> Option<Meeting> {
        let middle = 0.5 * (from + to);
        let at = |x: f64| state(pieces, x).0;
        let (first, s, last) = (at(from), at(middle), at(to));
        let p = self.point(s);
        let slack = (s - first).max(last - s).max(0.0);
        let mover = self.nearby(p, (start + from, start + to), slack)?;
        if to - from < MOMENT || self.nearby(p, (start + middle, start + middle), 0.0).is_some() {
            return Some(Meeting { mover, s, t: start + middle });
        }
        self.too_near(pieces, start, (from, middle)).or_else(|| self.too_near(pieces, start, (middle, to)))
    }

    /// A state from which a brake would not end in time.
    fn stranded(&self, pieces: &[Piece], start: f64, total: f64) -> Option<Meeting> {
        if !self.around.passive {
            return None;
        }
        let n = (total / BRAKES.0).ceil().max(1.0) as usize;
        (0..n).find_map(|k| self.brake(pieces, start, total * k as f64 / n as f64))
    }

    /// A brake called for `x` seconds after the start: the motion goes on for the latency, then comes to rest as fast as it can. Seen from now, every mover may
    /// go anywhere at its top speed.
    fn brake(&self, pieces: &[Piece], start: f64, x: f64) -> Option<Meeting> {
        let now = start + x;
        let (s, v, a) = state(pieces, x + self.around.latency);
        let profile = transition(State1 { v, a }, State1 { v: 0.0, a: 0.0 }, &Bounds::from(&self.limits))?;
        let time = profile.duration();
        (1..=BRAKES.1).find_map(|k| {
            let part = time * k as f64 / BRAKES.1 as f64;
            let s = s + profile.at(part).0;
            let p = self.point(s);
            let within = |m: &Mover| m.distance(p, now) - m.top_speed() * (self.around.latency + part) < self.around.radius;
            let present = |m: &Mover| !matches!(m.appears, Some(Appears::At(from)) if from > now + self.around.latency + part);
            // A robot that has come to rest where it stands has done what it can.
            let mover = self.around.movers.iter().position(|m| v > 0.0 && present(m) && within(m))?;
            Some(Meeting { mover, s, t: now })
        })
    }

    /// The error where there is no motion.
    pub fn hopeless(&self, meeting: &Meeting, horizon: f64) -> PlanError {
        let [x, y] = self.point(meeting.s);
        if meeting.t >= horizon {
            let reason = format!(
                "mover {} and others are in the way near ({x:.3}, {y:.3}), arc length {:.3} m, at all times up to {horizon:.0} s: this path is closed for a robot that \
                 keeps {:.3} m to movers",
                meeting.mover + 1,
                meeting.s,
                self.around.radius
            );
            return PlanError::Infeasible { reason, best_end_speed: None };
        }
        let reason = format!(
            "mover {} is in the way near ({x:.3}, {y:.3}), arc length {:.3} m, at {:.2} s, and no motion along this path that waits or slows down was found that keeps \
             {:.3} m to all movers within {horizon:.0} s",
            meeting.mover + 1,
            meeting.s,
            meeting.t,
            self.around.radius
        );
        PlanError::Infeasible { reason, best_end_speed: None }
    }
}
