//! Plain relaxation over cells and headings: shares no code with the searches it checks.

use guideway::world::{Bits, Corners};

pub const WAYS: [[i64; 2]; 8] = [[0, 1], [1, 0], [0, -1], [-1, 0], [1, 1], [1, -1], [-1, -1], [-1, 1]];

/// A map for a point robot, as its text has it: first row on top.
pub struct Map {
    pub free: Vec<Vec<bool>>,
}

impl Map {
    pub fn parse(text: &str) -> Self {
        let mut free: Vec<Vec<bool>> = text.lines().map(|line| line.bytes().map(|c| c == b'.').collect()).collect();
        free.reverse();
        Self { free }
    }

    pub fn size(&self) -> [u32; 2] {
        [self.free[0].len() as u32, self.free.len() as u32]
    }

    pub fn blocked(&self) -> Bits {
        let [w, h] = self.size();
        let mut bits = Bits::new(w, h);
        for (y, row) in self.free.iter().enumerate() {
            for (x, free) in row.iter().enumerate() {
                bits.set(x as u32, y as u32, !free);
            }
        }
        bits
    }

    pub fn open(&self, x: i64, y: i64) -> bool {
        usize::try_from(y)
            .ok()
            .and_then(|y| self.free.get(y))
            .is_some_and(|row| usize::try_from(x).ok().and_then(|x| row.get(x)).copied().unwrap_or(false))
    }

    pub fn step(&self, [x, y]: [i64; 2], [dx, dy]: [i64; 2], corners: Corners) -> bool {
        let beside = usize::from(self.open(x + dx, y)) + usize::from(self.open(x, y + dy));
        let needed = match corners {
            Corners::Squeeze => 0,
            Corners::Touch => 1,
            Corners::Clear => 2,
        };
        self.open(x + dx, y + dy) && (dx == 0 || dy == 0 || beside >= needed)
    }

    /// Least (cost, turns) from cell to cell, where a step costs its length and a turn `turn`; relaxed until nothing changes.
    pub fn best(&self, start: [u32; 2], goal: [u32; 2], corners: Corners, turn: f64) -> Option<(f64, u32)> {
        let [w, h] = self.size();
        let at = |x: i64, y: i64, k: usize| ((y * i64::from(w) + x) as usize) * 8 + k;
        let (sx, sy) = (i64::from(start[0]), i64::from(start[1]));
        if !(self.open(sx, sy) && self.open(i64::from(goal[0]), i64::from(goal[1]))) {
            return None;
        }
        if start == goal {
            return Some((0.0, 0));
        }
        let mut best = vec![(f64::INFINITY, u32::MAX); (w * h * 8) as usize];
        let less = |a: (f64, u32), b: (f64, u32)| a.0 < b.0 - 1e-9 || (a.0 < b.0 + 1e-9 && a.1 < b.1);
        let mut todo = std::collections::VecDeque::from([(sx, sy, 8)]);
        while let Some((x, y, from)) = todo.pop_front() {
            let known = if from == 8 { (0.0, 0) } else { best[at(x, y, from)] };
            for (k, &[dx, dy]) in WAYS.iter().enumerate() {
                if !self.step([x, y], [dx, dy], corners) {
                    continue;
                }
                let turns = u32::from(from != 8 && from != k);
                let offer = (known.0 + ((dx * dx + dy * dy) as f64).sqrt() + turn * f64::from(turns), known.1 + turns);
                let place = at(x + dx, y + dy, k);
                if less(offer, best[place]) {
                    best[place] = offer;
                    todo.push_back((x + dx, y + dy, k));
                }
            }
        }
        let end = at(i64::from(goal[0]), i64::from(goal[1]), 0);
        best[end..end + 8].iter().copied().reduce(|a, b| if less(b, a) { b } else { a }).filter(|b| b.0.is_finite())
    }
}
