//! Every lattice path worth choosing from: the nondominated set of length, turns and clearance (and with them energy, which grows with both costs).
//!
//! For a clearance asked for, a bi-objective search gives all trades of length against turns. As less clearance is asked for, that front only gets better; where it is the
//! same for two clearances it is the same for all between. So clearances are halved between differing fronts, and the set is complete without a search
//! for each of them.

use super::clearances::Clearances;
use super::leg::{anchor, no_path, no_way};
use super::step::ways;
use super::two_costs::{Maze, Trade};
use super::{Stopped, leg};
use crate::context::{Context, Stop};
use crate::error::PlanError;
use crate::plan::front::{Alternative, Front};
use crate::plan::legs::Leg;
use crate::query::Query;
use crate::world::shape::distance;
use std::collections::{BTreeMap, VecDeque};

/// Most cells of a map for the whole set: the search keeps about 130 bytes for each.
const MAX_CELLS: u64 = 1 << 21;

/// How much work a Pareto set may cost.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Effort {
    /// Clearances for which trades are searched.
    pub searches: u32,
    /// Labels expanded in all.
    pub labels: u64,
}

impl Default for Effort {
    fn default() -> Self {
        Self { searches: 500, labels: 4_000_000 }
    }
}

/// What was found.
#[derive(Debug, Clone, PartialEq)]
pub struct Pareto {
    /// The set, shortest first.
    pub front: Front,
    /// It is the whole set; else time or effort ended first, and all that is in it are paths.
    pub complete: bool,
    /// Clearances searched.
    pub searches: u32,
    /// Labels expanded.
    pub labels: u64,
    /// Length of the ways from start and goal to their cells' centres, m.
    pub stubs: f64,
    /// Why it stopped.
    pub stop: Stop,
}

/// The nondominated lattice paths of a query from start to goal.
/// # Errors
/// [`PlanError::BadParameter`] with via points and for maps of more than 2^21 cells; else as [`crate::plan::Planner::plan`]. That time or effort ran out
/// is no error: then `complete` is false.
pub fn pareto(query: &Query, effort: Effort, ctx: &mut Context) -> Result<Pareto, PlanError> {
    query.validate()?;
    let lattice = query.world.lattice(query.radius());
    let cells = u64::from(lattice.width()) * u64::from(lattice.height());
    if !query.via.is_empty() {
        return Err(PlanError::bad("via", query.via.len(), "none: alternatives join one start and one goal"));
    }
    if cells > MAX_CELLS {
        return Err(PlanError::bad("map size", format!("{cells} cells"), format!("at most {MAX_CELLS} cells for a set of alternatives")));
    }
    let ends = [query.start, query.goal];
    let (Some(start), Some(goal)) = (anchor(query, &lattice, ends[0]), anchor(query, &lattice, ends[1])) else {
        return Err(no_path(query, false, Some("no free cell centre of the lattice is in reach of the start or the goal".into())));
    };
    let leg = Leg { query, lattice: &lattice, start, goal, ends, before: 0.0 };
    let found = Sweep::new(&leg, effort).run(ctx);
    match found.stop {
        Stop::Converged if found.front.is_empty() => Err(no_way(&leg, ctx)),
        Stop::Cancelled if found.front.is_empty() => Err(PlanError::Cancelled),
        Stop::Budget if found.front.is_empty() => Err(leg::out_of_time(query)),
        _ => Ok(found),
    }
}

/// Trades for the clearances searched so far.
struct Sweep<'a> {
    leg: &'a Leg<'a>,
    effort: Effort,
    /// Least clearance of the ways to the centres of the first and the last cell, m.
    ends: f64,
    trades: BTreeMap<u32, Vec<Trade>>,
    searches: u32,
    labels: u64,
}

impl<'a> Sweep<'a> {
    fn new(leg: &'a Leg, effort: Effort) -> Self {
        let near = |k: usize, cell| leg.query.world.segment_clearance(leg.ends[k], leg.lattice.center(cell));
        let ends = near(0, leg.start).min(near(1, leg.goal)).max(0.0);
        Self { leg, effort, ends, trades: BTreeMap::new(), searches: 0, labels: 0 }
    }

    fn run(mut self, ctx: &mut Context) -> Pareto {
        let mut stopped = None;
        let mut stop = || {
            stopped = stopped.or_else(|| ctx.poll());
            stopped.is_some()
        };
        if self.leg.start == self.leg.goal {
            let mut front = Front::default();
            front.offer(Alternative::new(vec![self.leg.start], self.ends));
            return self.result(front, Stop::Converged);
        }
        let Ok(clearances) = Clearances::of(self.leg.query, self.leg.lattice, self.ends, &mut stop) else {
            return self.result(Front::default(), stopped.unwrap_or(Stop::Budget));
        };
        let whole = self.halve(&clearances, &mut stop).is_ok();
        let mut front = Front::default();
        for trade in self.trades.values_mut().rev().flat_map(std::mem::take) {
            let clearance = clearances.along(&trade.cells).unwrap_or(self.ends);
            front.offer(Alternative::new(trade.cells, clearance));
        }
        self.result(front, if whole { Stop::Converged } else { stopped.unwrap_or(Stop::Budget) })
    }

    fn result(self, front: Front, stop: Stop) -> Pareto {
        let at = |k: usize, cell| distance(self.leg.ends[k], self.leg.lattice.center(cell));
        let stubs = at(0, self.leg.start) + at(1, self.leg.goal);
        Pareto { front, complete: stop == Stop::Converged, searches: self.searches, labels: self.labels, stubs, stop }
    }

    /// Searches for clearances between differing fronts until there are none.
    fn halve(&mut self, clearances: &Clearances, stop: &mut dyn FnMut() -> bool) -> Result<(), Stopped> {
        let beyond = clearances.values().len() as u32;
        self.trades.insert(beyond, Vec::new());
        self.search(clearances, 0, stop)?;
        let mut open = VecDeque::from([(0, beyond)]);
        while let Some((low, high)) = open.pop_front() {
            if high - low < 2 || self.same(low, high) {
                continue;
            }
            let middle = u32::midpoint(low, high);
            self.search(clearances, middle, stop)?;
            open.extend([(low, middle), (middle, high)]);
        }
        Ok(())
    }

    fn same(&self, low: u32, high: u32) -> bool {
        let costs = |rank: u32| self.trades.get(&rank).into_iter().flatten().map(|t| (t.length, t.turns));
        costs(low).eq(costs(high))
    }

    /// All trades that keep the clearance of that rank; what was found before a stop stays.
    fn search(&mut self, clearances: &Clearances, rank: u32, stop: &mut dyn FnMut() -> bool) -> Result<(), Stopped> {
        if self.searches >= self.effort.searches || self.labels >= self.effort.labels || stop() {
            return Err(Stopped);
        }
        let lattice = self.leg.lattice;
        let steps = |cell: [u32; 2]| {
            let free = lattice.free().at(cell[0], cell[1]);
            if free { clearances.wide(cell, ways(lattice, self.leg.query.corners, cell), rank) } else { 0 }
        };
        let ways = (0..lattice.height()).flat_map(|y| (0..lattice.width()).map(move |x| [x, y])).map(steps).collect();
        let maze = Maze { lattice, ways, start: self.leg.start, goal: self.leg.goal };
        let trades = maze.solve(self.effort.labels - self.labels, stop);
        self.searches += 1;
        self.labels += trades.labels;
        self.trades.insert(rank, trades.found);
        if trades.whole { Ok(()) } else { Err(Stopped) }
    }
}
