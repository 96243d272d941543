//! The widest way between two points: how large a disc passes, and where it is narrowest.
//!
//! Every cell bounds the clearance inside it from above by that of its centre plus half its diagonal. The widest chain of cells under this bound gives an
//! upper bound on the radius; cells of it whose centre is narrower than the bound are split, until none is left. Cells that are open for every radius in
//! question are joined into regions, so a round looks only at the band of cells near the radius.

use crate::Point;
use crate::world::{Cell, World};
use std::collections::{BinaryHeap, HashMap, HashSet};
use std::f64::consts::FRAC_1_SQRT_2;

/// Cells are split at most that often; the bound is then tight to 2^-7 of half a cell's diagonal.
const DEEPEST: u32 = 7;
/// Clearances looked up for split cells before the bound is taken as it is.
const MOST: u64 = 2_000_000;
const CLOSED: u32 = 0;
const BAND: u32 = u32::MAX;

/// An upper bound on the radius of a disc that passes, m, and where it is attained, m.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Bottleneck {
    pub radius: f64,
    pub place: Point,
}

/// A cell split `2^level` times each way: clearances of the parts' centres, m.
struct Split {
    level: u32,
    values: Vec<f64>,
}

/// Part `[i, j]` of a cell.
type Part = (Cell, [u32; 2]);

#[derive(PartialEq)]
struct Key {
    wide: f64,
    part: Part,
    /// The part it was reached from: its place in the order of visits plus one.
    from: u32,
}
impl Eq for Key {}
impl Ord for Key {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        self.wide.total_cmp(&other.wide).then(other.part.cmp(&self.part))
    }
}
impl PartialOrd for Key {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

/// A search for the widest way between two points of a world.
pub(super) struct Widest<'a> {
    world: &'a World,
    size: [u32; 2],
    /// Half the diagonal of a cell, m.
    half: f64,
    centers: Vec<f64>,
    /// Closed, band, or the number of an open region.
    labels: Vec<u32>,
    /// Band cells beside each region.
    shores: Vec<Vec<Cell>>,
    splits: HashMap<Cell, Split>,
    ends: [Cell; 2],
    points: [Point; 2],
    /// Clearances looked up for split cells.
    looked: u64,
}

impl<'a> Widest<'a> {
    /// `None` if the ends lie outside.
    pub fn new(world: &'a World, points: [Point; 2]) -> Option<Self> {
        let lattice = world.lattice(0.0);
        let ends = [lattice.cell_at(points[0])?, lattice.cell_at(points[1])?];
        let centers = world.clearance_field().values();
        let half = (FRAC_1_SQRT_2 + 1e-9) * world.resolution();
        let count = centers.len();
        let size = world.size();
        Some(Self { world, size, half, centers, labels: vec![BAND; count], shores: Vec::new(), splits: HashMap::new(), ends, points, looked: 0 })
    }

    /// Upper bound on the radius, mostly no more than [`Widest::tolerance`] above the truth; `None` if nothing passes. `stop` is asked in every round.
    pub fn solve(&mut self, stop: &mut dyn FnMut() -> bool) -> Option<Bottleneck> {
        let rough = self.round()?.0;
        self.label(rough);
        let ends = [0, 1].map(|k| Bottleneck { radius: self.world.clearance(self.points[k]), place: self.points[k] });
        let end = if ends[1].radius < ends[0].radius { ends[1] } else { ends[0] };
        loop {
            let (bound, chain) = self.round()?;
            let target = bound.min(end.radius);
            if target <= self.tolerance() {
                return None;
            }
            let mut weak: Vec<Cell> = chain.iter().filter(|&&part| self.center(part) < target - self.tolerance()).map(|part| part.0).collect();
            weak.sort_unstable();
            weak.dedup();
            let split = weak.into_iter().filter(|&cell| self.split(cell, target - self.tolerance())).count();
            if split == 0 || self.looked > MOST || stop() {
                let narrowest = chain.iter().min_by(|a, b| self.center(**a).total_cmp(&self.center(**b)));
                let place = narrowest.map_or(end.place, |part| self.place(*part));
                return Some(if end.radius <= bound { end } else { Bottleneck { radius: bound, place } });
            }
        }
    }

    /// Twice the half diagonal of the smallest part, m.
    pub fn tolerance(&self) -> f64 {
        2.0 * self.half / f64::from(1 << DEEPEST)
    }

    fn index(&self, [x, y]: Cell) -> usize {
        y as usize * self.size[0] as usize + x as usize
    }

    fn level(&self, cell: Cell) -> u32 {
        self.splits.get(&cell).map_or(0, |s| s.level)
    }

    /// Clearance of the centre of a part, m.
    fn center(&self, (cell, [i, j]): Part) -> f64 {
        self.splits.get(&cell).map_or_else(|| self.centers[self.index(cell)], |s| s.values[(j << s.level | i) as usize])
    }

    /// Upper bound of the clearance in a part, m.
    fn wide(&self, part: Part) -> f64 {
        self.center(part) + self.half / f64::from(1 << self.level(part.0))
    }

    fn place(&self, (cell, [i, j]): Part) -> Point {
        let n = f64::from(1 << self.level(cell));
        self.world.cell_to_map([f64::from(cell[0]) + (f64::from(i) + 0.5) / n, f64::from(cell[1]) + (f64::from(j) + 0.5) / n])
    }

    /// Splits a cell once more. Parts of what is too narrow for `target` (m) keep the bound they have: no chain of that width needs them.
    fn split(&mut self, cell: Cell, target: f64) -> bool {
        let level = self.level(cell) + 1;
        if level > DEEPEST {
            return false;
        }
        let n = 1u32 << level;
        let at = |k: u32, i: u32| f64::from(k) + (f64::from(i) + 0.5) / f64::from(n);
        let finer = self.half / f64::from(n);
        let mut looked = 0;
        let parts = (0..n).flat_map(|j| (0..n).map(move |i| [i, j]));
        let values = parts.map(|[i, j]| {
            let whole = (cell, [i / 2, j / 2]);
            if self.wide(whole) < target {
                return self.wide(whole) - finer;
            }
            looked += 1;
            self.world.clearance(self.world.cell_to_map([at(cell[0], i), at(cell[1], j)]))
        });
        let values = values.collect();
        self.looked += looked;
        self.splits.insert(cell, Split { level, values });
        true
    }

    /// Closes cells that no chain needs and joins cells that are open for every radius up to `rough`, the bound of the first round.
    fn label(&mut self, rough: f64) {
        // A way through neighbouring centres loses at most half a diagonal against the chain's bound, twice.
        let least = rough - 3.0 * self.half;
        for (label, &c) in self.labels.iter_mut().zip(&self.centers) {
            *label = if c + self.half < least { CLOSED } else { BAND };
        }
        for start in 0..self.labels.len() {
            if self.labels[start] == BAND && self.centers[start] - self.half >= rough {
                self.shores.push(Vec::new());
                let region = self.shores.len() as u32;
                self.join(start, region, rough);
            }
        }
    }

    fn join(&mut self, start: usize, region: u32, rough: f64) {
        let width = self.size[0] as usize;
        let mut todo = vec![start];
        self.labels[start] = region;
        while let Some(at) = todo.pop() {
            let cell = [(at % width) as u32, (at / width) as u32];
            for next in self.around(cell) {
                let i = self.index(next);
                if self.labels[i] != BAND {
                    continue;
                }
                if self.centers[i] - self.half >= rough {
                    self.labels[i] = region;
                    todo.push(i);
                } else {
                    self.shores[region as usize - 1].push(next);
                }
            }
        }
        self.shores[region as usize - 1].sort_unstable();
        self.shores[region as usize - 1].dedup();
    }

    /// The eight neighbours of a cell.
    fn around(&self, [x, y]: Cell) -> impl Iterator<Item = Cell> + use<> {
        let [w, h] = self.size;
        let (xs, ys) = (x.saturating_sub(1)..=(x + 1).min(w - 1), y.saturating_sub(1)..=(y + 1).min(h - 1));
        ys.flat_map(move |j| xs.clone().map(move |i| [i, j])).filter(move |&c| c != [x, y])
    }

    /// Parts of `cell` that touch a part of the same or a neighbouring cell.
    fn touching(&self, (from, [i, j]): Part, cell: Cell) -> Vec<Part> {
        let (n, m) = (1i64 << self.level(from), 1i64 << self.level(cell));
        let range = |k: usize, part: u32| {
            // The part spans [part, part + 1] / n in its own cell; shifted and scaled into the other's parts, closed.
            let shift = (i64::from(from[k]) - i64::from(cell[k])) * n;
            let (lo, hi) = ((i64::from(part) + shift) * m, (i64::from(part) + 1 + shift) * m);
            ((lo + n - 1).div_euclid(n) - 1).max(0)..=hi.div_euclid(n).min(m - 1)
        };
        let xs = range(0, i);
        range(1, j).flat_map(|b| xs.clone().map(move |a| (cell, [a as u32, b as u32]))).collect()
    }

    /// The widest chain of parts (without those in open regions) and its bound.
    fn round(&self) -> Option<(f64, Vec<Part>)> {
        let mut queue = Queue { base: vec![false; self.labels.len()], regions: vec![false; self.shores.len()], ..Queue::default() };
        let mut bound = f64::INFINITY;
        if self.enter(self.ends[0], None, &mut queue) {
            return Some((bound, Vec::new()));
        }
        while let Some(Key { wide, part, from }) = queue.heap.pop() {
            bound = bound.min(wide);
            queue.visited.push((part, from));
            if part.0 == self.ends[1] {
                return Some((bound, queue.chain()));
            }
            for cell in self.around(part.0).chain([part.0]) {
                if self.enter(cell, Some(part), &mut queue) {
                    return Some((bound, queue.chain()));
                }
            }
        }
        None
    }

    /// Reaches a cell from a part beside it (or from nowhere: all of it); true if that reaches the open region of the goal.
    fn enter(&self, cell: Cell, beside: Option<Part>, queue: &mut Queue) -> bool {
        let label = self.labels[self.index(cell)];
        if label == CLOSED && beside.is_some() && cell != self.ends[1] {
            return false;
        }
        if label != BAND && label != CLOSED {
            if std::mem::replace(&mut queue.regions[label as usize - 1], true) {
                return false;
            }
            for &shore in &self.shores[label as usize - 1] {
                for next in self.around(shore).filter(|&c| self.labels[self.index(c)] == label) {
                    self.visit(shore, Some((next, [0, 0])), queue);
                }
            }
            return self.labels[self.index(self.ends[1])] == label;
        }
        self.visit(cell, beside, queue);
        false
    }

    /// Queues the parts of a band cell that touch a part beside it, or all.
    fn visit(&self, cell: Cell, beside: Option<Part>, queue: &mut Queue) {
        let n = 1 << self.level(cell);
        if n == 1 {
            if !std::mem::replace(&mut queue.base[self.index(cell)], true) {
                queue.push((cell, [0, 0]), self.wide((cell, [0, 0])));
            }
            return;
        }
        let parts = match beside {
            Some(part) => self.touching(part, cell),
            None => (0..n).flat_map(|j| (0..n).map(move |i| (cell, [i, j]))).collect(),
        };
        for part in parts {
            if queue.seen.insert(part) {
                queue.push(part, self.wide(part));
            }
        }
    }
}

/// Parts to visit, widest first; each once.
#[derive(Default)]
struct Queue {
    heap: BinaryHeap<Key>,
    /// Parts in the order of visits with what they were reached from.
    visited: Vec<(Part, u32)>,
    /// Parts of split cells that were queued.
    seen: HashSet<Part>,
    /// Whole cells that were queued.
    base: Vec<bool>,
    regions: Vec<bool>,
}

impl Queue {
    /// Queues a part reached from the one visited last.
    fn push(&mut self, part: Part, wide: f64) {
        self.heap.push(Key { wide, part, from: self.visited.len() as u32 });
    }

    /// The parts that led to the one visited last, that one first.
    fn chain(&self) -> Vec<Part> {
        let (mut chain, mut at) = (Vec::new(), self.visited.len() as u32);
        while at > 0 {
            let (part, from) = self.visited[at as usize - 1];
            chain.push(part);
            at = from;
        }
        chain
    }
}
