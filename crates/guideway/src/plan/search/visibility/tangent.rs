//! Exact search over tangents and arcs: the shortest path of a disc among squares, discs and convex polygons.
//!
//! A taut path is made of common tangents of inflated obstacles' circles and of arcs between them. A* runs over arrivals (circle, sense, angle); the
//! tangents that leave a circle are found when it is first expanded. A bound on the length keeps the candidates inside an ellipse; a path found below
//! the bound is optimal, otherwise the bound grows.

use super::circles::{Arc, Circle, Inflated, on};
use crate::Point;
use crate::world::shape::{distance, sub};
use std::cmp::Ordering;
use std::collections::{BinaryHeap, HashMap};
use std::rc::Rc;

/// Stands for the start among the numbers of circles.
pub(super) const START: u32 = u32::MAX;
/// Stands for the goal.
pub(super) const GOAL: u32 = u32::MAX - 1;

/// A piece of a path.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Piece {
    /// A straight line from one point to another.
    Line(Point, Point),
    /// An arc: centre, radius, first angle, signed turn (rad, positive counter-clockwise).
    Bend { center: Point, radius: f64, from: f64, turn: f64 },
}

/// How a search ended.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Outcome {
    /// The optimum and its length, m.
    Path(Vec<Piece>, f64),
    /// No path is shorter than the bound.
    Nothing,
    /// Stopped by the caller; every path is at least that long, m.
    Stopped(f64),
}

/// A tangent that leaves a circle.
#[derive(Debug, Clone, Copy)]
pub(super) struct Edge {
    /// Arc of the circle that it leaves, and the position there.
    pub arc: usize,
    pub depart: f64,
    pub to: u32,
    pub left: bool,
    /// Angle of arrival on the other circle.
    pub arrive: f64,
    pub length: f64,
    pub points: [Point; 2],
}

/// Arrival on a circle.
#[derive(Debug, Clone, Copy)]
struct Node {
    circle: u32,
    /// Travels counter-clockwise, the circle on the left.
    left: bool,
    angle: f64,
    g: f64,
    parent: u32,
    /// Angle at which the parent's circle was left, and the tangent.
    depart: f64,
    points: [Point; 2],
}

#[derive(PartialEq)]
struct Key {
    f: f64,
    node: u32,
}
impl Eq for Key {}
impl Ord for Key {
    fn cmp(&self, other: &Self) -> Ordering {
        other.f.total_cmp(&self.f).then(self.node.cmp(&other.node))
    }
}
impl PartialOrd for Key {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

/// Circles that are near each other.
struct Bucket {
    center: Point,
    reach: f64,
    members: Vec<u32>,
}

/// A search for paths no longer than a bound.
pub(super) struct Tangents<'a> {
    inflated: &'a Inflated<'a>,
    pub ends: [Point; 2],
    pub bound: f64,
    pub circles: Vec<Circle>,
    buckets: Vec<Bucket>,
    edges: HashMap<(u32, bool), Rc<Vec<Edge>>>,
    settled: HashMap<(u32, bool), Vec<(f64, f64)>>,
    nodes: Vec<Node>,
    heap: BinaryHeap<Key>,
    /// Nodes expanded.
    pub expansions: u64,
}

/// The common tangent of two circles that are passed on the left (or right): unit normal to the left of its direction, and length.
/// A circle on the left lies at its radius along the normal.
#[inline]
fn tangent(a: Point, ra: f64, b: Point, rb: f64) -> Option<(Point, f64)> {
    let v = sub(b, a);
    let d2 = v[0] * v[0] + v[1] * v[1];
    let k = rb - ra;
    let rest = d2 - k * k;
    // Touching circles share a tangent of length 0.
    if rest < -1e-9 * d2.sqrt() || d2 < 1e-24 {
        return None;
    }
    let length = rest.max(0.0).sqrt();
    let (p, q) = (k / d2, length / d2);
    Some(([p * v[0] - q * v[1], p * v[1] + q * v[0]], length))
}

impl<'a> Tangents<'a> {
    pub fn new(inflated: &'a Inflated<'a>, ends: [Point; 2], bound: f64) -> Self {
        let slack = 1e-9 * bound.min(1e9);
        let circles = inflated.circles(&|c, r| distance(ends[0], c) + distance(c, ends[1]) <= bound + 2.0 * r + slack);
        let buckets = buckets(&circles);
        Self {
            inflated,
            ends,
            bound,
            circles,
            buckets,
            edges: HashMap::new(),
            settled: HashMap::new(),
            nodes: Vec::new(),
            heap: BinaryHeap::new(),
            expansions: 0,
        }
    }

    /// What is searched among.
    pub fn inflated(&self) -> &'a Inflated<'a> {
        self.inflated
    }

    /// Circles within the bound.
    pub fn count(&self) -> u64 {
        self.circles.len() as u64
    }

    /// Runs the search; `poll` is asked after every expansion that looked for tangents and returns true to stop.
    pub fn solve(&mut self, poll: &mut dyn FnMut() -> bool) -> Outcome {
        let start = self.ends[0];
        self.keep(Node { circle: START, left: true, angle: 0.0, g: 0.0, parent: START, depart: 0.0, points: [start; 2] });
        while let Some(Key { f, node }) = self.heap.pop() {
            let at = self.nodes[node as usize];
            if at.circle == GOAL {
                return Outcome::Path(self.trace(node), at.g);
            }
            self.expansions += 1;
            if poll() {
                return Outcome::Stopped(f);
            }
            self.expand(node, at);
        }
        Outcome::Nothing
    }

    fn keep(&mut self, node: Node) {
        let f = node.g + distance(node.points[1], self.ends[1]);
        if f <= self.bound * (1.0 + 1e-12) {
            self.nodes.push(node);
            self.heap.push(Key { f, node: (self.nodes.len() - 1) as u32 });
        }
    }

    fn expand(&mut self, index: u32, at: Node) {
        if at.circle == START {
            for edge in self.leave(START, true).iter() {
                self.follow(index, edge, edge.length, 0.0);
            }
            return;
        }
        let circle = &self.circles[at.circle as usize];
        let (radius, unit) = (circle.radius, [at.angle.cos(), at.angle.sin()]);
        let Some((number, arc)) = circle.arcs.iter().copied().enumerate().find(|(_, a)| a.holds(unit)) else { return };
        let here = arc.position(at.angle);
        let done = self.settled.entry((at.circle, at.left)).or_default();
        // An earlier arrival that reaches this angle as cheaply along the arc makes this one useless.
        let key = number as f64 * 8.0;
        let dominated = done.iter().any(|&(p, g)| {
            (p - key) >= 0.0 && (p - key) < 8.0 && travel(&arc, p - key, here, at.left).is_some_and(|w| g + radius * w <= at.g + 1e-12)
        });
        if dominated {
            return;
        }
        done.push((key + here, at.g));
        let edges = self.leave(at.circle, at.left);
        for edge in edges.iter().filter(|e| e.arc == number) {
            if let Some(way) = travel(&arc, here, edge.depart, at.left) {
                self.follow(index, edge, radius * way + edge.length, arc.from + edge.depart);
            }
        }
    }

    fn follow(&mut self, parent: u32, edge: &Edge, cost: f64, depart: f64) {
        let g = self.nodes[parent as usize].g + cost;
        self.keep(Node { circle: edge.to, left: edge.left, angle: edge.arrive, g, parent, depart, points: edge.points });
    }

    /// All free tangents that leave a circle in a sense; found once.
    pub fn leave(&mut self, from: u32, left: bool) -> Rc<Vec<Edge>> {
        if let Some(edges) = self.edges.get(&(from, left)) {
            return Rc::clone(edges);
        }
        let mut found = Vec::new();
        self.look(from, left, (GOAL, true), &mut found);
        let (center, radius, arcs) = match from {
            START => (self.ends[0], 0.0, None),
            _ => (self.circles[from as usize].center, self.circles[from as usize].radius, Some(self.circles[from as usize].arcs.clone())),
        };
        let near: Vec<usize> = (0..self.buckets.len()).filter(|&i| self.in_reach(&self.buckets[i], center, radius, arcs.as_deref(), left)).collect();
        for i in near {
            for k in 0..self.buckets[i].members.len() {
                let to = self.buckets[i].members[k];
                if to != from {
                    self.look(from, left, (to, true), &mut found);
                    self.look(from, left, (to, false), &mut found);
                }
            }
        }
        let found = Rc::new(found);
        self.edges.insert((from, left), Rc::clone(&found));
        found
    }

    /// Can a tangent from one of the arcs meet the bucket, within the bound?
    fn in_reach(&self, bucket: &Bucket, center: Point, radius: f64, arcs: Option<&[Arc]>, left: bool) -> bool {
        let v = sub(bucket.center, center);
        let d = (v[0] * v[0] + v[1] * v[1]).sqrt();
        let (c, e) = (distance(bucket.center, self.ends[1]), distance(center, self.ends[0]));
        if e + d + c - 2.0 * bucket.reach - 2.0 * radius > self.bound {
            return false;
        }
        let Some(arcs) = arcs else { return true };
        if d <= bucket.reach + radius {
            return true;
        }
        // Directions of tangents turn with the arc; the bucket and the circle's own size widen them.
        let spread = ((bucket.reach + radius) / d).min(1.0).asin();
        let toward = v[1].atan2(v[0]);
        let quarter = if left { std::f64::consts::FRAC_PI_2 } else { -std::f64::consts::FRAC_PI_2 };
        arcs.iter().any(|arc| {
            let middle = arc.from + arc.extent / 2.0 + quarter;
            crate::world::shape::wrap(toward - middle).abs() <= spread + arc.extent / 2.0 + 1e-6
        })
    }

    /// Adds the tangent between two circles if it leaves and meets exposed arcs, may be part of a path within the bound, and is free.
    fn look(&mut self, from: u32, left: bool, (to, to_left): (u32, bool), found: &mut Vec<Edge>) {
        let side = |on_left: bool| if on_left { 1.0 } else { -1.0 };
        let (a, ra) = if from == START { (self.ends[0], 0.0) } else { self.round(from) };
        let (b, rb) = if to == GOAL { (self.ends[1], 0.0) } else { self.round(to) };
        let (sa, sb) = (side(left), side(to_left));
        let Some((n, length)) = tangent(a, sa * ra, b, sb * rb) else {
            if from == START && to == GOAL {
                found.push(Edge { arc: 0, depart: 0.0, to, left: true, arrive: 0.0, length: 0.0, points: self.ends });
            }
            return;
        };
        let (u, w) = ([-sa * n[0], -sa * n[1]], [-sb * n[0], -sb * n[1]]);
        let points = [[a[0] + ra * u[0], a[1] + ra * u[1]], [b[0] + rb * w[0], b[1] + rb * w[1]]];
        let exposed = |circles: &[Circle], i: u32, v: Point| circles[i as usize].arcs.iter().position(|arc| arc.holds(v));
        let leaves = if from == START { Some(0) } else { exposed(&self.circles, from, u) };
        let meets = to == GOAL || exposed(&self.circles, to, w).is_some();
        let total = distance(self.ends[0], points[0]) + length + distance(points[1], self.ends[1]);
        let (Some(arc), true) = (leaves, meets && total <= self.bound * (1.0 + 1e-12)) else { return };
        if !self.inflated.world.segment_free(points[0], points[1], self.inflated.robot) {
            return;
        }
        if to != GOAL && !self.circles[to as usize].exact {
            self.inflated.settle(&mut self.circles[to as usize]);
            if exposed(&self.circles, to, w).is_none() {
                return;
            }
        }
        let depart = if from == START { 0.0 } else { self.circles[from as usize].arcs[arc].position(u[1].atan2(u[0])) };
        found.push(Edge { arc, depart, to, left: to_left, arrive: w[1].atan2(w[0]), length, points });
    }

    /// Centre and radius of a circle.
    pub fn round(&self, i: u32) -> (Point, f64) {
        let circle = &self.circles[i as usize];
        (circle.center, circle.radius)
    }

    fn trace(&self, mut index: u32) -> Vec<Piece> {
        let mut pieces = Vec::new();
        while index != START {
            let node = self.nodes[index as usize];
            if node.circle == START {
                break;
            }
            pieces.push(Piece::Line(node.points[0], node.points[1]));
            let parent = self.nodes[node.parent as usize];
            if parent.circle != START {
                let (center, radius) = self.round(parent.circle);
                let turn = if parent.left { node.depart - parent.angle } else { parent.angle - node.depart };
                let mut turn = turn.rem_euclid(std::f64::consts::TAU);
                if turn > std::f64::consts::TAU - 1e-6 {
                    turn = 0.0;
                }
                pieces.push(Piece::Bend { center, radius, from: parent.angle, turn: if parent.left { turn } else { -turn } });
            }
            index = node.parent;
        }
        pieces.reverse();
        pieces
    }
}

/// Way along an arc from one position to another in a sense, rad; `None` if it leads the other way.
pub(super) fn travel(arc: &Arc, from: f64, to: f64, left: bool) -> Option<f64> {
    let way = if left { to - from } else { from - to };
    if arc.is_full() {
        let way = way.rem_euclid(std::f64::consts::TAU);
        return Some(if way > std::f64::consts::TAU - super::circles::ANGLE { 0.0 } else { way });
    }
    (way >= -super::circles::ANGLE).then_some(way.max(0.0))
}

/// Sorts circles into squares of about eight each.
fn buckets(circles: &[Circle]) -> Vec<Bucket> {
    let fold = |k: usize, f: fn(f64, f64) -> f64, e: f64| circles.iter().map(|c| c.center[k]).fold(e, f);
    let lo = [0, 1].map(|k| fold(k, f64::min, f64::INFINITY));
    let hi = [0, 1].map(|k| fold(k, f64::max, f64::NEG_INFINITY));
    let count = (circles.len() as f64 / 8.0).max(1.0);
    let side = ((hi[0] - lo[0]).max(1e-9) * (hi[1] - lo[1]).max(1e-9) / count).sqrt().max((hi[0] - lo[0]).max(hi[1] - lo[1]) / 4096.0).max(1e-9);
    let mut sorted: std::collections::BTreeMap<(i64, i64), Vec<u32>> = std::collections::BTreeMap::new();
    for (i, c) in circles.iter().enumerate() {
        let cell = [0, 1].map(|k| ((c.center[k] - lo[k]) / side) as i64);
        sorted.entry((cell[1], cell[0])).or_default().push(i as u32);
    }
    sorted
        .into_iter()
        .map(|((y, x), members)| {
            let center = [lo[0] + (x as f64 + 0.5) * side, lo[1] + (y as f64 + 0.5) * side];
            let reach = members.iter().map(|&i| distance(circles[i as usize].center, center) + circles[i as usize].radius).fold(0.0, f64::max);
            Bucket { center, reach, members }
        })
        .collect()
}

/// The polyline that runs around the outside of a path's arcs, longer than the path by no more than `excess` (relative), and refined where a corner of it
/// would not be free.
pub(super) fn polyline(pieces: &[Piece], inflated: &Inflated, excess: f64) -> Vec<Point> {
    let lengths = pieces.iter().map(|piece| match piece {
        Piece::Line(a, b) => (distance(*a, *b), 0.0),
        Piece::Bend { radius, turn, .. } => (radius * turn.abs(), radius * turn.abs()),
    });
    let (total, bent) = lengths.fold((0.0, 0.0), |(t, b), (l, k)| (t + l, b + k));
    // 2 tan h instead of 2 h: the excess is h^2 / 3 of the bent part.
    let half = (3.0 * excess * total / bent.max(1e-300)).sqrt().min(0.05);
    let mut points: Vec<Point> = Vec::new();
    for piece in pieces {
        match *piece {
            Piece::Line(a, b) => points.extend([a, b]),
            Piece::Bend { center, radius, from, turn } => {
                let mut step = half;
                let mut bend = around(center, radius, [from, turn], step);
                let free = |bend: &[Point]| bend.windows(2).all(|w| inflated.world.segment_free(w[0], w[1], inflated.robot));
                while step > 1e-4 && !free(&bend) {
                    step /= 4.0;
                    bend = around(center, radius, [from, turn], step);
                }
                points.extend(bend);
            }
        }
    }
    points.dedup_by(|a, b| distance(*a, *b) < 1e-12);
    points
}

/// Tangent polyline around an arc with corners every `2 half` rad or less.
fn around(center: Point, radius: f64, [from, turn]: [f64; 2], half: f64) -> Vec<Point> {
    if radius == 0.0 || turn == 0.0 {
        return vec![on(center, radius, from)];
    }
    let count = (turn.abs() / (2.0 * half)).ceil().max(1.0);
    let step = turn / (2.0 * count);
    let outer = radius / step.cos();
    let mut points = vec![on(center, radius, from)];
    points.extend((0..count as u32).map(|i| on(center, outer, from + step * (2.0 * f64::from(i) + 1.0))));
    points.push(on(center, radius, from + turn));
    points
}
