//! Local search on a lattice trail: pieces between turning points are replaced by a diagonal and a straight run where that is better.

use super::Task;
use super::roads::{Exit, Roads, Streets};
use super::walk::Trail;
use crate::plan::score::{Aim, Score};
use std::f64::consts::SQRT_2;

/// Turning points that a piece may hold. Longer ones are seldom free, and looking at all pairs takes longer than the ants.
const SPAN: usize = 16;

/// Improves a trail until no piece between two of its turning points, at most [`SPAN`] of them apart, can be replaced by one bend (in either order) for
/// the better.
pub(super) fn polish(task: &Task, trail: Trail) -> Trail {
    let mut work = Work::new(task.roads, task.aim, trail);
    while work.pass() {}
    work.trail
}

struct Work<'a> {
    roads: &'a Streets<'a>,
    aim: Aim,
    trail: Trail,
    /// Indices of both ends and of the nodes where the heading changes.
    turning: Vec<usize>,
    /// Diagonal steps before each node.
    diagonal: Vec<usize>,
}

impl<'a> Work<'a> {
    fn new(roads: &'a Streets<'a>, aim: Aim, trail: Trail) -> Self {
        let inner = (1..trail.exits.len()).filter(|&k| trail.exits[k].heading != trail.exits[k - 1].heading);
        let turning = std::iter::once(0).chain(inner).chain(std::iter::once(trail.nodes.len() - 1)).collect();
        let mut diagonal = vec![0];
        diagonal.extend(trail.exits.iter().scan(0, |sum, exit| {
            *sum += usize::from(exit.length > 1.0);
            Some(*sum)
        }));
        Self { roads, aim, trail, turning, diagonal }
    }

    /// Once along the trail; was anything improved?
    fn pass(&mut self) -> bool {
        let (mut improved, mut i) = (false, 0);
        while i + 1 < self.turning.len() {
            let last = (i + SPAN).min(self.turning.len() - 1);
            let better = (i + 1..=last).rev().find_map(|j| [true, false].into_iter().find_map(|order| self.replaced(i, j, order)));
            match better {
                Some(trail) => {
                    *self = Self::new(self.roads, self.aim, trail);
                    improved = true;
                }
                None => i += 1,
            }
        }
        improved
    }

    /// The trail with one bend between two of its turning points, if that is allowed and better.
    fn replaced(&self, i: usize, j: usize, diagonal_first: bool) -> Option<Trail> {
        let (a, b) = (self.turning[i], self.turning[j]);
        let runs = runs([a, b].map(|k| self.roads.cell(self.trail.nodes[k])), diagonal_first);
        if !self.worth([i, j], &runs).beats(self.trail.score) {
            return None;
        }
        let piece = walk(self.roads, self.trail.nodes[a], &runs)?;
        let exits: Vec<Exit> = self.trail.exits[..a].iter().chain(&piece).chain(&self.trail.exits[b..]).copied().collect();
        let nodes = std::iter::once(self.trail.nodes[0]).chain(exits.iter().map(|e| e.to)).collect();
        Some(Trail::new(self.roads, nodes, exits, self.aim))
    }

    /// What the trail would be worth with these runs between two turning points.
    fn worth(&self, [i, j]: [usize; 2], runs: &[(usize, u8); 2]) -> Score {
        let (exits, [a, b]) = (&self.trail.exits, [self.turning[i], self.turning[j]]);
        let mut headings: Vec<u8> = Vec::with_capacity(4);
        headings.extend(a.checked_sub(1).map(|k| exits[k].heading));
        headings.extend(runs.iter().filter(|run| run.0 > 0).map(|run| run.1));
        headings.extend(exits.get(b).map(|e| e.heading));
        let now = headings.windows(2).filter(|pair| pair[0] != pair[1]).count();
        let before = (i..=j).filter(|&k| k > 0 && k + 1 < self.turning.len()).count();
        let turns = self.trail.score.turns as usize + now - before;
        let slant = |heading: u8| matches!(heading, 0 | 2 | 5 | 7);
        let steps = self.trail.exits.len() - (b - a) + runs[0].0 + runs[1].0;
        let new: usize = runs.iter().filter(|run| slant(run.1)).map(|run| run.0).sum();
        let diagonal = self.diagonal[self.diagonal.len() - 1] - (self.diagonal[b] - self.diagonal[a]) + new;
        self.aim.score((steps - diagonal) as f64 + diagonal as f64 * SQRT_2, turns as u32)
    }
}

/// The runs, number of steps and heading, of the way with at most one bend.
fn runs([a, b]: [[u32; 2]; 2], diagonal_first: bool) -> [(usize, u8); 2] {
    let [dx, dy] = [0, 1].map(|k| i64::from(b[k]) - i64::from(a[k]));
    let diagonal = dx.abs().min(dy.abs());
    let straight = dx.abs().max(dy.abs()) - diagonal;
    let along = if dx.abs() > dy.abs() { [dx.signum(), 0] } else { [0, dy.signum()] };
    let runs = [(diagonal as usize, Streets::heading([dx.signum(), dy.signum()])), (straight as usize, Streets::heading(along))];
    if diagonal_first { runs } else { [runs[1], runs[0]] }
}

/// The exits along two runs, if every step is allowed.
fn walk(roads: &Streets, mut at: u32, runs: &[(usize, u8); 2]) -> Option<Vec<Exit>> {
    let mut way = Vec::with_capacity(runs[0].0 + runs[1].0);
    for &(count, heading) in runs {
        for _ in 0..count {
            let mut next = None;
            roads.visit(at, |exit| next = next.or((exit.heading == heading).then_some(exit)));
            way.push(next?);
            at = next?.to;
        }
    }
    Some(way)
}
