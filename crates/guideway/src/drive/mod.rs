//! Driving: a plant, a controller, and the loop between them.
//!
//! [`execute`] drives a planned [`crate::timing::Trajectory`] in a world that moves and returns a [`Run`]. The controller sees an [`Observation`] only: a
//! noisy pose, the speeds and the movers that are visible. The run is judged with the true state, exactly.

mod ask;
mod body;
mod controllers;
mod course;
mod critics;
mod crowd;
mod dwa;
mod execute;
mod eyes;
mod field;
mod filter;
mod guard;
mod guide;
mod improved;
mod lidar;
mod limiter;
mod local;
mod navigator;
mod outline;
mod pace;
mod pilot;
mod ramp;
mod rays;
mod record;
mod request;
mod rooms;
mod search;
mod sense;
mod separation;
#[cfg(test)]
mod testing;
mod to_go;
mod trace;
mod tracker;
mod unicycle;
mod ways;

pub use ask::{Ask, Planning, Replanner};
pub use controllers::{CONTROLLERS, ControllerEntry, Setup, controller};
pub use course::Course;
pub use dwa::Dwa;
pub use execute::{Job, Sense, execute, execute_on};
pub use eyes::Eyes;
pub use guide::{Guide, Passing, SubGoals};
pub use improved::{Divide, ImprovedDwa, Room};
pub use lidar::{Lidar, Scan};
pub use navigator::OwnReplanner;
pub use outline::Outline;
pub use pilot::{Pilot, Step};
pub use record::{Collision, Energy, Event, MoverRecord, Outcome, Percentiles, Run, Separation, Sketch, Tracking};
pub use request::{Delivery, Found, Request};
pub use sense::{Track, visible};
pub use to_go::{CostToGo, DEAR};
pub use trace::{PlanRow, StepRow, Trace};
pub use tracker::Tracker;
pub use unicycle::{Unicycle, UnicyclePlant};

use crate::Point;
use crate::context::Context;
use crate::error::PlanError;
use crate::query::Limits;
use crate::timing::{DEFAULT_TURN_ACCELERATION, DEFAULT_TURN_RATE};
use crate::world::{Footprint, World};
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// A mobile base that turns about its reference point.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Robot {
    /// What it covers.
    pub footprint: Footprint,
    /// Largest speed, m/s.
    pub speed: f64,
    /// Largest acceleration, m/s2.
    pub acceleration: f64,
    /// Largest deceleration, m/s2, positive.
    pub deceleration: f64,
    /// Largest jerk, m/s3. A base can do more; controllers that limit the jerk of their commands keep to it.
    pub jerk: f64,
    /// Largest turn rate, rad/s.
    pub turn_rate: f64,
    /// Largest turn acceleration, rad/s2.
    pub turn_acceleration: f64,
}

impl Robot {
    /// A robot from its footprint and limits. A turn rate or acceleration that is unlimited becomes
    /// [`crate::timing::DEFAULT_TURN_RATE`] or [`crate::timing::DEFAULT_TURN_ACCELERATION`]: a plant needs a number.
    /// # Errors
    /// [`PlanError::BadParameter`] for limits out of range.
    pub fn new(footprint: Footprint, limits: &Limits) -> Result<Self, PlanError> {
        let l = limits.validated()?;
        Ok(Self {
            footprint: footprint.validated()?,
            speed: l.speed,
            acceleration: l.acceleration,
            deceleration: l.deceleration,
            jerk: l.jerk,
            turn_rate: l.turn_rate.unwrap_or(DEFAULT_TURN_RATE),
            turn_acceleration: l.turn_acceleration.unwrap_or(DEFAULT_TURN_ACCELERATION),
        })
    }

    /// Distance the robot needs to stop from speed `v` (m/s), m.
    pub fn braking_distance(&self, v: f64) -> f64 {
        v * v / (2.0 * self.deceleration)
    }
}

/// What the base is asked to do.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Command {
    /// Speed, m/s.
    pub v: f64,
    /// Turn rate, rad/s, positive to the left.
    pub w: f64,
}

/// What a controller sees: estimates and visible movers, never the true world.
#[derive(Debug, Clone)]
pub struct Observation {
    /// s since the start of the run.
    pub time: f64,
    /// Estimated x, y (m) and heading (rad).
    pub pose: [f64; 3],
    /// Estimated speed, m/s.
    pub v: f64,
    /// Estimated turn rate, rad/s.
    pub w: f64,
    /// Movers that the sensor reports, in a fixed order.
    pub tracks: Vec<Track>,
    /// Age of the newest good look at the surroundings, s.
    pub age: f64,
    /// What the robot knows of the static world, where that is not the map it was given.
    pub known: Option<Arc<World>>,
    /// The newest scan, where there is a lidar.
    pub scan: Option<Arc<Scan>>,
    /// Share of the planned speed to drive at, 0 to 1; it changes within the limits of acceleration and jerk. See [`Observation::within`].
    pub share: f64,
    /// Largest speed allowed here, m/s.
    pub top: f64,
}

impl Observation {
    /// A robot that knows its map and sees no movers.
    pub fn new(time: f64, pose: [f64; 3], v: f64, w: f64) -> Self {
        Self { time, pose, v, w, tracks: Vec::new(), age: 0.0, known: None, scan: None, share: 1.0, top: f64::INFINITY }
    }

    /// A command within the share and the speed that are allowed: slower on the same arc, in place a slower turn. Doing it twice changes nothing.
    pub fn within(&self, robot: &Robot, command: Command) -> Command {
        let most = (self.share * robot.speed).min(self.top).max(0.0);
        if command.v.abs() > most {
            let slow = most / command.v.abs();
            return Command { v: most.copysign(command.v), w: command.w * slow };
        }
        if command.v == 0.0 {
            let rate = self.share.max(0.0) * robot.turn_rate;
            return Command { v: 0.0, w: command.w.clamp(-rate, rate) };
        }
        command
    }
}

/// The true state of a base; only the judge of a run reads it.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Motion {
    /// x, y (m) and heading (rad).
    pub pose: [f64; 3],
    /// m/s.
    pub v: f64,
    /// rad/s.
    pub w: f64,
}

/// Why a controller stops or asks for a new plan.
#[derive(Debug, Clone, PartialEq)]
pub struct Reason {
    /// For people.
    pub text: String,
    /// Centre and radius (m) of the disc that is in the way, if one is.
    pub place: Option<(Point, f64)>,
}

impl Reason {
    /// A reason without a place.
    pub fn new(text: impl Into<String>) -> Self {
        Self { text: text.into(), place: None }
    }
    /// A reason with what is in the way.
    pub fn at(text: impl Into<String>, track: &Track) -> Self {
        Self { text: text.into(), place: Some((track.position, track.outline.circumscribed())) }
    }
}

/// What a controller decides in one control step.
#[derive(Debug, Clone, PartialEq)]
pub enum Decision {
    /// Go on.
    Drive(Command),
    /// Brake with all the base has and stay.
    Stop(Reason),
    /// Brake and ask for a new plan.
    Replan(Reason),
}

/// How the commands of a controller are kept to the share and the speed that an [`Observation`] allows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Pacing {
    /// It does so itself, within the limit of jerk; its commands are not changed.
    Eased,
    /// It has judged each of its commands; they are cut and not changed otherwise.
    Judged,
    /// They are cut, and slowed where they would else exceed the limits of acceleration and jerk; never faster than decided.
    Slower,
    /// They are brought within the limits of acceleration, deceleration and jerk, also where that means to slow down later.
    Limited,
}

/// Turns observations into commands.
pub trait Controller: Send {
    /// What to follow, before the first step and after every new plan.
    fn follow(&mut self, guide: &Arc<Guide>);
    /// One control step.
    fn decide(&mut self, seen: &Observation, ctx: &mut Context) -> Decision;
    /// How its commands are kept to the share and the speed that an observation allows.
    fn pacing(&self) -> Pacing {
        Pacing::Slower
    }
    /// What the last step had in mind, for pictures.
    fn trace(&self) -> Option<Sketch> {
        None
    }
}

/// A mobile base: simulated or real.
pub trait Plant {
    /// What its sensors say about itself (no tracks; the sensing of movers is separate).
    fn observe(&mut self) -> Observation;
    /// Moves under a command for `dt` s.
    fn step(&mut self, u: Command, dt: f64);
    /// The true state, for judging a run.
    fn motion(&self) -> Motion;
    /// It cannot go on; the run ends as if the caller had cancelled it.
    fn failed(&self) -> bool {
        false
    }
}

/// The pose after moving with constant `v` (m/s) and `w` (rad/s) for `t` s: the exact arc, a line below 1e-6 rad/s.
#[inline]
pub fn arc(pose: [f64; 3], v: f64, w: f64, t: f64) -> [f64; 3] {
    let [x, y, yaw] = pose;
    if w.abs() < 1e-6 {
        let (s, c) = (yaw + 0.5 * w * t).sin_cos();
        return [x + v * t * c, y + v * t * s, yaw + w * t];
    }
    let (s0, c0) = yaw.sin_cos();
    let (s1, c1) = (yaw + w * t).sin_cos();
    [x + v / w * (s1 - s0), y - v / w * (c1 - c0), yaw + w * t]
}
