//! A tree of free straight edges with the cost of every node.

use super::kd::Kd;
use crate::Point;
use crate::world::shape::distance;

/// The tree. Nodes are known by the order in which they came; node 0 is the root.
pub(super) struct Tree {
    pub near: Kd,
    parents: Vec<u32>,
    children: Vec<Vec<u32>>,
    costs: Vec<f64>,
}

impl Tree {
    pub fn new(root: Point) -> Self {
        let mut near = Kd::default();
        near.insert(root);
        Self { near, parents: vec![0], children: vec![Vec::new()], costs: vec![0.0] }
    }

    pub fn len(&self) -> usize {
        self.costs.len()
    }

    pub fn point(&self, node: usize) -> Point {
        self.near.points()[node]
    }

    /// Length of the way from the root, m.
    pub fn cost(&self, node: usize) -> f64 {
        self.costs[node]
    }

    /// Adds a node.
    pub fn add(&mut self, p: Point, parent: usize) -> usize {
        let new = self.len();
        self.costs.push(self.costs[parent] + distance(self.point(parent), p));
        self.near.insert(p);
        self.parents.push(parent as u32);
        self.children.push(Vec::new());
        self.children[parent].push(new as u32);
        new
    }

    /// Hangs a node below another parent and corrects the costs of all that follow it.
    pub fn hang(&mut self, node: usize, parent: usize) {
        let old = self.parents[node] as usize;
        self.children[old].retain(|&c| c as usize != node);
        self.children[parent].push(node as u32);
        self.parents[node] = parent as u32;
        let mut todo = vec![node];
        while let Some(at) = todo.pop() {
            let above = self.parents[at] as usize;
            self.costs[at] = self.costs[above] + distance(self.point(above), self.point(at));
            todo.extend(self.children[at].iter().map(|&c| c as usize));
        }
    }

    /// From the root to a node.
    pub fn way(&self, node: usize) -> Vec<Point> {
        let (mut at, mut way) = (node, vec![self.point(node)]);
        while at != 0 {
            at = self.parents[at] as usize;
            way.push(self.point(at));
        }
        way.reverse();
        way
    }

    /// At most `most` edges (x, y, x of the parent, y of the parent), spread evenly over the order in which they came.
    pub fn edges(&self, most: usize) -> Vec<[f64; 4]> {
        let every = (self.len() / most.max(1)).max(1);
        let edge = |i: usize| {
            let (p, q) = (self.point(i), self.point(self.parents[i] as usize));
            [p[0], p[1], q[0], q[1]]
        };
        (1..self.len()).step_by(every).take(most).map(edge).collect()
    }
}
