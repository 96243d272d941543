//! A timed motion of joints along a path.

use super::Report;
use crate::path::Path;
use crate::timing::Piece;
use crate::timing::scurve::advance;

/// A motion along a path of any dimension: where it is when, and what holds it back where.
#[derive(Debug, Clone)]
pub struct JointMotion {
    /// The path it follows, rad.
    pub path: Path,
    /// Arc lengths of the grid, rad.
    pub s: Vec<f64>,
    /// Squared path speed at the grid, rad2/s2.
    pub x: Vec<f64>,
    /// Path acceleration between grid points, rad/s2.
    pub u: Vec<f64>,
    /// What is nearest to its bound on the interval that begins at each grid point (at the last: that ends there).
    pub active: Vec<String>,
    /// Maximum velocity curve at the grid: the squared path speed no motion can exceed there, rad2/s2.
    pub mvc: Vec<f64>,
    /// Stretches of constant path jerk in time order, [`Piece::Along`].
    pub pieces: Vec<Piece>,
    /// With limits of jerk: seconds that each costs against the motion without them; shares of the whole by what a small change of the limit is worth.
    pub price: Vec<(String, f64)>,
    /// How it was found.
    pub report: Report,
}

/// State of the joints at one time.
#[derive(Debug, Clone, PartialEq)]
pub struct JointState {
    /// s.
    pub t: f64,
    /// Arc length, rad.
    pub s: f64,
    /// Path speed, rad/s.
    pub speed: f64,
    /// Path acceleration, rad/s2.
    pub acceleration: f64,
    /// Path jerk, rad/s3.
    pub jerk: f64,
    /// Joint positions, speeds, accelerations and jerks: rad, rad/s, rad/s2, rad/s3.
    pub joints: [Vec<f64>; 4],
}

impl JointMotion {
    /// The maximum velocity curve at an arc length, between grid points by a line.
    pub(super) fn mvc_at(&self, s: f64) -> f64 {
        let k = self.s.partition_point(|a| *a <= s).clamp(1, self.s.len() - 1);
        let share = ((s - self.s[k - 1]) / (self.s[k] - self.s[k - 1])).clamp(0.0, 1.0);
        self.mvc[k - 1] + share * (self.mvc[k] - self.mvc[k - 1])
    }

    /// Total time, s.
    pub fn duration(&self) -> f64 {
        self.pieces.last().map_or(0.0, |piece| piece.start() + piece.duration())
    }

    /// State at time `t` (s), clamped to the motion; at a change of pieces, that of the later one.
    pub fn at(&self, t: f64) -> JointState {
        let t = t.clamp(0.0, self.duration());
        let i = self.pieces.partition_point(|p| p.start() <= t).saturating_sub(1);
        let (s, speed, acceleration, jerk) = match self.pieces.get(i) {
            Some(Piece::Along { t: start, s, speed, acceleration, jerk, duration }) => {
                let (s, v, a) = advance((*s, *speed, *acceleration), *jerk, (t - start).min(*duration));
                (s, v.max(0.0), a, *jerk)
            }
            _ => (0.0, 0.0, 0.0, 0.0),
        };
        let q = self.path.eval(s, 3);
        let joints = |f: &dyn Fn(usize) -> f64| (0..self.path.dimension()).map(f).collect::<Vec<f64>>();
        let speeds = joints(&|i| q[1][i] * speed);
        let accelerations = joints(&|i| q[1][i] * acceleration + q[2][i] * speed * speed);
        let jerks = joints(&|i| q[1][i] * jerk + 3.0 * q[2][i] * speed * acceleration + q[3][i] * speed * speed * speed);
        JointState { t, s, speed, acceleration, jerk, joints: [q[0].clone(), speeds, accelerations, jerks] }
    }

    /// States at times (s).
    pub fn sample(&self, times: &[f64]) -> Vec<JointState> {
        times.iter().map(|t| self.at(*t)).collect()
    }
}

/// The motion over one interval: constant jerk from a speed and an acceleration.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Leg {
    pub speed: f64,
    pub acceleration: f64,
    pub jerk: f64,
    pub duration: f64,
}

impl Leg {
    /// Over `step` from `x[0]` to `x[1]` (squared speeds) with jerk `bend` times the mean speed: between the two, distance and speeds leave one choice, the
    /// jerk.
    pub fn new(step: f64, x: [f64; 2], bend: f64) -> Self {
        let v = x.map(f64::sqrt);
        let mean = 0.5 * (v[0] + v[1]);
        let mut duration = step / mean;
        let mut jerk = bend * mean;
        // A falling acceleration always gets there; a rising one below 16/9, else the speed would turn round on the way.
        let gentle = (-3.0..1.5).contains(&(jerk * duration * duration / mean));
        if jerk == 0.0 || !gentle {
            jerk = 0.0;
            return Self { speed: v[0], acceleration: (x[1] - x[0]) / (2.0 * step), jerk, duration };
        }
        for _ in 0..20 {
            let miss = duration * (mean - jerk * duration * duration / 12.0) - step;
            let next = duration - miss / (mean - 0.25 * jerk * duration * duration);
            if (next - duration).abs() <= 1e-15 * duration {
                break;
            }
            duration = next;
        }
        Self { speed: v[0], acceleration: (v[1] - v[0]) / duration - 0.5 * jerk * duration, jerk, duration }
    }

    /// Squared speed and acceleration after the way `way`.
    pub fn at(&self, way: f64) -> [f64; 2] {
        let x = (self.speed * self.speed + 2.0 * self.acceleration * way).max(0.0);
        if self.jerk == 0.0 {
            return [x, self.acceleration];
        }
        let mut t = (2.0 * way / (self.speed + x.sqrt()).max(f64::MIN_POSITIVE)).min(self.duration);
        for _ in 0..6 {
            let (s, v, _) = advance((0.0, self.speed, self.acceleration), self.jerk, t);
            t = (t - (s - way) / v).clamp(0.0, self.duration);
            // The next step would be of the order of the square of this one.
            if (s - way).abs() <= 1e-6 * way {
                break;
            }
        }
        let (_, v, a) = advance((0.0, self.speed, self.acceleration), self.jerk, t);
        [v * v, a]
    }
}

/// A leg with a guess of when it is where: the cubic through its times and speeds at both ends.
pub(super) struct Clock<'a> {
    leg: &'a Leg,
    /// One over the length, and the coefficients of the cubic in the share of the way.
    inverse: f64,
    cubic: [f64; 3],
}

impl Leg {
    /// Over a way of the given length.
    pub fn clock(&self, length: f64) -> Clock<'_> {
        let end = self.speed + self.duration * (self.acceleration + 0.5 * self.jerk * self.duration);
        let [from, to] = [length / self.speed, length / end];
        Clock { leg: self, inverse: 1.0 / length, cubic: [from, 3.0 * self.duration - 2.0 * from - to, from + to - 2.0 * self.duration] }
    }
}

impl Clock<'_> {
    /// Squared speed and acceleration after the way `way`.
    pub fn at(&self, way: f64) -> [f64; 2] {
        let Leg { speed, acceleration, jerk, .. } = *self.leg;
        if jerk == 0.0 {
            return [(speed * speed + 2.0 * acceleration * way).max(0.0), acceleration];
        }
        let (z, [a, b, c]) = (way * self.inverse, self.cubic);
        let (s, v, a) = advance((0.0, speed, acceleration), jerk, z * (a + z * (b + z * c)));
        let late = (way - s) / v;
        // What is left after this step is of the order of its square.
        if (way - s).abs() <= 1e-6 * way {
            let v = v + late * (a + 0.5 * late * jerk);
            return [v * v, a + late * jerk];
        }
        self.leg.at(way)
    }
}

/// The legs between the points of a profile.
pub(super) fn legs(s: &[f64], x: &[f64], bend: &[f64]) -> Vec<Leg> {
    (0..bend.len()).map(|k| Leg::new(s[k + 1] - s[k], [x[k], x[k + 1]], bend[k])).collect()
}

/// Legs as pieces in time.
pub(super) fn pieces(s: &[f64], legs: &[Leg]) -> Vec<Piece> {
    let mut t = 0.0;
    let mut pieces = Vec::with_capacity(legs.len());
    for (s, leg) in s.iter().zip(legs) {
        let Leg { speed, acceleration, jerk, duration } = *leg;
        pieces.push(Piece::Along { t, s: *s, speed, acceleration, jerk, duration });
        t += duration;
    }
    pieces
}
