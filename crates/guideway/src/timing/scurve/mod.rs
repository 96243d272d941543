//! The asymmetric seven-phase S-curve: one axis from `(0, v_s, a_s)` to `(distance, v_e, a_e)` in minimum time under limits of
//! speed, acceleration, deceleration and jerk, each different if need be.
//!
//! Source: the asymmetric S-curve of \[zhang2025\], repaired and completed; see \[berscheid2021\] for the general problem. The motion never reverses.
//!
//! The guaranteed domain is `a_s >= 0`, `a_e <= 0` (seen in the direction of motion): there a plan exists exactly when the distance
//! is at least that of the direct transition, and the plan is the fastest. Outside it the whole family of profiles with one bump or
//! one dip is searched.

mod general;
mod peak;
mod transition;

pub use transition::{State1, transition};

use crate::error::PlanError;
use peak::{Side, Solved};

/// Jerk limits by phase, m/s3, all positive.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Jerks {
    /// While a positive acceleration builds up, m/s3.
    pub build: f64,
    /// While a positive acceleration is released, m/s3.
    pub release: f64,
    /// While a deceleration builds up, m/s3.
    pub brake: f64,
    /// While a deceleration is released, m/s3.
    pub unbrake: f64,
}

impl Jerks {
    /// The same limit in every phase, m/s3.
    pub const fn all(jerk: f64) -> Self {
        Self { build: jerk, release: jerk, brake: jerk, unbrake: jerk }
    }
}

/// Limits of one axis in its direction of motion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bounds {
    /// Largest speed, m/s.
    pub speed: f64,
    /// Largest acceleration, m/s2.
    pub acceleration: f64,
    /// Largest deceleration, m/s2, positive.
    pub deceleration: f64,
    /// Jerk limits, m/s3.
    pub jerk: Jerks,
}

/// One problem. A negative distance is the mirror image: speeds are then negative too, and the acceleration limit still bounds
/// the growth of `|v|`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SCurve {
    /// Distance to cover, m.
    pub distance: f64,
    /// Speed (m/s) and acceleration (m/s2) at the start.
    pub start: (f64, f64),
    /// Speed (m/s) and acceleration (m/s2) at the end.
    pub end: (f64, f64),
    /// Limits.
    pub bounds: Bounds,
}

/// Most phases of a profile: seven, and one more at either end outside the guaranteed domain, where a ramp of acceleration may
/// cross zero and change its jerk limit there.
pub const MAX_PHASES: usize = 9;

/// A stretch of constant jerk.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Phase {
    /// s, >= 0.
    pub duration: f64,
    /// m/s3.
    pub jerk: f64,
}

/// Position (m), speed (m/s), acceleration (m/s2), jerk (m/s3).
pub type Sample = (f64, f64, f64, f64);

/// A motion of up to [`MAX_PHASES`] phases of constant jerk.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Profile {
    start: (f64, f64),
    phases: [Phase; MAX_PHASES],
    count: usize,
}

impl Profile {
    /// A profile from its start (m/s, m/s2) and at most [`MAX_PHASES`] phases.
    fn new(start: (f64, f64), given: &[Phase]) -> Self {
        let mut phases = [Phase::default(); MAX_PHASES];
        let count = given.len().min(MAX_PHASES);
        phases[..count].copy_from_slice(&given[..count]);
        Self { start, phases, count }
    }

    /// Speed (m/s) and acceleration (m/s2) at its start.
    pub fn start(&self) -> (f64, f64) {
        self.start
    }

    /// Its phases in order; in the guaranteed domain exactly seven, some of them empty.
    pub fn phases(&self) -> &[Phase] {
        &self.phases[..self.count]
    }

    /// Total time, s.
    pub fn duration(&self) -> f64 {
        self.phases().iter().map(|p| p.duration).sum()
    }

    /// State at time `t` (s), clamped to the motion.
    pub fn at(&self, t: f64) -> Sample {
        let (mut s, (mut v, mut a)) = (0.0, self.start);
        let mut left = t.max(0.0);
        let mut jerk = 0.0;
        for phase in self.phases() {
            let tau = left.min(phase.duration);
            (s, v, a) = advance((s, v, a), phase.jerk, tau);
            jerk = phase.jerk;
            if left < phase.duration {
                break;
            }
            left -= phase.duration;
        }
        (s, v, a, jerk)
    }

    /// The largest speed in the motion, m/s (of a motion forwards).
    pub fn top_speed(&self) -> f64 {
        let mut state = (0.0, self.start.0, self.start.1);
        let mut top = state.1;
        for phase in self.phases() {
            let next = advance(state, phase.jerk, phase.duration);
            if state.2 > 0.0 && next.2 < 0.0 {
                top = top.max(state.1 - 0.5 * state.2 * state.2 / phase.jerk);
            }
            top = top.max(next.1);
            state = next;
        }
        top
    }

    fn mirrored(mut self) -> Self {
        self.start = (-self.start.0, -self.start.1);
        for phase in &mut self.phases {
            phase.jerk = -phase.jerk;
        }
        self
    }
}

/// Exact motion of `(s, v, a)` under constant jerk for `t` seconds.
#[inline]
pub fn advance((s, v, a): (f64, f64, f64), j: f64, t: f64) -> (f64, f64, f64) {
    (s + t * (v + t * (0.5 * a + t * j / 6.0)), v + t * (a + 0.5 * t * j), a + t * j)
}

/// The highest speed (m/s) up to `wanted` to which (`forward`), or from which, a change of speed from the slower one `v` (m/s) fits into `distance` (m), without
/// acceleration at its ends.
pub(super) fn reachable(v: f64, wanted: f64, distance: f64, bounds: &Bounds, forward: bool) -> f64 {
    let Bounds { acceleration, deceleration, jerk, .. } = *bounds;
    let (limit, jerks) = if forward { (acceleration, (jerk.build, jerk.release)) } else { (deceleration, (jerk.unbrake, jerk.brake)) };
    let side = Side::new(v, 0.0, limit, jerks);
    if wanted <= v || side.distance(wanted) <= distance {
        return wanted;
    }
    let (mut low, mut high) = (v, wanted);
    for _ in 0..50 {
        let w = f64::midpoint(low, high);
        if side.distance(w) <= distance { low = w } else { high = w }
    }
    low
}

impl SCurve {
    /// The fastest profile.
    /// # Errors
    /// [`PlanError::BadParameter`] for a limit that is not positive or a number that is not finite; [`PlanError::Infeasible`] with
    /// the shortest possible distance and, where there is one, the end speed nearest to the wanted one that can be reached.
    pub fn plan(&self) -> Result<Profile, PlanError> {
        self.check()?;
        let backward = self.distance < 0.0 || (self.distance == 0.0 && (self.start.0 < 0.0 || self.end.0 < 0.0));
        if backward {
            let flip = |(v, a): (f64, f64)| (-v, -a);
            let mirror = Self { distance: -self.distance, start: flip(self.start), end: flip(self.end), bounds: self.bounds };
            return mirror.forward().map(Profile::mirrored).map_err(mirror_error);
        }
        self.forward()
    }

    /// Refuses limits that are not positive and anything that is not finite.
    #[inline]
    fn check(&self) -> Result<(), PlanError> {
        let Bounds { speed, acceleration, deceleration, jerk } = self.bounds;
        let limits = [speed, acceleration, deceleration, jerk.build, jerk.release, jerk.brake, jerk.unbrake];
        let states = [self.distance, self.start.0, self.start.1, self.end.0, self.end.1];
        // One comparison for all of them: a sum of finite numbers that overflows is sorted out by the careful check.
        let positive = limits.iter().copied().fold(f64::INFINITY, f64::min) > 0.0;
        let sum: f64 = limits.iter().sum::<f64>() + states.iter().map(|x| x.abs()).sum::<f64>();
        if positive && sum < f64::INFINITY { Ok(()) } else { check_slowly(&limits, &states) }
    }

    #[inline]
    fn forward(&self) -> Result<Profile, PlanError> {
        self.check_states()?;
        if self.start.1 < 0.0 || self.end.1 > 0.0 {
            return general::plan(self);
        }
        let speed = self.bounds.speed;
        let sides = self.sides();
        let (after, before) = (sides[0].lowest, sides[1].lowest);
        if after.max(before) > speed * (1.0 + 1e-12) {
            return Err(overrun(speed, after, before));
        }
        match peak::solve(&sides, self.distance, speed) {
            Some(solved) => Ok(self.assemble(&sides, &solved)),
            None => Err(self.too_short()),
        }
    }

    #[inline]
    fn sides(&self) -> [Side; 2] {
        let Bounds { acceleration, deceleration, jerk, .. } = self.bounds;
        [
            Side::new(self.start.0, self.start.1, acceleration, (jerk.build, jerk.release)),
            Side::new(self.end.0, -self.end.1, deceleration, (jerk.unbrake, jerk.brake)),
        ]
    }

    /// The plan of a problem that is known to be valid, forwards and without acceleration at its ends; `None` if the distance is too short.
    /// Searches that try many problems do not need to know why one fails.
    #[inline]
    pub(super) fn between_troughs(&self) -> Option<Profile> {
        if self.distance <= 0.0 || self.start.0.max(self.end.0) > self.bounds.speed {
            return None;
        }
        let sides = self.sides();
        peak::solve(&sides, self.distance, self.bounds.speed).map(|solved| self.assemble(&sides, &solved))
    }

    /// States that no profile of the class can have.
    #[inline]
    fn check_states(&self) -> Result<(), PlanError> {
        let Bounds { speed, acceleration, deceleration, .. } = self.bounds;
        for (name, (v, a)) in [("start", self.start), ("end", self.end)] {
            if v < 0.0 {
                return Err(infeasible(format!("{name} speed {v} m/s points away from the goal; the motion never reverses")));
            }
            if v > speed * (1.0 + 1e-12) || a > acceleration * (1.0 + 1e-12) || -a > deceleration * (1.0 + 1e-12) {
                return Err(infeasible(format!("{name} speed {v} m/s or acceleration {a} m/s2 is outside the limits")));
            }
        }
        Ok(())
    }

    #[inline]
    fn assemble(&self, sides: &[Side; 2], &(climbs, cruise): &Solved) -> Profile {
        let (up, down) = (sides[0].times(climbs[0]), sides[1].times(climbs[1]));
        let j = self.bounds.jerk;
        let p = |duration: f64, jerk: f64| Phase { duration, jerk };
        let none = Phase::default();
        let phases = [
            p(up.0, j.build),
            p(up.1, 0.0),
            p(up.2, -j.release),
            p(cruise, 0.0),
            p(down.2, -j.brake),
            p(down.1, 0.0),
            p(down.0, j.unbrake),
            none,
            none,
        ];
        Profile { start: self.start, phases, count: 7 }
    }

    /// The error for a distance below that of the direct transition, with the nearest end speed that can be reached.
    #[cold]
    fn too_short(&self) -> PlanError {
        let shortest = |v: f64| transition(self.start.into(), (v, self.end.1).into(), &self.bounds).map(|p| p.at(f64::INFINITY).0);
        let fits = |v: f64| shortest(v).is_some_and(|d| d <= self.distance);
        let d_min = shortest(self.end.0);
        let mut best = None;
        if fits(self.start.0) {
            let (mut good, mut bad) = (self.start.0, self.end.0);
            for _ in 0..60 {
                let mid = f64::midpoint(good, bad);
                if fits(mid) { good = mid } else { bad = mid }
            }
            best = Some(good);
        }
        let at_least = d_min.map_or(String::from("no direct transition exists"), |d| format!("the shortest possible distance is {d:.9} m"));
        let advice =
            best.map_or(String::from("no end speed can be reached in it"), |v| format!("the nearest end speed that can be reached is {v:.6} m/s"));
        PlanError::Infeasible { reason: format!("distance {} m is too short: {at_least}; {advice}", self.distance), best_end_speed: best }
    }
}

#[cold]
fn check_slowly(limits: &[f64; 7], states: &[f64; 5]) -> Result<(), PlanError> {
    const NAMES: [&str; 7] = ["speed", "acceleration", "deceleration", "jerk.build", "jerk.release", "jerk.brake", "jerk.unbrake"];
    if let Some(i) = limits.iter().position(|x| !(*x > 0.0 && x.is_finite())) {
        return Err(PlanError::bad(NAMES[i], limits[i], "a finite number > 0"));
    }
    if states.iter().all(|x| x.is_finite()) {
        return Ok(());
    }
    Err(PlanError::bad("s-curve state", format!("{states:?}"), "finite distance, speeds and accelerations"))
}

/// The error for boundary accelerations that run over the speed limit.
#[cold]
fn overrun(speed: f64, after: f64, before: f64) -> PlanError {
    infeasible(format!("the speed limit {speed} m/s is overrun: speed {after} m/s follows from the start state, {before} m/s precedes the end state"))
}

#[cold]
fn infeasible(reason: String) -> PlanError {
    PlanError::Infeasible { reason, best_end_speed: None }
}

/// The best end speed of a mirrored problem has the mirrored sign.
fn mirror_error(e: PlanError) -> PlanError {
    match e {
        PlanError::Infeasible { reason, best_end_speed } => PlanError::Infeasible { reason, best_end_speed: best_end_speed.map(|v| -v) },
        other => other,
    }
}
