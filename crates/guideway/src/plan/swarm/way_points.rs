//! Way points: the other encoding, for comparison. Points joined by straight lines, drawn on the lattice; steps that are not allowed are counted.

use super::guided_walk::{Ground, Scratch};
use crate::world::Cell;

/// Draws the line through the points (pairs of keys, -1 to 1 across the lattice) into the scratch; gives back how many of its steps are not allowed.
pub(super) fn draw(ground: &Ground, [from, to]: [Cell; 2], keys: &[f64], scratch: &mut Scratch) -> u64 {
    let side = [ground.lattice.width(), ground.lattice.height()];
    let place = |pair: &[f64]| [0, 1].map(|i| ((0.5 + 0.5 * pair[i]) * f64::from(side[i])).clamp(0.0, f64::from(side[i] - 1)) as u32);
    scratch.cells.clear();
    scratch.cells.push(from);
    let mut last = from;
    for next in keys.chunks_exact(2).map(place).chain([to]) {
        line(last, next, &mut scratch.cells);
        last = next;
    }
    scratch.cells.windows(2).filter(|step| !ground.allows(step[0], step[1])).count() as u64
}

/// Cells from `a` (left out) to `b` along the straight line.
fn line(a: Cell, b: Cell, out: &mut Vec<Cell>) {
    let steps = a[0].abs_diff(b[0]).max(a[1].abs_diff(b[1]));
    let at = |i: usize, k: u32| {
        let (from, way) = (i64::from(a[i]), i64::from(b[i]) - i64::from(a[i]));
        (from + (2 * way * i64::from(k) + i64::from(steps)).div_euclid(2 * i64::from(steps))) as u32
    };
    out.extend((1..=steps).map(|k| [at(0, k), at(1, k)]));
}
