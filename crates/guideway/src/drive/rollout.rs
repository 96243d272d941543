//! Predicts what a manoeuvre leads to: driven on to the horizon, or turned into a full stop.

use super::field::{Field, Met};
use super::local::Local;
use super::{Robot, arc};
use crate::world::shape::wrap;

/// Integration step, s.
const STEP: f64 = 0.05;
/// Gain of the heading, 1/s.
const SPIN: f64 = 3.0;
/// Heading errors above this are turned in place, rad.
const PLACE: f64 = 0.7;
/// Speed over distance left on the last bit, 1/s.
const SOFT: f64 = 2.5;
/// Share of the deceleration that is planned with.
const EASY: f64 = 0.8;

/// A manoeuvre that the robot may choose.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Way {
    /// Constant speed (m/s) and turn rate (rad/s).
    Arc { v: f64, w: f64 },
    /// Along the path at a share of its reference speed, on a line so far to its left, m.
    Follow { share: f64, offset: f64 },
    /// Turned to a heading (rad, map frame), then straight at that speed, m/s.
    Heading { yaw: f64, v: f64 },
}

/// A predicted state.
#[derive(Debug, Clone, Copy)]
pub(super) struct Sim {
    pub pose: [f64; 3],
    pub v: f64,
    pub w: f64,
    /// Nearest mark.
    pub mark: usize,
}

/// What a prediction found.
#[derive(Debug, Clone, Copy)]
pub(super) struct Forecast {
    /// First contact, s.
    pub contact: Option<(f64, Met)>,
    /// The robot was at rest at the contact.
    pub parked: bool,
    /// State halfway and at the end or the contact.
    pub middle: Sim,
    pub end: Sim,
    /// Least room to movers, m.
    pub gap: f64,
    /// Room at the moment of rest if movers turn against the robot, m.
    pub doubt: f64,
}

/// Predicts from one observation.
pub(super) struct Predictor<'a> {
    pub field: &'a Field<'a>,
    pub local: &'a Local,
    pub robot: &'a Robot,
}

impl Predictor<'_> {
    /// Speeds that the manoeuvre asks for in a state.
    pub fn wanted(&self, way: Way, sim: &Sim) -> (f64, f64) {
        let mark = self.local.mark(sim.mark);
        let left = (self.local.length - self.local.relative(sim.mark, sim.pose)[0]).max(0.0);
        let stop = approach(EASY * self.robot.deceleration, left);
        match way {
            Way::Arc { v, w } => (v.min(stop), w),
            Way::Heading { yaw, v } => {
                let error = wrap(yaw - sim.pose[2]);
                (if error.abs() > PLACE { 0.0 } else { v * error.cos().powi(2) }, self.rate(SPIN * error))
            }
            Way::Follow { share, offset } => {
                let [_, lateral, heading] = self.local.relative(sim.mark, sim.pose);
                // A field of headings that leads to the offset line, steeper at low speed; the offset fades towards the end of the path.
                let aside = offset.clamp(-left, left) - lateral;
                let error = wrap((2.0 * aside / (0.5 + sim.v)).atan() - heading);
                let v = if error.abs() > PLACE { 0.0 } else { (share * mark.speed).min(stop) * error.cos().powi(2) };
                (v, self.rate(v * mark.curvature + SPIN * error))
            }
        }
    }

    fn rate(&self, w: f64) -> f64 {
        w.clamp(-self.robot.turn_rate, self.robot.turn_rate)
    }

    /// Drives `way` until `brake` (s), then stops as fast as it can on the same arc (or the path) and stays for `park` s; without a stop it ends at `horizon`.
    pub fn run(&self, way: Way, start: Sim, [brake, horizon, park]: [f64; 3]) -> Forecast {
        let mut sim = start;
        let (mut t, mut slack, mut safe, mut bend) = (0.0, 0.0, 0.0, None);
        let mut seen = Forecast { contact: None, parked: false, middle: start, end: start, gap: f64::INFINITY, doubt: f64::INFINITY };
        loop {
            let braking = t >= brake - 1e-9;
            let rest = braking && sim.v <= 1e-9;
            if let Some(met) = self.check(&sim, t, [&mut slack, &mut safe], &mut seen.gap) {
                (seen.contact, seen.parked, seen.end) = (Some((t, met)), rest, sim);
                return seen;
            }
            if rest {
                (seen.end, seen.doubt) = (sim, self.field.doubt([sim.pose[0], sim.pose[1]], t));
                self.stay(&sim, t, park, &mut seen);
                return seen;
            }
            if t >= horizon - 1e-9 {
                seen.end = sim;
                return seen;
            }
            let target = self.target(way, &sim, braking, &mut bend);
            slack -= self.advance(&mut sim, target);
            t += STEP;
            if t <= 0.5 * horizon {
                seen.middle = sim;
            }
        }
    }

    fn target(&self, way: Way, sim: &Sim, braking: bool, bend: &mut Option<f64>) -> (f64, f64) {
        let (v, w) = self.wanted(way, sim);
        if !braking {
            return (v, w);
        }
        let slower = (sim.v - self.robot.deceleration * STEP).max(0.0);
        let bend = *bend.get_or_insert(if sim.v > 0.05 { sim.w / sim.v } else { 0.0 });
        (0.0, bend * slower)
    }

    /// Moves on by one step; the length driven, m.
    fn advance(&self, sim: &mut Sim, (v, w): (f64, f64)) -> f64 {
        let r = self.robot;
        let next = v.clamp(sim.v - r.deceleration * STEP, sim.v + r.acceleration * STEP).max(0.0);
        let turn = w.clamp(sim.w - r.turn_acceleration * STEP, sim.w + r.turn_acceleration * STEP);
        let mean = 0.5 * (sim.v + next);
        let [x, y, yaw] = arc(sim.pose, mean, 0.5 * (sim.w + turn), STEP);
        *sim = Sim { pose: [x, y, wrap(yaw)], v: next, w: turn, mark: self.local.onward(sim.mark, [x, y]) };
        mean * STEP
    }

    /// Contact at this moment? Looks only where the free distance or the safe time found before has been used up.
    fn check(&self, sim: &Sim, t: f64, [slack, safe]: [&mut f64; 2], gap: &mut f64) -> Option<Met> {
        let p = [sim.pose[0], sim.pose[1]];
        if *slack <= sim.v * STEP {
            *slack = self.field.slack(p);
            if *slack <= 0.0 {
                return Some(Met::Static);
            }
        }
        if t >= *safe {
            let (room, id, time) = self.field.movers(p, t, self.robot.speed);
            *gap = gap.min(room);
            if room <= 0.0 {
                return Some(Met::Mover(id));
            }
            *safe = t + time;
        }
        None
    }

    /// Waits in place.
    fn stay(&self, sim: &Sim, from: f64, park: f64, seen: &mut Forecast) {
        let mut t = from;
        while t <= from + park {
            let (room, id, time) = self.field.movers([sim.pose[0], sim.pose[1]], t, 0.0);
            seen.gap = seen.gap.min(room);
            if room <= 0.0 {
                (seen.contact, seen.parked) = (Some((t, Met::Mover(id))), true);
                return;
            }
            t += time.max(STEP);
        }
    }
}

/// Speed (m/s) from which the base stops at `left` m with deceleration `a` (m/s2), and comes to rest softly over the last `a / SOFT^2` m.
fn approach(a: f64, left: f64) -> f64 {
    let soft = a / (SOFT * SOFT);
    if left < soft { SOFT * left } else { (2.0 * a * (left - 0.5 * soft)).sqrt() }
}
