//! O1: initial pheromone that is stronger around the straight line from start to goal.

use super::super::roads::Roads;
use super::Reading;

/// Weight of the distance from the line.
const SLOPE: f64 = 0.09;

/// The cone between two nodes.
#[derive(Debug, Clone, Copy)]
pub(in crate::plan::colony) struct Cone {
    reading: Reading,
    start: [f64; 2],
    goal: [f64; 2],
    /// Side of the grid, cells.
    side: f64,
}

impl Cone {
    pub fn new(roads: &impl Roads, reading: Reading, ends: [u32; 2], side: f64) -> Self {
        let [start, goal] = ends.map(|node| roads.position(node));
        Self { reading, start, goal, side: side.max(1.0) }
    }

    /// Relative strength at a position, cells.
    pub fn strength(&self, [x, y]: [f64; 2]) -> f64 {
        let rest = (self.goal[0] - x).hypot(self.goal[1] - y).max(1.0);
        let line = match self.reading {
            Reading::Literal => (x - y).abs() / self.side,
            Reading::Corrected => 1.0 - std::f64::consts::SQRT_2 * self.aside([x, y]) / self.side,
        };
        SLOPE.mul_add(line, 1.0 / rest) // (1)
    }

    /// Distance from the straight line through both ends, cells.
    fn aside(&self, [x, y]: [f64; 2]) -> f64 {
        let (u, v) = (self.goal[0] - self.start[0], self.goal[1] - self.start[1]);
        let length = u.hypot(v);
        if length < 1e-9 {
            return (x - self.start[0]).hypot(y - self.start[1]);
        }
        (u * (y - self.start[1]) - v * (x - self.start[0])).abs() / length
    }

    /// Mean strength over all nodes.
    pub fn mean(&self, roads: &impl Roads) -> f64 {
        let nodes = roads.nodes().max(1) as u32;
        (0..nodes).map(|node| self.strength(roads.position(node))).sum::<f64>() / f64::from(nodes)
    }
}
