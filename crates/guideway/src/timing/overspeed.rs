//! Velocity extreme search: where a speed profile rises above the ceiling of its path, and how much.
//!
//! Source: the closed loop of \[zhang2025\], whose velocity extremes and single or multiple overspeed regions are found here. The ceiling is constant in each
//! of its cells and the jerk in each phase, so crossings, extremes and integrals are exact, not samples.

use super::ceiling::Ceiling;
use super::scurve::{Profile, advance};
use serde::{Deserialize, Serialize};

/// A maximum of speed over ceiling counts above this.
const RATIO: f64 = 1.0 + 1e-6;
/// What rounding may add to a speed at the ceiling.
pub(super) const ROUNDING: f64 = 1.0 + 1e-9;
/// Regions nearer to each other than this are one, m.
const MERGE: f64 = 0.1;

/// A stretch of the path on which a profile is faster than the ceiling.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Region {
    /// Where it begins, m.
    pub from: f64,
    /// Where it ends, m.
    pub to: f64,
    /// Where the speed is largest as a multiple of the ceiling, m.
    pub worst: f64,
    /// The multiple there, above 1.
    pub ratio: f64,
    /// Integral of (speed / ceiling - 1) over the arc length, m.
    pub excess: f64,
}

impl Region {
    fn take(&mut self, next: &Self) {
        self.to = next.to;
        self.excess += next.excess;
        if next.ratio > self.ratio {
            (self.worst, self.ratio) = (next.worst, next.ratio);
        }
    }
}

/// The overspeed regions of a chain of profiles, each with its start (m), in order; those nearer than 0.1 m to each other are one.
pub fn regions(chain: &[(f64, Profile)], ceiling: &Ceiling) -> Vec<Region> {
    merged(&parts(chain, ceiling), ceiling, RATIO)
}

/// Regions from what lies above the ceiling; those whose largest ratio is at most `ratio` do not count.
pub(super) fn merged(parts: &[Region], ceiling: &Ceiling, ratio: f64) -> Vec<Region> {
    let stretches = joined(parts, 1e-9 * ceiling.length().max(1e-3));
    joined(&stretches.into_iter().filter(|r| r.ratio > ratio).collect::<Vec<_>>(), MERGE)
}

/// Velocity extremes above the ceiling: places (m) where speed over ceiling has a local maximum above 1, and that maximum.
pub fn extremes(chain: &[(f64, Profile)], ceiling: &Ceiling) -> Vec<(f64, f64)> {
    let parts = parts(chain, ceiling);
    let ratio = |i: Option<usize>, beside: f64| {
        i.and_then(|i| parts.get(i)).filter(|p| (p.worst - beside).abs() <= 2.0 * ceiling.step()).map_or(0.0, |p| p.ratio)
    };
    let top = |i: &usize| {
        let part = &parts[*i];
        part.ratio > RATIO && part.ratio > ratio(i.checked_sub(1), part.worst) && part.ratio >= ratio(Some(i + 1), part.worst)
    };
    (0..parts.len()).filter(top).map(|i| (parts[i].worst, parts[i].ratio)).collect()
}

/// Share of the length that is driven too fast: the integral of all regions over the length.
pub fn overspeed(regions: &[Region], length: f64) -> f64 {
    if length > 0.0 { regions.iter().map(|r| r.excess).sum::<f64>() / length } else { 0.0 }
}

/// Neighbours with a gap below `gap` (m) become one.
fn joined(parts: &[Region], gap: f64) -> Vec<Region> {
    let mut out: Vec<Region> = Vec::new();
    for part in parts {
        match out.last_mut() {
            Some(last) if part.from - last.to <= gap => last.take(part),
            _ => out.push(*part),
        }
    }
    out
}

/// What lies above the ceiling, at most two parts a cell and phase, in order.
pub(super) fn parts(chain: &[(f64, Profile)], ceiling: &Ceiling) -> Vec<Region> {
    let mut scan = Scan { ceiling, step: ceiling.step(), last: ceiling.cells().len() - 1, found: Vec::new() };
    for (from, profile) in chain {
        let (v, a) = profile.start();
        let mut state = (*from, v, a);
        for phase in profile.phases().iter().filter(|p| p.duration > 0.0) {
            // On either side of a zero of the acceleration the speed is monotone.
            let zero = -state.2 / phase.jerk;
            let cut = if zero > 0.0 && zero < phase.duration { zero } else { phase.duration };
            scan.phase(state, phase.jerk, cut);
            if cut < phase.duration {
                scan.phase(advance(state, phase.jerk, cut), phase.jerk, phase.duration - cut);
            }
            state = advance(state, phase.jerk, phase.duration);
        }
    }
    scan.found
}

type Motion = (f64, f64, f64);

struct Scan<'a> {
    ceiling: &'a Ceiling,
    step: f64,
    last: usize,
    found: Vec<Region>,
}

impl Scan<'_> {
    /// A stretch of constant jerk and monotone speed.
    fn phase(&mut self, state: Motion, jerk: f64, duration: f64) {
        let end = advance(state, jerk, duration).0;
        let first = ((state.0 / self.step) as usize).min(self.last);
        let last = ((end / self.step).ceil() as usize).saturating_sub(1).clamp(first, self.last);
        self.descend(state, (jerk, duration), (first, last));
    }

    /// The same inside cells `first..=last`.
    fn descend(&mut self, state: Motion, (jerk, duration): (f64, f64), (first, last): (usize, usize)) {
        let end = advance(state, jerk, duration);
        let middle = |k: usize| self.step * (k as f64 + 0.5);
        if state.1.max(end.1) <= ROUNDING * self.ceiling.lowest(middle(first), middle(last)) {
            return;
        }
        if first == last {
            self.cell(state, (jerk, duration), self.ceiling.cells()[first]);
            return;
        }
        let half = usize::midpoint(first, last);
        let t = reach(state, jerk, duration, self.step * (half + 1) as f64);
        self.descend(state, (jerk, t), (first, half));
        self.descend(advance(state, jerk, t), (jerk, duration - t), (half + 1, last));
    }

    /// Inside one cell with ceiling `c`.
    fn cell(&mut self, state: Motion, (jerk, duration): (f64, f64), c: f64) {
        let speed = |t: f64| advance(state, jerk, t).1;
        let (v0, v1) = (state.1, speed(duration));
        let (mut from, mut to) = (0.0, duration);
        if v0 <= c || v1 <= c {
            let (mut low, mut high) = (0.0, duration);
            for _ in 0..60 {
                let t = f64::midpoint(low, high);
                if (speed(t) > c) == (v1 > c) { high = t } else { low = t }
            }
            if v0 <= c { from = high } else { to = low }
        }
        let (start, end) = (advance(state, jerk, from), advance(state, jerk, to));
        if end.0 <= start.0 {
            return;
        }
        let (worst, top) = if start.1 >= end.1 { (start.0, start.1) } else { (end.0, end.1) };
        // The square of the speed is a polynomial of degree four: three points of Gauss are exact.
        let (mid, half) = (f64::midpoint(from, to), 0.5 * (to - from));
        let square = |x: f64| speed(mid + half * x).powi(2);
        let energy = half * (5.0 * (square(-0.6f64.sqrt()) + square(0.6f64.sqrt())) + 8.0 * square(0.0)) / 9.0;
        self.found.push(Region { from: start.0, to: end.0, worst, ratio: top / c, excess: (energy / c - (end.0 - start.0)).max(0.0) });
    }
}

/// Time at which a motion that does not reverse has come to `s`: Newton's rule inside a bracket.
fn reach(state: Motion, jerk: f64, duration: f64, s: f64) -> f64 {
    let (mut low, mut high) = (0.0, duration);
    let mut t = 0.5 * duration;
    for _ in 0..80 {
        let (x, v, _) = advance(state, jerk, t);
        if x > s {
            high = t;
        } else {
            low = t;
        }
        let next = t - (x - s) / v;
        let next = if next > low && next < high { next } else { f64::midpoint(low, high) };
        if (next - t).abs() <= 1e-15 * duration {
            return next;
        }
        t = next;
    }
    t
}
