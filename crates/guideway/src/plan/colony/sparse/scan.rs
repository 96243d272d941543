//! What a point sees: lattice points on the rows of a bit map, found by following beams of light from row to row.
//!
//! Coordinates are in cells. Beams are bounded by rays through lattice points; for a root that is a lattice point a ray lands on a lattice point exactly
//! when it does so in truth (quotients of small integers, see [`SNAP`]).

use crate::Point;
use crate::plan::search::runs::{Run, is_free, run_at, runs_over};
use crate::world::Bits;

/// Rays that pass a lattice point within this distance pass through it, cells.
const SNAP: f64 = 1e-10;

/// Free cells and the lattice points that are looked for.
#[derive(Clone, Copy)]
pub(super) struct Scene<'a> {
    pub free: &'a Bits,
    /// Bit `(x, y)` is the lower-left corner of cell `(x, y)`; one more column and row than cells.
    pub points: &'a Bits,
    /// May a point pass between two diagonal blocked cells?
    pub squeeze: bool,
}

/// Light on a row line.
#[derive(Clone, Copy)]
struct Beam {
    line: i32,
    up: bool,
    span: [f64; 2],
    /// Directions from the root that bound it.
    rays: [Point; 2],
}

/// Where the ray from `root` along `d` meets line `y`.
fn meet(root: Point, d: Point, y: f64) -> f64 {
    let x = root[0] + d[0] * (y - root[1]) / d[1];
    let near = x.round();
    if (x - near).abs() < SNAP { near } else { x }
}

impl Scene<'_> {
    /// Shows every wanted point that `root` sees in the half-planes that `sides` leaves open: above and below, each the columns to the left and to the
    /// right of the root. Of points on the root's own row and column line only the next ones. Some may be shown twice.
    pub fn look(&self, root: Point, sides: [[bool; 2]; 2], mut see: impl FnMut([u32; 2])) {
        let on_line = root[1].fract() == 0.0;
        let row = root[1].floor() as i32;
        let mut beams = Vec::new();
        for (up, [left, right]) in [(true, sides[0]), (false, sides[1])] {
            let cell = if on_line && !up { row - 1 } else { row };
            let Some(run) = self.holding(root[0], cell) else { continue };
            let line = if up { cell + 1 } else { cell };
            let span = [if left { f64::from(run.a) } else { root[0] }, if right { f64::from(run.b) } else { root[0] }];
            let rise = f64::from(line) - root[1];
            beams.push(Beam { line, up, span, rays: span.map(|x| [x - root[0], rise]) });
        }
        while let Some(beam) = beams.pop() {
            self.show(root, beam, &mut see);
            self.pass(root, beam, &mut beams);
        }
        for along in [0, 1].into_iter().filter(|&k| root[1 - k].fract() == 0.0) {
            for ahead in [1, -1] {
                self.slide(root, along, ahead, &mut see);
            }
        }
    }

    /// The run of a row that holds `x`, ends included.
    fn holding(&self, x: f64, row: i32) -> Option<Run> {
        let cell = x.floor() as i32;
        let before = if x.fract() == 0.0 { cell - 1 } else { cell };
        [cell, before].into_iter().find(|c| is_free(self.free, *c, row)).map(|c| run_at(self.free, c, row))
    }

    /// Points in the light, but for those straight above and below.
    fn show(&self, root: Point, beam: Beam, see: &mut impl FnMut([u32; 2])) {
        let (mut x, last) = (beam.span[0].ceil() as u32, beam.span[1].floor());
        while f64::from(x) <= last
            && let Some(found) = self.points.first(beam.line as u32, x, last as u32, true)
        {
            if f64::from(found) != root[0] {
                see([found, beam.line as u32]);
            }
            x = found + 1;
        }
    }

    /// The light that enters the next row, on its far line.
    fn pass(&self, root: Point, beam: Beam, beams: &mut Vec<Beam>) {
        let (cell, far) = if beam.up { (beam.line, beam.line + 1) } else { (beam.line - 1, beam.line - 1) };
        let [lo, hi] = beam.span;
        let (near, rise) = (f64::from(beam.line) - root[1], f64::from(far) - root[1]);
        for run in runs_over(self.free, cell, lo, hi) {
            let (a, b) = (f64::from(run.a), f64::from(run.b));
            let left = if a > lo { [a - root[0], near] } else { beam.rays[0] };
            let right = if b < hi { [b - root[0], near] } else { beam.rays[1] };
            let (l, r) = (meet(root, left, f64::from(far)), meet(root, right, f64::from(far)));
            if l > b || r < a {
                continue;
            }
            let (l, left) = if l < a { (a, [a - root[0], rise]) } else { (l, left) };
            let (r, right) = if r > b { (b, [b - root[0], rise]) } else { (r, right) };
            beams.push(Beam { line: far, up: beam.up, span: [l, r], rays: [left, right] });
        }
    }

    /// The next wanted point along a row line (or column line), if the way there is free: between free cells on one side at least, which only changes
    /// where it may squeeze.
    fn slide(&self, root: Point, along: usize, ahead: i32, see: &mut impl FnMut([u32; 2])) {
        let at = |p: i32, q: i32| if along == 0 { (p, q) } else { (q, p) };
        let line = root[1 - along] as i32;
        let mut p = if ahead > 0 { root[along].floor() as i32 } else { root[along].ceil() as i32 };
        let mut before = [true; 2];
        loop {
            let cell = if ahead > 0 { p } else { p - 1 };
            let now = [line, line - 1].map(|side| {
                let (x, y) = at(cell, side);
                is_free(self.free, x, y)
            });
            if !(before[0] && now[0] || before[1] && now[1] || self.squeeze && (now[0] || now[1])) {
                return;
            }
            before = now;
            p += ahead;
            let (x, y) = at(p, line);
            if self.points.at(x as u32, y as u32) {
                return see([x as u32, y as u32]);
            }
        }
    }
}
