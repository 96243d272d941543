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
/// Where it is known how fast things may move here: what is hidden is remembered for so long, s; it goes on as it did for so long, s.
const LURKING: f64 = 3.0;
const STEADY: f64 = 0.3;
/// Standard deviation of the centre of what is seen in part, m.
const CUT: f64 = 0.25;
/// Farther than so many standard deviations from where it was expected, it has turned.
const SURPRISE: f64 = 2.0;
/// What comes into sight may be what was hidden if that could be so near, m.
const BESIDE: f64 = 0.5;
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
    /// Where it was when it was seen last, and how far it may have been from there, m.
    last: (Point, f64),
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
    fn new(id: usize, blob: &Blob, (time, strict): (f64, bool)) -> Self {
        let r = noise(blob, strict);
        Self {
            id,
            place: blob.center,
            velocity: [0.0; 2],
            radius: blob.radius,
            p: [r, PACE * PACE, 0.0],
            last: (blob.center, 3.0 * r.sqrt()),
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

    /// Takes a look into account; `strict` where the top speed is known.
    fn correct(&mut self, blob: &Blob, strict: bool) {
        let r = noise(blob, strict);
        if strict && distance(self.place, blob.center).powi(2) > SURPRISE * SURPRISE * (self.p[0] + r) {
            // It turns: nothing is known of its speed any more, and of its place what is seen.
            self.p = [self.p[0] + r, PACE * PACE, self.p[2]];
        }
        let [a, b, c] = self.p;
        let s = a + r;
        let (k, l) = (a / s, c / s);
        for axis in 0..2 {
            let off = blob.center[axis] - self.place[axis];
            self.place[axis] += k * off;
            self.velocity[axis] += l * off;
        }
        self.p = [(1.0 - k) * a, b - l * c, (1.0 - k) * c];
        if !(strict && blob.cut && blob.radius < self.radius) {
            self.radius += (blob.radius - self.radius) * if blob.radius > self.radius { GROW } else { SHRINK };
        }
        self.last = (self.place, 3.0 * self.p[0].max(0.0).sqrt() + if blob.cut { 0.0 } else { distance(self.place, blob.center) });
        (self.seen, self.misses, self.matched) = (self.time, 0, true);
        if distance(self.place, self.anchor.0) > STAYS {
            (self.anchor, self.moved) = ((self.place, self.time), true);
        }
    }

    /// Is it nowhere within `reach` (m) of where it was last seen?
    fn gone(&self, reach: f64, open: &impl Fn(Point, f64) -> bool) -> bool {
        let ([x, y], ring) = (self.last.0, (0..8).map(|k| (0.25 * f64::from(k) * std::f64::consts::PI).sin_cos()));
        open(self.last.0, self.radius) && ring.into_iter().all(|(s, c)| open([x + reach * c, y + reach * s], self.radius))
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

    /// Where it is at `time`, how fast, and how far it may be from there: where the top speed is known nothing else is taken for granted.
    fn state(&self, time: f64, top: Option<f64>) -> (Point, Point, f64) {
        let settled = self.settled();
        let sure = !settled && self.p[1] < VAGUE * VAGUE;
        let velocity = if sure { self.velocity } else { [0.0; 2] };
        if let (Some(top), false) = (top, settled) {
            let hidden = (time - self.seen).max(0.0);
            let fades = (-hidden / STEADY).exp();
            let way = STEADY * (1.0 - fades);
            let place = [self.last.0[0] + way * velocity[0], self.last.0[1] + way * velocity[1]];
            let speed = velocity[0].hypot(velocity[1]);
            return (place, velocity.map(|v| v * fades), self.last.1 + top * hidden + way * speed);
        }
        let dt = time - self.time;
        let spread = self.p[0] + if settled { 0.0 } else { dt * (2.0 * self.p[2] + dt * self.p[1]) };
        ([self.place[0] + dt * velocity[0], self.place[1] + dt * velocity[1]], velocity, 3.0 * spread.max(0.0).sqrt())
    }

    /// As controllers see it at `time`; `top` (m/s) is the largest speed of all that moves here, where it is known.
    fn track(&self, time: f64, top: Option<f64>) -> Track {
        let (position, velocity, doubt) = self.state(time, top);
        let outline = Outline { points: vec![[0.0; 2]], radius: self.radius };
        Track { id: self.id, outline, position, velocity, bound: self.bound(top), doubt }
    }
}

/// Variance of the centre of a group, m2.
fn noise(blob: &Blob, strict: bool) -> f64 {
    (CENTER + HIDDEN * blob.radius + if strict && blob.cut { CUT } else { 0.0 }).powi(2)
}

/// All movers that are known.
#[derive(Debug)]
pub(super) struct Tracks {
    /// Top speed of all that moves here, m/s, where it is known.
    top: Option<f64>,
    all: Vec<Known>,
    next: usize,
    pairs: Vec<(f64, usize, usize)>,
    taken: Vec<bool>,
}

impl Tracks {
    /// None yet.
    pub fn new(top: Option<f64>) -> Self {
        Self { top, all: Vec::new(), next: 0, pairs: Vec::new(), taken: Vec::new() }
    }

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
            // Most are far away, which their coordinates tell.
            let near = |b: &Blob| (known.place[0] - b.center[0]).abs() < FAR && (known.place[1] - b.center[1]).abs() < FAR;
            for (j, blob) in blobs.iter().enumerate().filter(|(_, blob)| near(blob)) {
                let gate = (GATE * (known.p[0] + noise(blob, self.top.is_some())).sqrt()).clamp(NEAR, FAR);
                let off = distance(known.place, blob.center);
                if off < gate {
                    self.pairs.push((off, i, j));
                }
            }
        }
        self.pairs.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)).then(a.2.cmp(&b.2)));
        for &(_, i, j) in &self.pairs {
            if !self.all[i].matched && !self.taken[j] {
                self.all[i].correct(&blobs[j], self.top.is_some());
                self.taken[j] = true;
            }
        }
        if let Some(top) = self.top {
            self.found_again(blobs, (time, top));
        }
        let top = self.top;
        for known in self.all.iter_mut().filter(|k| !k.matched) {
            known.misses += u32::from(match top {
                Some(top) => known.gone(top * (time - known.seen), &open),
                None => open(known.place, known.radius),
            });
        }
        let hiding = if top.is_some() { LURKING } else { HIDING };
        self.all.retain(|k| k.misses < MISSES && time - k.seen < if k.moved { hiding } else { FADES });
        for (j, blob) in blobs.iter().enumerate() {
            // A part of a mover that something else splits is no mover of its own.
            let part = self.all.iter().any(|k| distance(k.place, blob.center) < k.radius);
            if !self.taken[j] && !part {
                self.all.push(Known::new(self.next, blob, (time, self.top.is_some())));
                self.next += 1;
            }
        }
    }

    /// What comes into sight where something that is missed could be by now is that, the nearest first.
    fn found_again(&mut self, blobs: &[Blob], (time, top): (f64, f64)) {
        self.pairs.clear();
        for (i, known) in self.all.iter().enumerate().filter(|(_, k)| !k.matched && k.moved) {
            let reach = top * (time - known.seen) + BESIDE;
            let off = |j: usize| distance(known.last.0, blobs[j].center);
            self.pairs.extend((0..blobs.len()).filter(|j| !self.taken[*j] && off(*j) < reach).map(|j| (off(j), i, j)));
        }
        self.pairs.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)).then(a.2.cmp(&b.2)));
        for &(_, i, j) in &self.pairs {
            if !self.all[i].matched && !self.taken[j] {
                let known = &mut self.all[i];
                let fresh = Known::new(known.id, &blobs[j], (time, true));
                *known = Known { moved: true, radius: known.radius.max(fresh.radius), ..fresh };
                self.taken[j] = true;
            }
        }
    }

    /// What controllers see at `time`, s.
    pub fn told(&self, time: f64) -> impl Iterator<Item = Track> + '_ {
        self.all.iter().map(move |k| k.track(time, self.top))
    }
}
