//! Shortest paths of several homotopy classes: the search over tangents and arcs, its nodes told apart by the rays that were crossed on the way.
//!
//! Sources: tangents and arcs as in `tangent.rs`; words of crossed rays as in \[bhattacharya2012\]. At a place that `k` classes have reached no worse, no
//! further class can be part of one of the `k` shortest to the goal, so it is dropped.

use super::circles::{Arc, Inflated, on};
use super::tangent::{Edge, GOAL, Piece, START, Tangents, polyline, travel};
use crate::Point;
use crate::plan::homotopy::rays::{Rays, Word, Words};
use crate::world::shape::distance;
use std::cmp::Ordering;
use std::collections::{BinaryHeap, HashMap};
use std::f64::consts::TAU;
use std::rc::Rc;

/// Relative excess of polylines over the exact length.
const EXCESS: f64 = 5e-7;

/// The shortest path of a class.
pub(in crate::plan) struct Taut {
    pub points: Vec<Point>,
    pub length: f64,
    pub word: Word,
}

/// Arrival on a circle after certain crossings.
#[derive(Clone, Copy)]
struct Node {
    circle: u32,
    left: bool,
    angle: f64,
    g: f64,
    parent: u32,
    word: u32,
    /// Angle at which the parent's circle was left, and the signed turn around it.
    bend: [f64; 2],
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
        other.f.total_cmp(&self.f).then(other.node.cmp(&self.node))
    }
}
impl PartialOrd for Key {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

/// Tangents with the rays that they cross.
type Edges = Rc<Vec<(Edge, Word)>>;
/// An earlier arrival: arc, position on it, cost, word.
type Arrival = (usize, f64, f64, u32);

/// A search for the shortest paths of `k` classes, none longer than a bound.
pub(in crate::plan) struct Classes<'a> {
    tangents: Tangents<'a>,
    rays: &'a Rays,
    words: Words,
    edges: HashMap<(u32, bool), Edges>,
    arrivals: HashMap<(u32, bool), Vec<Arrival>>,
    nodes: Vec<Node>,
    heap: BinaryHeap<Key>,
    k: usize,
    /// Nodes expanded.
    pub expansions: u64,
}

impl<'a> Classes<'a> {
    pub fn new(inflated: &'a Inflated<'a>, ends: [Point; 2], bound: f64, rays: &'a Rays, k: usize) -> Self {
        Self {
            tangents: Tangents::new(inflated, ends, bound),
            rays,
            words: Words::new(),
            edges: HashMap::new(),
            arrivals: HashMap::new(),
            nodes: Vec::new(),
            heap: BinaryHeap::new(),
            k,
            expansions: 0,
        }
    }

    /// Runs the search: classes by length, as many as there are within the bound, `k` at most. `poll` is asked after every expansion and returns true to
    /// stop; then the result is what was found before.
    pub fn solve(&mut self, poll: &mut dyn FnMut(u64) -> bool) -> Vec<Taut> {
        let mut found: Vec<(u32, u32)> = Vec::new();
        let start = self.tangents.ends[0];
        self.keep(Node { circle: START, left: true, angle: 0.0, g: 0.0, parent: START, word: 0, bend: [0.0; 2], points: [start; 2] });
        while let Some(Key { node, .. }) = self.heap.pop() {
            let at = self.nodes[node as usize];
            if at.circle == GOAL {
                if found.iter().all(|f| f.1 != at.word) {
                    found.push((node, at.word));
                }
                if found.len() == self.k {
                    break;
                }
                continue;
            }
            self.expansions += 1;
            if poll(self.expansions) {
                break;
            }
            self.expand(node, at);
        }
        found.into_iter().map(|(node, word)| self.taut(node, word)).collect()
    }

    fn taut(&self, node: u32, word: u32) -> Taut {
        let pieces = self.trace(node);
        let [start, goal] = self.tangents.ends;
        let mut points = polyline(&pieces, self.tangents.inflated(), EXCESS);
        points.insert(0, start);
        points.push(goal);
        points.dedup();
        Taut { points, length: self.nodes[node as usize].g, word: self.words.word(word).clone() }
    }

    fn keep(&mut self, node: Node) {
        let f = node.g + distance(node.points[1], self.tangents.ends[1]);
        if f <= self.tangents.bound * (1.0 + 1e-12) {
            self.nodes.push(node);
            self.heap.push(Key { f, node: (self.nodes.len() - 1) as u32 });
        }
    }

    fn expand(&mut self, index: u32, at: Node) {
        let edges = self.leave(at.circle, at.left);
        if at.circle == START {
            for (edge, word) in edges.iter() {
                self.follow(index, at, edge, ([0.0; 2], 0.0), word);
            }
            return;
        }
        let circle = &self.tangents.circles[at.circle as usize];
        let (center, radius, unit) = (circle.center, circle.radius, [at.angle.cos(), at.angle.sin()]);
        let Some((number, arc)) = circle.arcs.iter().copied().enumerate().find(|(_, a)| a.holds(unit)) else { return };
        let here = arc.position(at.angle);
        if self.known((number, &arc), here, at) {
            return;
        }
        self.arrivals.entry((at.circle, at.left)).or_default().push((number, here, at.g, at.word));
        for (edge, word) in edges.iter().filter(|e| e.0.arc == number) {
            let Some(way) = travel(&arc, here, edge.depart, at.left) else { continue };
            let bend = [at.angle, if at.left { way } else { -way }];
            let mut all = Word::new();
            self.rays.arc((center, radius), bend, [at.points[1], edge.points[0]], &mut all);
            all.extend(word);
            self.follow(index, at, edge, (bend, radius * way), &all);
        }
    }

    /// Is the class known here, reached no worse, or are there `k` better ones?
    fn known(&mut self, (number, arc): (usize, &Arc), here: f64, at: Node) -> bool {
        let (center, radius) = self.tangents.round(at.circle);
        let Some(arrivals) = self.arrivals.get(&(at.circle, at.left)) else { return false };
        let mut classes: Vec<u32> = Vec::new();
        let mut crossings = Word::new();
        for &(_, position, g, word) in arrivals.iter().filter(|a| a.0 == number) {
            let Some(way) = travel(arc, position, here, at.left).filter(|way| g + radius * way <= at.g + 1e-12) else { continue };
            crossings.clear();
            let from = arc.from + position;
            let turn = if at.left { way } else { -way };
            self.rays.arc((center, radius), [from, turn], [on(center, radius, from), on(center, radius, from + turn)], &mut crossings);
            let class = self.words.then(word, &crossings);
            if class == at.word {
                return true;
            }
            if !classes.contains(&class) {
                classes.push(class);
            }
        }
        classes.len() >= self.k
    }

    fn follow(&mut self, parent: u32, at: Node, edge: &Edge, (bend, arc): ([f64; 2], f64), crossings: &[i32]) {
        let word = self.words.then(at.word, crossings);
        let g = at.g + arc + edge.length;
        self.keep(Node { circle: edge.to, left: edge.left, angle: edge.arrive, g, parent, word, bend, points: edge.points });
    }

    /// The free tangents that leave a circle in a sense, with the rays that they cross.
    fn leave(&mut self, from: u32, left: bool) -> Edges {
        if let Some(edges) = self.edges.get(&(from, left)) {
            return Rc::clone(edges);
        }
        let crossings = |edge: &Edge| {
            let mut word = Word::new();
            self.rays.line(edge.points[0], edge.points[1], &mut word);
            word
        };
        let edges: Vec<(Edge, Word)> = self.tangents.leave(from, left).iter().map(|edge| (*edge, crossings(edge))).collect();
        let edges = Rc::new(edges);
        self.edges.insert((from, left), Rc::clone(&edges));
        edges
    }

    fn trace(&self, mut index: u32) -> Vec<Piece> {
        let mut pieces = Vec::new();
        while self.nodes[index as usize].circle != START {
            let node = self.nodes[index as usize];
            pieces.push(Piece::Line(node.points[0], node.points[1]));
            let parent = self.nodes[node.parent as usize];
            if parent.circle != START {
                let (center, radius) = self.tangents.round(parent.circle);
                let turn = if node.bend[1].abs() > TAU - 1e-6 { 0.0 } else { node.bend[1] };
                pieces.push(Piece::Bend { center, radius, from: node.bend[0], turn });
            }
            index = node.parent;
        }
        pieces.reverse();
        pieces
    }
}
