//! Exact any-angle search for a point robot among closed square cells.
//!
//! Source: interval search with roots as in Anya \[harabor2016\] and Polyanya \[cui2017\], here over the maximal free runs of the rows, which
//! are found on the fly: no mesh is built and no preprocessing is needed. A search node is an interval of a row line together with the
//! root, the last turning point, from which every point of the interval is visible. Start and goal are arbitrary points.
//!
//! Numbers: coordinates are in cells. Roots other than the start are lattice points, so a boundary ray is the quotient of two integers and
//! lands on a lattice point exactly when it does so in truth; rays from the start are snapped within [`SNAP`].
//!
//! The outside of the map counts as blocked.

use super::runs::{Run, is_free, run_at, runs_over};
use crate::Point;
use crate::world::Bits;
use std::collections::{BinaryHeap, HashMap};
use std::hash::{BuildHasherDefault, Hasher};

/// Rays that pass a lattice point within this distance pass through it, cells.
const SNAP: f64 = 1e-10;
const NONE: u32 = u32::MAX;

/// What the search found; lengths in cells.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Found {
    /// The optimum: points from start to goal.
    Path(Vec<Point>),
    /// Proved: there is none.
    Nothing,
    /// Stopped by the caller; the optimum is at least `bound`.
    Stopped { bound: f64 },
}

/// A search over one map.
pub(super) struct Rows<'a> {
    free: &'a Bits,
    squeeze: bool,
    start: Point,
    goal: Point,
    goal_runs: Vec<(i32, Run)>,
    heap: BinaryHeap<Key>,
    nodes: Vec<Node>,
    vacant: Vec<u32>,
    /// Roots with their predecessors.
    chain: Vec<(Point, u32)>,
    seen: HashMap<u64, Seen, BuildHasherDefault<Mix>>,
    /// Nodes expanded.
    pub expansions: u64,
}

#[derive(Debug, Clone, Copy)]
struct Node {
    root: Point,
    g: f64,
    /// Directions from the root that bound the cone on the left (smaller x) and on the right.
    left: Point,
    right: Point,
    /// The interval on line `y`.
    l: f64,
    r: f64,
    /// The run that is entered.
    run: Run,
    y: i32,
    up: bool,
    link: u32,
    last: bool,
}

/// What is known of a root: its distance, and the widest cone of each of the four kinds of turn that was started from it.
#[derive(Debug, Clone, Copy)]
struct Seen {
    g: f64,
    widest: [f64; 4],
    flat: u8,
}

#[derive(Debug, Clone, Copy, PartialEq)]
struct Key {
    f: f64,
    node: u32,
}
impl Eq for Key {}
impl Ord for Key {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        other.f.total_cmp(&self.f).then(self.node.cmp(&other.node))
    }
}
impl PartialOrd for Key {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

/// A multiplicative hash for lattice points.
#[derive(Debug, Default, Clone, Copy)]
struct Mix(u64);
impl Hasher for Mix {
    fn finish(&self) -> u64 {
        self.0
    }
    fn write(&mut self, bytes: &[u8]) {
        for &b in bytes {
            self.write_u64(u64::from(b));
        }
    }
    fn write_u64(&mut self, v: u64) {
        let h = (self.0 ^ v).wrapping_mul(0x9E37_79B9_7F4A_7C15);
        self.0 = h ^ (h >> 29);
    }
}

fn dist(a: Point, b: Point) -> f64 {
    let (x, y) = (a[0] - b[0], a[1] - b[1]);
    (x * x + y * y).sqrt()
}

/// Where the ray from `root` along `d` meets the line `y`; infinite for a ray along the line.
fn meet(root: Point, d: Point, y: f64) -> f64 {
    if d[1] == 0.0 {
        return if d[0] < 0.0 { f64::NEG_INFINITY } else { f64::INFINITY };
    }
    let x = root[0] + d[0] * (y - root[1]) / d[1];
    let near = x.round();
    if (x - near).abs() < SNAP { near } else { x }
}

/// Where that ray meets line `y` within `[a, b]`, and the ray; a ray that leaves through a side is made flat, which stands for "up to the end".
fn clip(root: Point, d: Point, y: f64, [a, b]: [f64; 2]) -> (f64, Point) {
    let x = meet(root, d, y);
    if x < a {
        (a, [-1.0, 0.0])
    } else if x > b {
        (b, [1.0, 0.0])
    } else {
        (x, d)
    }
}

fn slack(g: f64) -> f64 {
    1e-12 + 1e-14 * g
}

impl<'a> Rows<'a> {
    /// A search from `start` to `goal` (cells) over the free cells; `squeeze` lets the point pass between two diagonal blocked cells.
    /// Both points must lie in free cells.
    pub fn new(free: &'a Bits, squeeze: bool, start: Point, goal: Point) -> Self {
        let mut rows = Self {
            free,
            squeeze,
            start,
            goal,
            goal_runs: Vec::new(),
            heap: BinaryHeap::new(),
            nodes: Vec::new(),
            vacant: Vec::new(),
            chain: vec![(start, NONE)],
            seen: HashMap::default(),
            expansions: 0,
        };
        rows.goal_runs = rows.runs_holding(goal);
        rows
    }

    /// Runs whose closed rectangle holds `p`, (row, run): one, or more where `p` lies on a grid line.
    fn runs_holding(&self, p: Point) -> Vec<(i32, Run)> {
        let cells = |v: f64| if v.fract() == 0.0 { vec![v as i32, v as i32 - 1] } else { vec![v as i32] };
        let mut found = Vec::new();
        for y in cells(p[1]) {
            for x in cells(p[0]) {
                if is_free(self.free, x, y) && !found.contains(&(y, run_at(self.free, x, y))) {
                    found.push((y, run_at(self.free, x, y)));
                }
            }
        }
        found
    }

    /// Runs the search; `poll` is asked every few thousand expansions and returns true to stop.
    pub fn solve(&mut self, poll: &mut dyn FnMut() -> bool) -> Found {
        if self.start == self.goal {
            return Found::Path(vec![self.start, self.goal]);
        }
        if self.goal_runs.is_empty() {
            return Found::Nothing;
        }
        for held in self.runs_holding(self.start) {
            self.arrive(self.start, 0.0, 0, held);
        }
        while let Some(key) = self.heap.pop() {
            let node = self.nodes[key.node as usize];
            self.vacant.push(key.node);
            if node.last {
                return Found::Path(self.trace(node.link));
            }
            if self.stale(&node) {
                continue;
            }
            self.expansions += 1;
            if self.expansions.is_multiple_of(4096) && poll() {
                return Found::Stopped { bound: key.f };
            }
            self.expand(&node);
        }
        Found::Nothing
    }

    fn trace(&self, mut link: u32) -> Vec<Point> {
        let mut points = vec![self.goal];
        while link != NONE {
            let (point, up) = self.chain[link as usize];
            if points[points.len() - 1] != point {
                points.push(point);
            }
            link = up;
        }
        points.reverse();
        points
    }

    fn stale(&self, node: &Node) -> bool {
        node.link != 0 && self.seen.get(&self.vertex(node.root)).is_some_and(|s| node.g > s.g + slack(s.g))
    }

    fn vertex(&self, p: Point) -> u64 {
        p[1] as u64 * (u64::from(self.free.width()) + 1) + p[0] as u64
    }

    /// Everything that is visible from `root`, a point of the closed rectangle of `run`, without regard to the way it was reached.
    fn arrive(&mut self, root: Point, g: f64, link: u32, (row, run): (i32, Run)) {
        if self.goal_runs.contains(&(row, run)) {
            self.finish(g + dist(root, self.goal), link);
        }
        self.gaps(root, g, link, (row, run));
        let (a, b) = (f64::from(run.a), f64::from(run.b));
        for up in [true, false] {
            let y = if up { row + 1 } else { row };
            if f64::from(y) == root[1] {
                self.along((root, g, link), (y, if up { row + 1 } else { row - 1 }), [a, b], up);
            } else {
                self.fan(root, g, link, (y, up), [a, b], [[-1.0, 0.0], [1.0, 0.0]]);
            }
        }
    }

    /// Nodes on line `y` that are entered upwards or downwards from `root`, within `[lo, hi]`, all of it visible within the `cone`.
    fn fan(&mut self, root: Point, g: f64, link: u32, (y, up): (i32, bool), [lo, hi]: [f64; 2], cone: [Point; 2]) {
        let cell = if up { y } else { y - 1 };
        let free = self.free;
        let rise = f64::from(y) - root[1];
        for run in runs_over(free, cell, lo, hi) {
            let (a, b) = (f64::from(run.a), f64::from(run.b));
            // A flat boundary of the cone is replaced by the end of the rectangle, which is where it stops.
            let (l, left) = if a > lo || cone[0][1] == 0.0 { (a.max(lo), [a.max(lo) - root[0], rise]) } else { (lo, cone[0]) };
            let (r, right) = if b < hi || cone[1][1] == 0.0 { (b.min(hi), [b.min(hi) - root[0], rise]) } else { (hi, cone[1]) };
            self.push(Node { root, g, left, right, l, r, run, y, up, link, last: false });
        }
    }

    /// Moves along line `y` from `root` on it, within `[lo, hi]`: the runs of row `cell` on the other side are entered at their near end, around the
    /// blocked cell before it, or at once if they hold the root.
    fn along(&mut self, (root, g, link): (Point, f64, u32), (y, cell): (i32, i32), [lo, hi]: [f64; 2], up: bool) {
        let free = self.free;
        for run in runs_over(free, cell, lo, hi) {
            let (a, b) = (f64::from(run.a), f64::from(run.b));
            let (l, r) = (a.max(lo), b.min(hi));
            let ahead = if up { 1.0 } else { -1.0 };
            if a <= root[0] && root[0] <= b {
                self.push(Node { root, g, left: [-1.0, 0.0], right: [1.0, 0.0], l, r, run, y, up, link, last: false });
                continue;
            }
            let leftwards = b < root[0];
            let corner = [if leftwards { b } else { a }, root[1]];
            let g = g + (corner[0] - root[0]).abs();
            if !self.admit_flat(corner, g, leftwards, up) {
                continue;
            }
            let link = self.link(corner, link);
            let (left, right) = if leftwards { ([-1.0, 0.0], [0.0, ahead]) } else { ([0.0, ahead], [1.0, 0.0]) };
            self.push(Node { root: corner, g, left, right, l, r, run, y, up, link, last: false });
        }
    }

    fn link(&mut self, point: Point, from: u32) -> u32 {
        self.chain.push((point, from));
        (self.chain.len() - 1) as u32
    }

    fn expand(&mut self, node: &Node) {
        let (row, inner, far) = if node.up { (node.y, node.y - 1, node.y + 1) } else { (node.y - 1, node.y, node.y - 1) };
        let (a, b) = (f64::from(node.run.a), f64::from(node.run.b));
        let (lo, left) = clip(node.root, node.left, f64::from(far), [a, b]);
        let (hi, right) = clip(node.root, node.right, f64::from(far), [a, b]);
        if self.goal_runs.contains(&(row, node.run)) {
            self.reach_goal(node, inner);
        }
        if lo < hi {
            self.fan(node.root, node.g, node.link, (far, node.up), [lo, hi], [left, right]);
        }
        let y = f64::from(node.y);
        if node.root[1] == y {
            let from = (node.root, node.g, node.link);
            if node.left == [-1.0, 0.0] {
                self.along(from, (node.y, inner), [a, node.l], !node.up);
            }
            if node.right == [1.0, 0.0] {
                self.along(from, (node.y, inner), [node.r, b], !node.up);
            }
            self.gaps(node.root, node.g, node.link, (row, node.run));
            return;
        }
        self.gaps_in_cone(node, row);
        for leftwards in [true, false] {
            self.turn(node, inner, far, leftwards, if leftwards { (lo, left) } else { (hi, right) });
        }
    }

    /// May the path bend around the end of the interval? The corner belongs to a blocked cell beside the root's side of the line with free space
    /// behind it, or to the blocked cell at the end of the run that is entered, when the ray leads away from it.
    fn bends(&self, node: &Node, inner: i32, leftwards: bool) -> bool {
        if node.root[1] == f64::from(node.y) {
            return false;
        }
        let (x, end, beside) = if leftwards { (node.l, node.run.a, -1) } else { (node.r, node.run.b, 0) };
        if x == f64::from(end) {
            return if leftwards { node.root[0] < x } else { node.root[0] > x };
        }
        x.fract() == 0.0 && !is_free(self.free, x as i32 + beside, inner)
    }

    /// Bends around an end of the interval: the part of the far line behind the ray, and the line itself.
    fn turn(&mut self, node: &Node, inner: i32, far: i32, leftwards: bool, (cut, edge): (f64, Point)) {
        if !self.bends(node, inner, leftwards) {
            return;
        }
        let (x, ray) = if leftwards { (node.l, node.left) } else { (node.r, node.right) };
        let corner = [x, f64::from(node.y)];
        let g = node.g + dist(node.root, corner);
        if !self.admit(corner, g, (leftwards, node.up), ray[0] / ray[1].abs()) {
            return;
        }
        let link = self.link(corner, node.link);
        let (a, b) = (f64::from(node.run.a), f64::from(node.run.b));
        let (behind, beside, cone) = if leftwards { ([a, cut], [a, x], [[-1.0, 0.0], edge]) } else { ([cut, b], [x, b], [edge, [1.0, 0.0]]) };
        if behind[0] < behind[1] {
            self.fan(corner, g, link, (far, node.up), behind, cone);
        }
        self.along((corner, g, link), (node.y, inner), beside, !node.up);
    }

    /// First visit of a root, a shorter way to it, or an equally short one that opens a wider cone?
    fn admit(&mut self, p: Point, g: f64, (leftwards, up): (bool, bool), slope: f64) -> bool {
        let width = if leftwards { slope } else { -slope };
        let Some(seen) = self.visit(p, g) else { return false };
        let widest = &mut seen.widest[usize::from(leftwards) * 2 + usize::from(up)];
        if width <= *widest {
            return false;
        }
        *widest = width;
        true
    }

    fn admit_flat(&mut self, p: Point, g: f64, leftwards: bool, up: bool) -> bool {
        let Some(seen) = self.visit(p, g) else { return false };
        let bit = 1 << (usize::from(leftwards) * 2 + usize::from(up));
        let new = seen.flat & bit == 0;
        seen.flat |= bit;
        new
    }

    fn visit(&mut self, p: Point, g: f64) -> Option<&mut Seen> {
        let fresh = Seen { g, widest: [f64::NEG_INFINITY; 4], flat: 0 };
        let seen = self.seen.entry(self.vertex(p)).or_insert(fresh);
        if g > seen.g + slack(seen.g) {
            return None;
        }
        if g < seen.g - slack(seen.g) {
            *seen = fresh;
        }
        Some(seen)
    }

    fn reach_goal(&mut self, node: &Node, inner: i32) {
        let [x, y] = self.goal;
        let (l, r) = (meet(node.root, node.left, y), meet(node.root, node.right, y));
        let (root, goal) = (node.root, self.goal);
        if l - SNAP <= x && x <= r + SNAP || root[1] == y && y == f64::from(node.y) {
            self.finish(node.g + dist(root, goal), node.link);
            return;
        }
        let leftwards = x < l;
        if self.bends(node, inner, leftwards) {
            let corner = [if leftwards { node.l } else { node.r }, f64::from(node.y)];
            let link = self.link(corner, node.link);
            self.finish(node.g + dist(root, corner) + dist(corner, goal), link);
        }
    }

    fn finish(&mut self, f: f64, link: u32) {
        let none = [0.0; 2];
        let node = Node { root: none, g: f, left: none, right: none, l: 0.0, r: 0.0, run: Run { a: 0, b: 0 }, y: 0, up: true, link, last: true };
        self.keep(f, node);
    }

    fn push(&mut self, node: Node) {
        let y = f64::from(node.y);
        let mut goal = self.goal;
        // A goal behind the line is mirrored: the path has to cross the line first.
        if (goal[1] < y) == node.up && goal[1] != y {
            goal[1] = 2.0 * y - goal[1];
        }
        let (down, up) = ((y - node.root[1]).abs(), (goal[1] - y).abs());
        let x = if down + up == 0.0 { goal[0] } else { (node.root[0] * up + goal[0] * down) / (down + up) };
        let through = [x.clamp(node.l, node.r), y];
        let f = node.g + dist(node.root, through) + dist(through, goal);
        self.keep(f, node);
    }

    fn keep(&mut self, f: f64, node: Node) {
        let slot = if let Some(slot) = self.vacant.pop() {
            self.nodes[slot as usize] = node;
            slot
        } else {
            self.nodes.push(node);
            (self.nodes.len() - 1) as u32
        };
        self.heap.push(Key { f, node: slot });
    }

    /// Squeezes through the gaps at the corners of a run's rectangle that `root` sees.
    fn gaps(&mut self, root: Point, g: f64, link: u32, (row, run): (i32, Run)) {
        if self.squeeze {
            for (corner, beyond) in self.gaps_of(row, run) {
                self.squeeze(corner, g + dist(root, corner), link, beyond);
            }
        }
    }

    /// Squeezes through the gaps inside the cone of a node, or behind a bend.
    fn gaps_in_cone(&mut self, node: &Node, row: i32) {
        if !self.squeeze {
            return;
        }
        let inner = if node.up { node.y - 1 } else { node.y };
        for (corner, beyond) in self.gaps_of(row, node.run) {
            let (l, r) = (meet(node.root, node.left, corner[1]), meet(node.root, node.right, corner[1]));
            if l <= corner[0] && corner[0] <= r {
                self.squeeze(corner, node.g + dist(node.root, corner), node.link, beyond);
                continue;
            }
            let leftwards = corner[0] < l;
            if self.bends(node, inner, leftwards) {
                let bend = [if leftwards { node.l } else { node.r }, f64::from(node.y)];
                let link = self.link(bend, node.link);
                self.squeeze(corner, node.g + dist(node.root, bend) + dist(bend, corner), link, beyond);
            }
        }
    }

    /// Corners of a run's rectangle where two blocked cells meet diagonally, with the free cell beyond.
    fn gaps_of(&self, row: i32, run: Run) -> Vec<(Point, [i32; 2])> {
        let mut found = Vec::new();
        for (x, inside, outside) in [(run.a, run.a, run.a - 1), (run.b, run.b - 1, run.b)] {
            for (y, next) in [(row, row - 1), (row + 1, row + 1)] {
                if !is_free(self.free, inside, next) && is_free(self.free, outside, next) {
                    found.push(([f64::from(x), f64::from(y)], [outside, next]));
                }
            }
        }
        found
    }

    fn squeeze(&mut self, corner: Point, g: f64, link: u32, beyond: [i32; 2]) {
        let upwards = f64::from(beyond[1]) >= corner[1];
        if self.admit_flat(corner, g, f64::from(beyond[0]) < corner[0], upwards) {
            let link = self.link(corner, link);
            let run = run_at(self.free, beyond[0], beyond[1]);
            self.arrive(corner, g, link, (beyond[1], run));
        }
    }
}

#[cfg(test)]
mod tests;
