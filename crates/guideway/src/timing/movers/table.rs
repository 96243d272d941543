//! Which parts of a path are taken when: for each of many short cells of arc length, the times at which a mover may be too near to some place of it.

use super::course::Course;
use crate::path::Path;

/// Wanted length of a cell, m, and most cells of a path.
const CELL: (f64, f64) = (0.02, 4000.0);
/// Moments closer than that are not told apart, s.
const MOMENT: f64 = 0.004;
/// Added to the radius for rounding, m.
const ROUNDING: f64 = 1e-6;

/// Taken times by cell. What it calls free is free; it may call taken what is free by less than half a cell or a moment.
pub(super) struct Table {
    step: f64,
    /// Sorted times that do not overlap, s.
    taken: Vec<Vec<[f64; 2]>>,
    pub horizon: f64,
}

/// The cells that a motion passes: cell, and from when to when (s after its start) it may be there.
pub(super) type Passage = Vec<(u32, f64, f64)>;

impl Table {
    /// For a robot that keeps `radius` (m) to the movers. Times end at `horizon` (s); cells are `finer` times as short as usual.
    pub fn new(path: &Path, courses: &[Course], radius: f64, horizon: f64, finer: f64) -> Self {
        let length = path.length();
        let n = (length * finer / CELL.0).ceil().clamp(1.0, CELL.1 * finer);
        let step = length / n;
        let cell = |k: usize| {
            let p = path.planar(step * (k as f64 + 0.5)).point;
            let kept = radius + 0.5 * step + ROUNDING;
            merged(courses.iter().flat_map(|c| c.times(p, kept, horizon, MOMENT / finer)).collect())
        };
        Self { step, taken: (0..n as usize).map(cell).collect(), horizon }
    }

    /// The cell of an arc length (m).
    pub fn cell(&self, s: f64) -> usize {
        if self.step > 0.0 { ((s / self.step).max(0.0) as usize).min(self.taken.len() - 1) } else { 0 }
    }

    /// Arc length where a cell ends, m.
    pub fn end(&self, cell: usize) -> f64 {
        self.step * (cell + 1) as f64
    }

    /// Length of a cell, m.
    pub fn step(&self) -> f64 {
        self.step
    }

    /// Whether a cell is free from `t0` to `t1` (s).
    pub fn free(&self, cell: usize, t0: f64, t1: f64) -> bool {
        let times = &self.taken[cell];
        t1 <= self.horizon && times.get(times.partition_point(|span| span[1] < t0)).is_none_or(|span| span[0] > t1)
    }

    /// The first time (s) from `t` on at which a cell is free; infinite if there is none before the horizon.
    pub fn next_free(&self, cell: usize, t: f64) -> f64 {
        let times = &self.taken[cell];
        let next = match times.get(times.partition_point(|span| span[1] < t)) {
            Some(span) if span[0] <= t => span[1],
            _ => t,
        };
        if next < self.horizon { next } else { f64::INFINITY }
    }

    /// Whether a motion that begins at time `t` (s) is free everywhere.
    pub fn lets(&self, passage: &Passage, t: f64) -> bool {
        passage.iter().all(|&(cell, from, to)| self.free(cell as usize, t + from, t + to))
    }
}

fn merged(mut times: Vec<[f64; 2]>) -> Vec<[f64; 2]> {
    times.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let mut out: Vec<[f64; 2]> = Vec::new();
    for span in times {
        match out.last_mut() {
            Some(last) if last[1] >= span[0] => last[1] = last[1].max(span[1]),
            _ => out.push(span),
        }
    }
    out
}
