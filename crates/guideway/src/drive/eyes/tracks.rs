//! Movers over time: one Kalman filter (constant velocity) per mover, nearest neighbours first.
//!
//! Source: \[kalman1960\]; white acceleration as process noise. Both axes share one covariance, since neither motion nor measurement prefers one.

use super::blobs::Blob;
use crate::Point;
use crate::drive::{Outline, Track};
use crate::world::shape::distance;

/// Standard deviation of the acceleration of movers, m/s2.
const RESTLESS: f64 = 1.5;
/// Standard deviation of a measured centre, m, and what a share of the radius adds for the side that is not seen.
const CENTER: f64 = 0.02;
const HIDDEN: f64 = 0.05;
/// Standard deviation of the speed of a mover seen for the first time, m/s.
const PACE: f64 = 1.5;
/// Gate of the association, standard deviations, and at least so far and at most so far, m.
const GATE: f64 = 3.5;
const NEAR: f64 = 0.15;
const FAR: f64 = 0.8;
/// Something that never moved and is no longer seen is forgotten after so long, s.
const FADES: f64 = 0.3;
/// A mover that should be seen and is not is forgotten after so many scans; one that is hidden after so long, s.
const MISSES: u32 = 4;
const HIDING: f64 = 1.5;
/// Something that has not gone farther than this, m, for so long, s, is static.
const STAYS: f64 = 0.08;
const SETTLED: f64 = 1.0;
/// Where nobody says how fast things may move here: so fast, m/s, or so many times their speed.
const WALK: f64 = 1.0;
const HASTE: f64 = 1.2;
/// Speeds known worse than this are not told, m/s.
const VAGUE: f64 = 0.8;
/// The outline shrinks by this share of the difference per scan, and grows by that.
const SHRINK: f64 = 0.05;
const GROW: f64 = 0.5;

/// A mover as the filter knows it.
#[derive(Debug, Clone)]
pub(super) struct Known {
    pub id: usize,
    pub place: Point,
    pub velocity: Point,
    pub radius: f64,
    /// Variances of place and speed and their covariance.
    p: [f64; 3],
    /// Time of the state, s.
    time: f64,
    /// Time last seen, s.
    seen: f64,
    /// Where it was last known to move, and when, s; did it ever?
    anchor: (Point, f64),
    moved: bool,
    misses: u32,
    matched: bool,
}

impl Known {
    fn new(id: usize, blob: &Blob, time: f64) -> Self {
        let r = noise(blob);
        Self {
            id,
            place: blob.center,
            velocity: [0.0; 2],
            radius: blob.radius,
            p: [r, PACE * PACE, 0.0],
            time,
            seen: time,
            anchor: (blob.center, time),
            moved: false,
            misses: 0,
            matched: true,
        }
    }

    fn predict(&mut self, time: f64) {
        let dt = time - self.time;
        let [a, b, c] = self.p;
        let q = RESTLESS * RESTLESS;
        self.p = [a + 2.0 * dt * c + dt * dt * b + 0.25 * q * dt.powi(4), b + q * dt * dt, c + dt * b + 0.5 * q * dt.powi(3)];
        self.place = [self.place[0] + dt * self.velocity[0], self.place[1] + dt * self.velocity[1]];
        self.time = time;
    }

    fn correct(&mut self, blob: &Blob) {
        let [a, b, c] = self.p;
        let s = a + noise(blob);
        let (k, l) = (a / s, c / s);
        for axis in 0..2 {
            let off = blob.center[axis] - self.place[axis];
            self.place[axis] += k * off;
            self.velocity[axis] += l * off;
        }
        self.p = [(1.0 - k) * a, b - l * c, (1.0 - k) * c];
        self.radius += (blob.radius - self.radius) * if blob.radius > self.radius { GROW } else { SHRINK };
        (self.seen, self.misses, self.matched) = (self.time, 0, true);
        if distance(self.place, self.anchor.0) > STAYS {
            (self.anchor, self.moved) = ((self.place, self.time), true);
        }
    }

    fn speed(&self) -> f64 {
        self.velocity[0].hypot(self.velocity[1])
    }

    /// Has it rested long enough to count as static?
    fn settled(&self) -> bool {
        self.seen - self.anchor.1 >= SETTLED
    }

    /// The largest speed that it may take up, m/s; `top` is that of all that moves here, where it is known.
    fn bound(&self, top: Option<f64>) -> f64 {
        match top {
            _ if self.settled() => 0.0,
            Some(top) => top.max(self.speed()),
            None => WALK.max(HASTE * self.speed()),
        }
    }

    /// As controllers see it at `time`; `top` (m/s) is the largest speed of all that moves here, where it is known.
    fn track(&self, time: f64, top: Option<f64>) -> Track {
        let dt = time - self.time;
        let settled = self.settled();
        let sure = !settled && self.p[1] < VAGUE * VAGUE;
        let velocity = if sure { self.velocity } else { [0.0; 2] };
        let place = [self.place[0] + dt * velocity[0], self.place[1] + dt * velocity[1]];
        let spread = self.p[0] + if settled { 0.0 } else { dt * (2.0 * self.p[2] + dt * self.p[1]) };
        Track {
            id: self.id,
            outline: Outline { points: vec![[0.0; 2]], radius: self.radius },
            position: place,
            velocity,
            bound: self.bound(top),
            doubt: 3.0 * spread.max(0.0).sqrt(),
        }
    }
}

/// Variance of the centre of a group, m2.
fn noise(blob: &Blob) -> f64 {
    (CENTER + HIDDEN * blob.radius).powi(2)
}

/// All movers that are known.
#[derive(Debug, Default)]
pub(super) struct Tracks {
    all: Vec<Known>,
    next: usize,
    pairs: Vec<(f64, usize, usize)>,
    taken: Vec<bool>,
}

impl Tracks {
    /// Forgets all; numbers are not used again.
    pub fn clear(&mut self) {
        self.all.clear();
    }

    /// Moves all on to `time`, s.
    pub fn predict(&mut self, time: f64) {
        for known in &mut self.all {
            known.predict(time);
            known.matched = false;
        }
    }

    /// Is `p` on or beside something that moves?
    pub fn cover(&self, p: Point) -> bool {
        self.all.iter().any(|k| {
            let reach = k.radius + NEAR;
            // Most are far away, which their coordinates tell.
            k.moved && (k.place[0] - p[0]).abs() < reach && (k.place[1] - p[1]).abs() < reach && distance(k.place, p) < reach
        })
    }

    /// The scan of `time`: matches groups with movers, begins new ones. `open` tells whether a ray towards a point passes beyond a distance, m.
    pub fn update(&mut self, blobs: &[Blob], time: f64, open: impl Fn(Point, f64) -> bool) {
        self.taken.clear();
        self.taken.resize(blobs.len(), false);
        self.pairs.clear();
        for (i, known) in self.all.iter().enumerate() {
            for (j, blob) in blobs.iter().enumerate() {
                let gate = (GATE * (known.p[0] + noise(blob)).sqrt()).clamp(NEAR, FAR);
                let off = distance(known.place, blob.center);
                if off < gate {
                    self.pairs.push((off, i, j));
                }
            }
        }
        self.pairs.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)).then(a.2.cmp(&b.2)));
        for &(_, i, j) in &self.pairs {
            if !self.all[i].matched && !self.taken[j] {
                self.all[i].correct(&blobs[j]);
                self.taken[j] = true;
            }
        }
        for known in self.all.iter_mut().filter(|k| !k.matched) {
            known.misses += u32::from(open(known.place, known.radius));
        }
        self.all.retain(|k| k.misses < MISSES && time - k.seen < if k.moved { HIDING } else { FADES });
        for (j, blob) in blobs.iter().enumerate() {
            // A part of a mover that something else splits is no mover of its own.
            let part = self.all.iter().any(|k| distance(k.place, blob.center) < k.radius);
            if !self.taken[j] && !part {
                self.all.push(Known::new(self.next, blob, time));
                self.next += 1;
            }
        }
    }

    /// What controllers see at `time`, s.
    pub fn told(&self, time: f64, top: Option<f64>) -> impl Iterator<Item = Track> + '_ {
        self.all.iter().map(move |k| k.track(time, top))
    }
}
