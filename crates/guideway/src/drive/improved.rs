//! The improved dynamic window approach, in the settings of its source and in ours.
//!
//! Source: \[lu2025\] on \[fox1997\] (`preset=paper`); passive safety as in \[bouraine2012\] (`preset=default`). Equations, parameters and the proof of
//! the guarantee: `docs/methods/improved-dwa.md`.

mod left;
mod paper;
mod plan;
mod readings;

pub use readings::{Divide, Room};

use super::critics::Weights;
use super::{Controller, Setup};
use crate::error::PlanError;
use crate::plan::Preset;
use serde::{Deserialize, Serialize};

/// Parameters of the improved dynamic window.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
#[expect(clippy::struct_excessive_bools, reason = "independent switches, each a parameter of its own")]
pub struct ImprovedDwa {
    /// Whose settings.
    pub preset: Preset,
    /// Weight of the heading to the sub-goal.
    pub heading: f64,
    /// Weight of the free distance along the arc.
    pub dist: f64,
    /// Weight of the speed.
    pub velocity: f64,
    /// Weight of the agreement with the direction of the path.
    pub path: f64,
    /// Weight of the time to the goal that is left at the end of the prediction, 1/s.
    pub to_go: f64,
    /// Weight of the distance from the path over time, 1/(m s).
    pub deviation: f64,
    /// Weight of nearness to movers over time, 1/s.
    pub near: f64,
    /// Weight of standing in the way of movers over time, 1/s.
    pub exposed: f64,
    /// Weight of standing in the way of movers that turn around, over time, 1/s.
    pub turned: f64,
    /// Weight of a change of the command, s/m.
    pub change: f64,
    /// Weight of keeping to the side chosen before.
    pub keep_on: f64,
    /// Control period, s: the window of the source, and how long a command may act in the guarantee.
    pub period: f64,
    /// Prediction, s.
    pub horizon: f64,
    /// Distance kept to obstacles in predictions, m (null: to static ones half the planned clearance, 0.02 to 0.1 m, to movers 0.1 m).
    pub safety: Option<f64>,
    /// Steps of the sampled speeds (m/s) and turn rates (rad/s).
    pub speed_step: f64,
    /// Steps of the sampled turn rates, rad/s.
    pub turn_step: f64,
    /// Above this speed the robot brakes when obstacles are nearer than `safety`, below it turns in place, m/s.
    pub emergency: f64,
    /// What `dist` is (`preset=paper`).
    pub room: Room,
    /// Distances count up to this in `dist`, m.
    pub far: f64,
    /// What the scores of a critic are divided by (`preset=paper`).
    pub divide: Divide,
    /// The heading to the sub-goal is judged so long ahead, s.
    pub aim: f64,
    /// Is `safety` measured from the reference point, not from the hull?
    pub centred: bool,
    /// Below `emergency`, nearer than `safety`: turns in place towards the sub-goal; else the window goes on.
    pub pivot: bool,
    /// Arcs on which anything is met within `horizon` are out; else those on which the robot could not stop before it.
    pub clear: bool,
    /// Only commands after which a full brake ends before anything can be met.
    pub guarantee: bool,
    /// Commanded speeds keep to the jerk of the robot, but for emergencies.
    pub jerk_limited: bool,
    /// Bound of the error of pose and model, m.
    pub error: f64,
    /// Growth of that bound with the distance driven, 1.
    pub drift: f64,
    /// Time constant of the speed, s.
    pub lag_speed: f64,
    /// Time constant of the turn rate, s.
    pub lag_turn: f64,
    /// Time until a command reaches the actuators, s.
    pub delay: f64,
    /// Growth of the distance kept to movers with the time predicted, m/s.
    pub growth: f64,
    /// Plans kept in the search.
    pub beam: u32,
    /// Speed of driving backwards to get out of the way, m/s; 0: never.
    pub reverse: f64,
    /// Trust in each observed pose against odometry, 0 to 1.
    pub trust: f64,
    /// Time without progress after which a new plan is asked for, s.
    pub patience: f64,
}

impl Default for ImprovedDwa {
    fn default() -> Self {
        Self {
            preset: Preset::Default,
            heading: 0.0,
            dist: 0.0,
            velocity: 0.0,
            path: 0.2,
            to_go: 1.0,
            deviation: 0.15,
            near: 0.6,
            exposed: 1.0,
            turned: 1.0,
            change: 0.1,
            keep_on: 0.03,
            period: 0.05,
            horizon: 4.0,
            safety: None,
            speed_step: 0.01,
            turn_step: 0.02,
            emergency: 0.2,
            room: Room::Free,
            far: 2.0,
            divide: Divide::Sum,
            aim: 1.0,
            centred: false,
            pivot: true,
            clear: false,
            guarantee: true,
            jerk_limited: false,
            error: 0.015,
            drift: 0.02,
            lag_speed: 0.08,
            lag_turn: 0.06,
            delay: 0.0,
            growth: 0.02,
            beam: 6,
            reverse: 0.3,
            trust: 0.2,
            patience: 6.0,
        }
    }
}

impl ImprovedDwa {
    /// The settings of the source; its four weights in the order of its objective.
    pub fn paper() -> Self {
        Self {
            preset: Preset::Paper,
            heading: 0.45,
            dist: 0.35,
            velocity: 0.12,
            path: 0.08,
            to_go: 0.0,
            deviation: 0.0,
            near: 0.0,
            exposed: 0.0,
            turned: 0.0,
            change: 0.0,
            keep_on: 0.0,
            period: 0.1,
            horizon: 3.0,
            safety: Some(0.35),
            guarantee: false,
            reverse: 0.0,
            ..Self::default()
        }
    }

    /// The controller for a robot in a world.
    /// # Errors
    /// [`PlanError::BadParameter`] for a parameter out of range.
    pub fn build(self, setup: &Setup) -> Result<Box<dyn Controller>, PlanError> {
        let named = [
            ("heading", self.heading),
            ("dist", self.dist),
            ("velocity", self.velocity),
            ("path", self.path),
            ("to_go", self.to_go),
            ("deviation", self.deviation),
            ("near", self.near),
            ("exposed", self.exposed),
            ("turned", self.turned),
            ("change", self.change),
            ("keep_on", self.keep_on),
            ("safety", self.safety.unwrap_or(0.0)),
            ("emergency", self.emergency),
            ("far", self.far),
            ("aim", self.aim),
            ("error", self.error),
            ("drift", self.drift),
            ("growth", self.growth),
            ("reverse", self.reverse),
            ("trust", self.trust),
            ("patience", self.patience),
        ];
        super::controllers::check("improved-dwa", &named)?;
        let times = [
            ("period", self.period, [1e-3, 1.0]),
            ("horizon", self.horizon, [0.1, 30.0]),
            ("lag_speed", self.lag_speed, [0.0, 2.0]),
            ("lag_turn", self.lag_turn, [0.0, 2.0]),
            ("delay", self.delay, [0.0, 2.0]),
            ("speed_step", self.speed_step, [1e-3, 1.0]),
            ("turn_step", self.turn_step, [1e-3, 1.0]),
            ("beam", f64::from(self.beam), [1.0, 1000.0]),
        ];
        if let Some((name, value, [low, high])) = times.into_iter().find(|(_, v, [low, high])| !(*low..=*high).contains(v)) {
            return Err(PlanError::bad(format!("improved-dwa.{name}"), value, format!("{low} to {high}")));
        }
        Ok(if self.preset == Preset::Paper { paper::build(self, setup) } else { plan::build(self, setup) })
    }

    fn weights(&self) -> Weights {
        let p = self;
        Weights {
            heading: p.heading,
            dist: p.dist,
            velocity: p.velocity,
            path: p.path,
            to_go: p.to_go,
            deviation: p.deviation,
            near: p.near,
            exposed: p.exposed,
            turned: p.turned,
            change: p.change,
            keep_on: p.keep_on,
        }
    }
}

#[cfg(test)]
mod tests;
