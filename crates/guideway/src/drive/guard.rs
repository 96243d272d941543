//! The guarantee: a command is given only if a full brake after it ends at rest before anything can be met.
//!
//! Source: passive safety, \[bouraine2012\]; the induction is in `docs/methods/improved-dwa.md`.

use super::field::{Field, Met};
use super::ramp::Ramp;
use super::{Command, Robot, arc};

/// Integration step while the command holds and while the base brakes, s.
const STEPS: [f64; 2] = [0.02, 0.03];
/// Below these speeds (m/s, rad/s) the base counts as standing; what is left of the motion is within the bound of the error.
const REST: [f64; 2] = [0.008, 0.008];
/// Nearer than this is met, m.
const MET: f64 = 1e-4;
/// Static obstacles farther than this beyond the margin are not told apart, m.
const FAR: f64 = 0.6;
/// Longest manoeuvre, s.
const LONGEST: f64 = 60.0;

/// What the guard is told about base and estimates.
#[derive(Debug, Clone, Copy)]
pub(super) struct Bounds {
    /// Time constants of speed and turn rate, s.
    pub lag: [f64; 2],
    /// Time until a command reaches the actuators, s.
    pub delay: f64,
    /// Longest time to the next decision, s.
    pub hold: f64,
    /// Error of the estimated position, heading times reach included, and of the model of the base, m.
    pub error: f64,
    /// Growth of that error with the distance driven, 1.
    pub drift: f64,
}

/// A state of the base.
#[derive(Debug, Clone, Copy)]
pub(super) struct State {
    pub pose: [f64; 3],
    pub v: f64,
    pub w: f64,
}

/// The guard of one control step.
pub(super) struct Guard<'a> {
    field: &'a Field<'a>,
    robot: &'a Robot,
    bounds: Bounds,
    start: State,
    /// What the actuators follow until the new command reaches them.
    before: Command,
    /// Room to static obstacles now, m.
    room: f64,
    /// Movers that cannot move and stand nearer than the error; they count as static.
    touching: Vec<(usize, f64)>,
    reach: f64,
}

/// How far an arc may go before it must be looked at again.
struct Free {
    still: f64,
    moving: f64,
}

impl<'a> Guard<'a> {
    pub fn new((field, reach): (&'a Field<'a>, f64), robot: &'a Robot, bounds: Bounds, start: State, before: Command) -> Self {
        let room = field.gap(start.pose, bounds.error + FAR);
        let near = |id: usize| field.reach(start.pose, 0.0, &others(field, id)).0;
        let fixed = field.tracks().filter(|t| t.bound <= 0.0).map(|t| (t.id, near(t.id)));
        let touching = fixed.filter(|(_, gap)| *gap < 2.0 * bounds.error).collect();
        Self { field, robot, bounds, start, before, room, touching, reach }
    }

    /// The state after `t` s, while the new command is still on its way.
    pub fn ahead(&self, t: f64) -> State {
        let n = (t / STEPS[0]).ceil();
        (0..n as u32).fold(self.start, |at, _| self.follow(&at, self.before, t / n))
    }

    /// Holds `command` until the next decision can act, then brakes with all the base has or, with a ramp at that command, within the limit of jerk: when the
    /// base then stands (s from now), or what could be met before. `spare` (m) is kept beyond the error.
    ///
    /// Exact along the arcs of the model by conservative advancement: the footprint keeps the bound of the error to static obstacles and to everything
    /// that a mover could have reached by then. A base that already stands nearer may leave, but not come nearer than half of the room it has.
    pub fn certify(&self, command: Command, mut ramp: Option<Ramp>, spare: f64) -> Result<f64, Met> {
        let b = &self.bounds;
        let (mut at, mut t, mut driven) = (self.start, 0.0, 0.0);
        let mut free = Free { still: 0.0, moving: 0.0 };
        while t < LONGEST {
            let braking = t >= b.delay + b.hold - 1e-9;
            if braking && at.v.abs() < REST[0] && at.w.abs() < REST[1] && ramp.is_none_or(Ramp::rests) {
                return Ok(t);
            }
            let (u, until) = match () {
                () if braking => (Command { v: ramp.as_mut().map_or(0.0, |ramp| ramp.step(0.0, STEPS[1])), w: 0.0 }, f64::INFINITY),
                () if t < b.delay - 1e-9 => (self.before, b.delay),
                () => (command, b.delay + b.hold),
            };
            let h = STEPS[usize::from(braking)].min(until - t);
            let next = self.follow(&at, u, h);
            let mean = [f64::midpoint(at.v, next.v), f64::midpoint(at.w, next.w)];
            self.clear(&mut free, at.pose, mean, ([t, h], driven, spare))?;
            driven += mean[0].abs() * h;
            t += h;
            at = next;
        }
        Err(Met::Static)
    }

    /// The state after `h` s under a command: first-order lags within the limits, the exact arc of the mean speeds.
    fn follow(&self, at: &State, u: Command, h: f64) -> State {
        let r = self.robot;
        let v = lagged([at.v, u.v], share(self.bounds.lag[0], h), [r.acceleration, r.deceleration], h);
        let w = lagged([at.w, u.w], share(self.bounds.lag[1], h), [r.turn_acceleration; 2], h);
        State { pose: arc(at.pose, f64::midpoint(at.v, v), f64::midpoint(at.w, w), h), v, w }
    }

    /// Is the arc of one step free?
    fn clear(&self, free: &mut Free, pose: [f64; 3], [v, w]: [f64; 2], ([t, h], driven, spare): ([f64; 2], f64, f64)) -> Result<(), Met> {
        let own = v.abs() + w.abs() * self.reach + self.bounds.drift * v.abs();
        let error = |tau: f64| self.bounds.error + spare + self.bounds.drift * (driven + v.abs() * tau);
        let still = |tau: f64| {
            let at = arc(pose, v, w, tau);
            let margin = error(tau).min(if self.room > 0.0 { 0.5 * self.room } else { self.room - MET });
            let fixed = |(id, now): &(usize, f64)| {
                let gap = self.field.reach(at, 0.0, &others(self.field, *id)).0;
                gap - error(tau).min(if *now > 0.0 { 0.5 * now } else { now - MET })
            };
            let touching = self.touching.iter().map(fixed).fold(f64::INFINITY, f64::min);
            (self.field.gap(at, FAR + margin.max(0.0)) - margin).min(touching)
        };
        advance(&mut free.still, own, h, &mut |tau| (still(tau), Met::Static))?;
        let but: Vec<usize> = self.touching.iter().map(|f| f.0).collect();
        let mut moving = |tau: f64| {
            let (gap, id) = self.field.reach(arc(pose, v, w, tau), t + tau, &but);
            (gap - error(tau), Met::Mover(id))
        };
        advance(&mut free.moving, own + self.field.fastest(), h, &mut moving)
    }
}

/// Numbers of all tracks but one.
fn others(field: &Field, id: usize) -> Vec<usize> {
    field.tracks().map(|t| t.id).filter(|i| *i != id).collect()
}

/// Conservative advancement over `h` s: `room` (m) is used up at `speed`, and looked up anew where there is none left.
fn advance(room: &mut f64, speed: f64, h: f64, look: &mut dyn FnMut(f64) -> (f64, Met)) -> Result<(), Met> {
    let mut tau = 0.0;
    while *room < speed * (h - tau) || *room <= 0.0 {
        tau = (tau + room.max(0.0) / speed.max(1e-9)).min(h);
        let (gap, met) = look(tau);
        if gap < MET {
            return Err(met);
        }
        *room = gap;
    }
    *room -= speed * (h - tau);
    Ok(())
}

/// The share of the way to its target that an actuator with time constant `lag` (s) covers in `h` s without limits.
pub(super) fn share(lag: f64, h: f64) -> f64 {
    if lag > 0.0 { -(-h / lag).exp_m1() } else { 1.0 }
}

/// The next value of an actuator that covers this share of the way to its target, with the rate limits [away from zero, towards zero], after `h` s.
#[inline]
pub(super) fn lagged([x, target]: [f64; 2], share: f64, limits: [f64; 2], h: f64) -> f64 {
    let wanted = (target - x) * share;
    let [away, toward] = limits;
    let limit = if x * wanted < 0.0 { toward } else { away } * h;
    x + wanted.clamp(-limit, limit)
}
