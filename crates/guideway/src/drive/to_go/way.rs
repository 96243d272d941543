//! The way down a field of costs.

use super::CostToGo;
use crate::Point;
use crate::world::shape::norm;

/// Cost of a cell's width where a way begins or ends in a cell that is not free.
const STRAY: f64 = 10.0;
/// Steps of a way: a cell's neighbours and those of a knight, with what must be free beside them.
const STEPS: [[i64; 2]; 16] =
    [[1, 0], [1, 1], [0, 1], [-1, 1], [-1, 0], [-1, -1], [0, -1], [1, -1], [2, 1], [1, 2], [-1, 2], [-2, 1], [-2, -1], [-1, -2], [1, -2], [2, -1]];

impl CostToGo {
    /// The cheapest way from `from` to the goal, both included, m; `None` where there is none. Every straight part leads over cells where the body fits.
    pub fn way(&self, from: Point) -> Option<Vec<Point>> {
        let mut at = self.entry(from)?;
        let mut points = vec![from];
        while self.cost[at] > 0.0 {
            points.push(self.frame.center(at));
            let Some(next) = self.down(at) else { break };
            at = next;
        }
        let end = points.len() - 1;
        if end > 0 && self.frame.at(points[end]) == self.frame.at(self.goal) {
            points[end] = self.goal;
        } else {
            points.push(self.goal);
        }
        Some(self.pulled(&points))
    }

    /// The cell at a place if the body fits there, else the cheapest beside it; none if the goal cannot be reached from it.
    fn entry(&self, p: Point) -> Option<usize> {
        let [x, y] = self.frame.cells(p);
        if let Some(own) = self.frame.at(p).filter(|&i| self.slow[i].is_finite()) {
            return self.cost[own].is_finite().then_some(own);
        }
        let (x, y) = (x.floor() as i64, y.floor() as i64);
        let around = (-1..=1).flat_map(|dy| (-1..=1).map(move |dx| (x.saturating_add(dx), y.saturating_add(dy))));
        around.filter_map(|(x, y)| self.inside(x, y)).filter(|&i| self.cost[i].is_finite()).min_by(|a, b| self.cost[*a].total_cmp(&self.cost[*b]))
    }

    /// The neighbour down the steepest slope.
    fn down(&self, at: usize) -> Option<usize> {
        let mut best: Option<(f32, usize)> = None;
        for step in STEPS {
            let Some(next) = self.step(at, step) else { continue };
            let slope = (self.cost[at] - self.cost[next]) / (step[0] as f32).hypot(step[1] as f32);
            if slope > best.map_or(0.0, |b| b.0) {
                best = Some((slope, next));
            }
        }
        best.map(|b| b.1)
    }

    /// Where a step leads if the cells it passes are free.
    pub(super) fn step(&self, at: usize, [dx, dy]: [i64; 2]) -> Option<usize> {
        let stride = self.frame.stride() as i64;
        let go = |x: i64, y: i64| at as i64 + y * stride + x;
        // Cells between: halfway in each direction, rounded both ways.
        let (hx, hy) = (dx.signum(), dy.signum());
        let beside: [[i64; 2]; 2] = match (dx.abs(), dy.abs()) {
            (1, 1) => [[dx, 0], [0, dy]],
            (2, 1) => [[hx, 0], [hx, hy]],
            (1, 2) => [[0, hy], [hx, hy]],
            _ => [[0, 0]; 2],
        };
        let end = go(dx, dy);
        // The frame is one cell wide: its neighbours on the far side are no cells.
        let free = |i: i64| usize::try_from(i).ok().and_then(|i| self.slow.get(i)).is_some_and(|f| f.is_finite());
        (beside.iter().all(|s| free(go(s[0], s[1]))) && free(end)).then_some(end as usize)
    }

    /// The way with straight parts in place of corners where that costs no more.
    fn pulled(&self, points: &[Point]) -> Vec<Point> {
        let mut costs = vec![0.0; points.len()];
        for i in 1..points.len() {
            costs[i] = costs[i - 1] + self.along(points[i - 1], points[i]);
        }
        let (mut out, mut i) = (vec![points[0]], 0);
        while i + 1 < points.len() {
            // Doubling, then bisection: the farthest of the tried ones that a straight part reaches for no more.
            let fits = |k: usize| self.along(points[i], points[k]) <= (costs[k] - costs[i]) * (1.0 + 1e-9) + 1e-9;
            let (mut good, mut step) = (i + 1, 1);
            while i + 2 * step < points.len() && fits(i + 2 * step) {
                step *= 2;
                good = i + step;
            }
            let mut bad = (i + 2 * step).min(points.len());
            while good + 1 < bad {
                let middle = good.midpoint(bad);
                if fits(middle) { good = middle } else { bad = middle }
            }
            out.push(points[good]);
            i = good;
        }
        out
    }

    /// Cost of a straight part, cells: the sum over the cells it passes. Infinite where it leaves the free cells; those of its ends pass at [`STRAY`].
    pub(super) fn along(&self, a: Point, b: Point) -> f64 {
        let (p, q) = (self.frame.cells(a), self.frame.cells(b));
        let d = [q[0] - p[0], q[1] - p[1]];
        let length = norm(d);
        let (mut cell, last) = (p.map(|v| v.floor() as i64), q.map(|v| v.floor() as i64));
        let mut next = [0, 1].map(|k| if d[k] == 0.0 { f64::INFINITY } else { (cell[k] as f64 + f64::from(u8::from(d[k] > 0.0)) - p[k]) / d[k] });
        let (mut at, mut sum) = (0.0, 0.0);
        let most = (last[0] - cell[0]).abs() + (last[1] - cell[1]).abs();
        let ends = [self.frame.at(a), self.frame.at(b)];
        for _ in 0..=most {
            let k = usize::from(next[1] < next[0]);
            let until = next[k].clamp(at, 1.0);
            let index = self.inside(cell[0], cell[1]);
            let cost = index.map_or(f64::INFINITY, |i| f64::from(self.slow[i]));
            let cost = if cost.is_infinite() && (index.is_none() || ends.contains(&index)) { STRAY } else { cost };
            if cost.is_infinite() {
                return cost;
            }
            sum += cost * (until - at);
            (at, cell[k]) = (until, cell[k] + if d[k] > 0.0 { 1 } else { -1 });
            next[k] += 1.0 / d[k].abs();
        }
        sum * length
    }

    /// The padded index of a cell, if it is one.
    fn inside(&self, x: i64, y: i64) -> Option<usize> {
        let [w, h] = self.frame.size.map(|n| n as i64);
        (x >= 0 && y >= 0 && x < w && y < h).then(|| self.frame.index(x, y))
    }
}
