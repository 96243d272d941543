//! Movers as a search asks for them again and again: outline and top speed worked out once.

use crate::Point;
use crate::world::shape::{Shape, dot, sub};
use crate::world::{Appears, Loop, Mover};

/// Least step of time where a walk along a course would stand still, s: two moments that close are one.
const TICK: f64 = 1e-9;

/// One mover on its course.
pub(super) struct Course<'a> {
    pub mover: &'a Mover,
    outline: Shape,
    /// No corner of the outline is farther from its origin, m.
    pub reach: f64,
    /// Top speed along its track, m/s.
    pub speed: f64,
    /// Not present before, s.
    pub from: f64,
    /// Time of the track (s) after which it jumps back to its start, if it does.
    jump: Option<f64>,
}

impl<'a> Course<'a> {
    pub fn new(mover: &'a Mover) -> Self {
        let from = if let Some(Appears::At(t)) = mover.appears { t } else { 0.0 };
        let ends = mover.track.first().zip(mover.track.last()).filter(|(a, b)| a[1..] != b[1..]);
        let jump = ends.filter(|_| mover.repeat == Loop::Cycle).map(|(_, last)| last[0]);
        Self { mover, outline: mover.outline(), reach: mover.shape.circumscribed(), speed: mover.top_speed(), from, jump }
    }

    /// Signed distance from `p` (m) to the outline at time `t` (s), m.
    pub fn distance(&self, p: Point, t: f64) -> f64 {
        let apart = sub(p, self.mover.at(t).0);
        // A root is much cheaper than a hypotenuse that never overflows.
        if let Shape::Disc { radius, .. } = self.outline { dot(apart, apart).sqrt() - radius } else { self.outline.distance(apart) }
    }

    /// Where the mover is at time `t` (s), m.
    pub fn at(&self, t: f64) -> Point {
        self.mover.at(t).0
    }

    /// The point at rest is at least that far from the mover between two times (s), m, or the mover jumps.
    pub fn far(&self, p: Point, t0: f64, t1: f64) -> f64 {
        if self.jump.is_some() { f64::NEG_INFINITY } else { self.distance(p, 0.5 * (t0 + t1)) - 0.5 * (t1 - t0) * self.speed }
    }

    /// Whether it is there at that time (s) or before.
    pub fn present(&self, until: f64) -> bool {
        until >= self.from
    }

    /// The times (s) up to `horizon` at which a point at rest may be nearer than `radius` (m): none is left out, and they are too long by less than
    /// `moment` (s) at either end of each.
    pub fn times(&self, p: Point, radius: f64, horizon: f64, moment: f64) -> Vec<[f64; 2]> {
        let mut out: Vec<[f64; 2]> = Vec::new();
        let mut t = self.from;
        while t <= horizon {
            let apart = self.distance(p, t) - radius;
            // So long the mover needs to change from free to not free or back.
            let sure = apart.abs() / self.speed;
            let until = self.before_a_jump(t, t + if sure.is_nan() { 0.0 } else { sure }.max(moment)).min(horizon + TICK);
            if apart <= 0.0 || sure < moment {
                match out.last_mut() {
                    Some(last) if last[1] >= t => last[1] = until,
                    _ => out.push([t, until]),
                }
            }
            t = until.max(t + TICK);
        }
        out
    }

    /// The earlier of `until` and the next jump after `t`, s.
    fn before_a_jump(&self, t: f64, until: f64) -> f64 {
        let Some(period) = self.jump else { return until };
        let tau = (t + self.mover.phase).rem_euclid(period);
        until.min(t + period - tau)
    }
}
