//! Lines of sight between cell centres, and the parts that both Theta* planners share.

use super::leg::{anchor, no_lattice_path, no_path};
use crate::Point;
use crate::context::{Context, Stop};
use crate::error::PlanError;
use crate::path::Path;
use crate::plan::Solution;
use crate::query::Query;
use crate::world::{Bits, Cell, ClearanceField, Corners, Lattice, shape};
use std::cell::RefCell;
use std::sync::Arc;

/// Does a point see from one cell centre to another? Exact, in integers: closed blocked squares may be touched, the gap between two blocked cells that
/// meet at a corner is passed only with `squeeze`. Only the part of the way within `rows` is looked at.
pub(super) fn cells_see(free: &Bits, [a, b]: [Cell; 2], squeeze: bool, rows: [u32; 2]) -> bool {
    let (a, b) = if a[1] <= b[1] { (a, b) } else { (b, a) };
    let [ax, ay, bx, by] = [a[0], a[1], b[0], b[1]].map(i64::from);
    let all = |y: i64, x0: i64, x1: i64| run_free(free, y as u32, x0, x1);
    if ay == by {
        return all(ay, ax.min(bx), ax.max(bx));
    }
    let (dx, height) = (bx - ax, by - ay);
    // The line meets the upper border of row `ay + k` at x = (2 ax + 1) / 2 + dx (2 k + 1) / (2 height): `num / den` in cells.
    let den = 2 * height;
    let border = |k: i64| (2 * ax + 1) * height + dx * (2 * k + 1);
    let (first, last) = ((i64::from(rows[0]) - ay).max(0), (i64::from(rows[1]) - ay).min(height));
    let mut from = if first == 0 { (2 * ax + 1) * height } else { border(first - 1) };
    for k in first..=last {
        let y = ay + k;
        let to = if k == height { (2 * bx + 1) * height } else { border(k) };
        let (lo, hi) = (from.min(to), from.max(to));
        let (x0, x1) = (lo.div_euclid(den), (hi + den - 1).div_euclid(den) - 1);
        if !all(y, x0, x1) {
            return false;
        }
        // Through a lattice point, diagonally.
        if k < height && dx != 0 && !squeeze && to % den == 0 {
            let x = to / den;
            let (left, right) = if dx > 0 { ([x - 1, y + 1], [x, y]) } else { ([x - 1, y], [x, y + 1]) };
            if !free.at(left[0] as u32, left[1] as u32) && !free.at(right[0] as u32, right[1] as u32) {
                return false;
            }
        }
        from = to;
    }
    true
}

/// Are all cells `x0..=x1` of a row free?
fn run_free(free: &Bits, y: u32, x0: i64, x1: i64) -> bool {
    if x0 > x1 {
        return true;
    }
    let row = free.row(y);
    let (w0, w1) = ((x0 >> 6) as usize, (x1 >> 6) as usize);
    let (first, last) = (!0u64 << (x0 & 63), !0u64 >> (63 - (x1 & 63)));
    if w0 == w1 {
        return !row[w0] & first & last == 0;
    }
    !row[w0] & first == 0 && !row[w1] & last == 0 && row[w0 + 1..w1].iter().all(|&w| w == !0)
}

/// Lines of sight on a lattice, for the robot of the query.
pub(super) struct Sight<'a> {
    query: &'a Query,
    pub lattice: &'a Lattice,
    /// A point robot among cells.
    point: bool,
    field: Arc<ClearanceField>,
    /// How far the disc may go from anywhere in a cell: [`UNKNOWN`], [`SHUT`], [`NEAR`], or that plus whole cells.
    room: RefCell<Vec<u8>>,
}

/// Nobody has looked yet.
const UNKNOWN: u8 = 0;
/// The disc fits nowhere in the cell.
const SHUT: u8 = 1;
/// The disc fits in parts of the cell, or reaches less than a cell beyond.
const NEAR: u8 = 2;
/// Steps along a stretch that is near obstacles, cells.
const STRIDE: f64 = 1.0;

impl<'a> Sight<'a> {
    pub fn new(query: &'a Query, lattice: &'a Lattice) -> Self {
        let point = lattice.radius() == 0.0 && query.world.shapes().is_empty();
        let cells = lattice.width() as usize * lattice.height() as usize;
        Self { query, lattice, point, field: query.world.clearance_field(), room: RefCell::new(vec![UNKNOWN; cells]) }
    }

    /// Is the straight way between two free centres free? Goes along it in steps as long as the room around the cell at hand allows; the stretches
    /// where it allows none are tested exactly.
    pub fn see(&self, a: Cell, b: Cell) -> bool {
        let mut room = self.room.borrow_mut();
        let length = span(a, b);
        let from = a.map(|v| f64::from(v) + 0.5);
        let ahead = [0, 1].map(|k| (f64::from(b[k]) - f64::from(a[k])) / length.max(1.0));
        let (mut t, mut near) = (0.0, None);
        while t < length {
            let cell = [0, 1].map(|k| (from[k] + t * ahead[k]) as u32);
            let known = &mut room[cell[1] as usize * self.lattice.width() as usize + cell[0] as usize];
            if *known == UNKNOWN {
                *known = self.look(cell);
            }
            match *known {
                SHUT => return false,
                NEAR => {
                    near = near.or(Some(t));
                    t += STRIDE;
                }
                steps => {
                    if near.take().is_some_and(|since| !self.stretch([a, b], length, [since, t])) {
                        return false;
                    }
                    t += f64::from(steps - NEAR);
                }
            }
        }
        near.is_none_or(|since| self.stretch([a, b], length, [since, length]))
    }

    /// Room around a cell: what the centre's clearance exceeds the need anywhere in the cell by.
    fn look(&self, cell: Cell) -> u8 {
        let half = std::f64::consts::FRAC_1_SQRT_2 + 1e-6;
        let spare = (self.field.at(cell) - self.lattice.radius()) / self.lattice.resolution();
        if spare < -half { SHUT } else { (spare - half).clamp(0.0, 250.0) as u8 + NEAR }
    }

    /// Is that part of the way from centre to centre free? Lengths in cells.
    fn stretch(&self, [a, b]: [Cell; 2], length: f64, [since, until]: [f64; 2]) -> bool {
        let along = |p: f64, q: f64, t: f64| p + t / length * (q - p);
        if self.point {
            let row = |t: f64| (along(f64::from(a[1]), f64::from(b[1]), t) + 0.5) as u32;
            let rows = [row(since).min(row(until)).saturating_sub(1), row(since).max(row(until)) + 1];
            return cells_see(self.lattice.free(), [a, b], self.query.corners == Corners::Squeeze, rows);
        }
        let (from, to) = (self.lattice.center(a), self.lattice.center(b));
        let at = |t: f64| [0, 1].map(|k| along(from[k], to[k], t));
        self.query.world.segment_free(
            if since == 0.0 { from } else { at(since) },
            if until == length { to } else { at(until) },
            self.lattice.radius(),
        )
    }

    /// Free neighbours of a cell.
    pub fn neighbours(&self, cell: Cell) -> impl Iterator<Item = Cell> + '_ {
        const STEPS: [(i64, i64); 8] = [(1, 0), (0, 1), (-1, 0), (0, -1), (1, 1), (-1, 1), (-1, -1), (1, -1)];
        let open = STEPS.into_iter().filter(move |&(dx, dy)| self.lattice.step_free(cell, dx, dy, self.query.corners));
        open.map(move |(dx, dy)| [(i64::from(cell[0]) + dx) as u32, (i64::from(cell[1]) + dy) as u32])
    }
}

/// Distance of two cell centres in cells.
pub(super) fn span(a: Cell, b: Cell) -> f64 {
    let (x, y) = (f64::from(a[0]) - f64::from(b[0]), f64::from(a[1]) - f64::from(b[1]));
    (x * x + y * y).sqrt()
}

/// Open list and marks of a Theta* search. Memory is zeroed lazily: cells that are never seen cost nothing.
pub(super) struct Tree {
    width: u32,
    /// Distance, and parent's index plus one; 0 is unseen.
    marks: Vec<[u64; 2]>,
    closed: Vec<bool>,
    open: Open,
}

/// Queued cells in buckets of nearly equal estimates, the last one first.
#[derive(Default)]
struct Open {
    buckets: Vec<Vec<u32>>,
    /// Estimate of bucket 0.
    base: f64,
    /// No bucket below holds a cell.
    first: usize,
}

/// Buckets per cell of length.
const FINE: f64 = 16.0;

impl Open {
    /// `f` in cells, not below the straight way of the whole leg.
    fn push(&mut self, f: f64, cell: u32) {
        let at = ((f - self.base) * FINE).max(0.0) as usize;
        if at >= self.buckets.len() {
            self.buckets.resize_with(at + 1, Vec::new);
        }
        self.buckets[at].push(cell);
        self.first = self.first.min(at);
    }
    fn pop(&mut self) -> Option<u32> {
        while let Some(bucket) = self.buckets.get_mut(self.first) {
            if let Some(cell) = bucket.pop() {
                return Some(cell);
            }
            *bucket = Vec::new();
            self.first += 1;
        }
        None
    }
}

impl Tree {
    fn new(lattice: &Lattice, base: f64) -> Self {
        let cells = lattice.width() as usize * lattice.height() as usize;
        Self { width: lattice.width(), marks: vec![[0; 2]; cells], closed: vec![false; cells], open: Open { base, ..Open::default() } }
    }
    fn index(&self, cell: Cell) -> usize {
        cell[1] as usize * self.width as usize + cell[0] as usize
    }
    fn cell(&self, index: u32) -> Cell {
        [index % self.width, index / self.width]
    }
    pub fn g(&self, cell: Cell) -> f64 {
        let [g, parent] = self.marks[self.index(cell)];
        if parent as u32 == 0 { f64::INFINITY } else { f64::from_bits(g) }
    }
    pub fn parent(&self, cell: Cell) -> Cell {
        self.cell((self.marks[self.index(cell)][1] as u32).wrapping_sub(1))
    }
    pub fn is_closed(&self, cell: Cell) -> bool {
        self.closed[self.index(cell)]
    }
    /// Sets distance and parent without queueing.
    pub fn assign(&mut self, cell: Cell, g: f64, parent: Cell) {
        let (i, p) = (self.index(cell), self.index(parent));
        let hidden = self.marks[i][1] & (!0 << 32);
        self.marks[i] = [g.to_bits(), (p as u64 + 1) | hidden];
    }
    /// Remembers that `parent` does not see the cell.
    pub fn hide(&mut self, cell: Cell, parent: Cell) {
        let (i, p) = (self.index(cell), self.index(parent));
        self.marks[i][1] = self.marks[i][1] & u64::from(u32::MAX) | (p as u64 + 1) << 32;
    }
    /// Was that the last one that was found not to see the cell?
    pub fn is_hidden(&self, cell: Cell, parent: Cell) -> bool {
        self.marks[self.index(cell)][1] >> 32 == self.index(parent) as u64 + 1
    }
    /// Sets distance and parent and queues the cell.
    pub fn offer(&mut self, cell: Cell, g: f64, parent: Cell, goal: Cell) {
        self.assign(cell, g, parent);
        self.open.push(g + span(cell, goal), self.index(cell) as u32);
    }
    fn pop(&mut self) -> Option<Cell> {
        while let Some(cell) = self.open.pop() {
            if !std::mem::replace(&mut self.closed[cell as usize], true) {
                return Some(self.cell(cell));
            }
        }
        None
    }
}

/// One leg of a Theta* search: `expand(sight, tree, cell, goal)` handles a closed cell.
fn leg(sight: &Sight, [start, goal]: [Cell; 2], ctx: &mut Context, expand: Expand) -> Result<(Vec<Cell>, u64), Option<Stop>> {
    let mut tree = Tree::new(sight.lattice, span(start, goal));
    tree.offer(start, 0.0, start, goal);
    let mut expansions = 0;
    while let Some(cell) = tree.pop() {
        expansions += 1;
        if expansions % 1024 == 0
            && let Some(stop) = ctx.poll()
        {
            return Err(Some(stop));
        }
        expand(sight, &mut tree, cell, goal);
        if cell == goal {
            let mut cells = vec![goal];
            let mut at = goal;
            while at != start {
                at = tree.parent(at);
                cells.push(at);
            }
            cells.reverse();
            return Ok((cells, expansions));
        }
    }
    Err(None)
}

/// What a variant does with a cell that was just closed.
pub(super) type Expand = fn(&Sight, &mut Tree, Cell, Cell);

/// Plans a query leg by leg with a variant of Theta*.
pub(super) fn plan(query: &Query, ctx: &mut Context, expand: Expand) -> Result<Solution, PlanError> {
    query.validate()?;
    let lattice = query.world.lattice(query.radius());
    let sight = Sight::new(query, &lattice);
    let mut expansions = 0;
    let points = crate::plan::through(query, |from, to| {
        let (Some(start), Some(goal)) = (anchor(query, &lattice, from), anchor(query, &lattice, to)) else {
            return Err(no_path(query, false, Some("no free cell centre of the lattice is in reach of the start or the goal".into())));
        };
        let (cells, count) = leg(&sight, [start, goal], ctx, expand).map_err(|stop| match stop {
            Some(Stop::Cancelled) => PlanError::Cancelled,
            Some(_) => no_path(query, false, Some("the budget of time was spent".into())),
            None => no_lattice_path(query, false, ctx),
        })?;
        expansions += count;
        Ok(with_ends(query, from, cells.into_iter().map(|c| lattice.center(c)).collect(), to))
    })?;
    let cost = points.windows(2).map(|w| shape::distance(w[0], w[1])).sum();
    Ok(Solution::of_search(Path::polyline(&points), cost, expansions, ctx))
}

/// Joins the exact ends to the centres and drops the first and last centre where the way past them is free.
fn with_ends(query: &Query, from: Point, mut centers: Vec<Point>, to: Point) -> Vec<Point> {
    let radius = query.radius();
    let see = |a: Point, b: Point| a == b || query.world.segment_free(a, b, radius);
    if centers.len() > 1 && see(from, centers[1]) {
        centers.remove(0);
    }
    let last = centers.len() - 1;
    if last > 0 && see(centers[last - 1], to) {
        centers.pop();
    }
    if centers.len() == 1 && see(from, to) {
        centers.clear();
    }
    let mut points = vec![from];
    points.extend(centers);
    points.push(to);
    points
}

#[cfg(test)]
mod tests;
