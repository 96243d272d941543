//! The speed ceiling along a path: `v_c(s) = min(v_m, sqrt(a_lat / |k|), w_max / |k|, clearance-based)`.
//!
//! Source: kinematics of a planar curve (`v^2 |k|` sideways, `v |k|` of turn rate); the clearance-based part is whatever the caller gives.
//! Kept as the lowest value in each of many short cells, so that whatever stays below it in a cell stays below the ceiling everywhere in it.

use super::scurve::{Profile, advance};
use crate::path::Path;
use crate::query::Limits;

/// Wanted length of a cell, m.
const CELL: f64 = 0.01;
/// Most cells on a path, and fewest.
const CELLS: (f64, f64) = (64.0, 40_000.0);
/// Samples of the curvature in a cell.
const SAMPLES: usize = 4;
/// Share by which the ceiling is lowered for rounding.
const MARGIN: f64 = 1e-7;
/// Share that rounding may add to a speed at the ceiling; far below the margin.
const ROUNDING: f64 = 1.0 + 1e-11;

/// A speed ceiling over `[0, length]`, constant in each cell.
#[derive(Debug, Clone)]
pub struct Ceiling {
    length: f64,
    step: f64,
    /// 1 / step.
    per_metre: f64,
    /// `table[k][i]` is the lowest value in cells `i .. i + 2^k`.
    table: Vec<Vec<f64>>,
}

impl Ceiling {
    /// From the lowest value (m/s, positive) in each of the equal cells that make up `length` (m).
    pub fn from_cells(length: f64, cells: Vec<f64>) -> Self {
        let step = length / cells.len().max(1) as f64;
        let mut table = vec![cells];
        let mut width = 1;
        while 2 * width <= table[0].len() {
            let last = &table[table.len() - 1];
            let next = (0..=table[0].len() - 2 * width).map(|i| last[i].min(last[i + width])).collect();
            table.push(next);
            width *= 2;
        }
        Self { length, step, per_metre: 1.0 / step, table }
    }

    /// The ceiling on a stretch of a planar path from `from` to `to` (m). `extra` adds a ceiling (m/s) of the arc length, sampled.
    pub fn of_path(path: &Path, (from, to): (f64, f64), limits: &Limits, extra: Option<&dyn Fn(f64) -> f64>) -> Self {
        let length = to - from;
        let count = (length / CELL).ceil().clamp(CELLS.0, CELLS.1) as usize;
        let unlimited = limits.turn_rate.is_none() && limits.lateral_acceleration.is_none();
        if unlimited && extra.is_none() || path.degree() == 1 && extra.is_none() {
            return Self::from_cells(length, vec![limits.speed]);
        }
        let fine = length / (count * SAMPLES) as f64;
        // One sample beyond either end, held inside the stretch: beyond a corner another curve begins.
        let inside = |i: usize| from + (fine * i as f64).clamp(1e-9 * length, length * (1.0 - 1e-9));
        let curvature: Vec<f64> = (0..=count * SAMPLES).map(|i| path.planar(inside(i)).curvature.abs()).collect();
        let bend = |i: usize| {
            let at = |k: usize| curvature[k.min(curvature.len() - 1)];
            (at(i + 1) - 2.0 * at(i) + at(i.saturating_sub(1))).abs()
        };
        // Where polynomial pieces meet the curvature has a kink, and often a peak: it is looked up there, on both sides.
        let mut kinks = vec![0.0f64; count];
        for joint in path.joints().into_iter().map(|s| s - from).filter(|s| *s > 0.0 && *s < length) {
            for s in [joint - 1e-9 * length, joint + 1e-9 * length] {
                let cell = ((s / length * count as f64) as usize).min(count - 1);
                kinks[cell] = kinks[cell].max(path.planar(from + s).curvature.abs());
            }
        }
        let cells = (0..count).map(|cell| {
            let range = cell * SAMPLES..=(cell + 1) * SAMPLES;
            // Between samples a smooth curve rises above both by at most an eighth of its second difference.
            let highest = range.clone().map(|i| curvature[i]).fold(kinks[cell], f64::max) + 0.25 * range.clone().map(bend).fold(0.0, f64::max);
            let by_clearance = extra.map_or(f64::INFINITY, |f| range.map(|i| f(inside(i))).fold(f64::INFINITY, f64::min));
            limit(highest, limits).min(by_clearance) * (1.0 - MARGIN)
        });
        Self::from_cells(length, cells.map(|c| c.min(limits.speed)).collect())
    }

    /// m.
    pub fn length(&self) -> f64 {
        self.length
    }
    /// Length of a cell, m.
    pub fn step(&self) -> f64 {
        self.step
    }
    /// Lowest speed in each cell, m/s.
    pub fn cells(&self) -> &[f64] {
        &self.table[0]
    }

    fn cell(&self, s: f64) -> usize {
        ((s * self.per_metre) as usize).min(self.table[0].len() - 1)
    }

    /// Ceiling at `s`, m/s.
    pub fn at(&self, s: f64) -> f64 {
        self.table[0][self.cell(s)]
    }

    /// Lowest ceiling between two arc lengths, m/s.
    pub fn lowest(&self, from: f64, to: f64) -> f64 {
        let (i, j) = (self.cell(from), self.cell(to) + 1);
        let level = (j - i).ilog2() as usize;
        let row = &self.table[level];
        row[i].min(row[j - (1 << level)])
    }

    /// Highest ceiling between two arc lengths, m/s.
    pub fn highest(&self, from: f64, to: f64) -> f64 {
        self.table[0][self.cell(from)..=self.cell(to)].iter().copied().fold(0.0, f64::max)
    }

    /// Whether a profile that starts at `from` stays below the ceiling everywhere.
    pub fn allows(&self, from: f64, profile: &Profile) -> bool {
        // Most profiles that do not are too fast where a phase ends.
        let (v, a) = profile.start();
        let mut state = (from, v, a);
        for phase in profile.phases() {
            state = advance(state, phase.jerk, phase.duration);
            if state.1 > self.at(state.0) * ROUNDING {
                return false;
            }
        }
        self.first_excess(from, profile).is_none()
    }

    /// Where a profile that starts at `from` first rises above the ceiling, m (`None`: nowhere). Exact up to the length of a cell.
    pub fn first_excess(&self, from: f64, profile: &Profile) -> Option<f64> {
        let (v, a) = profile.start();
        let mut state = (from, v, a);
        for phase in profile.phases() {
            if phase.duration > 0.0 {
                if let Some(s) = self.phase_excess(state, phase.jerk, phase.duration, 0) {
                    return Some(s);
                }
                state = advance(state, phase.jerk, phase.duration);
            }
        }
        None
    }

    fn phase_excess(&self, state: (f64, f64, f64), jerk: f64, duration: f64, depth: u32) -> Option<f64> {
        let end = advance(state, jerk, duration);
        let mut top = state.1.max(end.1);
        if state.2 > 0.0 && end.2 < 0.0 {
            top = top.max(state.1 - 0.5 * state.2 * state.2 / jerk);
        }
        if top <= self.lowest(state.0, end.0) * ROUNDING {
            return None;
        }
        if state.1 > self.at(state.0) * ROUNDING || depth >= 24 || self.cell(state.0) == self.cell(end.0) {
            return Some(state.0);
        }
        let half = 0.5 * duration;
        self.phase_excess(state, jerk, half, depth + 1).or_else(|| self.phase_excess(advance(state, jerk, half), jerk, duration - half, depth + 1))
    }
}

/// Highest speed that curvature `k` (1/m) allows, m/s.
fn limit(k: f64, limits: &Limits) -> f64 {
    let turn = limits.turn_rate.map_or(f64::INFINITY, |w| w / k);
    let lateral = limits.lateral_acceleration.map_or(f64::INFINITY, |a| (a / k).sqrt());
    if k > 0.0 { turn.min(lateral) } else { f64::INFINITY }
}

/// The ceiling along a whole path for reports: (arc length in m, speed in m/s) at the middle of each cell.
pub fn ceiling(path: &Path, limits: &Limits) -> Vec<(f64, f64)> {
    let ceiling = Ceiling::of_path(path, (0.0, path.length()), limits, None);
    let step = ceiling.step();
    ceiling.cells().iter().enumerate().map(|(i, v)| (step * (i as f64 + 0.5), *v)).collect()
}
