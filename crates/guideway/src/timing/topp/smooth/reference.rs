//! A smooth motion near the second-order optimum, in whose time the jerk-limited problem is posed.
//!
//! The speed of the second-order optimum is averaged over two windows of time. Written in the time of this reference, a motion has a speed of about 1
//! everywhere, at rest too, where in terms of arc length the jerk-limited problem is singular.
//!
//! A motion that does not start at rest is continued evenly before its start. The mean then starts behind the path, so it is followed from where it is on the
//! path but for a part that fades away and gives it the speed asked for: its speed is that of the motion at the start and near it for a slow one too.

use crate::timing::topp::motion::Leg;

/// Integrals of the position of a second-order motion, and its mean over two windows.
pub(super) struct Reference {
    /// Start time, arc length, its first and second integral over time at the start of each leg.
    starts: Vec<[f64; 4]>,
    legs: Vec<Leg>,
    duration: f64,
    windows: [f64; 2],
    /// Speeds before the start and after the end.
    speeds: [f64; 2],
    /// When the mean motion is at the start and at the end.
    range: [f64; 2],
    /// What its speed lacks there, and how long it takes to fade away.
    missing: [f64; 2],
    fading: f64,
}

/// Arc length and its first three derivatives by the time of the reference.
pub(super) type Course4 = [f64; 4];

/// Most of the duration in which the change of the speed at an end fades away.
const FADING: f64 = 0.25;

impl Reference {
    /// From the legs of a motion, and whether it moves already at its start and still at its end.
    pub fn new(legs: &[Leg], windows: [f64; 2], moving: [bool; 2]) -> Self {
        let mut starts = Vec::with_capacity(legs.len() + 1);
        let mut now = [0.0; 4];
        for leg in legs {
            starts.push(now);
            let [_, s, p, r] = integrals(leg, now, leg.duration);
            now = [now[0] + leg.duration, s, p, r];
        }
        starts.push(now);
        let [duration, length, ..] = now;
        let [first, last] = [&legs[0], &legs[legs.len() - 1]];
        let speeds = [first.speed, last.speed + last.duration * (last.acceleration + 0.5 * last.duration * last.jerk)];
        let speeds = [0, 1].map(|end| if moving[end] { speeds[end] } else { 0.0 });
        let window = windows[0] + windows[1];
        let fading = window.min(FADING * duration);
        let range = [0.0, duration + windows[0] + windows[1]];
        let mut mean = Self { starts, legs: legs.to_vec(), duration, windows, speeds, range, missing: [0.0; 2], fading };
        if moving[0] {
            mean.range[0] = root([0.0, window], |t| mean.mean(t)[0] - 0.25 * fading * (speeds[0] - mean.mean(t)[1]));
        }
        if moving[1] {
            mean.range[1] = root([duration, duration + window], |t| mean.mean(t)[0] - length + 0.25 * fading * (speeds[1] - mean.mean(t)[1]));
        }
        mean.missing = [0, 1].map(|end| if moving[end] { speeds[end] - mean.mean(mean.range[end])[1] } else { 0.0 });
        mean
    }

    /// Total time, s.
    pub fn duration(&self) -> f64 {
        self.range[1] - self.range[0]
    }

    /// Speed, position, first and second integral of the position of the motion itself.
    fn motion(&self, t: f64) -> [f64; 4] {
        let even = |v: f64, [at, s, p, r]: [f64; 4]| integrals(&Leg { speed: v, acceleration: 0.0, jerk: 0.0, duration: 0.0 }, [at, s, p, r], t - at);
        if t <= 0.0 {
            return even(self.speeds[0], [0.0; 4]);
        }
        if t >= self.duration {
            return even(self.speeds[1], self.starts[self.starts.len() - 1]);
        }
        let k = (self.starts.partition_point(|start| start[0] <= t) - 1).min(self.legs.len() - 1);
        integrals(&self.legs[k], self.starts[k], t - self.starts[k][0])
    }

    /// The reference at time `t`.
    pub fn at(&self, t: f64) -> Course4 {
        let mut now = self.mean(self.range[0] + t);
        for (end, sign) in [(0, -1.0), (1, 1.0)] {
            let away = if end == 0 { t } else { self.duration() - t };
            if self.missing[end] != 0.0 && away < self.fading {
                let (left, inverse) = (1.0 - away / self.fading, 1.0 / self.fading);
                let parts =
                    [0.25 * sign * self.fading * left.powi(4), left.powi(3), 3.0 * sign * inverse * left * left, 6.0 * inverse * inverse * left];
                now.iter_mut().zip(parts).for_each(|(now, part)| *now += self.missing[end] * part);
            }
        }
        now
    }

    /// The mean motion at time `t` after the start of the first window.
    fn mean(&self, t: f64) -> Course4 {
        let [a, b] = self.windows;
        let corners = [t, t - a, t - b, t - a - b].map(|t| self.motion(t));
        let mean = |i: usize| (corners[0][i] - corners[1][i] - corners[2][i] + corners[3][i]) / (a * b);
        [mean(3), mean(2), mean(1), mean(0)]
    }
}

/// Where a function that rises between two places is 0.
fn root([mut low, mut high]: [f64; 2], value: impl Fn(f64) -> f64) -> f64 {
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if value(middle) < 0.0 {
            low = middle;
        } else {
            high = middle;
        }
    }
    0.5 * (low + high)
}

/// Speed, position and its integrals after the time `t` of a leg.
fn integrals(leg: &Leg, [_, s, p, r]: [f64; 4], t: f64) -> [f64; 4] {
    let Leg { speed: v, acceleration: a, jerk: j, .. } = *leg;
    [
        v + t * (a + 0.5 * t * j),
        s + t * (v + t * (0.5 * a + t * j / 6.0)),
        p + t * (s + t * (0.5 * v + t * (a / 6.0 + t * j / 24.0))),
        r + t * (p + t * (0.5 * s + t * (v / 6.0 + t * (a / 24.0 + t * j / 120.0)))),
    ]
}
