//! The loop between controller and plant, and the judge beside it.

use super::record::{Log, moving};
use super::sense::Stage;
use super::separation::{Judge, Leg, With};
use super::{
    Collision, Command, Controller, Course, Decision, Event, Guide, Lidar, Motion, MoverRecord, Observation, Outcome, Percentiles, Plant, Reason,
    Robot, Run, Separation, Unicycle,
};
use crate::Point;
use crate::context::Context;
use crate::error::PlanError;
use crate::query::Query;
use crate::timing::Trajectory;
use crate::world::shape::{distance, wrap};
use crate::world::{Mover, Shape, World};
use serde::{Deserialize, Serialize};
use std::sync::Arc;
use std::time::Instant;

/// Plans and times a new motion for a changed query, whose world holds what is in the way; it starts at the robot's pose, at rest.
pub type Replanner<'a> = dyn Fn(&Query, &mut Context) -> Result<Trajectory, PlanError> + Sync + 'a;

/// How movers (and, without a map, static obstacles) are seen.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Sense {
    /// The truth about those that are present.
    #[default]
    Truth,
    /// What a lidar on the robot shows, tracked.
    Lidar(Lidar),
}

/// Sub-steps per control step at which the true pose is read; between them the judge follows the arc.
const SUBSTEPS: u32 = 4;

/// What to drive. Build with [`Job::new`] and change the public fields.
pub struct Job<'a> {
    /// Where, from, to; its world holds the movers.
    pub query: &'a Query,
    /// The planned motion.
    pub trajectory: &'a Trajectory,
    /// The base.
    pub robot: Robot,
    /// The plant that [`execute`] builds.
    pub plant: Unicycle,
    /// Distance from the goal that counts as arrived, m.
    pub arrival: f64,
    /// Arrival also asks for rest (and for the goal heading, within 0.1 rad, if the query has one).
    pub stop_at_goal: bool,
    /// Longest run, s; `None` is three times the planned duration and 60 s.
    pub time_limit: Option<f64>,
    /// A run without progress (0.05 m nearer to the end of its course, or a new plan) for so long is stuck, s.
    pub stuck_after: f64,
    /// Command period, s.
    pub period: f64,
    /// How the surroundings are seen.
    pub sense: Sense,
    /// Does the robot know the static world from the start? Else it knows its bounds and what its lidar has seen.
    pub map_known: bool,
    /// Plans anew when the controller asks; without one it waits.
    pub replanner: Option<&'a Replanner<'a>>,
}

impl<'a> Job<'a> {
    /// A job with the robot that the query and the trajectory describe, arrival within 0.1 m at rest, and no replanner.
    /// # Errors
    /// [`PlanError::BadParameter`] for limits or a footprint out of range.
    pub fn new(query: &'a Query, trajectory: &'a Trajectory) -> Result<Self, PlanError> {
        let robot = Robot::new(query.footprint.clone(), &trajectory.limits)?;
        let plant = Unicycle::default();
        Ok(Self {
            query,
            trajectory,
            robot,
            plant,
            arrival: 0.1,
            stop_at_goal: true,
            time_limit: None,
            stuck_after: 30.0,
            period: 0.02,
            sense: Sense::Truth,
            map_known: true,
            replanner: None,
        })
    }

    fn validate(&self) -> Result<(), PlanError> {
        self.plant.validated()?;
        let named = [
            ("arrival", self.arrival, [1e-6, 1e6]),
            ("time_limit", self.time_limit.unwrap_or(1.0), [1e-6, 1e5]),
            ("stuck_after", self.stuck_after, [1e-3, 1e6]),
            ("period", self.period, [1e-4, 1.0]),
        ];
        match named.into_iter().find(|(_, v, range)| !(range[0]..=range[1]).contains(v)) {
            Some((name, value, range)) => Err(PlanError::bad(name, value, format!("{} to {}", range[0], range[1]))),
            None => Ok(()),
        }
    }
}

/// Drives the job on its unicycle plant, with noise from the seed of `ctx`. A run that does not arrive is a result, not an error.
/// # Errors
/// [`PlanError::BadParameter`] for a job out of range.
pub fn execute(job: &Job, controller: &mut dyn Controller, ctx: &mut Context) -> Result<Run, PlanError> {
    job.validate()?;
    let pose = Course::new(job.trajectory)?.start().pose;
    let yaw = job.query.start_yaw.unwrap_or(pose[2]);
    let mut plant = job.plant.place(&job.robot, [pose[0], pose[1], yaw], ctx.seed());
    execute_on(job, controller, &mut plant, ctx)
}

/// As [`execute`], on any plant; it starts where the plant is.
/// # Errors
/// As [`execute`].
pub fn execute_on(job: &Job, controller: &mut dyn Controller, plant: &mut dyn Plant, ctx: &mut Context) -> Result<Run, PlanError> {
    job.validate()?;
    let course = Arc::new(Course::new(job.trajectory)?);
    let mut drive = Drive::new(job, &course);
    controller.follow(&Arc::new(Guide::along(Arc::clone(&course))));
    let limit = job.time_limit.unwrap_or(3.0 * course.duration() + 60.0);
    let outcome = loop {
        let t = drive.steps as f64 * job.period;
        if let Some(outcome) = drive.judge_state(plant.motion(), t) {
            break outcome;
        }
        if t >= limit {
            break Outcome::Timeout;
        }
        if ctx.poll().is_some() {
            drive.cancelled = true;
            drive.event(t, "cancel", "cancelled by the caller or by the budget");
            break Outcome::Timeout;
        }
        let mut seen = plant.observe();
        seen.time = t;
        seen.tracks = drive.stage.tracks(t);
        let started = Instant::now();
        let decision = controller.decide(&seen, ctx);
        drive.seconds.push(started.elapsed().as_secs_f64());
        let command = drive.obey(decision, &seen, controller, ctx);
        if drive.move_on(plant, command, t) {
            break Outcome::Collision;
        }
    };
    Ok(drive.finish(outcome, plant.motion()))
}

/// The state of the loop.
struct Drive<'a> {
    job: &'a Job<'a>,
    course: Arc<Course>,
    stage: Stage,
    judge: Judge<'a>,
    log: Log,
    seconds: Vec<f64>,
    events: Vec<Event>,
    steps: u64,
    replans: u32,
    emergency_stops: u32,
    stopping: Option<String>,
    /// Arc length reached, m.
    s: f64,
    /// Least distance left so far, m, and when it was reached, s.
    progress: (f64, f64),
    collision: Option<Collision>,
    ended: Option<f64>,
    cancelled: bool,
}

impl<'a> Drive<'a> {
    fn new(job: &'a Job<'a>, course: &Arc<Course>) -> Self {
        let mut log = Log::default();
        log.courses.push((0, Arc::clone(course)));
        Self {
            job,
            course: Arc::clone(course),
            stage: Stage::new(job.query.world.movers()),
            judge: Judge::new(&job.query.world, &job.robot.footprint),
            log,
            seconds: Vec::new(),
            events: Vec::new(),
            steps: 0,
            replans: 0,
            emergency_stops: 0,
            stopping: None,
            s: 0.0,
            progress: (f64::INFINITY, 0.0),
            collision: None,
            ended: None,
            cancelled: false,
        }
    }

    fn event(&mut self, t: f64, kind: &str, reason: impl Into<String>) {
        self.events.push(Event { t, kind: kind.into(), reason: reason.into() });
    }

    /// Records the true state at the start of a step; triggers, arrival and progress.
    fn judge_state(&mut self, m: Motion, t: f64) -> Option<Outcome> {
        let p = [m.pose[0], m.pose[1]];
        self.log.driven.push([t, m.pose[0], m.pose[1], m.pose[2], m.v, m.w]);
        self.stage.trigger(p, t);
        let row = self.log.driven[self.log.driven.len() - 1];
        let heading = self.job.query.goal_yaw.is_none_or(|yaw| wrap(m.pose[2] - yaw).abs() <= 0.1);
        if distance(p, self.job.query.goal) <= self.job.arrival && (!self.job.stop_at_goal || (!moving(&row) && heading)) && self.at_the_end(p) {
            return Some(Outcome::Arrived);
        }
        let window = 1.0 + 2.0 * m.v.abs() * self.job.period;
        self.s = self.course.project(p, self.s, self.s + window).0;
        let state = self.course.at_length(self.s);
        let left = self.course.length() - self.s + distance(p, [state.pose[0], state.pose[1]]);
        if left < self.progress.0 - 0.05 {
            self.progress = (left, t);
        }
        (t - self.progress.1 > self.job.stuck_after).then_some(Outcome::Stuck)
    }

    /// A course that passes its goal on the way does not arrive there.
    fn at_the_end(&self, p: Point) -> bool {
        self.job.query.via.is_empty() || self.course.length() - self.course.project(p, self.s, self.s + 1.0).0 <= self.job.arrival + 1.0
    }

    /// The command that a decision means.
    fn obey(&mut self, decision: Decision, seen: &Observation, controller: &mut dyn Controller, ctx: &mut Context) -> Command {
        let fast = self.log.driven.last().is_some_and(|r| r[4].abs() > 0.2);
        let (reason, replan) = match decision {
            Decision::Drive(command) => {
                if self.stopping.take().is_some() {
                    self.event(seen.time, "go", "");
                }
                return command;
            }
            Decision::Stop(reason) => (reason, false),
            Decision::Replan(reason) => (reason, true),
        };
        if self.stopping.is_none() && fast {
            self.emergency_stops += 1;
        }
        if self.stopping.as_ref() != Some(&reason.text) {
            self.event(seen.time, "stop", reason.text.clone());
            self.stopping = Some(reason.text.clone());
        }
        if replan {
            self.replan(&reason, seen, controller, ctx);
        }
        Command::default()
    }

    fn replan(&mut self, reason: &Reason, seen: &Observation, controller: &mut dyn Controller, ctx: &mut Context) {
        let Some(replanner) = self.job.replanner else {
            self.event(seen.time, "no-plan", "there is no replanner");
            return;
        };
        let mut inner = Context::new(ctx.seed().wrapping_add(u64::from(self.replans) + 1)).with_threads(ctx.threads());
        let course = changed(self.job.query, &self.job.robot, seen, reason, (&self.course, self.s))
            .and_then(|query| replanner(&query, &mut inner))
            .and_then(|trajectory| Course::new(&trajectory));
        match course {
            Ok(course) => {
                self.course = Arc::new(course);
                self.log.courses.push((self.log.driven.len(), Arc::clone(&self.course)));
                self.replans += 1;
                (self.s, self.progress) = (0.0, (f64::INFINITY, seen.time));
                controller.follow(&Arc::new(Guide::along(Arc::clone(&self.course))));
                self.event(seen.time, "replan", reason.text.clone());
            }
            Err(e) => self.event(seen.time, "no-plan", e.name()),
        }
    }

    /// Moves plant and time on by one period; true on a collision.
    fn move_on(&mut self, plant: &mut dyn Plant, command: Command, t: f64) -> bool {
        self.log.commands.push(command.v);
        let h = self.job.period / f64::from(SUBSTEPS);
        for i in 0..SUBSTEPS {
            let start = t + h * f64::from(i);
            let before = plant.motion();
            plant.step(command, h);
            let leg = Leg::between(start, h, before.pose, plant.motion().pose);
            if let Some((with, when)) = self.judge.watch(&leg, &self.stage) {
                self.collide(with, when, &before);
                return true;
            }
        }
        self.steps += 1;
        false
    }

    fn collide(&mut self, with: With, t: f64, m: &Motion) {
        let parked = m.v.abs() < 0.01 && m.w.abs() < 0.01;
        let (name, unavoidable) = match with {
            With::Static => ("static".to_owned(), false),
            With::Border => ("border".to_owned(), false),
            With::Mover(i) => {
                let appeared = self.stage.since[i].is_some_and(|since| since > 0.0 && t - since < self.job.period);
                (format!("mover {i}"), parked || appeared)
            }
        };
        self.event(t, "collision", name.clone());
        self.collision = Some(Collision { t, with: name, unavoidable });
        self.ended = Some(t);
    }

    fn finish(mut self, outcome: Outcome, m: Motion) -> Run {
        let end = self.ended.unwrap_or(self.steps as f64 * self.job.period);
        if self.log.driven.last().is_none_or(|r| r[0] < end) {
            self.log.driven.push([end, m.pose[0], m.pose[1], m.pose[2], m.v, m.w]);
        }
        let first = self.log.driven.iter().find(|r| moving(r)).map_or(end, |r| r[0]);
        let goal = self.job.query.goal;
        let finite = |d: f64| d.is_finite().then_some(d);
        Run {
            outcome,
            time: end - first,
            movers: self.job.query.world.movers().iter().zip(&self.stage.since).map(|(m, s)| recorded(m, *s, end)).collect(),
            replans: self.replans,
            min_separation: Separation { still: finite(self.judge.still), movers: finite(self.judge.moving) },
            emergency_stops: self.emergency_stops,
            step_seconds: Percentiles::of(self.seconds),
            tracking: self.log.tracking(goal, self.job.trajectory.limits.jerk, &self.job.robot, self.job.period),
            energy: self.log.energy(),
            driven: self.log.driven,
            events: self.events,
            collision: self.collision,
            cancelled: self.cancelled,
        }
    }
}

/// The query from where the robot is, in a world that holds the place in the way as a disc. Clearance and disc shrink as far as the robot's own
/// place needs it, so that it can leave.
fn changed(query: &Query, robot: &Robot, seen: &Observation, reason: &Reason, (course, s): (&Course, f64)) -> Result<Query, PlanError> {
    let start = [seen.pose[0], seen.pose[1]];
    let body = robot.footprint.circumscribed();
    let clearance = query.clearance.min(query.world.clearance(start) - body - 1e-6).max(0.0);
    let needed = body + clearance;
    let disc = reason.place.and_then(|(center, radius)| {
        let room = distance(center, start) - needed - 1e-6;
        let clear_goal = distance(center, query.goal) - body - query.clearance - 1e-6;
        let radius = radius.min(room).min(clear_goal);
        (radius > 0.0).then_some(Shape::Disc { center, radius })
    });
    let ahead = |p: &&Point| course.project(**p, 0.0, course.length()).0 > s + 0.1;
    Ok(Query {
        world: Arc::new(overlaid(&query.world, disc)?),
        start,
        start_yaw: Some(seen.pose[2]),
        via: query.via.iter().filter(ahead).copied().collect(),
        clearance,
        ..query.clone()
    })
}

/// The static part of a world with one shape more.
fn overlaid(world: &World, extra: Option<Shape>) -> Result<World, PlanError> {
    let shapes: Vec<Shape> = world.shapes().iter().cloned().chain(extra).collect();
    match world.grid() {
        Some(grid) => Ok(World::from_grid(grid.clone()).with_shapes(shapes)),
        None => World::from_shapes(world.bounds(), shapes, world.resolution()),
    }
}

/// A mover's motion up to `end`, dense enough to draw and exact between rows.
fn recorded(mover: &Mover, since: Option<f64>, end: f64) -> MoverRecord {
    let from = since.unwrap_or(0.0);
    let mut times: Vec<f64> = (0..=((end - from).max(0.0) / 0.1).ceil() as usize).map(|i| (from + 0.1 * i as f64).min(end)).collect();
    times.extend(corners(mover, from, end));
    times.sort_by(f64::total_cmp);
    times.dedup_by(|b, a| *b - *a < 1e-9);
    let track = if since.is_some() { times.into_iter().map(|t| [t, mover.at(t).0[0], mover.at(t).0[1]]).collect() } else { Vec::new() };
    MoverRecord { outline: super::Outline::of(&mover.shape), since, track }
}

/// Times in `from..end` at which a mover changes its velocity; 1e-6 s before and after each jump back to its start.
fn corners(mover: &Mover, from: f64, end: f64) -> Vec<f64> {
    use crate::world::Loop;
    let last = mover.track[mover.track.len() - 1][0];
    if last <= 0.0 {
        return Vec::new();
    }
    let period = if mover.repeat == Loop::Shuttle { 2.0 * last } else { last };
    let rounds = match mover.repeat {
        Loop::Once => 0..=0,
        _ => ((from + mover.phase) / period).floor() as i64..=((end + mover.phase) / period).ceil() as i64,
    };
    let mut times = Vec::new();
    for k in rounds {
        let base = k as f64 * period - mover.phase;
        for row in &mover.track {
            match mover.repeat {
                Loop::Cycle if row[0] == last => times.extend([base + last - 1e-6, base + last + 1e-6]),
                Loop::Shuttle => times.extend([base + row[0], base + period - row[0]]),
                _ => times.push(base + row[0]),
            }
        }
    }
    times.retain(|t| *t > from && *t < end);
    times
}

#[cfg(test)]
mod tests;
