//! The settings of the source: one window, four critics, sub-goals, an emergency rule.

use super::{Divide, ImprovedDwa, Room};
use crate::Point;
use crate::context::Context;
use crate::drive::body::Body;
use crate::drive::critics::{Candidate, Weights};
use crate::drive::dwa::{Progress, admissible, stops, why};
use crate::drive::field::{Field, Margins, Met};
use crate::drive::filter::Filter;
use crate::drive::{Command, Controller, Course, Decision, Guide, Observation, Reason, Setup, Sketch, SubGoals, arc};
use crate::timing::State;
use crate::world::shape::wrap;
use std::f64::consts::PI;
use std::sync::Arc;

/// Nearer obstacles than this double the number of sampled speeds, m.
const DENSE: f64 = 1.0;
/// Turned in place towards the sub-goal until the heading is this near, rad.
const AIMED: f64 = 0.2;
/// Steps along an arc at which its nearest obstacle is looked for, s.
const LOOK: f64 = 0.2;
/// Free distances are looked for at most so long, s.
const LONG: f64 = 10.0;
/// Time that passes before braking begins, as in the classic window, s.
const REACTION: f64 = 0.15;
/// The path is looked at so far ahead, and first at places so far apart, m.
const AHEAD: f64 = 4.0;
const MARKS: f64 = 0.05;

pub(super) fn build(p: ImprovedDwa, setup: &Setup) -> Box<dyn Controller> {
    Box::new(made(p, setup))
}

fn made(p: ImprovedDwa, setup: &Setup) -> Window {
    let (body, safety) = (Body::of(&setup.robot.footprint), p.safety.unwrap_or(0.35));
    Window {
        weights: if p.divide == Divide::Scale { scaled(p, setup.robot.speed) } else { p.weights() },
        filter: Filter::new(p.trust.min(1.0)),
        safety: if p.centred { body.beyond(safety) } else { safety },
        setup: setup.clone(),
        body,
        p,
        guide: None,
        progress: Progress::default(),
        sub_goals: None,
        sketch: Sketch::default(),
    }
}

/// The piece of the path that arcs may lead to.
struct Ahead<'a> {
    course: &'a Course,
    /// Arc length of its start, m.
    from: f64,
    marks: Vec<State>,
}

impl<'a> Ahead<'a> {
    fn new(course: &'a Course, from: f64) -> Self {
        let n = (AHEAD / MARKS).ceil() as u32;
        Self { course, from, marks: course.at_lengths((0..=n).map(|k| from + MARKS * f64::from(k))) }
    }

    /// Direction of the path where it is nearest to `p`, rad.
    fn direction(&self, p: Point) -> f64 {
        let away = |m: &State| (p[0] - m.pose[0]).powi(2) + (p[1] - m.pose[1]).powi(2);
        let s = self.marks.iter().min_by(|a, b| away(a).total_cmp(&away(b))).map_or(self.from, |m| m.s);
        self.course.at_length(self.course.project(p, (s - MARKS).max(self.from), (s + MARKS).min(self.from + AHEAD)).0).pose[2]
    }
}

/// The weights over what their critics can be at most.
fn scaled(p: ImprovedDwa, speed: f64) -> Weights {
    let w = p.weights();
    Weights { heading: w.heading / PI, dist: w.dist / p.far.max(1e-12), velocity: w.velocity / speed, path: w.path / PI, ..w }
}

struct Window {
    p: ImprovedDwa,
    weights: Weights,
    safety: f64,
    setup: Setup,
    body: Body,
    filter: Filter,
    guide: Option<Arc<Guide>>,
    progress: Progress,
    sub_goals: Option<SubGoals>,
    sketch: Sketch,
}

impl Controller for Window {
    fn follow(&mut self, guide: &Arc<Guide>) {
        self.guide = Some(Arc::clone(guide));
        (self.progress, self.sub_goals) = (Progress::at(guide.from), Some(SubGoals::new(guide)));
    }

    fn decide(&mut self, seen: &Observation, _ctx: &mut Context) -> Decision {
        let Some(guide) = self.guide.clone() else { return Decision::Stop(Reason::new("no course to follow")) };
        let mut seen = seen.clone();
        self.filter.apply(&mut seen);
        let left = match self.progress.check(&guide.course, &seen, self.p.patience) {
            Ok(left) => left,
            Err(decision) => return decision,
        };
        let end = guide.course.end().pose;
        let next = self.sub_goals.as_mut().and_then(|goals| {
            goals.advance([seen.pose[0], seen.pose[1]], self.progress.s);
            goals.next()
        });
        let target = next.unwrap_or([end[0], end[1]]);
        self.sketch.sub_goal = Some(target);
        self.choose(&guide.course, &seen, (target, left))
    }

    fn trace(&self) -> Option<Sketch> {
        Some(self.sketch.clone())
    }
}

impl Window {
    fn choose(&mut self, course: &Course, seen: &Observation, (target, left): ([f64; 2], f64)) -> Decision {
        let world = seen.known.clone().unwrap_or_else(|| Arc::clone(&self.setup.world));
        let margins = Margins { still: self.safety, moving: self.safety, growth: 0.0 };
        let field = Field::new(&world, &self.setup.robot, &self.body, seen, (margins, self.p.horizon));
        let clearance = field.nearest(seen.pose, 0.0, self.p.far.max(DENSE));
        if let Some(decision) = self.emergency(clearance, target, seen) {
            return decision;
        }
        let (robot, p) = (&self.setup.robot, &self.p);
        let (mut open, mut met, path) = (Vec::new(), None, Ahead::new(course, self.progress.s));
        for [v, w] in self.window(seen, clearance) {
            let first = field.contact(seen.pose, [v, w], self.sight(v));
            let contact = first.filter(|(t, _)| *t <= p.horizon);
            met = met.or(contact.map(|c| c.1));
            let free = contact.map_or(robot.speed * p.horizon, |(t, _)| v * t);
            let out = if p.clear { contact.is_some() } else { !admissible(robot, [v, w], (free - v * REACTION).max(0.0)) };
            if out || !stops(robot, v, [seen.v, left, p.period, p.period]) {
                continue;
            }
            let dist = self.dist(&field, seen.pose, [v, w], first.map(|c| c.0));
            let (next, end) = (arc(seen.pose, v, w, p.aim), arc(seen.pose, v, w, p.horizon));
            // The path critic judges the heading at the end of the prediction, that of the sub-goal its own.
            open.push((Candidate { v, w, end: next, target, along: path.direction([end[0], end[1]]), dist, ..Candidate::default() }, end[2]));
        }
        self.best(&open, met, seen)
    }

    /// How long ahead contacts are looked for, s.
    fn sight(&self, v: f64) -> f64 {
        if self.p.room == Room::Free && v > 0.0 { (self.p.far / v).clamp(self.p.horizon, LONG.max(self.p.horizon)) } else { self.p.horizon }
    }

    fn best(&mut self, open: &[(Candidate, f64)], met: Option<Met>, seen: &Observation) -> Decision {
        // `along` relative to the heading after the next interval, so that the table needs one pose.
        let all: Vec<Candidate> = open.iter().map(|(c, yaw)| Candidate { along: wrap(c.along - yaw + c.end[2]), ..*c }).collect();
        let line = |v: f64, w: f64| (0..=6).map(|i| arc(seen.pose, v, w, 0.5 * f64::from(i))).map(|p| [p[0], p[1]]).collect::<Vec<_>>();
        let every = all.len().div_ceil(12).max(1);
        self.sketch.fan = all.iter().step_by(every).map(|c| line(c.v, c.w)).collect();
        self.sketch.chosen.clear();
        let best = if self.p.divide == Divide::Scale { self.weights.best_total(&all) } else { self.weights.best(&all) };
        let Some(c) = best else { return Decision::Stop(why(met, seen)) };
        self.sketch.chosen = line(c.v, c.w);
        Decision::Drive(Command { v: c.v, w: c.w })
    }

    /// Brakes where obstacles are nearer than the safety distance; once slow, turns in place towards the sub-goal.
    fn emergency(&self, clearance: f64, target: [f64; 2], seen: &Observation) -> Option<Decision> {
        if clearance >= self.safety {
            return None;
        }
        if seen.v > self.p.emergency {
            return Some(Decision::Stop(Reason::new(format!("obstacle at {clearance:.2} m"))));
        }
        if !self.p.pivot {
            return None;
        }
        let turn = wrap((target[1] - seen.pose[1]).atan2(target[0] - seen.pose[0]) - seen.pose[2]);
        let rate = self.setup.robot.turn_rate;
        (turn.abs() > AIMED).then(|| Decision::Drive(Command { v: 0.0, w: (2.0 * turn).clamp(-rate, rate) }))
    }

    /// What the critic `dist` of an arc is that meets something at a time (s) or not in sight, m.
    fn dist(&self, field: &Field, pose: [f64; 3], [v, w]: [f64; 2], first: Option<f64>) -> f64 {
        let (far, horizon) = (self.p.far, self.p.horizon);
        let n = (horizon / LOOK).ceil().max(1.0);
        let times = (0..=n as u32).map(|i| horizon * f64::from(i) / n);
        match self.p.room {
            Room::Free => first.filter(|_| v > 0.0).map_or(far, |t| (v * t).min(far)),
            Room::Least => times.fold(far, |least, t| least.min(field.nearest(arc(pose, v, w, t), t, least))).max(0.0),
            Room::Mean => times.map(|t| field.nearest(arc(pose, v, w, t), t, far).max(0.0)).sum::<f64>() / (n + 1.0),
            Room::End => field.nearest(arc(pose, v, w, horizon), horizon, far).max(0.0),
        }
    }

    /// The speeds that can be reached within a period, on the grid of the resolution; the slowest and turn rate zero are always among them.
    fn window(&self, seen: &Observation, clearance: f64) -> Vec<[f64; 2]> {
        let (r, dt) = (&self.setup.robot, self.p.period);
        let (v, w) = (seen.v.clamp(0.0, r.speed), seen.w.clamp(-r.turn_rate, r.turn_rate));
        let (slow, fast) = ((v - r.deceleration * dt).max(0.0), (v + r.acceleration * dt).min(r.speed));
        let (right, left) = ((w - r.turn_acceleration * dt).max(-r.turn_rate), (w + r.turn_acceleration * dt).min(r.turn_rate));
        let speeds = grid([slow, fast], if clearance < DENSE { 0.5 * self.p.speed_step } else { self.p.speed_step });
        let mut turns = grid([right, left], self.p.turn_step);
        if right < 0.0 && left > 0.0 {
            turns.push(0.0);
        }
        speeds.iter().flat_map(|v| turns.iter().map(|w| [*v, *w])).collect()
    }
}

/// From `low` in steps to `high`, both included.
fn grid([low, high]: [f64; 2], step: f64) -> Vec<f64> {
    let n = ((high - low) / step).floor().clamp(0.0, 2000.0) as u32;
    let mut all: Vec<f64> = (0..=n).map(|i| low + step * f64::from(i)).collect();
    if high - all[all.len() - 1] > 1e-9 {
        all.push(high);
    }
    all
}

#[cfg(test)]
mod tests;
