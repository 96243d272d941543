//! Checks a motion against its limits: own evaluation of the pieces, at 1 kHz and at least eight samples a piece.

use super::check::Check;
use crate::path::Path;
use crate::query::Limits;
use crate::timing::{Piece, Trajectory};
use std::f64::consts::{PI, TAU};

/// Samples per second.
const RATE: f64 = 1000.0;
/// Fewest samples of a piece, and about the most of a motion.
const SAMPLES: (usize, usize) = (8, 400_000);
/// Share of a limit that rounding may add.
const SHARE: f64 = 1e-6;
/// Jumps below this are rounding: m, m/s, m/s2, rad or s.
const JUMP: f64 = 1e-6;

/// What the motion was asked to do at its ends.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Asked {
    /// m/s.
    pub start_speed: f64,
    /// m/s.
    pub end_speed: f64,
    /// rad.
    pub start_yaw: Option<f64>,
    /// rad.
    pub goal_yaw: Option<f64>,
}

/// Every check in a fixed order: `times`, `position`, `progress`, `speed continuity`, `acceleration continuity`, `heading`, `ends`, `speed`,
/// `acceleration`, `deceleration`, `jerk`, `turn rate`, `lateral acceleration`, `turn acceleration` (in place). `at` is the time, s.
pub fn motion(trajectory: &Trajectory, asked: &Asked) -> Vec<Check> {
    let mut inspector = Inspector::new(&trajectory.path, &trajectory.limits, trajectory.duration());
    let mut last = Instant { t: 0.0, s: 0.0, v: asked.start_speed, a: 0.0, yaw: asked.start_yaw, blur: 0.0 };
    let mut clock = 0.0;
    for piece in &trajectory.pieces {
        let (start, duration) = match piece {
            Piece::Along { t, duration, .. } | Piece::Turn { t, duration, .. } => (*t, *duration),
        };
        inspector.times.see((start - clock).abs(), clock, 0.0);
        inspector.times.see(if duration >= 0.0 { 0.0 } else { f64::NAN }, clock, 0.0);
        clock = start + duration;
        last = inspector.piece(piece, &last);
    }
    inspector.end(&last, asked, clock);
    inspector.into_checks()
}

/// What is known at one instant.
#[derive(Debug, Clone, Copy)]
struct Instant {
    t: f64,
    s: f64,
    v: f64,
    a: f64,
    /// `None` where nothing was asked.
    yaw: Option<f64>,
    /// How far the heading may be off because it was taken a little inside the piece, rad.
    blur: f64,
}

struct Inspector<'a> {
    path: &'a Path,
    length: f64,
    step: f64,
    times: Check,
    position: Check,
    progress: Check,
    speed_jump: Check,
    acceleration_jump: Check,
    heading: Check,
    ends: Check,
    speed: Check,
    acceleration: Check,
    deceleration: Check,
    jerk: Check,
    turn_rate: Check,
    lateral: Check,
    turning: Check,
}

impl<'a> Inspector<'a> {
    fn new(path: &'a Path, limits: &Limits, duration: f64) -> Self {
        let jump = |name| Check::below(name, Some(JUMP));
        Self {
            path,
            length: path.length(),
            step: (1.0 / RATE).max(duration / SAMPLES.1 as f64),
            times: jump("times"),
            position: jump("position"),
            progress: jump("progress"),
            speed_jump: jump("speed continuity"),
            acceleration_jump: jump("acceleration continuity"),
            heading: jump("heading"),
            ends: jump("ends"),
            speed: Check::below("speed", Some(limits.speed)),
            acceleration: Check::below("acceleration", Some(limits.acceleration)),
            deceleration: Check::below("deceleration", Some(limits.deceleration)),
            jerk: Check::below("jerk", Some(limits.jerk)),
            turn_rate: Check::below("turn rate", limits.turn_rate),
            lateral: Check::below("lateral acceleration", limits.lateral_acceleration),
            turning: Check::below("turn acceleration", limits.turn_acceleration),
        }
    }

    /// Heading (rad) and curvature (1/m) from the derivatives by arc length.
    fn direction(&self, s: f64) -> (f64, f64) {
        let rows = self.path.eval(s, 2);
        let (d, dd) = (&rows[1], &rows[2]);
        (d[1].atan2(d[0]), d[0] * dd[1] - d[1] * dd[0])
    }

    /// Compares the end of a piece with the start of the next.
    fn join(&mut self, before: &Instant, after: &Instant) {
        self.position.see((after.s - before.s).abs(), after.t, 0.0);
        self.speed_jump.see((after.v - before.v).abs(), after.t, 0.0);
        self.acceleration_jump.see((after.a - before.a).abs(), after.t, 0.0);
        if let (Some(x), Some(y)) = (before.yaw, after.yaw) {
            self.heading.see(apart(x, y), after.t, before.blur + after.blur);
        }
    }

    fn piece(&mut self, piece: &Piece, before: &Instant) -> Instant {
        match *piece {
            Piece::Along { t, s, speed, acceleration, jerk, duration } => {
                // A little inside the piece: at a corner the heading belongs to the neighbour.
                let inside = 1e-9 * self.length;
                let (yaw, curvature) = self.direction(s + inside);
                let first = Instant { t, s, v: speed, a: acceleration, yaw: Some(yaw), blur: 2.0 * inside * curvature.abs() };
                self.join(before, &first);
                self.jerk.see(jerk.abs(), t, SHARE * self.jerk.limit.unwrap_or(0.0));
                self.along(&first, jerk, duration, inside)
            }
            Piece::Turn { turn, t, duration, s, from } => {
                self.join(before, &Instant { t, s, v: 0.0, a: 0.0, yaw: Some(from), blur: 0.0 });
                // A trapezoid of the rate: with the largest rate the acceleration is infinite, with the limit's the rate is known.
                let swing = turn.abs();
                let least = 4.0 * swing / (duration * duration);
                let acceleration = self.turning.limit.unwrap_or(crate::timing::DEFAULT_TURN_ACCELERATION);
                let top = 0.5 * acceleration * (duration - (duration * duration - 4.0 * swing / acceleration).max(0.0).sqrt());
                self.turning.see(least, t, SHARE * acceleration);
                self.turn_rate.see(top, t, SHARE * self.turn_rate.limit.unwrap_or(0.0));
                Instant { t: t + duration, s, v: 0.0, a: 0.0, yaw: Some(from + turn), blur: 0.0 }
            }
        }
    }

    /// Samples a piece along the path; returns its last instant.
    fn along(&mut self, first: &Instant, jerk: f64, duration: f64, inside: f64) -> Instant {
        let n = ((duration / self.step).ceil() as usize).max(SAMPLES.0);
        let mut last = *first;
        for k in 0..=n {
            let x = duration * k as f64 / n as f64;
            let now = Instant {
                t: first.t + x,
                s: first.s + first.v * x + first.a * x * x / 2.0 + jerk * x * x * x / 6.0,
                v: first.v + first.a * x + jerk * x * x / 2.0,
                a: first.a + jerk * x,
                yaw: None,
                blur: 0.0,
            };
            self.progress.see(last.s - now.s, now.t, 0.0);
            self.progress.see(-now.v, now.t, 0.0);
            self.position.see((now.s - self.length).max(-now.s), now.t, 0.0);
            see(&mut self.speed, now.v, now.t);
            see(&mut self.acceleration, now.a, now.t);
            see(&mut self.deceleration, -now.a, now.t);
            let (_, curvature) = self.direction(now.s.clamp(first.s + inside, self.length));
            see(&mut self.turn_rate, (curvature * now.v).abs(), now.t);
            see(&mut self.lateral, (curvature * now.v * now.v).abs(), now.t);
            last = now;
        }
        let (yaw, curvature) = self.direction(last.s - inside);
        (last.yaw, last.blur) = (Some(yaw), 2.0 * inside * curvature.abs());
        last
    }

    fn end(&mut self, last: &Instant, asked: &Asked, clock: f64) {
        self.position.see((last.s - self.length).abs(), clock, 0.0);
        self.ends.see((last.v - asked.end_speed).abs(), clock, 0.0);
        self.ends.see(last.a.abs(), clock, 0.0);
        if let (Some(x), Some(y)) = (last.yaw, asked.goal_yaw) {
            self.ends.see(apart(x, y), clock, last.blur);
        }
    }

    fn into_checks(self) -> Vec<Check> {
        let mut all = vec![
            self.times,
            self.position,
            self.progress,
            self.speed_jump,
            self.acceleration_jump,
            self.heading,
            self.ends,
            self.speed,
            self.acceleration,
            self.deceleration,
            self.jerk,
            self.turn_rate,
            self.lateral,
            self.turning,
        ];
        for check in &mut all {
            // Nothing to see, e.g. no turn in place.
            if check.worst == f64::NEG_INFINITY {
                check.worst = 0.0;
            }
        }
        all
    }
}

/// A value against a limit with the share of rounding.
fn see(check: &mut Check, value: f64, t: f64) {
    check.see(value, t, SHARE * check.limit.unwrap_or(0.0));
}

/// Angle between two headings, rad.
fn apart(x: f64, y: f64) -> f64 {
    let d = (x - y).abs() % TAU;
    if d > PI { TAU - d } else { d }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::context::Context;
    use crate::timing::{TimingOptions, time};

    type Fault = (&'static str, fn(&mut Trajectory));

    fn bent() -> Path {
        let control = [[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [2.0, 1.0], [2.0, 2.0]].concat();
        Path::new(3, 2, vec![0.0, 0.0, 0.0, 0.0, 0.5, 1.0, 1.0, 1.0, 1.0], control).unwrap()
    }

    fn limits() -> Limits {
        Limits { turn_rate: Some(1.0), lateral_acceleration: Some(0.5), turn_acceleration: Some(2.0), ..Limits::default() }
    }

    fn failed(trajectory: &Trajectory, asked: &Asked) -> Vec<&'static str> {
        motion(trajectory, asked).iter().filter(|c| !c.ok).map(|c| c.name).collect()
    }

    #[test]
    fn a_good_motion_passes_and_each_fault_is_found() {
        let options = TimingOptions { start_yaw: Some(1.0), goal_yaw: Some(-1.0), ..TimingOptions::default() };
        let asked = Asked { start_yaw: Some(1.0), goal_yaw: Some(-1.0), ..Asked::default() };
        let good = time(&bent(), &limits(), &options, &mut Context::new(1)).unwrap();
        assert_eq!(failed(&good, &asked), Vec::<&str>::new(), "{:#?}", motion(&good, &asked));
        let faults: [Fault; 8] = [
            ("turn rate", |t| t.limits.turn_rate = Some(0.3)),
            ("lateral acceleration", |t| t.limits.lateral_acceleration = Some(0.1)),
            ("speed", |t| t.limits.speed = 0.4),
            ("deceleration", |t| t.limits.deceleration = 0.2),
            ("acceleration", |t| t.limits.acceleration = 0.2),
            ("jerk", |t| t.limits.jerk = 1.0),
            ("position", |t| t.pieces[3] = t.pieces[4]),
            ("turn acceleration", |t| t.limits.turn_acceleration = Some(0.5)),
        ];
        for (name, spoil) in faults {
            let mut bad = good.clone();
            spoil(&mut bad);
            assert!(failed(&bad, &asked).contains(&name), "{name}: {:#?}", motion(&bad, &asked));
        }
        assert!(failed(&good, &Asked { goal_yaw: Some(0.0), ..asked }).contains(&"ends"));
        assert!(failed(&good, &Asked { end_speed: 0.5, ..asked }).contains(&"ends"));
        assert!(failed(&good, &Asked { start_yaw: Some(0.5), ..asked }).contains(&"heading"));
    }

    #[test]
    fn a_piece_that_lies_about_its_state_is_found() {
        let good = time(&bent(), &limits(), &TimingOptions::default(), &mut Context::new(1)).unwrap();
        for i in 0..good.pieces.len() {
            let mut bad = good.clone();
            if let Piece::Along { speed, .. } = &mut bad.pieces[i] {
                *speed += 1e-3;
            }
            assert!(!failed(&bad, &Asked::default()).is_empty(), "piece {i}");
            let mut bad = good.clone();
            if let Piece::Along { duration, .. } = &mut bad.pieces[i] {
                *duration = f64::NAN;
            }
            assert!(!failed(&bad, &Asked::default()).is_empty(), "piece {i}");
        }
    }
}
