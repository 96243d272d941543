//! Lines of sight between cell centres, and the parts that both Theta* planners share.

use super::leg::{anchor, in_own_cells, no_lattice_path, no_path};
use crate::Point;
use crate::context::{Context, Stop};
use crate::error::PlanError;
use crate::path::Path;
use crate::plan::Solution;
use crate::query::Query;
use crate::world::{Bits, Cell, Corners, Lattice, shape};
use std::collections::BinaryHeap;

/// Does a point see from one cell centre to another? Exact, in integers: closed blocked squares may be touched, the gap between two blocked cells that
/// meet at a corner is passed only with `squeeze`.
pub(super) fn cells_see(free: &Bits, a: Cell, b: Cell, squeeze: bool) -> bool {
    let (a, b) = if a[1] <= b[1] { (a, b) } else { (b, a) };
    let [ax, ay, bx, by] = [a[0], a[1], b[0], b[1]].map(i64::from);
    let all = |y: i64, x0: i64, x1: i64| run_free(free, y as u32, x0, x1);
    if ay == by {
        return all(ay, ax.min(bx), ax.max(bx));
    }
    let (dx, rows) = (bx - ax, by - ay);
    // The line meets the upper border of row `ay + k` at x = (2 ax + 1) / 2 + dx (2 k + 1) / (2 rows): `num / den` in cells.
    let den = 2 * rows;
    let mut from = (2 * ax + 1) * rows;
    for k in 0..=rows {
        let y = ay + k;
        let to = if k == rows { (2 * bx + 1) * rows } else { (2 * ax + 1) * rows + dx * (2 * k + 1) };
        let (lo, hi) = (from.min(to), from.max(to));
        let (x0, x1) = (lo.div_euclid(den), (hi + den - 1).div_euclid(den) - 1);
        if !all(y, x0, x1) {
            return false;
        }
        // Through a lattice point, diagonally.
        if k < rows && dx != 0 && to % den == 0 && !squeeze {
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
    point: bool,
    /// Cells where the disc fits all over, and cells where it may fit somewhere.
    quick: Option<[Bits; 2]>,
}

impl<'a> Sight<'a> {
    pub fn new(query: &'a Query, lattice: &'a Lattice) -> Self {
        let point = query.radius() == 0.0 && query.world.shapes().is_empty();
        let quick = (!point).then(|| {
            let half = (std::f64::consts::FRAC_1_SQRT_2 + 1e-9) * query.world.resolution();
            [half, -half].map(|margin| query.world.clearance_field().at_least(query.radius() + margin))
        });
        Self { query, lattice, point, quick }
    }

    /// Is the straight way between two free centres free?
    pub fn see(&self, a: Cell, b: Cell) -> bool {
        if self.point {
            return cells_see(self.lattice.free(), a, b, self.query.corners == Corners::Squeeze);
        }
        if let Some([surely, perhaps]) = &self.quick {
            if cells_see(surely, a, b, true) {
                return true;
            }
            if !cells_see(perhaps, a, b, true) {
                return false;
            }
        }
        self.query.world.segment_free(self.lattice.center(a), self.lattice.center(b), self.query.radius())
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
    (f64::from(a[0]) - f64::from(b[0])).hypot(f64::from(a[1]) - f64::from(b[1]))
}

/// Open list and marks of a Theta* search. Memory is zeroed lazily: cells that are never seen cost nothing.
pub(super) struct Tree {
    width: u32,
    g: Vec<f64>,
    /// Parent's index plus one; 0 is unseen.
    parent: Vec<u32>,
    closed: Vec<bool>,
    heap: BinaryHeap<Entry>,
}

#[derive(PartialEq)]
struct Entry {
    f: f64,
    g: f64,
    cell: u32,
}
impl Eq for Entry {}
impl Ord for Entry {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        other.f.total_cmp(&self.f).then(self.g.total_cmp(&other.g)).then(other.cell.cmp(&self.cell))
    }
}
impl PartialOrd for Entry {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

impl Tree {
    fn new(lattice: &Lattice) -> Self {
        let cells = lattice.width() as usize * lattice.height() as usize;
        Self { width: lattice.width(), g: vec![0.0; cells], parent: vec![0; cells], closed: vec![false; cells], heap: BinaryHeap::new() }
    }
    fn index(&self, cell: Cell) -> usize {
        cell[1] as usize * self.width as usize + cell[0] as usize
    }
    fn cell(&self, index: u32) -> Cell {
        [index % self.width, index / self.width]
    }
    pub fn g(&self, cell: Cell) -> f64 {
        let i = self.index(cell);
        if self.parent[i] == 0 { f64::INFINITY } else { self.g[i] }
    }
    pub fn parent(&self, cell: Cell) -> Cell {
        self.cell(self.parent[self.index(cell)] - 1)
    }
    pub fn is_closed(&self, cell: Cell) -> bool {
        self.closed[self.index(cell)]
    }
    /// Sets distance and parent without queueing.
    pub fn assign(&mut self, cell: Cell, g: f64, parent: Cell) {
        let (i, p) = (self.index(cell), self.index(parent));
        self.g[i] = g;
        self.parent[i] = p as u32 + 1;
    }
    /// Sets distance and parent and queues the cell.
    pub fn offer(&mut self, cell: Cell, g: f64, parent: Cell, goal: Cell) {
        self.assign(cell, g, parent);
        self.heap.push(Entry { f: g + span(cell, goal), g, cell: self.index(cell) as u32 });
    }
    fn pop(&mut self) -> Option<Cell> {
        while let Some(entry) = self.heap.pop() {
            if !self.closed[entry.cell as usize] && entry.g == self.g[entry.cell as usize] {
                self.closed[entry.cell as usize] = true;
                return Some(self.cell(entry.cell));
            }
        }
        None
    }
}

/// One leg of a Theta* search: `expand(sight, tree, cell, goal)` handles a closed cell.
fn leg(sight: &Sight, [start, goal]: [Cell; 2], ctx: &mut Context, expand: Expand) -> Result<(Vec<Cell>, u64), Option<Stop>> {
    let mut tree = Tree::new(sight.lattice);
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
            None => no_lattice_path(query, in_own_cells(&lattice, [(from, start), (to, goal)]), ctx),
        })?;
        expansions += count;
        Ok(with_ends(query, from, cells.into_iter().map(|c| lattice.center(c)).collect(), to))
    })?;
    let cost = points.windows(2).map(|w| shape::distance(w[0], w[1])).sum();
    Ok(Solution::of_search(Path::polyline(&points), cost, expansions, ctx))
}

/// Joins the exact ends to the centres and drops the first and last centre where the way past them is free.
fn with_ends(query: &Query, from: Point, mut centers: Vec<Point>, to: Point) -> Vec<Point> {
    let see = |a: Point, b: Point| a == b || query.world.segment_free(a, b, query.radius());
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
