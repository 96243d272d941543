//! Tracks the timed motion: Kanayama's law on a clock that waits for the robot.
//!
//! Source: \[kanayama1990\]; the gains are our own, for robots of about 1 m/s.
//! Departures: turns in place add `k_turn * e_theta`; poses are filtered with odometry; reference speeds lead by the actuator lag; the clock runs
//! at a rate from 0 to 1, slower when the robot falls behind, 0 when something is on the path ahead, and the reference speeds scale with it, so
//! that stops and restarts keep the acceleration limits.

use super::filter::Filter;
use super::{Command, Controller, Course, Decision, Guide, Observation, Pacing, Reason, Setup, Track};
use crate::context::Context;
use crate::error::PlanError;
use crate::timing::State;
use crate::world::shape::wrap;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// Distance from the end of the motion that is driven after it is over, m, at most how fast, m/s, and the bearing above which it is first turned to, rad.
const BESIDE: f64 = 0.06;
const HOMING: f64 = 0.3;
const ASIDE: f64 = 0.5;

/// Parameters of the tracker.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Tracker {
    /// Gain along the heading, 1/s.
    pub k_x: f64,
    /// Gain across the heading, 1/m2.
    pub k_y: f64,
    /// Gain of the heading, 1/m.
    pub k_theta: f64,
    /// Gain of the heading in turns in place, 1/s.
    pub k_turn: f64,
    /// The reference speeds are read so far ahead, s: makes up for actuator lags.
    pub lead: f64,
    /// Trust in each observed pose against odometry, 0 to 1.
    pub trust: f64,
    /// The clock slows when the robot is farther behind than this, m.
    pub behind: f64,
    /// Distance kept to movers ahead, m.
    pub margin: f64,
    /// Movers are predicted over the braking time and this, s.
    pub foresight: f64,
    /// Waiting time after which a new plan is asked for, s.
    pub patience: f64,
}

impl Default for Tracker {
    fn default() -> Self {
        Self { k_x: 1.5, k_y: 4.0, k_theta: 2.5, k_turn: 2.5, lead: 0.08, trust: 0.2, behind: 0.3, margin: 0.2, foresight: 1.0, patience: 5.0 }
    }
}

impl Tracker {
    /// The controller for a robot in a world.
    /// # Errors
    /// [`PlanError::BadParameter`] for a negative or infinite parameter.
    pub fn build(self, setup: &Setup) -> Result<Box<dyn Controller>, PlanError> {
        let named = [
            ("k_x", self.k_x),
            ("k_y", self.k_y),
            ("k_theta", self.k_theta),
            ("k_turn", self.k_turn),
            ("lead", self.lead),
            ("trust", self.trust),
            ("behind", self.behind),
            ("margin", self.margin),
            ("foresight", self.foresight),
            ("patience", self.patience),
        ];
        super::controllers::check("tracker", &named)?;
        let radius = setup.robot.footprint.circumscribed();
        let filter = Filter::new(self.trust.min(1.0));
        let setup = setup.clone();
        Ok(Box::new(Following { p: self, setup, radius, filter, course: None, clock: 0.0, rate: 0.0, s: 0.0, last: None, waiting: None }))
    }
}

/// The tracker at work.
struct Following {
    p: Tracker,
    setup: Setup,
    radius: f64,
    filter: Filter,
    course: Option<Arc<Course>>,
    /// Time along the course, s.
    clock: f64,
    /// How fast it runs, 0 to 1.
    rate: f64,
    /// Arc length of the robot's projection, m.
    s: f64,
    last: Option<f64>,
    /// Since when something is in the way, s.
    waiting: Option<f64>,
}

impl Controller for Following {
    fn pacing(&self) -> Pacing {
        Pacing::Limited
    }

    fn follow(&mut self, guide: &Arc<Guide>) {
        self.course = Some(Arc::clone(&guide.course));
        self.clock = if guide.from > 0.0 { guide.course.at_length(guide.from).t } else { 0.0 };
        (self.rate, self.s, self.waiting) = (0.0, guide.from, None);
    }

    fn decide(&mut self, seen: &Observation, _ctx: &mut Context) -> Decision {
        let Some(course) = self.course.clone() else { return Decision::Stop(Reason::new("no course to follow")) };
        let mut seen = seen.clone();
        self.filter.apply(&mut seen);
        let seen = &seen;
        let dt = self.last.map_or(0.0, |t| seen.time - t);
        self.last = Some(seen.time);
        self.s = course.project([seen.pose[0], seen.pose[1]], self.s, self.s + 0.2 + 2.0 * seen.v.abs() * dt).0;
        if let Some(track) = self.in_the_way(&course, seen) {
            self.rate = 0.0;
            let since = *self.waiting.get_or_insert(seen.time);
            if seen.time - since >= self.p.patience && seen.v.abs() < 0.05 {
                self.waiting = Some(seen.time);
                return Decision::Replan(Reason::at(format!("mover {} stays on the path", track.id), track));
            }
            return Decision::Stop(Reason::at(format!("mover {} ahead on the path", track.id), track));
        }
        self.waiting = None;
        self.advance(&course, seen, dt);
        let reference = course.at(self.clock);
        if self.clock >= course.duration() {
            if let Some(home) = self.home(&reference, seen) {
                return Decision::Drive(home);
            }
            if error(&reference, seen)[0] < 0.01 && seen.v.abs() < 0.05 {
                return Decision::Stop(Reason::new("end of the motion"));
            }
        }
        Decision::Drive(self.law(&reference, &course.at(self.clock + self.rate * self.p.lead), seen))
    }
}

impl Following {
    /// Moves the clock on.
    fn advance(&mut self, course: &Course, seen: &Observation, dt: f64) {
        let reference = course.at(self.clock);
        let e = error(&reference, seen);
        let late = (e[0].abs().max(e[1].abs()) - self.p.behind).max(0.0) / self.p.behind.max(1e-3) + (e[2].abs() - 0.4).max(0.0) / 0.4;
        let robot = &self.setup.robot;
        let next = course.at(self.clock + 0.1);
        let allowed = seen.share.min(seen.top / next.speed.max(reference.speed).max(1e-9)).max(0.0);
        let target = (1.0 - late).clamp(0.0, 1.0).min(allowed);
        let rise = if next.speed > 0.05 || next.turn_rate.abs() < 0.05 {
            robot.acceleration / next.speed.max(0.2)
        } else {
            robot.turn_acceleration / next.turn_rate.abs().max(0.2)
        };
        self.rate = target.min(self.rate + rise * dt);
        self.clock = (self.clock + self.rate * dt).min(course.duration());
    }

    /// The motion is over and its end is still away, as after a lateral error that a reference at rest cannot mend: straight to it, slowly.
    fn home(&self, end: &State, seen: &Observation) -> Option<Command> {
        let [ahead, left, _] = error(end, seen);
        let (off, robot) = (ahead.hypot(left), &self.setup.robot);
        let turn = left.atan2(ahead);
        let v = if turn.abs() > ASIDE { 0.0 } else { (self.p.k_x * off).min(HOMING).min(robot.speed) * turn.cos() };
        (off > BESIDE).then(|| Command { v, w: (self.p.k_turn * turn).clamp(-robot.turn_rate, robot.turn_rate) })
    }

    /// Kanayama's law.
    fn law(&self, reference: &State, ahead: &State, seen: &Observation) -> Command {
        let [ex, ey, et] = error(reference, seen);
        let (v, w) = (self.rate * ahead.speed, self.rate * ahead.turn_rate);
        // A clock that a large heading error has stopped runs again only once the robot has turned back.
        let turning = reference.speed < 1e-3 || v < 1e-3;
        let spin = if turning { self.p.k_turn * et } else { 0.0 };
        let along = if turning && et.abs() > 0.1 { 0.0 } else { self.p.k_x * ex };
        let robot = &self.setup.robot;
        Command {
            v: (v * et.cos() + along).clamp(0.0, robot.speed),
            w: (w + v * (self.p.k_y * ey + self.p.k_theta * et.sin()) + spin).clamp(-robot.turn_rate, robot.turn_rate),
        }
    }

    /// The first mover that comes near the stretch the robot needs to stop and a little more.
    fn in_the_way<'t>(&self, course: &Course, seen: &'t Observation) -> Option<&'t Track> {
        let v = seen.v.abs();
        let stop = v / self.setup.robot.deceleration;
        let ahead = self.setup.robot.braking_distance(v) + 0.2 * v + self.p.margin;
        let keep = self.radius + self.p.margin;
        let (steps, times) = ((ahead / 0.05).ceil() as u32, ((stop + self.p.foresight) / 0.1).ceil() as u32);
        seen.tracks.iter().find(|track| {
            // Beside one that is nearer than that already it may go on as long as it comes no nearer.
            let keep = keep.min(track.distance([seen.pose[0], seen.pose[1]], 0.0) - 0.01).max(self.radius);
            (1..=steps).any(|i| {
                let at = course.at_length(self.s + ahead * f64::from(i) / f64::from(steps));
                let p = [at.pose[0], at.pose[1]];
                let nears = |t: f64| track.distance(p, t) < keep;
                (0..=times).any(|k| nears((stop + self.p.foresight) * f64::from(k) / f64::from(times.max(1))))
            })
        })
    }
}

/// Reference minus robot in the robot's frame: ahead (m), left (m), heading (rad).
fn error(reference: &State, seen: &Observation) -> [f64; 3] {
    let (dx, dy) = (reference.pose[0] - seen.pose[0], reference.pose[1] - seen.pose[1]);
    let (s, c) = seen.pose[2].sin_cos();
    [c * dx + s * dy, c * dy - s * dx, wrap(reference.pose[2] - seen.pose[2])]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::drive::testing::{legs, limits, query, room};
    use crate::drive::{Plant, Robot, Setup};
    use crate::world::{Footprint, World};

    /// The clock stops when the heading is far off; the robot must turn back, or it would wait for ever.
    #[test]
    fn a_robot_that_points_elsewhere_turns_back() {
        let course = Arc::new(Course::new(&legs(&[[0.0, 0.0], [5.0, 0.0]], limits())).unwrap());
        let world = Arc::new(World::from_shapes([-1.0, -1.0, 6.0, 1.0], Vec::new(), 0.1).unwrap());
        let robot = Robot::new(Footprint::Disc(0.1), &limits()).unwrap();
        let mut tracker = Tracker::default().build(&Setup { world, robot, clearance: 0.0 }).unwrap();
        tracker.follow(&Arc::new(Guide::along(Arc::clone(&course))));
        let (mut ctx, mut last) = (Context::new(0), Command::default());
        for k in 0..400 {
            let time = 0.02 * f64::from(k);
            let state = course.at(time.min(2.0));
            let (off, v) = if k < 100 { (0.0, state.speed) } else { (1.2, 0.0) };
            let seen = Observation::new(time, [state.pose[0], state.pose[1], off], v, 0.0);
            let Decision::Drive(command) = tracker.decide(&seen, &mut ctx) else { panic!("nothing is in the way") };
            last = command;
        }
        assert!(last.w < -0.5, "{last:?}");
    }

    /// Beside the end of the motion with a reference at rest there is no lateral feedback; it must be driven to all the same.
    #[test]
    fn a_robot_beside_the_end_goes_there() {
        let query = query(&room([-1.0, -1.0, 6.0, 1.0], Vec::new(), Vec::new()), &[[0.0, 0.0], [2.0, 0.0]]);
        let motion = legs(&[[0.0, 0.0], [2.0, 0.0]], limits());
        let course = Arc::new(Course::new(&motion).unwrap());
        let robot = Robot::new(Footprint::Disc(0.1), &limits()).unwrap();
        let setup = Setup { world: Arc::clone(&query.world), robot: robot.clone(), clearance: 0.0 };
        let mut plant = crate::drive::Unicycle::default().place(&robot, [0.0, 0.17, 0.0], 1);
        // Without lateral feedback it comes to the end beside it.
        let mut aside = Tracker { k_y: 0.0, k_theta: 0.0, ..Tracker::default() }.build(&setup).unwrap();
        aside.follow(&Arc::new(Guide::along(Arc::clone(&course))));
        for k in 0..1000 {
            let seen = Observation { time: 0.02 * f64::from(k), ..plant.observe() };
            match aside.decide(&seen, &mut Context::new(0)) {
                Decision::Drive(command) => plant.step(command, 0.02),
                _ => plant.step(Command::default(), 0.02),
            }
        }
        let [x, y, _] = plant.motion().pose;
        assert!((x - 2.0).hypot(y) < 0.08, "{x} {y}");
    }
}
