//! Exact lattice paths under soft clearance: the length weighed by how near obstacles are ([`Soft::price`]).
//!
//! A step costs its length times the mean price of its two cells, whose clearance is exact. No metre costs less than 1, so the octile distance
//! never overestimates. Of equal estimates the cell with the lower index goes first.

use super::leg::{no_way, out_of_time};
use super::step::{DIRECTIONS, ways};
use crate::context::{Context, Stop};
use crate::error::PlanError;
use crate::plan::Solution;
use crate::plan::legs::{self, Leg};
use crate::query::{Query, Soft};
use crate::world::{Cell, ClearanceField, shape};
use serde_json::json;
use std::cmp::Ordering;
use std::collections::BinaryHeap;
use std::f64::consts::SQRT_2;
use std::sync::Arc;

/// Expansions between two looks at the budget.
const POLL: u64 = 1024;

/// Plans a query leg by leg, with the octile distance ahead or without.
pub(super) fn plan(soft: Soft, informed: bool, query: &Query, ctx: &mut Context) -> Result<Solution, PlanError> {
    let field = query.world.clearance_field();
    let (mut cost, mut expansions) = (0.0, 0);
    let route = legs::plan(query, ctx, |leg, ctx| {
        let mut search = Search::new(soft, &field, leg);
        let cells = search.run(informed, ctx)?;
        let stub = |k: usize, cell: Cell| shape::distance(leg.ends[k], leg.lattice.center(cell)) * search.price(cell);
        cost += search.least[search.index(leg.goal)] * leg.lattice.resolution() + stub(0, leg.start) + stub(1, leg.goal);
        expansions += search.expansions;
        Ok(cells)
    })?;
    let found = Solution::of_search(route.path(), cost, expansions, ctx);
    let trace = json!({ "soft_clearance": { "clearance": soft.clearance, "weight": soft.weight } });
    Ok(Solution { cells: Some(route.cells), trace, ..found })
}

/// A cell that waits, the least estimate first.
#[derive(PartialEq)]
struct Node {
    estimate: f64,
    at: usize,
}

impl Eq for Node {}

impl PartialOrd for Node {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Node {
    fn cmp(&self, other: &Self) -> Ordering {
        other.estimate.total_cmp(&self.estimate).then(other.at.cmp(&self.at))
    }
}

struct Search<'a> {
    soft: Soft,
    field: &'a Arc<ClearanceField>,
    leg: &'a Leg<'a>,
    /// Least known cost from the start, cells of open ground.
    least: Vec<f64>,
    /// Direction of the step that led there.
    from: Vec<u8>,
    closed: Vec<bool>,
    expansions: u64,
}

impl<'a> Search<'a> {
    fn new(soft: Soft, field: &'a Arc<ClearanceField>, leg: &'a Leg<'a>) -> Self {
        let cells = leg.lattice.width() as usize * leg.lattice.height() as usize;
        Self { soft, field, leg, least: vec![f64::INFINITY; cells], from: vec![0; cells], closed: vec![false; cells], expansions: 0 }
    }

    fn index(&self, [x, y]: Cell) -> usize {
        y as usize * self.leg.lattice.width() as usize + x as usize
    }

    fn cell(&self, at: usize) -> Cell {
        let width = self.leg.lattice.width() as usize;
        [(at % width) as u32, (at / width) as u32]
    }

    fn price(&self, cell: Cell) -> f64 {
        self.soft.price(self.field.at(cell) - self.leg.lattice.radius())
    }

    /// The cells of a cheapest path, start and goal included.
    fn run(&mut self, informed: bool, ctx: &mut Context) -> Result<Vec<Cell>, PlanError> {
        let (start, goal) = (self.index(self.leg.start), self.index(self.leg.goal));
        let mut open = BinaryHeap::from([Node { estimate: 0.0, at: start }]);
        self.least[start] = 0.0;
        while let Some(Node { at, .. }) = open.pop() {
            if std::mem::replace(&mut self.closed[at], true) {
                continue;
            }
            if at == goal {
                return Ok(self.way(start, goal));
            }
            self.expansions += 1;
            if self.expansions.is_multiple_of(POLL) {
                match ctx.poll() {
                    Some(Stop::Cancelled) => return Err(PlanError::Cancelled),
                    Some(_) => return Err(out_of_time(self.leg.query)),
                    None => {}
                }
            }
            self.expand(at, informed, &mut open);
        }
        Err(no_way(self.leg, ctx))
    }

    fn expand(&mut self, at: usize, informed: bool, open: &mut BinaryHeap<Node>) {
        let cell = self.cell(at);
        let (allowed, price) = (ways(self.leg.lattice, self.leg.query.corners, cell), self.price(cell));
        for (k, [dx, dy]) in DIRECTIONS.into_iter().enumerate().filter(|(k, _)| allowed >> k & 1 == 1) {
            let next = [cell[0].wrapping_add_signed(dx), cell[1].wrapping_add_signed(dy)];
            let to = self.index(next);
            let length = if k % 2 == 0 { 1.0 } else { SQRT_2 };
            let cost = self.least[at] + length * f64::midpoint(price, self.price(next));
            if cost < self.least[to] {
                (self.least[to], self.from[to]) = (cost, k as u8);
                let left = if informed { octile(next, self.leg.goal) } else { 0.0 };
                open.push(Node { estimate: cost + left, at: to });
            }
        }
    }

    fn way(&self, start: usize, goal: usize) -> Vec<Cell> {
        let (mut cells, mut at) = (vec![self.cell(goal)], goal);
        while at != start {
            let [dx, dy] = DIRECTIONS[self.from[at] as usize];
            let [x, y] = self.cell(at);
            let before = [x.wrapping_add_signed(-dx), y.wrapping_add_signed(-dy)];
            at = self.index(before);
            cells.push(before);
        }
        cells.reverse();
        cells
    }
}

/// Length of the shortest path on an open lattice, cells.
fn octile(a: Cell, b: Cell) -> f64 {
    let (dx, dy) = (f64::from(a[0].abs_diff(b[0])), f64::from(a[1].abs_diff(b[1])));
    dx.max(dy) + (SQRT_2 - 1.0) * dx.min(dy)
}

#[cfg(test)]
mod tests {
    use crate::context::Context;
    use crate::plan::Planner;
    use crate::plan::search::{AStar, Dijkstra};
    use crate::query::{Query, Soft};
    use crate::refine::{Refiner, Simplify, Smooth};
    use crate::world::{Bits, Grid, World};
    use rand::RngExt;
    use rand_chacha::ChaCha8Rng;
    use rand_chacha::rand_core::SeedableRng;
    use std::sync::Arc;

    fn query(blocked: &Bits, [start, goal]: [[f64; 2]; 2], soft: Option<Soft>) -> Query {
        let world = Arc::new(World::from_grid(Grid::new(blocked.clone(), None, 1.0, [0.0; 3]).unwrap()));
        Query { soft, ..Query::new(world, start, goal) }
    }

    /// By relaxing every step until nothing falls any more.
    fn cheapest(query: &Query, soft: Soft) -> f64 {
        let (lattice, field) = (query.world.lattice(0.0), query.world.clearance_field());
        let (w, h) = (lattice.width(), lattice.height());
        let price = |c: [u32; 2]| soft.price(field.at(c));
        let mut least = vec![f64::INFINITY; (w * h) as usize];
        let at = |p: [f64; 2]| lattice.cell_at(p).unwrap();
        let place = |c: [u32; 2]| (c[1] * w + c[0]) as usize;
        least[place(at(query.start))] = 0.0;
        loop {
            let before = least.clone();
            for (x, y) in (0..h).flat_map(|y| (0..w).map(move |x| (x, y))).filter(|&(x, y)| lattice.is_free(x.into(), y.into())) {
                for (dx, dy) in (-1..=1).flat_map(|dy| (-1..=1).map(move |dx| (dx, dy))).filter(|d| *d != (0, 0)) {
                    if lattice.step_free([x, y], dx, dy, query.corners) {
                        let next = [(i64::from(x) + dx) as u32, (i64::from(y) + dy) as u32];
                        let cost = least[place([x, y])] + (dx as f64).hypot(dy as f64) * 0.5 * (price([x, y]) + price(next));
                        least[place(next)] = least[place(next)].min(cost);
                    }
                }
            }
            if before == least {
                return least[place(at(query.goal))];
            }
        }
    }

    #[test]
    fn both_searches_find_the_cheapest_path() {
        let mut rng = ChaCha8Rng::seed_from_u64(5);
        for _ in 0..40 {
            let mut bits = Bits::new(14, 11);
            (0..30).for_each(|_| bits.set(rng.random_range(1..13), rng.random_range(0..11), true));
            let soft = Soft { clearance: rng.random_range(0.5..4.0), weight: rng.random_range(0.0..6.0) };
            bits.set(0, 0, false);
            let asked = query(&bits, [[0.5, 0.5], [13.5, 10.5]], Some(soft));
            let truth = cheapest(&asked, soft);
            for planner in [&AStar {} as &dyn Planner, &Dijkstra {}] {
                match planner.plan(&asked, &mut Context::new(0)) {
                    Ok(found) => assert!((found.cost - truth).abs() < 1e-9 && found.length() <= found.cost + 1e-9, "{} {truth}", found.cost),
                    Err(error) => assert!(truth.is_infinite() && error.name() == "NoPath"),
                }
            }
        }
    }

    #[test]
    fn refined_ways_keep_off_too() {
        // A block beside the straight line: the shortest way touches it.
        let mut bits = Bits::new(40, 21);
        (15..25).for_each(|x| (0..10).for_each(|y| bits.set(x, y, true)));
        let ends = [[1.5, 10.5], [38.5, 10.5]];
        let least = |soft: Option<Soft>, refiner: &dyn Refiner| {
            let asked = query(&bits, ends, soft);
            let found = AStar {}.plan(&asked, &mut Context::new(0)).unwrap();
            let path = refiner.refine(&found.path, &asked, &mut Context::new(0)).unwrap().path;
            (0..=1000)
                .map(|k| path.eval(path.length() * f64::from(k) / 1000.0, 0)[0].clone())
                .map(|p| asked.world.clearance([p[0], p[1]]))
                .fold(9.0, f64::min)
        };
        let soft = Some(Soft { clearance: 4.0, weight: 4.0 });
        for refiner in [&Simplify::default() as &dyn Refiner, &Smooth::default()] {
            assert!(least(None, refiner) < 0.6 && least(soft, refiner) > 2.5, "{} {}", least(None, refiner), least(soft, refiner));
        }
    }
}
