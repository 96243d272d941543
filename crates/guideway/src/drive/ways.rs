//! Manoeuvres, and what they lead to: predicted in (place, time) with the lags and limits of the base.

use super::Robot;
use super::crowd::{Around, Crowd, WIDE};
use super::field::{Field, Met};
use super::guard::{lagged, share};
use super::local::Local;
use crate::world::shape::wrap;

/// Integration step, s.
pub(super) const STEP: f64 = 0.1;
/// Gain of the heading, 1/s.
const SPIN: f64 = 3.0;
/// Heading errors above this are turned in place, rad.
const PLACE: f64 = 0.7;
/// Speed over distance left on the last bit, 1/s.
const SOFT: f64 = 2.5;
/// Share of the deceleration that is planned with.
const EASY: f64 = 0.8;
/// So far ahead is the point that a robot heads for which has left the path, m.
const AHEAD: f64 = 0.8;
/// A place that is met only after this time is free, s.
const EXPOSED: f64 = 4.0;
/// Below this the base stands, m/s.
const STANDING: f64 = 0.02;

/// A manoeuvre that the robot may choose.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Way {
    /// Constant speed (m/s) and turn rate (rad/s).
    Arc { v: f64, w: f64 },
    /// Along the path at a share of its reference speed, on a line so far to its left, m.
    Follow { share: f64, offset: f64 },
    /// Turned to a heading (rad, map frame), then straight at that speed, m/s.
    Heading { yaw: f64, v: f64 },
    /// Turned towards a point of the path ahead, then straight there, at most at that speed, m/s.
    Toward { v: f64 },
}

impl Way {
    /// A number for the kind and the side it leads to, to keep to what was chosen before.
    pub fn side(self) -> i32 {
        match self {
            Self::Follow { offset, .. } => (10.0 * offset).round() as i32,
            Self::Arc { v, w } => 10_000 + 10 * i32::from(w > 0.0) + 100 * i32::from(w < 0.0) + i32::from(v > 0.0),
            Self::Heading { yaw, v } => 20_000 + (yaw * 2.0).round() as i32 + 100 * i32::from(v > 0.0),
            Self::Toward { .. } => 30_000,
        }
    }
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

/// A prediction, and what it found.
#[derive(Debug, Clone, Copy)]
pub(super) struct Forecast {
    way: Way,
    /// First contact, s from now.
    pub contact: Option<(f64, Met)>,
    /// The robot was at rest at the contact.
    pub parked: bool,
    /// When it could not be sure to stop in time any more, s from now.
    pub late: Option<f64>,
    /// State at the end or the contact; on the way there the present one.
    pub end: Sim,
    /// Integral of the distance from the path, m s, and of the nearness to movers, s.
    pub aside: f64,
    pub near: f64,
    /// Has it met something?
    over: bool,
    /// s from now; nothing is near until `safe`.
    t: f64,
    safe: f64,
    /// What any point of the body has moved at most, and may move before a static obstacle can be met, m.
    driven: f64,
    slack: f64,
    facing: Facing,
    /// Relative to the path, where it is known.
    place: Option<[f64; 2]>,
}

impl Forecast {
    fn at(way: Way, start: Sim, pace: &Pace) -> Self {
        let (t, facing) = (pace.span[0], pace.facing);
        let (contact, late, place) = (None, None, None);
        Self { way, contact, parked: false, late, end: start, aside: 0.0, near: 0.0, over: false, t, safe: t, driven: 0.0, slack: 0.0, facing, place }
    }
}

/// Sine and cosine of the heading that was asked for last: most steps begin where the one before ended.
#[derive(Debug, Clone, Copy)]
struct Facing {
    /// rad, bit by bit, and its sine and cosine.
    yaw: u64,
    known: (f64, f64),
}

impl Facing {
    fn at(yaw: f64) -> Self {
        Self { yaw: yaw.to_bits(), known: yaw.sin_cos() }
    }

    fn sin_cos(&mut self, yaw: f64) -> (f64, f64) {
        if self.yaw != yaw.to_bits() {
            *self = Self::at(yaw);
        }
        self.known
    }

    /// As [`super::arc`], to the last bit.
    fn arc(&mut self, [x, y, yaw]: [f64; 3], v: f64, w: f64, t: f64) -> [f64; 3] {
        if w.abs() < 1e-6 {
            let (s, c) = self.sin_cos(yaw + 0.5 * w * t);
            return [x + v * t * c, y + v * t * s, yaw + w * t];
        }
        let (s0, c0) = self.sin_cos(yaw);
        let (s1, c1) = self.sin_cos(yaw + w * t);
        [x + v / w * (s1 - s0), y - v / w * (c1 - c0), yaw + w * t]
    }
}

/// The steps of a prediction.
#[derive(Clone, Copy)]
pub(super) struct Pace {
    /// s from now.
    span: [f64; 2],
    n: u32,
    /// s.
    h: f64,
    /// Shares of the way to their targets that speed and turn rate cover in a step.
    shares: [f64; 2],
    /// The heading at first.
    facing: Facing,
}

/// Predicts from one observation.
pub(super) struct Predictor<'a> {
    pub field: &'a Field<'a>,
    pub local: &'a Local,
    pub robot: &'a Robot,
    /// Time constants of speed and turn rate, s.
    pub lag: [f64; 2],
    /// Distance of the farthest point that turning moves, m.
    pub arm: f64,
    /// Largest offset from the path that costs nothing more, m.
    pub limit: f64,
    /// Reaction time (s) and error (m) of the stops.
    pub stop: [f64; 2],
    /// Stops at the end of the path begin so much earlier, s.
    pub early: f64,
}

impl<'a> Predictor<'a> {
    /// Speeds that the manoeuvre asks for in a state.
    pub fn wanted(&self, way: Way, sim: &Sim) -> (f64, f64) {
        self.speeds(way, sim, None)
    }

    /// As [`Predictor::wanted`], with the place relative to the path where it is known.
    #[inline]
    fn speeds(&self, way: Way, sim: &Sim, known: Option<[f64; 2]>) -> (f64, f64) {
        let (mark, early) = (self.local.mark(sim.mark), self.early * sim.v.max(0.0));
        match way {
            Way::Arc { v, w } => (v, w),
            Way::Heading { yaw, v } => self.turned(wrap(yaw - sim.pose[2]), v),
            Way::Toward { v } => {
                let target = self.local.beyond(sim.mark, AHEAD);
                let (dx, dy) = (target.point[0] - sim.pose[0], target.point[1] - sim.pose[1]);
                let far = if target.s >= self.local.length - 1e-6 { (dx.hypot(dy) - early).max(0.0) } else { f64::INFINITY };
                self.turned(wrap(dy.atan2(dx) - sim.pose[2]), v.min(approach(EASY * self.robot.deceleration, far)))
            }
            Way::Follow { share, offset } => {
                let [s, lateral] = known.unwrap_or_else(|| self.local.relative(sim.mark, sim.pose));
                let left = (self.local.length - s - early).max(0.0);
                // A field of headings that leads to the offset line, steeper at low speed; the offset fades towards the end of the path.
                let aside = offset.clamp(-left, left) - lateral;
                let error = wrap((2.0 * aside / (0.5 + sim.v.max(0.0))).atan() - wrap(sim.pose[2] - mark.yaw));
                let stop = approach(EASY * self.robot.deceleration, left);
                let v = if error.abs() > PLACE { 0.0 } else { (share * mark.speed).min(stop) * error.cos().powi(2) };
                (v, self.rate(v * mark.curvature + SPIN * error))
            }
        }
    }

    /// Turns by `error` (rad) and drives at `v` (m/s) as far as that is done.
    fn turned(&self, error: f64, v: f64) -> (f64, f64) {
        (if error.abs() > PLACE { 0.0 } else { v * error.cos().powi(2) }, self.rate(SPIN * error))
    }

    fn rate(&self, w: f64) -> f64 {
        w.clamp(-self.robot.turn_rate, self.robot.turn_rate)
    }

    /// Puts into `part` those movers that may make a difference to what is driven from `start` over a span of time, s: to the way itself, and to the stops on it.
    pub fn part(&self, start: &Sim, span: [f64; 2], [on, stops]: &mut [Crowd<'a>; 2]) {
        let r = self.robot;
        let (v, w) = (start.v.abs().max(r.speed).max(self.local.top), start.w.abs().max(r.turn_rate));
        self.field.part(start.pose, span, [r.speed, v + self.arm * w], on);
        let ([whole, length], (crowd, reach)) = (self.stop_of(v, w), self.field.crowd());
        crowd.threats(([start.pose[0], start.pose[1]], reach + self.stop[1] + length), span, [v, whole], stops);
    }

    /// How long a stop from these speeds takes, s, and how far it leads, m.
    fn stop_of(&self, v: f64, w: f64) -> [f64; 2] {
        let (brake, turn) = (v / self.robot.deceleration, w / self.robot.turn_acceleration);
        [self.stop[0] + brake.max(turn) + self.lag[0], v * (self.stop[0] + 0.5 * brake)]
    }

    /// The steps from `start` over a span of time, s from now.
    pub fn pace(&self, start: &Sim, span: [f64; 2]) -> Pace {
        let n = ((span[1] - span[0]) / STEP).round().max(1.0);
        let h = (span[1] - span[0]) / n;
        Pace { span, n: n as u32, h, shares: self.lag.map(|lag| share(lag, h)), facing: Facing::at(start.pose[2]) }
    }

    /// Drives each of `ways` from `start`, whose time is that at which `pace` begins, until it ends or the first contact, among the movers of `crowd` on the way and
    /// for stops on it. All go on step by step together: what one waits for, a sine or a root, another one's step fills.
    pub fn run(&self, ways: &[Way], start: &Sim, pace: &Pace, crowds: [&Crowd; 2], all: &mut Vec<Forecast>) {
        all.clear();
        all.extend(ways.iter().map(|way| Forecast::at(*way, *start, pace)));
        for _ in 0..pace.n {
            for one in all.iter_mut().filter(|one| !one.over) {
                self.go_on(one, pace);
            }
            for one in all.iter_mut().filter(|one| !one.over) {
                one.over = self.look(one, pace, crowds);
            }
        }
    }

    /// One step.
    #[inline]
    fn go_on(&self, one: &mut Forecast, pace: &Pace) {
        let (v, w) = self.speeds(one.way, &one.end, one.place);
        let moved = self.advance(&mut one.end, [v, w], pace.h, (pace.shares, &mut one.facing));
        one.t += pace.h;
        one.slack -= moved;
        one.driven += moved;
    }

    /// What a step has led to: true if it is the last.
    #[inline]
    fn look(&self, one: &mut Forecast, pace: &Pace, [crowd, stops]: [&Crowd; 2]) -> bool {
        let (sim, t, h, driven) = (one.end, one.t, pace.h, one.driven);
        if one.slack <= 0.0 {
            one.slack = self.field.free(sim.pose);
            if one.slack <= 0.0 {
                one.contact = Some((t, Met::Static));
                return true;
            }
        }
        if t >= one.safe {
            let Around { room, safe, close } = self.field.movers_of(crowd, sim.pose, (t, crowd.spent(driven, t - pace.span[0])), self.robot.speed);
            if room <= 0.0 {
                one.parked = sim.v.abs() + self.arm * sim.w.abs() < STANDING;
                one.contact = Some((t, Met::Mover(self.field.first(sim.pose, t))));
                return true;
            }
            one.near += h * close;
            if room < self.field.fastest() * (self.stop[0] + sim.v.abs() / self.robot.deceleration + 0.5) + sim.v.abs()
                && !self.stoppable(&sim, t, (stops, stops.spent(driven, t - pace.span[0])))
            {
                one.late = Some(t);
                return true;
            }
            // Until then nothing is near, whatever the robot does.
            one.safe = t + if room > WIDE { safe * (1.0 - WIDE / room) } else { 0.0 };
        }
        let place = self.local.relative(sim.mark, sim.pose);
        one.place = Some(place);
        one.aside += h * place[1].abs().min(self.limit);
        false
    }

    /// Moves on by one step; how far any point of the body has moved at most, m.
    fn advance(&self, sim: &mut Sim, [v, w]: [f64; 2], h: f64, (shares, facing): ([f64; 2], &mut Facing)) -> f64 {
        let r = self.robot;
        let next = lagged([sim.v, v], shares[0], [r.acceleration, r.deceleration], h);
        let turn = lagged([sim.w, w], shares[1], [r.turn_acceleration; 2], h);
        let (mean, bend) = (0.5 * (sim.v + next), 0.5 * (sim.w + turn));
        let [x, y, yaw] = facing.arc(sim.pose, mean, bend, h);
        *sim = Sim { pose: [x, y, wrap(yaw)], v: next, w: turn, mark: self.local.nearest(sim.mark, [x, y]) };
        (mean.abs() + self.arm * bend.abs()) * h
    }

    /// Could the robot at `sim`, `t` s from now, still stop before movers can reach it, if they kept their velocities until then? At least nearly so:
    /// looked at halfway through the stop and at its end.
    fn stoppable(&self, sim: &Sim, t: f64, (crowd, spent): (&Crowd, f64)) -> bool {
        let [reaction, error] = self.stop;
        let (v, w, reach) = (sim.v.abs(), sim.w.abs(), self.field.crowd().1);
        if v < STANDING && w < STANDING {
            return true;
        }
        let ([whole, length], turn) = (self.stop_of(v, w), w / self.robot.turn_acceleration);
        if crowd.surely_beyond(([sim.pose[0], sim.pose[1]], reach + error + length), [t, whole], spent) {
            return true;
        }
        let at = |share: f64| {
            let [x, y, yaw] = sim.pose;
            let bend = yaw + sim.w * share * (0.5 * turn + reaction) * 0.5;
            let (sin, cos) = bend.sin_cos();
            [x + sim.v.signum() * share * length * cos, y + sim.v.signum() * share * length * sin]
        };
        let free = |share: f64, more: f64| crowd.beyond((at(share), reach), [t, more], error, spent);
        // Halfway in time three quarters of the way are driven.
        free(1.0, whole) && free(0.75, 0.5 * whole)
    }

    /// How soon a robot that begins to stop at `sim`, `t` s from now, would be met where it then stands (0 never, 1 at once): by movers that go on, and by movers
    /// that turn around at `t`.
    pub fn exposure(&self, sim: &Sim, t: f64) -> [f64; 2] {
        let brake = sim.v.abs() / self.robot.deceleration;
        let far = 0.5 * sim.v * (self.stop[0] + brake);
        let [x, y, yaw] = sim.pose;
        let pose = if far == 0.0 { sim.pose } else { [x + far * yaw.cos(), y + far * yaw.sin(), yaw] };
        self.field.met(pose, t, EXPOSED).map(|after| (1.0 - after / EXPOSED).max(0.0))
    }
}

/// What may be done to get out of the way, from rest or slowly; backwards only where `reverse` (m/s) is not 0.
pub(super) fn escapes(robot: &Robot, reverse: f64, sim: &Sim, level: usize) -> Vec<Way> {
    let (top, rate) = (robot.speed, robot.turn_rate);
    let back = if reverse > 0.0 { -1.0 } else { 0.0 };
    let mut all = vec![Way::Arc { v: 0.0, w: 0.0 }];
    let turns: &[f64] = if level == 0 { &[-0.9, -0.35, 0.0, 0.35, 0.9] } else { &[-0.5, 0.0, 0.5] };
    let speeds = [0.1, 0.2, 0.4, 0.8].into_iter().flat_map(|v| [v, back * v]).filter(|v| *v != 0.0);
    all.extend(speeds.flat_map(|v| turns.iter().map(move |w| Way::Arc { v: v * top, w: w * rate })));
    all.extend([-0.9, 0.9].map(|w| Way::Arc { v: 0.0, w: w * rate }));
    if level > 0 {
        all.extend([-1.0, 1.0].map(|turn| Way::Heading { yaw: wrap(sim.pose[2] + turn * 1.5), v: 0.4 * top }));
    }
    all
}

/// Speed (m/s) from which the base stops at `left` m with deceleration `a` (m/s2), and comes to rest softly over the last `a / SOFT^2` m.
fn approach(a: f64, left: f64) -> f64 {
    let soft = a / (SOFT * SOFT);
    if left < soft { SOFT * left } else { (2.0 * a * (left - 0.5 * soft)).sqrt() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::drive::arc;

    #[test]
    fn arcs_with_headings_kept_in_mind_are_the_same_to_the_last_bit() {
        let (mut facing, mut pose) = (Facing::at(0.3), [1.0, -2.0, 0.3]);
        for k in 0..500_u32 {
            let w = [0.0, 0.7, -1.9, 1e-7, 0.02][k as usize % 5] * f64::from(k / 40);
            let (found, exact) = (facing.arc(pose, 0.01 * f64::from(k), w, 0.1), arc(pose, 0.01 * f64::from(k), w, 0.1));
            assert_eq!(found.map(f64::to_bits), exact.map(f64::to_bits));
            pose = [exact[0], exact[1], wrap(exact[2])];
        }
    }
}
