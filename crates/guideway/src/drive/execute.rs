//! The loop between controller and plant, and the judge beside it.

use super::record::{Log, moving};
use super::sense::Stage;
use super::separation::{Judge, Leg, With};
use super::trace::Tracer;
use super::{
    Collision, Command, Controller, Course, Delivery, Event, Lidar, Motion, MoverRecord, Outcome, Outline, Percentiles, Pilot, Plant, Replanner,
    Robot, Run, Scan, Separation, Step, Unicycle,
};
use crate::Point;
use crate::context::Context;
use crate::error::PlanError;
use crate::query::Query;
use crate::timing::Trajectory;
use crate::world::shape::{distance, wrap};
use crate::world::{Mover, SpeedMap};
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};
use std::sync::Arc;
use std::time::Instant;

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
    /// A run without progress (0.05 m nearer to the end of its course) for so long is stuck, s.
    pub stuck_after: f64,
    /// Command period, s.
    pub period: f64,
    /// How the surroundings are seen.
    pub sense: Sense,
    /// Does the robot know the static world from the start? Else it knows its bounds and what its lidar has seen.
    pub map_known: bool,
    /// Top speed of whatever moves here, m/s: what a lidar cannot tell of the movers it shows. Without it [`Eyes`](super::Eyes) have to guess.
    pub mover_speed: Option<f64>,
    /// Plans anew where the way is blocked; without one the robot waits.
    pub replanner: Option<&'a Replanner<'a>>,
    /// When its plans can be driven; times are at most 1000 s.
    pub delivery: Delivery,
    /// How fast may be driven where.
    pub speed_map: Option<Arc<SpeedMap>>,
    /// Keep what reports show of single steps?
    pub trace: bool,
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
            mover_speed: None,
            replanner: None,
            delivery: Delivery::AtOnce,
            speed_map: None,
            trace: false,
        })
    }

    fn validate(&self) -> Result<(), PlanError> {
        self.plant.validated()?;
        let named = [
            ("arrival", self.arrival, [1e-6, 1e6]),
            ("time_limit", self.time_limit.unwrap_or(1.0), [1e-6, 1e5]),
            ("stuck_after", self.stuck_after, [1e-3, 1e6]),
            ("period", self.period, [1e-4, 1.0]),
            ("plan_time", if let Delivery::After(wait) = self.delivery { wait } else { 0.0 }, [0.0, 1e3]),
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
    let mut pilot = Pilot::of_job(job, Box::new(controller))?;
    let course = Arc::clone(&pilot.guide().course);
    let limit = job.time_limit.unwrap_or(3.0 * course.duration() + 60.0);
    let mut drive = Drive::new(job, course, ctx.seed());
    let outcome = loop {
        let t = drive.steps as f64 * job.period;
        if let Some(outcome) = drive.judge_state(plant.motion(), t) {
            break outcome;
        }
        if t >= limit {
            break Outcome::Timeout;
        }
        if ctx.poll().is_some() || plant.failed() {
            drive.cancelled = true;
            drive.event(t, "cancel", "cancelled by the caller or by the budget");
            break Outcome::Timeout;
        }
        let command = drive.pilot(&mut pilot, plant, t, ctx);
        if drive.move_on(plant, command, t) {
            break Outcome::Collision;
        }
    };
    Ok(drive.finish(outcome, plant.motion(), pilot.replans()))
}

/// The state of the loop.
struct Drive<'a> {
    job: &'a Job<'a>,
    course: Arc<Course>,
    stage: Stage,
    judge: Judge<'a>,
    log: Log,
    tracer: Option<Tracer>,
    seconds: Vec<f64>,
    plan_seconds: Vec<f64>,
    /// Noise of the lidar, and when it has turned next, s.
    rays: ChaCha8Rng,
    next_scan: f64,
    events: Vec<Event>,
    steps: u64,
    emergency_stops: u32,
    /// Arc length reached, m.
    s: f64,
    /// Least distance left so far, m, and when it was reached, s.
    progress: (f64, f64),
    collision: Option<Collision>,
    ended: Option<f64>,
    cancelled: bool,
}

impl<'a> Drive<'a> {
    fn new(job: &'a Job<'a>, course: Arc<Course>, seed: u64) -> Self {
        let mut log = Log::default();
        log.courses.push((0, Arc::clone(&course)));
        Self {
            job,
            tracer: job.trace.then(|| Tracer::new(&course)),
            course,
            stage: Stage::new(job.query.world.movers()),
            judge: Judge::new(&job.query.world, &job.robot.footprint),
            log,
            seconds: Vec::new(),
            plan_seconds: Vec::new(),
            rays: Lidar::random(seed),
            next_scan: 0.0,
            events: Vec::new(),
            steps: 0,
            emergency_stops: 0,
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

    /// One control step: what the sensors show, what the pilot makes of it, and the record of both.
    fn pilot(&mut self, pilot: &mut Pilot, plant: &mut dyn Plant, t: f64, ctx: &mut Context) -> Command {
        let mut seen = plant.observe();
        seen.time = t;
        let scan = self.scan(plant.motion().pose, t);
        if self.job.sense == Sense::Truth {
            seen.tracks = self.stage.tracks(t);
        }
        let started = Instant::now();
        let step = pilot.step(&mut seen, scan, ctx);
        self.seconds.push(started.elapsed().as_secs_f64() - step.plan_seconds.iter().sum::<f64>());
        let fast = self.log.driven.last().is_some_and(|r| r[4].abs() > 0.2);
        self.emergency_stops += u32::from(step.stopped && fast);
        if step.replanned {
            self.take(&pilot.guide().course, t, &step);
        }
        if let Some(tracer) = &mut self.tracer {
            tracer.step(&seen, &step, pilot);
        }
        self.plan_seconds.extend(step.plan_seconds);
        self.events.extend(step.events);
        step.command
    }

    /// A scan of what is there, when the lidar has turned.
    fn scan(&mut self, pose: [f64; 3], t: f64) -> Option<Scan> {
        let Sense::Lidar(lidar) = self.job.sense else { return None };
        if t + 1e-9 < self.next_scan {
            return None;
        }
        self.next_scan += 1.0 / lidar.rate;
        let movers: Vec<(Outline, Point)> = self.stage.present().map(|(_, mover, outline)| (outline.clone(), mover.at(t).0)).collect();
        Some(lidar.scan(self.job.query.world.solid(), &movers, (pose, t), &mut self.rays))
    }

    /// A new course is in force. It is no progress by itself.
    fn take(&mut self, course: &Arc<Course>, t: f64, step: &Step) {
        self.course = Arc::clone(course);
        self.log.courses.push((self.log.driven.len(), Arc::clone(course)));
        (self.s, self.progress.0) = (0.0, course.length() + 0.05);
        if let Some(tracer) = &mut self.tracer {
            let why = step.events.iter().rev().find(|e| e.kind == "replan").map_or("", |e| &e.reason);
            tracer.plan(t, course, why);
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

    fn finish(mut self, outcome: Outcome, m: Motion, replans: u32) -> Run {
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
            replans,
            forbidden: self.judge.forbidden,
            min_separation: Separation { still: finite(self.judge.still), movers: finite(self.judge.moving) },
            emergency_stops: self.emergency_stops,
            period: self.job.period,
            step_seconds: Percentiles::of(self.seconds),
            plan_seconds: Percentiles::of(self.plan_seconds),
            tracking: self.log.tracking(goal, self.job.trajectory.limits.jerk, &self.job.robot, self.job.period),
            energy: self.log.energy(),
            driven: self.log.driven,
            events: self.events,
            collision: self.collision,
            cancelled: self.cancelled,
            trace: self.tracer.map(Tracer::finish),
        }
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
