//! Perception, navigation and control behind one step: what [`execute`](super::execute) runs, and what a robot's own control loop calls.

use super::navigator::Navigator;
use super::{Command, Controller, Course, Decision, Event, Eyes, Guide, Job, Observation, OwnReplanner, Reason, Robot, Scan, Sense, Sketch};
use crate::Point;
use crate::context::Context;
use crate::error::PlanError;
use crate::query::Query;
use crate::timing::Trajectory;
use std::sync::Arc;

/// Older looks at the surroundings than this are not driven on, s.
const BLIND: f64 = 0.5;

/// What comes out of a control step.
#[derive(Debug, Clone, PartialEq)]
pub struct Step {
    /// What the base is asked to do; zero means full braking.
    pub command: Command,
    /// Why it is to stop, if it is.
    pub stop: Option<String>,
    /// Does the stop begin with this step?
    pub stopped: bool,
    /// What happened in this step.
    pub events: Vec<Event>,
    /// Is there a new guide?
    pub replanned: bool,
    /// Wall-clock time of each plan in this step, s.
    pub plan_seconds: Vec<f64>,
}

/// Drives a robot along a motion, step by step.
pub struct Pilot<'a> {
    controller: Box<dyn Controller + 'a>,
    eyes: Option<Eyes>,
    navigator: Navigator<'a>,
    /// Why the robot was to stop in the last step.
    stopping: Option<String>,
    blind: bool,
}

impl<C: Controller + ?Sized> Controller for &mut C {
    fn follow(&mut self, guide: &Arc<Guide>) {
        (**self).follow(guide);
    }
    fn decide(&mut self, seen: &Observation, ctx: &mut Context) -> Decision {
        (**self).decide(seen, ctx)
    }
    fn trace(&self) -> Option<Sketch> {
        (**self).trace()
    }
}

impl<'a> Pilot<'a> {
    /// A pilot for a robot that is to drive a trajectory made for a query. Without a replanner it waits where the way is blocked.
    /// # Errors
    /// [`PlanError::BadParameter`] for a trajectory that is no [`Course`].
    pub fn new(
        (query, trajectory): (&Query, &Trajectory),
        robot: &Robot,
        mut controller: Box<dyn Controller + 'a>,
        replanner: Option<Box<OwnReplanner<'a>>>,
    ) -> Result<Self, PlanError> {
        let navigator = Navigator::new(query, robot, Arc::new(Course::new(trajectory)?), replanner);
        controller.follow(navigator.guide());
        Ok(Self { controller, eyes: None, navigator, stopping: None, blind: false })
    }

    /// The pilot of a job. Where the map is not known it plans on what its eyes have seen, from nothing on.
    /// # Errors
    /// As [`Pilot::new`], and for a lidar out of range.
    pub fn of_job(job: &Job<'a>, controller: Box<dyn Controller + 'a>) -> Result<Self, PlanError> {
        let replanner = job.replanner.map(|f| -> Box<OwnReplanner<'a>> { Box::new(move |ask, ctx| f(ask, ctx)) });
        let world = if job.map_known { Arc::clone(&job.query.world) } else { Arc::new(job.query.world.emptied()?) };
        let query = Query { world, ..job.query.clone() };
        let pilot = Self::new((&query, job.trajectory), &job.robot, controller, replanner)?;
        match job.sense {
            Sense::Truth if job.map_known => Ok(pilot),
            Sense::Truth => Err(PlanError::bad("map", "none", "known, or none with a lidar to see by (sense)")),
            Sense::Lidar(lidar) => Ok(pilot.with_eyes(Eyes::new(lidar, &query.world, job.map_known)?)),
        }
    }

    /// Adds perception: observations then come without tracks and get them from scans.
    #[must_use]
    pub fn with_eyes(mut self, eyes: Eyes) -> Self {
        self.eyes = Some(eyes);
        self
    }

    /// What is followed now.
    pub fn guide(&self) -> &Arc<Guide> {
        self.navigator.guide()
    }
    /// The sub-goal that the robot heads for, m.
    pub fn sub_goal(&self) -> Option<Point> {
        self.navigator.sub_goal()
    }
    /// New plans so far.
    pub fn replans(&self) -> u32 {
        self.navigator.replans
    }
    /// What the controller had in mind in the last step.
    pub fn sketch(&self) -> Option<Sketch> {
        self.controller.trace()
    }

    /// One control step from what the sensors say. With perception `seen` is filled in from `scan`; without, it comes with tracks.
    pub fn step(&mut self, seen: &mut Observation, scan: Option<Scan>, ctx: &mut Context) -> Step {
        if let Some(eyes) = &mut self.eyes {
            eyes.look(seen, scan);
        }
        let mut replanned = false;
        if self.navigator.before(seen, ctx) {
            self.follow();
            replanned = true;
        }
        let decision = self.decide(seen, ctx);
        if self.navigator.after(seen, &decision, ctx) {
            self.follow();
            replanned = true;
        }
        let (command, stop, stopped) = self.obey(decision, seen.time);
        let (events, plan_seconds) = (std::mem::take(&mut self.navigator.events), std::mem::take(&mut self.navigator.seconds));
        Step { command, stop, stopped, events, replanned, plan_seconds }
    }

    fn follow(&mut self) {
        self.controller.follow(self.navigator.guide());
    }

    /// What the controller decides, unless there is no way or nothing is seen.
    fn decide(&mut self, seen: &Observation, ctx: &mut Context) -> Decision {
        let valid = seen.time.is_finite() && seen.pose.iter().chain([&seen.v, &seen.w]).all(|v| v.is_finite());
        if !valid {
            return Decision::Stop(Reason::new("the pose, the speeds or the time are not finite"));
        }
        let blind = seen.age.is_nan() || seen.age > BLIND;
        if blind != self.blind {
            self.blind = blind;
            let (kind, text) = if blind { ("blind", format!("nothing seen for {:.1} s", seen.age)) } else { ("go", "seen again".into()) };
            self.navigator.event(seen.time, kind, text);
        }
        if blind {
            return Decision::Stop(Reason::new("nothing is seen"));
        }
        let decision = self.controller.decide(seen, ctx);
        match self.navigator.lost() {
            Some(reason) if matches!(decision, Decision::Drive(_)) => Decision::Stop(reason),
            _ => decision,
        }
    }

    /// The command that a decision means, why to stop, and whether that is new.
    fn obey(&mut self, decision: Decision, t: f64) -> (Command, Option<String>, bool) {
        let reason = match decision {
            Decision::Drive(command) => {
                if self.stopping.take().is_some() {
                    self.navigator.event(t, "go", "");
                }
                return (command, None, false);
            }
            Decision::Stop(reason) | Decision::Replan(reason) => reason,
        };
        let begins = self.stopping.is_none();
        if self.stopping.as_ref() != Some(&reason.text) {
            self.navigator.event(t, "stop", reason.text.clone());
            self.stopping = Some(reason.text.clone());
        }
        (Command::default(), Some(reason.text), begins)
    }
}

#[cfg(test)]
mod tests;
