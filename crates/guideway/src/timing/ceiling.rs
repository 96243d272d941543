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
/// Polynomial pieces up to this length, cells, are sampled by themselves: a tight bend is made of them.
const SHORT: f64 = 4.0;
/// Spans of such a piece.
const INNER: usize = 16;
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
        let sharpest = sharpest(path, (from, to), count);
        let cells = (0..count).map(|cell| {
            let range = cell * SAMPLES..=(cell + 1) * SAMPLES;
            // Between samples a smooth curve rises above both by at most an eighth of its second difference.
            let highest = range.clone().map(|i| curvature[i]).fold(sharpest[cell], f64::max) + 0.25 * range.clone().map(bend).fold(0.0, f64::max);
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

/// Largest curvature, 1/m, in each of `count` cells of a stretch, as far as the places where polynomial pieces meet and short pieces tell: there the curvature
/// has kinks, and peaks that even samples miss.
fn sharpest(path: &Path, (from, to): (f64, f64), count: usize) -> Vec<f64> {
    let (length, mut cells) = (to - from, vec![0.0f64; count]);
    let (step, tiny) = (length / count as f64, 1e-9 * length);
    let cell = |s: f64| (((s - from) / step).max(0.0) as usize).min(count - 1);
    let curvature = |s: f64| path.planar(s.clamp(from + tiny, to - tiny)).curvature.abs();
    let mut raise = |from: f64, to: f64, k: f64| cells[cell(from)..=cell(to)].iter_mut().for_each(|c| *c = c.max(k));
    for w in path.joints().windows(2).filter(|w| w[1] > from && w[0] < to) {
        for s in w {
            raise(s - tiny, s + tiny, curvature(*s));
        }
        if w[1] - w[0] > SHORT * step {
            continue;
        }
        let place = |k: usize| w[0] + (w[1] - w[0]) * k as f64 / INNER as f64;
        let values: Vec<f64> = (0..=INNER).map(|k| curvature(place(k))).collect();
        let bend = |k: usize| (values[k - 1] - 2.0 * values[k] + values[k + 1]).abs();
        for k in 0..INNER {
            let bend = bend(k.max(1)).max(bend((k + 1).min(INNER - 1)));
            raise(place(k), place(k + 1), values[k].max(values[k + 1]) + 0.25 * bend);
        }
    }
    cells
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

#[cfg(test)]
mod tests {
    use super::*;

    /// Bends far tighter than a cell: the curvature between the even samples counts too.
    #[test]
    fn the_ceiling_holds_at_every_place_of_tight_bends() {
        for (k, size) in [0.003, 0.01, 0.03, 0.1].into_iter().enumerate() {
            let corner = 5.0 + 0.0037 * k as f64;
            // Two legs, and knots `size` apart around the corner between them.
            let inner = (-3..=3).map(|k| corner + size * f64::from(k));
            let knots: Vec<f64> = [0.0; 4].into_iter().chain(inner).chain([10.0; 4]).collect();
            let control = knots.windows(3).skip(1).take(knots.len() - 4).map(|w| w.iter().sum::<f64>() / 3.0);
            let control: Vec<f64> = control.flat_map(|s| if s < corner { [s, 0.0] } else { [corner, s - corner] }).collect();
            let path = Path::new(3, 2, knots, control).unwrap();
            let limits = Limits { lateral_acceleration: Some(0.3), ..Limits::default() };
            let ceiling = Ceiling::of_path(&path, (0.0, path.length()), &limits, None);
            for i in 0..=200_000 {
                let s = path.length() * f64::from(i) / 200_000.0;
                let (v, bend) = (ceiling.at(s), path.planar(s).curvature.abs());
                assert!(v * v * bend <= 0.3, "{} m/s2 at {s} m of {}, size {size}", v * v * bend, path.length());
            }
        }
    }
}
