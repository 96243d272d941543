//! Perception, navigation and control behind one step: what [`execute`](super::execute) runs, and what a robot's own control loop calls.

use super::limiter::Limiter;
use super::navigator::Navigator;
use super::pace::Pace;
use super::{
    Command, Controller, Course, Decision, Event, Eyes, Found, Guide, Job, Observation, OwnReplanner, Pacing, Reason, Request, Robot, Scan, Sense,
    Sketch, Track,
};
use crate::Point;
use crate::context::Context;
use crate::error::PlanError;
use crate::query::Query;
use crate::timing::Trajectory;
use crate::world::SpeedMap;
use std::collections::HashSet;
use std::sync::Arc;

/// Braking for a slower zone begins so much before it has to, s.
const AHEAD: f64 = 0.2;
/// Older looks at the surroundings than this are not driven on, s.
const BLIND: f64 = 0.5;
/// What a lidar shows counts as moving from this speed on, m/s.
const LIVELY: f64 = 0.15;

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
    /// Movers that have been named; none before the first step.
    named: Option<HashSet<usize>>,
    /// What is added to the time of the caller, and the last time, s.
    clock: [f64; 2],
    pace: Pace,
    limiter: Limiter,
    speed_map: Option<Arc<SpeedMap>>,
    robot: Robot,
}

impl<C: Controller + ?Sized> Controller for &mut C {
    fn follow(&mut self, guide: &Arc<Guide>) {
        (**self).follow(guide);
    }
    fn decide(&mut self, seen: &Observation, ctx: &mut Context) -> Decision {
        (**self).decide(seen, ctx)
    }
    fn pacing(&self) -> Pacing {
        (**self).pacing()
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
        Ok(Self {
            controller,
            eyes: None,
            navigator,
            stopping: None,
            blind: false,
            named: None,
            clock: [0.0, f64::NEG_INFINITY],
            pace: Pace::new(robot, trajectory.limits.jerk),
            limiter: Limiter::new(robot, trajectory.limits.jerk),
            speed_map: None,
            robot: robot.clone(),
        })
    }

    /// The pilot of a job.
    /// # Errors
    /// As [`Pilot::owned`].
    pub fn of_job(job: &Job<'a>, controller: Box<dyn Controller + 'a>) -> Result<Self, PlanError> {
        let replanner = job.replanner.map(|f| -> Box<OwnReplanner<'a>> { Box::new(move |ask, ctx| f(ask, ctx)) });
        Self::owned(job, controller, replanner)
    }

    /// A pilot for what a job describes, its replanner aside. Where the map is not known it plans on what its eyes have seen, from nothing on.
    /// # Errors
    /// As [`Pilot::new`], for a lidar or a speed of movers out of range, and for a robot without a map and a lidar.
    pub fn owned(job: &Job, controller: Box<dyn Controller + 'a>, replanner: Option<Box<OwnReplanner<'a>>>) -> Result<Self, PlanError> {
        let world = if job.map_known { Arc::clone(&job.query.world) } else { Arc::new(job.query.world.emptied()?) };
        let query = Query { world, ..job.query.clone() };
        let mut pilot = Self::new((&query, job.trajectory), &job.robot, controller, replanner)?;
        pilot.speed_map.clone_from(&job.speed_map);
        pilot.navigator.delivery = job.delivery;
        match job.sense {
            Sense::Truth if job.map_known => Ok(pilot),
            Sense::Truth => Err(PlanError::bad("map", "none", "known, or none with a lidar to see by (sense)")),
            Sense::Lidar(lidar) => Ok(pilot.with_eyes(Eyes::new(lidar, &query.world, job.map_known)?.with_mover_speed(job.mover_speed)?)),
        }
    }

    /// Adds perception: observations then come without tracks and get them from scans.
    #[must_use]
    pub fn with_eyes(mut self, eyes: Eyes) -> Self {
        self.eyes = Some(eyes);
        self
    }

    /// Is a plan to be made outside of the steps ([`Delivery::Elsewhere`]), and nobody has begun with it?
    pub fn plan_due(&self) -> bool {
        self.navigator.asks()
    }
    /// That plan, for whoever makes it, in a thread of its own: [`Request::solve`], then [`Pilot::deliver`]. Handed out once.
    pub fn request(&mut self) -> Option<Request> {
        self.navigator.request()
    }
    /// A plan that was made; the next step takes it, if it is still needed.
    pub fn deliver(&mut self, found: Found) {
        self.navigator.found(found);
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

    /// Share of the planned speed that is asked for.
    pub fn share(&self) -> f64 {
        self.pace.share
    }
    /// Drives at this share of the planned speed, 0 to 1, from now on; the change keeps to the limits of acceleration and jerk.
    /// # Errors
    /// [`PlanError::BadParameter`] for a share that is none.
    pub fn set_share(&mut self, share: f64) -> Result<(), PlanError> {
        if !(0.0..=1.0).contains(&share) {
            return Err(PlanError::bad("override", share, "0 to 1"));
        }
        self.pace.share = share;
        Ok(())
    }
    /// Stops on the path, within the limits of deceleration and jerk, or goes on.
    pub fn hold(&mut self, hold: bool) {
        self.pace.held = hold;
    }

    /// One control step from what the sensors say. With perception `seen` is filled in from `scan`; without, it comes with tracks.
    pub fn step(&mut self, seen: &mut Observation, scan: Option<Scan>, ctx: &mut Context) -> Step {
        if let Some(eyes) = &mut self.eyes {
            eyes.look(seen, scan);
        }
        seen.time = self.steady(seen.time);
        self.name(seen);
        let mut replanned = false;
        if self.navigator.before(seen, ctx) {
            self.follow();
            replanned = true;
        }
        seen.share = self.pace.step(seen.time);
        seen.top = self.allowed(seen);
        let decision = self.decide(seen, ctx);
        let decision = self.paced(decision, seen);
        if self.pace.now() > 0.0 && self.navigator.after(seen, &decision, ctx) {
            self.follow();
            replanned = true;
        }
        let (command, stop, stopped) = self.obey(decision, seen.time);
        let (events, plan_seconds) = (std::mem::take(&mut self.navigator.events), std::mem::take(&mut self.navigator.seconds));
        Step { command, stop, stopped, events, replanned, plan_seconds }
    }

    /// Says which movers have come into sight since the start: by the truth any, by scans those that are seen to move.
    fn name(&mut self, seen: &Observation) {
        let all = self.eyes.is_none();
        let moves = |t: &&Track| all || t.velocity[0].hypot(t.velocity[1]) > LIVELY;
        let Some(named) = &mut self.named else {
            self.named = Some(seen.tracks.iter().filter(moves).map(|t| t.id).collect());
            return;
        };
        for track in seen.tracks.iter().filter(moves) {
            if named.insert(track.id) {
                let ([x, y], [vx, vy]) = (track.position, track.velocity);
                let text = format!("mover {} at ({x:.2}, {y:.2}), {:.2} m/s", track.id, vx.hypot(vy));
                self.navigator.event(seen.time, "appeared", text);
            }
        }
    }

    /// The time on a clock that never runs back, s: where that of the caller does, it goes on from where it was.
    fn steady(&mut self, t: f64) -> f64 {
        let [shift, last] = self.clock;
        if t.is_finite() {
            self.clock = if t + shift < last { [last - t, last] } else { [shift, t + shift] };
            return self.clock[1];
        }
        t
    }

    fn follow(&mut self) {
        self.controller.follow(self.navigator.guide());
    }

    /// A decision within the speed that is allowed: slower on the same arc where the controller has not done so itself.
    fn paced(&mut self, decision: Decision, seen: &Observation) -> Decision {
        let pacing = self.controller.pacing();
        let decision = match decision {
            Decision::Drive(command) if pacing != Pacing::Eased => {
                let cut = seen.within(&self.robot, command);
                let most = (seen.share * self.robot.speed).min(seen.top);
                let overridden = self.pace.held || self.pace.now() < 1.0;
                Decision::Drive(self.limiter.step((command, cut), most, (seen.time, overridden), pacing))
            }
            other => other,
        };
        let rolls = pacing != Pacing::Judged && matches!(decision, Decision::Drive(command) if command.v != 0.0);
        let decision = if self.pace.held && seen.share <= 0.0 && !rolls { Decision::Stop(Reason::new("held")) } else { decision };
        if !matches!(decision, Decision::Drive(_)) {
            self.limiter.braked(seen.v, seen.time);
        }
        decision
    }

    /// Largest speed that the map of speeds allows here, and from which those ahead on the course are met in time, m/s.
    fn allowed(&self, seen: &Observation) -> f64 {
        let Some(map) = &self.speed_map else { return f64::INFINITY };
        let p = [seen.pose[0], seen.pose[1]];
        let course = &self.guide().course;
        let (robot, eases) = (&self.robot, self.controller.pacing() == Pacing::Eased);
        // A ramp needs longer for the same: its rate must rise and fall.
        let time = if eases { 2.0 * AHEAD + robot.deceleration / robot.jerk } else { AHEAD };
        let slow = if eases { 0.7 * robot.deceleration } else { robot.deceleration };
        let reach = seen.v * seen.v / (2.0 * slow) + time * seen.v.abs();
        let n = (reach / (0.5 * map.resolution())).ceil().clamp(1.0, 1e4);
        let ahead = |k: u32| {
            let d = reach * f64::from(k) / n;
            let pose = course.at_length(self.navigator.reached() + d).pose;
            let limit = map.around([pose[0], pose[1]]);
            (limit * limit + 2.0 * slow * (d - time * seen.v.abs()).max(0.0)).sqrt()
        };
        (1..=n as u32).map(ahead).fold(map.around(p), f64::min)
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
        match self.navigator.halt(seen) {
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
