//! How late a motion among movers arrives at least: as if it could change its speed at once.

use super::motions::Motions;
use super::table::Table;

/// Step of time, s.
pub(super) const STEP: f64 = 0.1;

/// The step of time in which `t` (s) lies.
pub(super) fn bin(t: f64) -> usize {
    (t / STEP) as usize
}

/// Earliest arrival at the goal by station and step of time.
pub(super) struct Bound {
    /// By station: the earliest arrival (s) of whoever is there at the start of a step of time; infinite if there is none.
    arrival: Vec<Vec<f64>>,
}

impl Bound {
    pub fn new(motions: &Motions, table: &Table) -> Self {
        let stations = motions.stations();
        let bins = bin(table.horizon) + 1;
        let mut arrival = vec![Vec::new(); stations.len()];
        for k in (0..stations.len()).rev() {
            let row = (0..bins).map(|b| {
                let t = b as f64 * STEP;
                let Some(next) = arrival.get(k + 1) else { return t };
                let there = reach(table, (stations[k], stations[k + 1]), t, motions.plain.limits.speed);
                if there < table.horizon { later(next, there) } else { f64::INFINITY }
            });
            arrival[k] = row.collect();
        }
        Self { arrival }
    }

    /// The earliest arrival (s) of whoever is at a station at time `t` (s).
    pub fn arrival(&self, station: usize, t: f64) -> f64 {
        later(&self.arrival[station], t)
    }
}

/// Arrivals grow with time: that of the start of the step is a bound for all of it.
fn later(row: &[f64], t: f64) -> f64 {
    row.get(bin(t)).copied().unwrap_or(f64::INFINITY)
}

/// When the cell of the second arc length (m) can be entered by whoever is at the first one at time `t` (s): through free cells, each as fast as may be. Overtaken
/// by nobody: who enters a cell later leaves it no earlier.
fn reach(table: &Table, (from, to): (f64, f64), t: f64, speed: f64) -> f64 {
    let (first, last) = (table.cell(from), table.cell(to));
    let mut t = t;
    for cell in first + 1..=last {
        // The first cell may be nearly behind.
        t += if cell == first + 1 { 0.0 } else { table.step() / speed };
        t = table.next_free(cell, t);
    }
    t
}
