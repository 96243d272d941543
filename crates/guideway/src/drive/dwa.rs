//! The classic dynamic window approach.
//!
//! Source: \[fox1997\]. `V_s`: limits of the base; `V_d`: what can be reached within a period; `V_a`: what can still be stopped before the first
//! contact on the arc. The best of `heading`, `dist` and `velocity`, each divided by its sum over the candidates, is driven.
//! Departures: the angular bound uses the arc's own angle, not metres; contacts are those of the footprint's discs, and include movers at constant
//! velocity, in (arc, time); the distance driven during the reaction time is taken off the free distance; the target is a point of the planned path
//! ahead (`look_ahead`; infinite means the goal itself, as in the source); speed is limited so that the base can stop at the goal.

use super::body::Body;
use super::critics::{Candidate, Weights};
use super::field::{Field, Margins, Met};
use super::filter::Filter;
use super::{Command, Controller, Course, Decision, Guide, Observation, Reason, Robot, Setup, arc};
use crate::context::Context;
use crate::error::PlanError;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// Distance to the end of the path that counts as there, and beside it, m; farther beside it a new plan is asked for.
const THERE: f64 = 0.03;
const BESIDE: f64 = 0.1;

/// Parameters of the dynamic window.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Dwa {
    /// Weight of the heading to the target.
    pub heading: f64,
    /// Weight of the free distance along the arc.
    pub dist: f64,
    /// Weight of the speed.
    pub velocity: f64,
    /// Time in which a new speed must be reached, s.
    pub period: f64,
    /// Prediction, s.
    pub horizon: f64,
    /// Time that passes before braking begins, s.
    pub reaction: f64,
    /// Sampled speeds.
    pub speeds: u32,
    /// Sampled turn rates.
    pub turns: u32,
    /// Distance kept to obstacles, m.
    pub safety: f64,
    /// Is `safety` measured from the reference point, not from the hull?
    pub centred: bool,
    /// The target is so far ahead on the path, m.
    pub look_ahead: f64,
    /// Trust in each observed pose against odometry, 0 to 1.
    pub trust: f64,
    /// Time without progress after which a new plan is asked for, s.
    pub patience: f64,
}

impl Default for Dwa {
    fn default() -> Self {
        Self {
            heading: 2.0,
            dist: 0.2,
            velocity: 0.2,
            period: 0.1,
            horizon: 3.0,
            reaction: 0.15,
            speeds: 11,
            turns: 21,
            safety: 0.05,
            centred: false,
            look_ahead: 1.0,
            trust: 0.2,
            patience: 6.0,
        }
    }
}

impl Dwa {
    /// The controller for a robot in a world.
    /// # Errors
    /// [`PlanError::BadParameter`] for a parameter out of range.
    pub fn build(self, setup: &Setup) -> Result<Box<dyn Controller>, PlanError> {
        let named = [
            ("heading", self.heading),
            ("dist", self.dist),
            ("velocity", self.velocity),
            ("period", self.period),
            ("horizon", self.horizon),
            ("reaction", self.reaction),
            ("safety", self.safety),
            ("look_ahead", self.look_ahead),
            ("trust", self.trust),
            ("patience", self.patience),
        ];
        super::controllers::check("dwa", &named)?;
        super::controllers::samples("dwa", &[("speeds", self.speeds), ("turns", self.turns)])?;
        Ok(Box::new(Window {
            weights: Weights { heading: self.heading, dist: self.dist, velocity: self.velocity, ..Weights::default() },
            body: Body::of(&setup.robot.footprint),
            filter: Filter::new(self.trust.min(1.0)),
            setup: setup.clone(),
            p: self,
            course: None,
            progress: Progress::default(),
        }))
    }
}

/// How far a robot has come along its course, and since when it has not come farther.
#[derive(Debug, Clone, Copy)]
pub(super) struct Progress {
    /// Arc length of the robot's projection, m.
    pub s: f64,
    /// Arc length reached, m, and when, s.
    best: (f64, f64),
}

impl Default for Progress {
    fn default() -> Self {
        Self::at(0.0)
    }
}

impl Progress {
    /// From arc length `s` (m) on.
    pub fn at(s: f64) -> Self {
        Self { s, best: (s, f64::NAN) }
    }

    /// The distance that is left, m; a decision at the end and after `patience` s without progress.
    pub fn check(&mut self, course: &Course, seen: &Observation, patience: f64) -> Result<f64, Decision> {
        let p = [seen.pose[0], seen.pose[1]];
        self.s = course.project(p, self.s, self.s + 0.5).0;
        let end = course.end().pose;
        // Along the path, not to its last point: that may be passed at a distance, and would be circled.
        let left = course.length() - self.s;
        if left < THERE && (end[0] - p[0]).hypot(end[1] - p[1]) < BESIDE {
            return Err(Decision::Stop(Reason::new("at the end of the path")));
        }
        if self.best.1.is_nan() || self.s > self.best.0 + 0.1 {
            self.best = (self.s, seen.time);
        }
        if seen.time - self.best.1 > patience {
            self.best.1 = seen.time;
            return Err(Decision::Replan(nearest(seen)));
        }
        Ok(left)
    }
}

/// The dynamic window at work.
struct Window {
    p: Dwa,
    weights: Weights,
    setup: Setup,
    body: Body,
    filter: Filter,
    course: Option<Arc<Course>>,
    progress: Progress,
}

impl Controller for Window {
    fn follow(&mut self, guide: &Arc<Guide>) {
        self.course = Some(Arc::clone(&guide.course));
        self.progress = Progress::at(guide.from);
    }

    fn decide(&mut self, seen: &Observation, _ctx: &mut Context) -> Decision {
        let Some(course) = self.course.clone() else { return Decision::Stop(Reason::new("no course to follow")) };
        let mut seen = seen.clone();
        self.filter.apply(&mut seen);
        match self.progress.check(&course, &seen, self.p.patience) {
            Ok(left) => {
                let ahead = course.at_length(self.progress.s + self.p.look_ahead).pose;
                self.choose(&seen, [ahead[0], ahead[1]], left)
            }
            Err(decision) => decision,
        }
    }
}

impl Window {
    fn choose(&self, seen: &Observation, target: [f64; 2], left: f64) -> Decision {
        let safety = if self.p.centred { self.body.beyond(self.p.safety) } else { self.p.safety };
        let margins = Margins { still: safety, moving: safety, growth: 0.0 };
        let world = seen.known.as_deref().unwrap_or(&self.setup.world);
        let (robot, cap) = (&self.setup.robot, self.setup.robot.speed * self.p.horizon);
        let field = Field::new(world, robot, &self.body, seen, (margins, self.p.horizon));
        let (mut open, mut met) = (Vec::new(), None);
        for (v, w) in window(robot, seen, self.p.period, [self.p.speeds, self.p.turns]) {
            let contact = field.contact(seen.pose, [v, w], self.p.horizon);
            met = met.or(contact.map(|c| c.1));
            let dist = contact.map_or(cap, |(t, _)| (v * t).min(cap));
            let dist = if v == 0.0 && contact.is_none_or(|c| c.1 != Met::Static) { cap } else { dist };
            let free = (dist - v * self.p.reaction).max(0.0);
            if admissible(robot, [v, w], free) && stops(robot, v, [seen.v, left, self.p.reaction, self.p.period]) {
                open.push(Candidate { v, w, dist, end: arc(seen.pose, v, w, self.p.period), target, ..Candidate::default() });
            }
        }
        match self.weights.best(&open) {
            Some(c) => Decision::Drive(Command { v: c.v, w: c.w }),
            None => Decision::Stop(why(met, seen)),
        }
    }
}

/// Can the base stop within `free` m of its arc, in distance and in angle?
pub(super) fn admissible(robot: &Robot, [v, w]: [f64; 2], free: f64) -> bool {
    let angle = free * w.abs() / v.max(0.01);
    v <= (2.0 * free * robot.deceleration).sqrt() && (v == 0.0 || w.abs() <= (2.0 * angle * robot.turn_acceleration).sqrt())
}

/// Can it stop at the end of the path, `left` m ahead, after a `reaction` time (s), or does it brake as hard as it can within a `period` (s)?
pub(super) fn stops(robot: &Robot, v: f64, [now, left, reaction, period]: [f64; 4]) -> bool {
    v <= now - 0.99 * robot.deceleration * period || v == 0.0 || left + 0.01 >= robot.braking_distance(v) + v * reaction
}

/// The speeds that can be reached within a `period` (s), in a fixed order; the lowest speed and turn rate zero are always among them.
fn window(r: &Robot, seen: &Observation, period: f64, [speeds, turns]: [u32; 2]) -> Vec<(f64, f64)> {
    let (v, w) = (seen.v.clamp(0.0, r.speed), seen.w.clamp(-r.turn_rate, r.turn_rate));
    let (low, high) = ((v - r.deceleration * period).max(0.0), (v + r.acceleration * period).min(r.speed));
    let (left, right) = ((w - r.turn_acceleration * period).max(-r.turn_rate), (w + r.turn_acceleration * period).min(r.turn_rate));
    let step = |a: f64, b: f64, i: u32, n: u32| a + (b - a) * f64::from(i) / f64::from((n - 1).max(1));
    let mut rates: Vec<f64> = (0..turns).map(|i| step(left, right, i, turns)).collect();
    if left < 0.0 && right > 0.0 {
        rates.push(0.0);
    }
    (0..speeds).flat_map(|i| rates.iter().map(move |w| (step(low, high, i, speeds), *w))).collect()
}

/// Why no candidate was left.
pub(super) fn why(met: Option<Met>, seen: &Observation) -> Reason {
    match met {
        Some(Met::Mover(id)) => match seen.tracks.iter().find(|t| t.id == id) {
            Some(track) => Reason::at(format!("mover {id} is too near"), track),
            None => Reason::new(format!("mover {id} is too near")),
        },
        Some(Met::Static) => Reason::new("no way to stop in time but now"),
        None => Reason::new("no admissible speed"),
    }
}

/// The nearest mover within 2 m as what is in the way.
pub(super) fn nearest(seen: &Observation) -> Reason {
    let p = [seen.pose[0], seen.pose[1]];
    let near = seen.tracks.iter().map(|t| (t.distance(p, 0.0), t)).filter(|(d, _)| *d < 2.0).min_by(|a, b| a.0.total_cmp(&b.0));
    match near {
        Some((_, track)) => Reason::at(format!("no progress, mover {} is near", track.id), track),
        None => Reason::new("no progress"),
    }
}

#[cfg(test)]
mod tests;
