//! The first pass: seven phases over a whole path, from rest to rest, in closed form (section 6.2 for `a_s = a_e = 0`), and the speed as a function of the place.

use crate::query::Limits;

/// A motion from rest to rest.
#[derive(Debug, Clone, Copy)]
pub(super) struct FirstPass {
    length: f64,
    jerk: f64,
    /// Peak speed `v_p`, m/s.
    pub top: f64,
    up: Ramp,
    down: Ramp,
    /// Total time `T`, s.
    pub time: f64,
}

/// From rest to the peak speed.
#[derive(Debug, Clone, Copy)]
struct Ramp {
    /// Acceleration limit, m/s2.
    limit: f64,
    /// Distance, m, and time, s.
    length: f64,
    time: f64,
    /// Where the jerk phase ends and where the next one begins, m; speed at the former, m/s.
    bend: f64,
    release: f64,
    speed: f64,
}

impl Ramp {
    fn new(top: f64, limit: f64, jerk: f64) -> Self {
        let saturated = jerk * top > limit * limit; // A1, D1
        let first = if saturated { limit / jerk } else { (top / jerk).sqrt() };
        let time = if saturated { top / limit + first } else { 2.0 * first };
        let length = 0.5 * top * time;
        let (bend, speed) = (jerk * first * first * first / 6.0, 0.5 * jerk * first * first);
        let release = length - (top * first - bend);
        Self { limit, length, time, bend, release, speed }
    }

    /// Speed at distance `s` from rest.
    fn speed(&self, s: f64, top: f64, jerk: f64) -> f64 {
        if s <= self.bend {
            let t = (6.0 * s.max(0.0) / jerk).cbrt();
            0.5 * jerk * t * t
        } else if s < self.release {
            (self.speed * self.speed + 2.0 * self.limit * (s - self.bend)).sqrt()
        } else {
            // Backwards from the end of the ramp, where the speed is the peak: x = v u - j u^3 / 6, concave, so Newton's steps come from below.
            let x = (self.length - s).max(0.0);
            let mut u = x / top;
            for _ in 0..4 {
                u += (x - u * (top - jerk * u * u / 6.0)) / (top - 0.5 * jerk * u * u);
            }
            top - 0.5 * jerk * u * u
        }
    }
}

/// Distance to reach `v` from rest and its derivative.
fn reach(v: f64, limit: f64, jerk: f64) -> (f64, f64) {
    if jerk * v > limit * limit {
        (0.5 * v * (v / limit + limit / jerk), v / limit + 0.5 * limit / jerk)
    } else {
        let t = (v / jerk).sqrt();
        (v * t, 1.5 * t)
    }
}

impl FirstPass {
    /// The fastest motion over `length` > 0 m.
    pub fn new(length: f64, limits: &Limits) -> Self {
        let Limits { acceleration: a, deceleration: b, jerk, .. } = *limits;
        let both = |v: f64| {
            let (up, down) = (reach(v, a, jerk), reach(v, b, jerk));
            (up.0 + down.0, up.1 + down.1)
        };
        let mut top = limits.speed;
        if both(top).0 > length {
            // The distance grows ever faster with the speed: Newton's steps come down to the root and never pass it.
            for _ in 0..60 {
                let (distance, slope) = both(top);
                let next = top - (distance - length) / slope;
                if next >= top || next <= 0.0 {
                    break;
                }
                top = next;
            }
        }
        let (up, down) = (Ramp::new(top, a, jerk), Ramp::new(top, b, jerk));
        let cruise = ((length - up.length - down.length) / top).max(0.0); // T4
        Self { length, jerk, top, up, down, time: up.time + cruise + down.time }
    }

    /// Speed at arc length `s`, m/s.
    #[inline]
    pub fn speed(&self, s: f64) -> f64 {
        if s < self.up.length {
            self.up.speed(s, self.top, self.jerk)
        } else if s > self.length - self.down.length {
            self.down.speed(self.length - s, self.top, self.jerk)
        } else {
            self.top
        }
    }

    /// Arc length at time `t` (s), m.
    pub fn place(&self, t: f64) -> f64 {
        if t < self.up.time {
            travelled(t, &self.up, self.top, self.jerk)
        } else if t > self.time - self.down.time {
            self.length - travelled(self.time - t, &self.down, self.top, self.jerk)
        } else {
            self.up.length + self.top * (t - self.up.time)
        }
    }
}

/// Distance from rest after `t` seconds of a ramp, m.
fn travelled(t: f64, ramp: &Ramp, top: f64, jerk: f64) -> f64 {
    let first = (2.0 * ramp.speed / jerk).sqrt();
    let left = ramp.time - t;
    if t <= first {
        jerk * t.max(0.0).powi(3) / 6.0
    } else if left > first {
        let u = t - first;
        ramp.bend + u * (ramp.speed + 0.5 * ramp.limit * u)
    } else {
        ramp.length - left * (top - jerk * left * left / 6.0)
    }
}
