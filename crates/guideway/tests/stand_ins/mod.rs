//! The two calibrated stand-in scenes, and a search on (cell, heading) that shares nothing with the planners.

use guideway::query::Query;
use guideway::world::{Bits, Cell, Corners, Grid, World};
use std::collections::BTreeMap;
use std::sync::Arc;

/// Scene 1 and 2: 20 x 20 cells of 1 m, first row on top.
pub const SCENES: [&str; 2] = [include_str!("../scenes/pso-aco-1.txt"), include_str!("../scenes/pso-aco-2.txt")];

/// A point robot from the lower left to the upper right cell.
pub fn scene(text: &str) -> Query {
    let rows: Vec<&str> = text.lines().collect();
    let n = rows.len() as u32;
    let mut blocked = Bits::new(n, n);
    for (y, row) in rows.iter().rev().enumerate() {
        for (x, c) in row.bytes().enumerate() {
            blocked.set(x as u32, y as u32, c == b'#');
        }
    }
    let world = World::from_grid(Grid::new(blocked, None, 1.0, [0.0; 3]).unwrap());
    Query::new(Arc::new(world), [0.5, 0.5], [f64::from(n) - 0.5; 2])
}

/// Cell and heading; 8 at the start.
type Node = (i64, i64, usize);

const STEPS: [[i64; 2]; 8] = [[1, 0], [1, 1], [0, 1], [-1, 1], [-1, 0], [-1, -1], [0, -1], [1, -1]];

/// A path of least length and, among those, of fewest turns: labels (length in units of 1e-9 cells, turns) on (cell, heading).
pub fn least_turns(text: &str, corners: Corners) -> (Vec<Cell>, u32) {
    let rows: Vec<&[u8]> = text.lines().rev().map(str::as_bytes).collect();
    let n = rows.len() as i64;
    let free = |x: i64, y: i64| x >= 0 && y >= 0 && x < n && y < n && rows[y as usize][x as usize] == b'.';
    let goal = (n - 1, n - 1);
    let mut open: BTreeMap<(u64, u32, Node), Node> = BTreeMap::from([((0, 0, (0, 0, 8)), (0, 0, 8))]);
    let mut from: BTreeMap<Node, Node> = BTreeMap::new();
    while let Some(((length, turns, node), before)) = open.pop_first() {
        if from.contains_key(&node) {
            continue;
        }
        from.insert(node, before);
        let (x, y, heading) = node;
        if (x, y) == goal {
            let mut cells = vec![[x as u32, y as u32]];
            let mut at = node;
            while (at.0, at.1) != (0, 0) {
                at = from[&at];
                cells.push([at.0 as u32, at.1 as u32]);
            }
            cells.reverse();
            return (cells, turns);
        }
        for (way, [dx, dy]) in STEPS.into_iter().enumerate() {
            let sides = [free(x + dx, y), free(x, y + dy)].into_iter().filter(|side| *side).count();
            let needed = if dx * dy == 0 { 0 } else { [1, 2][usize::from(corners == Corners::Clear)] };
            if free(x + dx, y + dy) && sides >= needed {
                let step = if dx * dy == 0 { 1_000_000_000 } else { 1_414_213_562 };
                let turned = u32::from(heading < 8 && heading != way);
                open.insert((length + step, turns + turned, (x + dx, y + dy, way)), node);
            }
        }
    }
    panic!("no path")
}
