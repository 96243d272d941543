//! A smooth motion near the second-order optimum, in whose time the jerk-limited problem is posed.
//!
//! The speed of the second-order optimum is averaged over two windows of time. Written in the time of this reference, a motion has a speed of about 1
//! everywhere, at rest too, where in terms of arc length the jerk-limited problem is singular.

use crate::timing::topp::motion::Leg;

/// Integrals of the position of a second-order motion, and its mean over two windows.
pub(super) struct Reference {
    /// Start time, arc length, its first and second integral over time at the start of each leg.
    starts: Vec<[f64; 4]>,
    legs: Vec<Leg>,
    duration: f64,
    windows: [f64; 2],
}

/// Arc length and its first three derivatives by the time of the reference.
pub(super) type Course4 = [f64; 4];

impl Reference {
    /// From the legs of a motion from rest to rest.
    pub fn new(legs: &[Leg], windows: [f64; 2]) -> Self {
        let mut starts = Vec::with_capacity(legs.len() + 1);
        let mut now = [0.0; 4];
        for leg in legs {
            starts.push(now);
            let [_, s, p, r] = integrals(leg, now, leg.duration);
            now = [now[0] + leg.duration, s, p, r];
        }
        starts.push(now);
        Self { starts, legs: legs.to_vec(), duration: now[0], windows }
    }

    /// Total time, s.
    pub fn duration(&self) -> f64 {
        self.duration + self.windows[0] + self.windows[1]
    }

    /// Speed, position, first and second integral of the position of the motion itself.
    fn motion(&self, t: f64) -> [f64; 4] {
        if t <= 0.0 {
            return [0.0; 4];
        }
        if t >= self.duration {
            let [end, s, p, r] = self.starts[self.starts.len() - 1];
            let late = t - end;
            return [0.0, s, p + s * late, r + late * (p + 0.5 * s * late)];
        }
        let k = (self.starts.partition_point(|start| start[0] <= t) - 1).min(self.legs.len() - 1);
        integrals(&self.legs[k], self.starts[k], t - self.starts[k][0])
    }

    /// The mean motion at time `t`.
    pub fn at(&self, t: f64) -> Course4 {
        let [a, b] = self.windows;
        let corners = [t, t - a, t - b, t - a - b].map(|t| self.motion(t));
        let mean = |i: usize| (corners[0][i] - corners[1][i] - corners[2][i] + corners[3][i]) / (a * b);
        [mean(3), mean(2), mean(1), mean(0)]
    }
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
