//! The graph of convex obstacle corners, start and goal, with straight taut edges.
//!
//! A shortest path of a point among squares bends only at convex corners, towards the blocked cell \[lozano1979\]; so an edge counts only if it can be
//! part of such a bend at both of its ends. That keeps a shortest path and leaves few edges. Edges of a node are found at the first visit (`scan.rs`).
//! Where a node has more than [`Corners::most`] of them, only the shortest are kept: that happens on maps of some ten thousand corners only.

use super::super::roads::{ANY, Exit, Roads};
use super::scan::Scene;
use crate::Point;
use crate::plan::search::runs::is_free;
use crate::world::Bits;
use std::sync::OnceLock;

/// Number of the start.
pub(super) const START: u32 = 0;
/// Number of the goal.
pub(super) const GOAL: u32 = 1;

/// Slots at most: their directory takes some megabytes then.
const SLOTS: usize = 1 << 23;

/// Corners of the blocked cells, start and goal. Lengths are in cells of the map it is given.
pub(in crate::plan) struct Corners<'a> {
    free: &'a Bits,
    squeeze: bool,
    points: Bits,
    /// Number of the first corner of each row line.
    first: Vec<u32>,
    spots: Vec<[u32; 2]>,
    ends: [Point; 2],
    /// Nodes that the start and the goal see, sorted.
    seen: [Vec<u32>; 2],
    /// Where the exits of a node lead, sorted: lengths are computed again at every visit, which saves most of the memory.
    exits: Vec<OnceLock<Box<[u32]>>>,
    /// Slots of a node, as a power of two.
    shift: u32,
    /// What an edge costs beside its length, cells.
    toll: f64,
}

impl<'a> Corners<'a> {
    /// The graph of free cells between two points in free cells (cells). `sees` tells for certain whether the straight way between two points is free: it
    /// is asked for the ways of start and goal, which need not be lattice points.
    pub fn new(free: &'a Bits, squeeze: bool, ends: [Point; 2], toll: f64, sees: impl Fn(Point, Point) -> bool) -> Self {
        let points = corners_of(free, squeeze);
        let (mut first, mut spots) = (vec![2], Vec::new());
        for y in 0..points.height() {
            let (mut x, last) = (0, points.width() - 1);
            while x <= last
                && let Some(found) = points.first(y, x, last, true)
            {
                spots.push([found, y]);
                x = found + 1;
            }
            first.push(2 + spots.len() as u32);
        }
        let mut exits = Vec::new();
        exits.resize_with(spots.len() + 2, OnceLock::new);
        let shift = (SLOTS / exits.len()).max(32).ilog2();
        let mut roads = Self { free, squeeze, points, first, spots, ends, seen: [Vec::new(), Vec::new()], exits, shift, toll };
        roads.seen = [START, GOAL].map(|end| roads.seen_from(end, &sees));
        if sees(ends[0], ends[1]) {
            for (from, to) in [(START, GOAL), (GOAL, START)] {
                roads.seen[from as usize].insert(0, to);
            }
        }
        roads
    }

    /// Corners.
    pub fn count(&self) -> usize {
        self.spots.len()
    }

    /// Longer side of the map, cells.
    pub fn side(&self) -> f64 {
        f64::from(self.free.width().max(self.free.height()))
    }

    /// Most exits of a node.
    pub fn most(&self) -> usize {
        1 << self.shift
    }

    fn scene(&self) -> Scene<'_> {
        Scene { free: self.free, points: &self.points, squeeze: self.squeeze }
    }

    fn seen_from(&self, end: u32, sees: &impl Fn(Point, Point) -> bool) -> Vec<u32> {
        let (root, mut found) = (self.ends[end as usize], Vec::new());
        self.scene().look(root, [[true; 2]; 2], |spot| {
            let at = spot.map(f64::from);
            if at != root && self.taut(spot, [root[0] - at[0], root[1] - at[1]]) && sees(root, at) {
                found.push(self.node(spot));
            }
        });
        found.sort_unstable();
        found.dedup();
        found
    }

    fn node(&self, [x, y]: [u32; 2]) -> u32 {
        let row = self.points.row(y);
        let word = (x >> 6) as usize;
        let before: u32 = row[..word].iter().map(|w| w.count_ones()).sum();
        self.first[y as usize] + before + (row[word] & ((1 << (x & 63)) - 1)).count_ones()
    }

    /// Quadrant of the only blocked cell around a corner; `None` if there are two.
    fn quadrant(&self, [x, y]: [u32; 2]) -> Option<[f64; 2]> {
        let (x, y) = (x as i32, y as i32);
        let blocked = |dx: i32, dy: i32| !is_free(self.free, x + (dx - 1) / 2, y + (dy - 1) / 2);
        let mut found = [(1, 1), (-1, 1), (1, -1), (-1, -1)].into_iter().filter(|&(dx, dy)| blocked(dx, dy));
        let only = found.next().filter(|_| found.next().is_none());
        only.map(|(dx, dy)| [f64::from(dx), f64::from(dy)])
    }

    /// Can a way that leaves a corner in direction `d` have bent there?
    fn taut(&self, spot: [u32; 2], d: Point) -> bool {
        self.quadrant(spot).is_none_or(|q| d[0] * q[0] * d[1] * q[1] <= 0.0)
    }

    fn find(&self, node: u32) -> Box<[u32]> {
        let mut found = if let Some(spot) = node.checked_sub(2).map(|k| self.spots[k as usize]) {
            self.corner_exits(node, spot)
        } else {
            self.seen[node as usize].clone()
        };
        if found.len() > self.most() {
            found.sort_by(|a, b| self.distance(node, *a).total_cmp(&self.distance(node, *b)).then(a.cmp(b)));
            found.truncate(self.most());
        }
        found.sort_unstable();
        found.into()
    }

    fn corner_exits(&self, node: u32, spot: [u32; 2]) -> Vec<u32> {
        let root = spot.map(f64::from);
        // Ways bend towards the blocked quadrant: they leave into the two beside it.
        let sides = self.quadrant(spot).map_or([[true; 2]; 2], |q| {
            let left = q[0] * q[1] > 0.0;
            [[left, !left], [!left, left]]
        });
        let mut found = Vec::new();
        self.scene().look(root, sides, |to| {
            let d = [f64::from(to[0]) - root[0], f64::from(to[1]) - root[1]];
            if to != spot && self.taut(spot, d) && self.taut(to, [-d[0], -d[1]]) {
                found.push(self.node(to));
            }
        });
        found.sort_unstable();
        found.dedup();
        for end in [START, GOAL] {
            if self.seen[end as usize].binary_search(&node).is_ok() {
                found.push(end);
            }
        }
        found
    }

    fn ahead(&self, node: u32) -> &[u32] {
        self.exits[node as usize].get_or_init(|| self.find(node))
    }

    /// The exits of a node.
    pub fn of(&self, node: u32) -> impl Iterator<Item = Exit> {
        let exit = move |(k, &to): (usize, &u32)| Exit {
            to,
            slot: (node << self.shift) + k as u32,
            length: self.distance(node, to) + self.toll,
            heading: ANY,
        };
        self.ahead(node).iter().enumerate().map(exit)
    }

    /// Nodes whose exits are known.
    pub fn expanded(&self) -> usize {
        self.exits.iter().filter(|e| e.get().is_some()).count()
    }
}

impl Roads for Corners<'_> {
    fn nodes(&self) -> usize {
        self.exits.len()
    }
    fn slots(&self) -> usize {
        self.exits.len() << self.shift
    }
    fn visit(&self, node: u32, see: impl FnMut(Exit)) {
        self.of(node).for_each(see);
    }
    fn back(&self, from: u32, exit: Exit) -> u32 {
        // Missing only where too many exits were cut.
        self.ahead(exit.to).binary_search(&from).map_or(exit.slot, |k| (exit.to << self.shift) + k as u32)
    }
    fn distance(&self, a: u32, b: u32) -> f64 {
        let ([ax, ay], [bx, by]) = (self.position(a), self.position(b));
        let (dx, dy) = (ax - bx, ay - by);
        (dx * dx + dy * dy).sqrt()
    }
    fn position(&self, node: u32) -> [f64; 2] {
        node.checked_sub(2).map_or_else(|| self.ends[node as usize], |k| self.spots[k as usize].map(f64::from))
    }
}

/// Lattice points with exactly one blocked cell around them, and with `squeeze` those with two that meet only there. Outside is blocked.
fn corners_of(free: &Bits, squeeze: bool) -> Bits {
    let (w, h) = (free.width(), free.height());
    let mut points = Bits::new(w + 1, h + 1);
    for y in 0..=h {
        let above = (y < h).then(|| free.row(y));
        let below = (y > 0).then(|| free.row(y - 1));
        let at = |row: Option<&[u64]>, i: usize| row.and_then(|r| r.get(i)).copied().unwrap_or(0);
        let shifted = |row, i: usize| at(row, i) << 1 | i.checked_sub(1).map_or(0, |k| at(row, k) >> 63);
        for (i, word) in points.row_mut(y).iter_mut().enumerate() {
            let [ne, nw, se, sw] = [!at(above, i), !shifted(above, i), !at(below, i), !shifted(below, i)];
            let odd = ne ^ nw ^ se ^ sw;
            let three = (ne & nw & (se | sw)) | (se & sw & (ne | nw));
            let gaps = (ne & sw & !nw & !se) | (nw & se & !ne & !sw);
            *word = (odd & !three) | if squeeze { gaps } else { 0 };
        }
    }
    points
}
