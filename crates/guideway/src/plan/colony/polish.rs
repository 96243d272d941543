//! Local search on a lattice trail: pieces between turning points are replaced by a diagonal and a straight run where that is better.

use super::Task;
use super::roads::{Exit, Roads, Streets};
use super::walk::Trail;
use crate::plan::score::Aim;
use crate::world::Cell;

/// Improves a trail until no piece between two of its turning points can be replaced by one bend (in either order) for the better.
pub(super) fn polish(task: &Task, trail: Trail) -> Trail {
    let mut best = trail;
    while let Some(better) = improved(task.roads, task.aim, &best) {
        best = better;
    }
    best
}

fn improved(roads: &Streets, aim: Aim, trail: &Trail) -> Option<Trail> {
    let ends = turning(trail);
    for (i, &a) in ends.iter().enumerate() {
        for &b in ends[i + 1..].iter().rev().filter(|b| **b > a + 1) {
            for diagonal_first in [true, false] {
                let Some(piece) = bend(roads, trail.nodes[a], trail.nodes[b], diagonal_first) else { continue };
                let longer: f64 = piece.iter().map(|e| e.length).sum::<f64>() - trail.exits[a..b].iter().map(|e| e.length).sum::<f64>();
                if longer > 1e-9 && aim == Aim::Shortest {
                    continue;
                }
                let exits: Vec<Exit> = trail.exits[..a].iter().chain(&piece).chain(&trail.exits[b..]).copied().collect();
                let nodes: Vec<u32> = std::iter::once(trail.nodes[0]).chain(exits.iter().map(|e| e.to)).collect();
                let next = Trail::new(roads, nodes, exits, aim);
                if next.score.beats(trail.score) {
                    return Some(next);
                }
            }
        }
    }
    None
}

/// Indices of both ends and of the nodes where the heading changes.
fn turning(trail: &Trail) -> Vec<usize> {
    let inner = (1..trail.exits.len()).filter(|&k| trail.exits[k].heading != trail.exits[k - 1].heading);
    std::iter::once(0).chain(inner).chain(std::iter::once(trail.nodes.len() - 1)).collect()
}

/// The way from `a` to `b` with at most one bend.
fn bend(roads: &Streets, a: u32, b: u32, diagonal_first: bool) -> Option<Vec<Exit>> {
    let (mut at, goal) = (roads.cell(a).map(i64::from), roads.cell(b).map(i64::from));
    let (dx, dy) = (goal[0] - at[0], goal[1] - at[1]);
    let diagonal = dx.abs().min(dy.abs());
    let straight = dx.abs().max(dy.abs()) - diagonal;
    let along = if dx.abs() > dy.abs() { [dx.signum(), 0] } else { [0, dy.signum()] };
    let runs = [(diagonal, [dx.signum(), dy.signum()]), (straight, along)];
    let runs = if diagonal_first { runs } else { [runs[1], runs[0]] };
    let mut way = Vec::with_capacity((diagonal + straight) as usize);
    let mut exits = Vec::with_capacity(8);
    for (count, step) in runs {
        for _ in 0..count {
            let (from, to): (Cell, Cell) = (at.map(|v| v as u32), [(at[0] + step[0]) as u32, (at[1] + step[1]) as u32]);
            let node = roads.node(to);
            roads.exits(roads.node(from), &mut exits);
            way.push(*exits.iter().find(|e| e.to == node)?);
            at = to.map(i64::from);
        }
    }
    Some(way)
}
