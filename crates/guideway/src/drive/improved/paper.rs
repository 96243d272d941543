//! The settings of the source: one window, four critics, sub-goals, an emergency rule.

use super::ImprovedDwa;
use crate::context::Context;
use crate::drive::body::Body;
use crate::drive::critics::{Candidate, Weights};
use crate::drive::dwa::{Progress, admissible, stops, why};
use crate::drive::field::{Field, Margins, Met};
use crate::drive::filter::Filter;
use crate::drive::{Command, Controller, Course, Decision, Guide, Observation, Reason, Setup, Sketch, SubGoals, arc};
use crate::world::shape::wrap;
use std::sync::Arc;

/// Distances to obstacles count up to this, m.
const SATURATED: f64 = 2.0;
/// Nearer obstacles than this double the number of sampled speeds, m.
const DENSE: f64 = 1.0;
/// Turned in place towards the sub-goal until the heading is this near, rad.
const AIMED: f64 = 0.2;
/// Steps along an arc at which its nearest obstacle is looked for, s.
const LOOK: f64 = 0.2;

pub(super) fn build(p: ImprovedDwa, setup: &Setup) -> Box<dyn Controller> {
    Box::new(Window {
        weights: p.weights(),
        filter: Filter::new(p.trust.min(1.0)),
        body: Body::of(&setup.robot.footprint),
        setup: setup.clone(),
        safety: p.safety.unwrap_or(0.35),
        p,
        guide: None,
        progress: Progress::default(),
        sub_goals: None,
        sketch: Sketch::default(),
    })
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
        (self.progress, self.sub_goals) = (Progress::default(), Some(SubGoals::new(guide)));
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
        let clearance = field.nearest(seen.pose, 0.0, SATURATED.max(DENSE));
        if let Some(decision) = self.emergency(clearance, target, seen) {
            return decision;
        }
        let (mut open, mut met) = (Vec::new(), None);
        for [v, w] in self.window(seen, clearance) {
            if let Some((_, with)) = field.contact(seen.pose, [v, w], self.p.horizon) {
                met = met.or(Some(with));
                continue;
            }
            let dist = self.nearest(&field, seen.pose, [v, w]);
            let free = self.setup.robot.speed * self.p.horizon;
            if !(admissible(&self.setup.robot, [v, w], free) && stops(&self.setup.robot, v, [seen.v, left, self.p.period, self.p.period])) {
                continue;
            }
            let next = arc(seen.pose, v, w, self.p.period);
            let end = arc(seen.pose, v, w, self.p.horizon);
            let along = course.at_length(course.project([end[0], end[1]], self.progress.s, self.progress.s + 4.0).0).pose[2];
            // The path critic judges the heading at the end of the prediction, that of the sub-goal the one after the next interval.
            open.push((Candidate { v, w, end: next, target, along, dist, ..Candidate::default() }, end[2]));
        }
        self.best(&open, met, seen)
    }

    fn best(&mut self, open: &[(Candidate, f64)], met: Option<Met>, seen: &Observation) -> Decision {
        // `along` relative to the heading after the next interval, so that the table needs one pose.
        let all: Vec<Candidate> = open.iter().map(|(c, yaw)| Candidate { along: wrap(c.along - yaw + c.end[2]), ..*c }).collect();
        let line = |v: f64, w: f64| (0..=6).map(|i| arc(seen.pose, v, w, 0.5 * f64::from(i))).map(|p| [p[0], p[1]]).collect::<Vec<_>>();
        let every = all.len().div_ceil(12).max(1);
        self.sketch.fan = all.iter().step_by(every).map(|c| line(c.v, c.w)).collect();
        self.sketch.chosen.clear();
        let Some(c) = self.weights.best(&all) else { return Decision::Stop(why(met, seen)) };
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
        let turn = wrap((target[1] - seen.pose[1]).atan2(target[0] - seen.pose[0]) - seen.pose[2]);
        let rate = self.setup.robot.turn_rate;
        (turn.abs() > AIMED).then(|| Decision::Drive(Command { v: 0.0, w: (2.0 * turn).clamp(-rate, rate) }))
    }

    /// Smallest distance to obstacles over the arc, m.
    fn nearest(&self, field: &Field, pose: [f64; 3], [v, w]: [f64; 2]) -> f64 {
        let n = (self.p.horizon / LOOK).ceil().max(1.0);
        let times = (0..=n as u32).map(|i| self.p.horizon * f64::from(i) / n);
        times.fold(SATURATED, |least, t| least.min(field.nearest(arc(pose, v, w, t), t, least))).max(0.0)
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
