//! Random problems and an independent integrator; nothing here calls the planner's own arithmetic.

use guideway::timing::{Bounds, Jerks, SCurve};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

#[derive(Debug, Clone, Copy)]
pub struct Problem {
    pub distance: f64,
    pub start: (f64, f64),
    pub end: (f64, f64),
    pub bounds: Bounds,
}

#[derive(Debug, Clone, Copy)]
pub struct End {
    pub s: f64,
    pub v: f64,
    pub a: f64,
}

/// Log-uniform in a range.
fn spread(rng: &mut ChaCha8Rng, low: f64, high: f64) -> f64 {
    low * (high / low).powf(rng.random::<f64>())
}

fn random_bounds(rng: &mut ChaCha8Rng) -> Bounds {
    let jerk = spread(rng, 0.5, 200.0);
    let mut jerks = Jerks::all(jerk);
    if rng.random::<f64>() < 0.5 {
        jerks = Jerks { build: jerk, release: spread(rng, 0.5, 200.0), brake: spread(rng, 0.5, 200.0), unbrake: spread(rng, 0.5, 200.0) };
    }
    Bounds { speed: spread(rng, 0.1, 10.0), acceleration: spread(rng, 0.1, 20.0), deceleration: spread(rng, 0.1, 20.0), jerk: jerks }
}

/// A boundary state at the limits now and then, else at rest or anywhere that can keep the speed limit.
fn boundary(rng: &mut ChaCha8Rng, speed: f64, acceleration: f64, jerk: f64) -> (f64, f64) {
    let v = match rng.random_range(0..4) {
        0 => 0.0,
        1 => speed,
        _ => speed * rng.random::<f64>(),
    };
    let most = acceleration.min((2.0 * jerk * (speed - v)).max(0.0).sqrt());
    let a = match rng.random_range(0..4) {
        0 => 0.0,
        1 => most * (1.0 - 1e-12),
        _ => most * rng.random::<f64>(),
    };
    (v, a)
}

/// A problem of the guaranteed domain; some are too short.
pub fn domain(rng: &mut ChaCha8Rng) -> Problem {
    let bounds = random_bounds(rng);
    let start = boundary(rng, bounds.speed, bounds.acceleration, bounds.jerk.release);
    let (v, a) = boundary(rng, bounds.speed, bounds.deceleration, bounds.jerk.brake);
    let mut problem = Problem { distance: 0.0, start, end: (v, -a), bounds };
    let shortest = problem.shortest();
    problem.distance = match rng.random_range(0..4) {
        0 => spread(rng, 1e-4, 100.0),
        1 => shortest * (1.0 + rng.random::<f64>()) + 1e-9,
        _ => shortest + spread(rng, 1e-3, 30.0),
    };
    problem
}

/// A problem with accelerations of any sign at the ends that need no reversal by themselves.
pub fn free(rng: &mut ChaCha8Rng) -> Problem {
    let mut problem = domain(rng);
    if rng.random::<f64>() < 0.7 {
        let most = (2.0 * problem.bounds.jerk.unbrake * problem.start.0).sqrt();
        problem.start.1 = -problem.bounds.deceleration.min(most) * rng.random::<f64>();
    }
    if rng.random::<f64>() < 0.7 {
        let most = (2.0 * problem.bounds.jerk.build * problem.end.0).sqrt();
        problem.end.1 = problem.bounds.acceleration.min(most) * rng.random::<f64>();
    }
    problem
}

/// Integrates phases one by one with compensated sums.
pub fn flown(problem: &Problem, phases: impl Iterator<Item = (f64, f64)>) -> End {
    let mut s = Sum::default();
    let mut v = Sum { value: problem.start.0, rest: 0.0 };
    let mut a = Sum { value: problem.start.1, rest: 0.0 };
    for (t, j) in phases {
        s.add(v.value * t);
        s.add(a.value * t * t / 2.0);
        s.add(j * t * t * t / 6.0);
        v.add(a.value * t);
        v.add(j * t * t / 2.0);
        a.add(j * t);
    }
    End { s: s.value, v: v.value, a: a.value }
}

#[derive(Default, Clone, Copy)]
struct Sum {
    value: f64,
    rest: f64,
}

impl Sum {
    fn add(&mut self, x: f64) {
        let y = x - self.rest;
        let t = self.value + y;
        self.rest = (t - self.value) - y;
        self.value = t;
    }
}

/// Largest excess over a limit in a profile sampled finely, with the inner extremes of each phase.
pub fn limits_excess(problem: &Problem, phases: impl Iterator<Item = (f64, f64)>) -> f64 {
    let b = &problem.bounds;
    let (mut v, mut a) = problem.start;
    let mut worst = f64::NEG_INFINITY;
    for (t, j) in phases {
        worst = worst.max(-t);
        let inner = if j == 0.0 { 0.0 } else { -a / j };
        for tau in [0.0, 0.25 * t, 0.5 * t, 0.75 * t, t, inner.clamp(0.0, t)] {
            let (speed, acceleration) = (v + a * tau + j * tau * tau / 2.0, a + j * tau);
            worst = worst.max(speed - b.speed).max(-speed).max(acceleration - b.acceleration).max(-b.deceleration - acceleration);
        }
        if t > 0.0 {
            let middle = a + 0.5 * j * t;
            let limit = match (middle > 0.0, j > 0.0) {
                (true, true) => b.jerk.build,
                (true, false) => b.jerk.release,
                (false, false) => b.jerk.brake,
                (false, true) => b.jerk.unbrake,
            };
            // In the instant of crossing zero either neighbour's jerk is right.
            let tiny = middle.abs() * t < 1e-9;
            worst = worst.max(if tiny { f64::NEG_INFINITY } else { j.abs() - limit });
        }
        v += a * t + j * t * t / 2.0;
        a += j * t;
    }
    worst
}

/// Time and distance of one side from `(v, a)` up to `(w, 0)` with peak acceleration at most `limit`.
fn side((v, a): (f64, f64), w: f64, limit: f64, (near, far): (f64, f64)) -> (f64, f64) {
    let free = ((2.0 * (w - v) + a * a / near) / (1.0 / near + 1.0 / far)).max(0.0).sqrt();
    let p = free.min(limit).max(a);
    let ramps = (p * p - a * a) / (2.0 * near) + p * p / (2.0 * far);
    let hold = if p > 0.0 { ((w - v - ramps) / p).max(0.0) } else { 0.0 };
    let (mut s, mut speed, mut acc, mut time) = (0.0, v, a, 0.0);
    for (t, j) in [((p - a) / near, near), (hold, 0.0), (p / far, -far)] {
        s += speed * t + acc * t * t / 2.0 + j * t * t * t / 6.0;
        speed += acc * t + j * t * t / 2.0;
        acc += j * t;
        time += t;
    }
    (time, s)
}

impl Problem {
    pub fn curve(&self) -> SCurve {
        SCurve { distance: self.distance, start: self.start, end: self.end, bounds: self.bounds }
    }

    /// Lowest top speed that the boundary accelerations allow.
    pub fn lowest_top(&self) -> f64 {
        let j = &self.bounds.jerk;
        (self.start.0 + self.start.1.powi(2) / (2.0 * j.release)).max(self.end.0 + self.end.1.powi(2) / (2.0 * j.brake))
    }

    /// Time and distance through the top speed `w` with scaled limits of acceleration, deceleration and jerk (1: the full ones).
    pub fn through(&self, w: f64, up: f64, down: f64, jerk: f64) -> (f64, f64) {
        let j = &self.bounds.jerk;
        let first = side(self.start, w, up * self.bounds.acceleration, (jerk * j.build, jerk * j.release));
        let second = side((self.end.0, -self.end.1), w, down * self.bounds.deceleration, (jerk * j.unbrake, jerk * j.brake));
        (first.0 + second.0, first.1 + second.1)
    }

    /// Shortest distance in the guaranteed domain.
    pub fn shortest(&self) -> f64 {
        self.through(self.lowest_top(), 1.0, 1.0, 1.0).1
    }

    /// Least time over a grid of feasible profiles: top speed, acceleration, deceleration and jerk below their limits.
    pub fn fine_search(&self, grid: usize) -> f64 {
        let low = self.lowest_top();
        let mut best = f64::INFINITY;
        let top = |i: usize| low + (self.bounds.speed - low) * i as f64 / (10 * grid) as f64;
        for i in 0..=10 * grid {
            let w = top(i);
            for (up, down) in (0..grid * grid).map(|k| (1.0 - (k / grid) as f64 / grid as f64, 1.0 - (k % grid) as f64 / grid as f64)) {
                for jerk in [1.0, 0.8] {
                    let (time, distance) = self.through(w, up, down, jerk);
                    // Smaller jerk cannot always release the boundary accelerations below the top speed.
                    let valid = jerk == 1.0 || self.start.1 == 0.0 && self.end.1 == 0.0;
                    if valid && distance <= self.distance && w > 0.0 {
                        best = best.min(time + (self.distance - distance) / w);
                    }
                }
            }
        }
        best
    }
}
