//! Exact searches on the legs of a query, with budget and cancel; the ends of legs; and how it is reported that there is no path.

use super::{Ask, End, jump, step};
use crate::Point;
use crate::context::{Context, Stop};
use crate::error::{NoPath, PlanError};
use crate::plan::Solution;
use crate::plan::legs::{self, Leg};
use crate::query::Query;
use crate::world::{Cell, Corners, Lattice, shape};
use serde_json::{Value, json};

/// Which exact search to run. All find paths of the same cost.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Engine {
    /// Uninformed.
    Dijkstra,
    /// With the octile heuristic.
    AStar,
    /// Jump points; A* where the lattice has corners that are closed by the robot's radius and the rule lets paths pass them.
    JumpPoint,
}

impl Engine {
    /// The engine that really runs. Jump points need the step rule to follow from free cells alone.
    fn on(self, lattice: &Lattice, corners: Corners) -> Self {
        if self == Self::JumpPoint && !lattice.plain(corners) { Self::AStar } else { self }
    }

    fn name(self) -> &'static str {
        match self {
            Self::Dijkstra => "dijkstra",
            Self::AStar => "astar",
            Self::JumpPoint => "jump-point",
        }
    }
}

/// Runs one search with 32-bit costs and again with 64-bit costs where those do not suffice. Leaves turning points (or all cells) in `out`.
pub(super) fn run(engine: Engine, ask: &mut Ask, out: &mut Vec<Cell>) -> End {
    let engine = engine.on(ask.lattice, ask.corners);
    if ask.lattice.width().max(ask.lattice.height()) < 16384 {
        let end = with::<u32>(engine, ask, out);
        if !matches!(end, End::Overflow) {
            return end;
        }
    }
    with::<u64>(engine, ask, out)
}

fn with<C: super::open::Cost>(engine: Engine, ask: &mut Ask, out: &mut Vec<Cell>) -> End {
    match engine {
        Engine::Dijkstra => step::search::<C, false>(ask, out),
        Engine::AStar => step::search::<C, true>(ask, out),
        Engine::JumpPoint => jump::search::<C>(ask, out),
    }
}

/// The shortest lattice path for a query: the reference of every lattice planner.
/// # Errors
/// As [`crate::plan::Planner::plan`].
pub fn grid_optimum(query: &Query, ctx: &mut Context) -> Result<Solution, PlanError> {
    plan(Engine::JumpPoint, query, ctx)
}

/// Plans a query leg by leg; by price where it asks for soft clearance.
pub(super) fn plan(engine: Engine, query: &Query, ctx: &mut Context) -> Result<Solution, PlanError> {
    if let Some(soft) = query.soft.filter(|_| engine != Engine::JumpPoint) {
        return super::soft::plan(soft, engine == Engine::AStar, query, ctx);
    }
    let (mut expansions, mut runs) = (0, engine);
    let route = legs::plan(query, ctx, |leg, ctx| {
        runs = engine.on(leg.lattice, query.corners);
        let (cells, count) = search(engine, leg, ctx)?;
        expansions += count;
        Ok(cells)
    })?;
    let trace = if runs == engine { Value::Null } else { json!({ "engine": runs.name() }) };
    let found = Solution::of_search(route.path(), route.length, expansions, ctx);
    Ok(Solution { cells: Some(route.cells), trace, ..found })
}

/// One leg: the turning points (or all cells) of a shortest path, and the nodes expanded. Also the proof that there is none.
pub(in crate::plan) fn search(engine: Engine, leg: &Leg, ctx: &mut Context) -> Result<(Vec<Cell>, u64), PlanError> {
    let (query, mut found, mut stopped) = (leg.query, Vec::new(), None);
    let mut stop = || {
        stopped = ctx.poll();
        stopped.is_some()
    };
    let mut ask = Ask { lattice: leg.lattice, start: leg.start, goal: leg.goal, corners: query.corners, stop: &mut stop };
    match run(engine, &mut ask, &mut found) {
        End::Found(steps) => Ok((found, steps.expansions)),
        End::Exhausted => Err(no_way(leg, ctx)),
        End::Stopped if stopped == Some(Stop::Cancelled) => Err(PlanError::Cancelled),
        End::Stopped => Err(out_of_time(query)),
        End::Overflow => Err(no_path(query, false, Some("the path is too long for exact costs".into()))),
    }
}

/// A leg that has no path on the lattice, explained.
pub(super) fn no_way(leg: &Leg, ctx: &mut Context) -> PlanError {
    let own = in_own_cells(leg.lattice, [(leg.ends[0], leg.start), (leg.ends[1], leg.goal)]);
    no_lattice_path(leg.query, own, ctx)
}

/// A search that ended with its budget of time.
pub(super) fn out_of_time(query: &Query) -> PlanError {
    no_path(query, false, Some("the budget of time was spent".into()))
}

/// The free cell that a search begins or ends at: the own cell of `p`, or the one with the nearest centre that can be reached from it in a straight
/// line, up to two cells or the robot's radius away.
pub(in crate::plan) fn anchor(query: &Query, lattice: &Lattice, p: Point) -> Option<Cell> {
    let own = lattice.cell_at(p)?;
    let reach = |c: Cell| {
        let center = lattice.center(c);
        lattice.free().at(c[0], c[1]) && (center == p || query.world.segment_free(p, center, lattice.radius()))
    };
    if reach(own) {
        return Some(own);
    }
    let rings = (lattice.radius() / lattice.resolution()).ceil().clamp(2.0, f64::from(lattice.width().max(lattice.height()))) as u32;
    let mut best: Option<(f64, Cell)> = None;
    for ring in 1..=rings {
        // Centres of this ring are no nearer than that.
        if best.is_some_and(|(d, _)| d <= (f64::from(ring) - 0.5) * lattice.resolution()) {
            break;
        }
        for cell in ring_around(lattice, own, ring) {
            let d = shape::distance(lattice.center(cell), p);
            if best.is_none_or(|(least, _)| d < least) && reach(cell) {
                best = Some((d, cell));
            }
        }
    }
    best.map(|(_, cell)| cell)
}

/// Cells of the lattice that are `ring` > 0 columns or rows away from a cell, and no more.
fn ring_around(lattice: &Lattice, [x, y]: Cell, ring: u32) -> impl Iterator<Item = Cell> {
    let (w, h) = (lattice.width(), lattice.height());
    (y.saturating_sub(ring)..=(y + ring).min(h - 1)).flat_map(move |cy| {
        let step = if cy.abs_diff(y) == ring { 1 } else { 2 * ring };
        let sides = (i64::from(x) - i64::from(ring)..=i64::from(x) + i64::from(ring)).step_by(step as usize);
        sides.filter_map(move |cx| u32::try_from(cx).ok().filter(|&cx| cx < w).map(|cx| [cx, cy]))
    })
}

/// Is each point anchored in its own cell? Only then does a search from the anchors speak for the points.
pub(super) fn in_own_cells(lattice: &Lattice, ends: [(Point, Cell); 2]) -> bool {
    ends.iter().all(|&(p, cell)| lattice.cell_at(p) == Some(cell))
}

/// No path on the lattice, explained, and proved if the search began and ended in the points' own cells. A way between its cell centres may exist.
pub(super) fn no_lattice_path(query: &Query, own: bool, ctx: &mut Context) -> PlanError {
    let mut why = super::explain(query, ctx);
    if !why.proved {
        let more = why.reason.map(|r| format!(" ({r})")).unwrap_or_default();
        why.reason = Some(format!("no chain of neighbouring cell centres joins start and goal{more}"));
    }
    why.proved |= own;
    PlanError::NoPath(Box::new(why))
}

/// The one place where a lattice search reports that there is no path.
pub(in crate::plan) fn no_path(query: &Query, proved: bool, reason: Option<String>) -> PlanError {
    PlanError::NoPath(Box::new(NoPath { proved, needed: query.radius(), reason, ..NoPath::default() }))
}
