//! A dynamic window that is steered by the planned motion and never gives up a free way to stop.
//!
//! Source: \[fox1997\] for the window, \[kanayama1990\] for following the path, passive safety (stand still before anything can be met) as in
//! \[bouraine2012\].
//! Manoeuvres: arcs of the dynamic window, and the path itself at shares of the speed planned, beside it by some offsets. Each is predicted twice
//! in (place, time) against the static map and movers at constant velocity: turned into a full stop after one period, and driven on to the
//! horizon. A manoeuvre is admitted only if the stop meets nothing while the robot moves. Where the robot would be met after the stop, going on
//! for some time and stopping then must be free, else the manoeuvre ranks below all others. Of the admitted the one with the best sum of critics
//! is driven. If that one will be met, or none is admitted, the robot gets out of the way: any manoeuvre, headings all around too, that leads to
//! a place where it is not met, or is met last. No reverse.

use super::dwa::{nearest, why, window};
use super::field::{Field, Margins, Met};
use super::filter::Filter;
use super::local::Local;
use super::rollout::{Forecast, Predictor, Sim, Way};
use super::{Command, Controller, Course, Decision, Guide, Observation, Reason, Setup};
use crate::context::Context;
use crate::error::PlanError;
use crate::world::shape::wrap;
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;
use std::sync::Arc;

/// Shares of the reference speed and offsets (m) of the manoeuvres along the path.
const SHARES: [f64; 3] = [1.0, 0.6, 0.25];
const OFFSETS: [f64; 7] = [0.0, -0.3, 0.3, -0.6, 0.6, -1.0, 1.0];
/// Shares of the horizon after which a plan to get out of the way may stop.
const GO_ON: [f64; 5] = [0.0, 0.2, 0.4, 0.7, 1.0];
/// Headings tried to get out of the way.
const ROUND: u32 = 12;
/// Room to movers above which they no longer count as near, m.
const NEAR: f64 = 1.0;
/// Distance to the end of the path that counts as there, m.
const THERE: f64 = 0.03;
/// Distance beside the end of the path that counts as there, m, and the speed at which the robot goes there from farther away, m/s.
const BESIDE: f64 = 0.06;
const HOMING: f64 = 0.3;

/// Parameters of the predictive dynamic window.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Predictive {
    /// Weight of the progress along the path, as a share of what the reference speed allows.
    pub progress: f64,
    /// Weight of the distance from the path, 1/m.
    pub deviation: f64,
    /// Weight of the heading against the path, 1/rad.
    pub heading: f64,
    /// Weight of nearness to movers.
    pub near: f64,
    /// Weight of an expected contact that can still be avoided.
    pub risk: f64,
    /// Weight of a stop that may come too late if a mover turns against the robot.
    pub doubt: f64,
    /// Weight of keeping to the manoeuvre chosen before.
    pub keep_on: f64,
    /// Weight of a change of the command, s/m.
    pub change: f64,
    /// Time after which a chosen manoeuvre may turn into a stop, s; covers the command period and the actuator lags.
    pub period: f64,
    /// Prediction, s.
    pub horizon: f64,
    /// Time that the place of a stop must stay free, s.
    pub park: f64,
    /// Time for which a chosen command is held before the next choice, s.
    pub hold: f64,
    /// Sampled speeds.
    pub speeds: u32,
    /// Sampled turn rates.
    pub turns: u32,
    /// Distance kept to static obstacles, m; `None`: half the planned clearance, at least 0.02 and at most 0.1.
    pub margin: Option<f64>,
    /// Distance kept to movers, m.
    pub keep: f64,
    /// Growth of that distance with the time predicted, m/s.
    pub growth: f64,
    /// Trust in each observed pose against odometry, 0 to 1.
    pub trust: f64,
    /// Time without progress after which a new plan is asked for, s.
    pub patience: f64,
}

impl Default for Predictive {
    fn default() -> Self {
        Self {
            progress: 1.0,
            deviation: 0.5,
            heading: 0.1,
            near: 0.3,
            risk: 0.6,
            doubt: 0.5,
            keep_on: 0.1,
            change: 0.05,
            period: 0.15,
            horizon: 3.0,
            park: 2.5,
            hold: 0.04,
            speeds: 3,
            turns: 9,
            margin: None,
            keep: 0.15,
            growth: 0.02,
            trust: 0.2,
            patience: 6.0,
        }
    }
}

impl Predictive {
    /// The controller for a robot in a world.
    /// # Errors
    /// [`PlanError::BadParameter`] for a parameter out of range.
    pub fn build(self, setup: &Setup) -> Result<Box<dyn Controller>, PlanError> {
        let named = [
            ("progress", self.progress),
            ("deviation", self.deviation),
            ("heading", self.heading),
            ("near", self.near),
            ("risk", self.risk),
            ("doubt", self.doubt),
            ("keep_on", self.keep_on),
            ("change", self.change),
            ("period", self.period),
            ("horizon", self.horizon),
            ("park", self.park),
            ("hold", self.hold),
            ("margin", self.margin.unwrap_or(0.0)),
            ("keep", self.keep),
            ("growth", self.growth),
            ("trust", self.trust),
            ("patience", self.patience),
        ];
        super::controllers::check("predictive-dwa", &named)?;
        super::controllers::samples("predictive-dwa", &[("speeds", self.speeds), ("turns", self.turns)])?;
        let still = self.margin.unwrap_or((0.5 * setup.clearance).clamp(0.02, 0.1));
        let margins = Margins { still, moving: self.keep, growth: self.growth };
        let filter = Filter::new(self.trust.min(1.0));
        Ok(Box::new(Steering {
            p: self,
            setup: setup.clone(),
            margins,
            filter,
            course: None,
            s: 0.0,
            best: (0.0, f64::NAN),
            last: (Command::default(), None),
            held: None,
        }))
    }
}

/// The predictive window at work.
struct Steering {
    p: Predictive,
    setup: Setup,
    margins: Margins,
    filter: Filter,
    course: Option<Arc<Course>>,
    /// Arc length of the robot's projection, m.
    s: f64,
    /// Arc length reached, m, and when, s.
    best: (f64, f64),
    /// The command and the side of the path chosen before.
    last: (Command, Option<i32>),
    /// The command that is held, and until when, s.
    held: Option<(f64, Command)>,
}

/// The best manoeuvre so far.
struct Choice {
    score: f64,
    command: Command,
    way: Way,
    /// It will be met even if it stops.
    exposed: bool,
    /// What slows it down.
    met: Option<Met>,
}

impl Controller for Steering {
    fn follow(&mut self, guide: &Arc<Guide>) {
        self.course = Some(Arc::clone(&guide.course));
        (self.s, self.best, self.last) = (0.0, (0.0, f64::NAN), (Command::default(), None));
        self.held = None;
    }

    fn decide(&mut self, seen: &Observation, _ctx: &mut Context) -> Decision {
        let Some(course) = self.course.clone() else { return Decision::Stop(Reason::new("no course to follow")) };
        let mut seen = seen.clone();
        self.filter.apply(&mut seen);
        self.s = course.project([seen.pose[0], seen.pose[1]], self.s, self.s + 0.5).0;
        if let Some(decision) = self.at_the_end(&course, &seen) {
            return decision;
        }
        if self.best.1.is_nan() || self.s > self.best.0 + 0.1 {
            self.best = (self.s, seen.time);
        }
        if seen.time - self.best.1 > self.p.patience {
            self.best.1 = seen.time;
            return Decision::Replan(nearest(&seen));
        }
        if let Some((until, command)) = self.held
            && seen.time < until - 1e-9
        {
            return Decision::Drive(command);
        }
        let decision = self.choose(&course, &seen);
        self.held = if let Decision::Drive(command) = decision { Some((seen.time + self.p.hold, command)) } else { None };
        decision
    }
}

impl Steering {
    /// At the last point: the last turn in place, then rest.
    fn at_the_end(&self, course: &Course, seen: &Observation) -> Option<Decision> {
        let end = course.end().pose;
        if course.length() - self.s > THERE || off(end, seen) > BESIDE {
            return None;
        }
        let arrival = course.states().iter().rev().find(|q| q.s < course.length() - 1e-6).map_or(end[2], |q| q.pose[2]);
        let turn = wrap(end[2] - seen.pose[2]);
        if wrap(end[2] - arrival).abs() > 0.05 && turn.abs() > 0.03 && seen.v < 0.1 {
            let rate = self.setup.robot.turn_rate;
            return Some(Decision::Drive(Command { v: 0.0, w: (2.0 * turn).clamp(-rate, rate) }));
        }
        Some(Decision::Stop(Reason::new("at the end of the path")))
    }

    fn choose(&mut self, course: &Course, seen: &Observation) -> Decision {
        let robot = &self.setup.robot.clone();
        let span = self.p.horizon + self.p.park + 3.0;
        let field = Field::new(&self.setup.world, robot, seen, self.margins, span);
        let local = Local::new(course, self.s, robot.speed * (self.p.horizon + 0.5) + 0.5);
        let predictor = Predictor { field: &field, local: &local, robot };
        let start = Sim { pose: seen.pose, v: seen.v.max(0.0), w: seen.w, mark: 0 };
        let ways = if course.length() - self.s > THERE { self.ways(seen, local.first().speed) } else { home(course.end().pose, seen) };
        let mut met = None;
        let mut best = self.best_of(&predictor, &start, &ways, &mut met);
        if best.as_ref().is_none_or(|b| b.exposed) {
            best = self.escape(&predictor, &start, &ways);
        }
        self.last = best.as_ref().map_or((Command::default(), None), |c| (c.command, Some(side(c.way))));
        match best {
            Some(c) if c.command.v > 0.02 || c.command.w.abs() > 0.05 => Decision::Drive(c.command),
            Some(c) => Decision::Stop(why(c.met.or(met), seen)),
            None => Decision::Stop(why(met, seen)),
        }
    }

    /// All manoeuvres, the path itself first.
    fn ways(&self, seen: &Observation, reference: f64) -> Vec<Way> {
        let along = OFFSETS.iter().flat_map(|offset| SHARES.iter().map(|share| Way::Follow { share: *share, offset: *offset }));
        let arcs = window(&self.setup, seen, [self.p.period, reference], [self.p.speeds, self.p.turns]);
        along.chain(std::iter::once(Way::Arc { v: 0.0, w: 0.0 })).chain(arcs.into_iter().map(|(v, w)| Way::Arc { v, w })).collect()
    }

    fn best_of(&self, predictor: &Predictor, start: &Sim, ways: &[Way], met: &mut Option<Met>) -> Option<Choice> {
        let mut best: Option<Choice> = None;
        for way in ways {
            let stop = predictor.run(*way, *start, [self.p.period, f64::INFINITY, self.p.park]);
            if let Some((_, with)) = stop.contact
                && !stop.parked
            {
                *met = met.or(Some(with));
                continue;
            }
            let on = predictor.run(*way, *start, [f64::INFINITY, self.p.horizon, 0.0]);
            let exposed = stop.contact.filter(|_| !self.way_out(predictor, start, *way)).map(|c| c.0);
            let (v, w) = predictor.wanted(*way, start);
            let command = Command { v, w };
            let mut score = self.score(predictor, start, (&on, exposed), command);
            if exposed.is_none() && start.v.max(v) > 0.05 {
                score -= self.p.doubt * (-stop.doubt / NEAR).clamp(0.0, 1.0);
            }
            if beside(*way) && self.last.1 == Some(side(*way)) {
                score += self.p.keep_on;
            }
            if best.as_ref().is_none_or(|b| score > b.score) {
                best = Some(Choice { score, command, way: *way, exposed: exposed.is_some(), met: on.contact.or(stop.contact).map(|c| c.1) });
            }
        }
        best
    }

    /// Does going on for some time, then stopping and staying, meet nothing?
    fn way_out(&self, predictor: &Predictor, start: &Sim, way: Way) -> bool {
        GO_ON.iter().any(|share| predictor.run(way, *start, [share * self.p.horizon, f64::INFINITY, self.p.park]).contact.is_none())
    }

    /// The manoeuvre that gets out of the way: free for good with most room, else free for longest. Headings all around are tried as well.
    fn escape(&self, predictor: &Predictor, start: &Sim, ways: &[Way]) -> Option<Choice> {
        let top = predictor.robot.speed;
        let around = (0..ROUND).flat_map(|i| [top, 0.4 * top].map(|v| Way::Heading { yaw: wrap(f64::from(i) * TAU / f64::from(ROUND)), v }));
        let mut best: Option<Choice> = None;
        for way in ways.iter().copied().chain(around) {
            let value = |share: &f64| {
                let plan = predictor.run(way, *start, [(share * self.p.horizon).max(self.p.period), f64::INFINITY, self.p.park]);
                match plan.contact {
                    None => 10.0 + plan.gap.min(NEAR) - 0.3 * share,
                    Some((t, _)) => t - if plan.parked { 0.0 } else { 0.5 },
                }
            };
            let kept = if self.last.1 == Some(side(way)) { 0.2 } else { 0.0 };
            let score = GO_ON.iter().map(value).fold(f64::NEG_INFINITY, f64::max) + kept;
            if best.as_ref().is_none_or(|b| score > b.score) {
                let (v, w) = predictor.wanted(way, start);
                best = Some(Choice { score, command: Command { v, w }, way, met: None, exposed: false });
            }
        }
        best
    }

    /// The critics; larger is better.
    fn score(&self, predictor: &Predictor, start: &Sim, (on, exposed): (&Forecast, Option<f64>), command: Command) -> f64 {
        let (p, local) = (&self.p, predictor.local);
        let place = |sim: &Sim| local.relative(sim.mark, sim.pose);
        let (from, middle, end) = (place(start), place(&on.middle), place(&on.end));
        let reach = (local.first().speed.max(0.2) * p.horizon).min((local.length - from[0]).max(0.3));
        let mut score = p.progress * (end[0] - from[0]) / reach;
        if local.length - from[0] <= THERE {
            // Home: nearer to the last point is better.
            let goal = local.mark(0).point;
            let far = |sim: &Sim| (sim.pose[0] - goal[0]).hypot(sim.pose[1] - goal[1]);
            score += p.progress * (far(start) - far(&on.end));
        }
        score -= p.deviation * (0.6 * middle[1].abs() + 0.4 * end[1].abs()) + p.heading * end[2].abs();
        score -= p.near * (1.0 - on.gap / NEAR).clamp(0.0, 1.0);
        score -= p.change * ((command.v - self.last.0.v).abs() + 0.3 * (command.w - self.last.0.w).abs());
        if let Some((t, with)) = on.contact {
            let soon = (1.0 - t / p.horizon).max(0.0);
            score -= if with == Met::Static { 0.2 } else { 1.0 } * p.risk * soon;
        }
        if let Some(hit) = exposed {
            score -= 2.0 + 2.0 * (1.0 - hit / (p.horizon + p.park)).max(0.0);
        }
        score
    }
}

/// Distance from the end pose, m.
fn off(end: [f64; 3], seen: &Observation) -> f64 {
    (end[0] - seen.pose[0]).hypot(end[1] - seen.pose[1])
}

/// Beside the end of the path: straight to it, or wait.
fn home(end: [f64; 3], seen: &Observation) -> Vec<Way> {
    let yaw = (end[1] - seen.pose[1]).atan2(end[0] - seen.pose[0]);
    let v = off(end, seen).min(HOMING);
    [1.0, 0.5, 0.0].map(|share| Way::Heading { yaw, v: share * v }).to_vec()
}

/// Does it leave the path for a line beside it?
fn beside(way: Way) -> bool {
    matches!(way, Way::Follow { offset, .. } if offset != 0.0)
}

/// Which line beside the path a manoeuvre leads to, in tenths of a metre; arcs share one number.
fn side(way: Way) -> i32 {
    match way {
        Way::Follow { offset, .. } => (10.0 * offset).round() as i32,
        Way::Arc { .. } => i32::MAX,
        Way::Heading { yaw, .. } => 1000 + (yaw * 100.0).round() as i32,
    }
}

#[cfg(test)]
mod tests;
