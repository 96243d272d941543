//! Exact lattice paths that are shortest and, of these, turn least; or that need the least energy.
//!
//! Shortest: A* \[hart1968\] closes every cell of every shortest path; which steps belong to one follows from exact integer costs, and the fewest
//! turns among them from one pass in the order of cost: per cell the fewest turns of a shortest path to it, and the headings with which it can be entered
//! with so few. Any other heading costs at least one turn more, no less than turning here, so it need not be kept.

use super::open::{Cost, Open};
use super::step::ways;
use super::tree::{Grown, Tree, beside, grow, price};
use super::{Ask, least_energy, leg};
use crate::context::{Context, Stop};
use crate::error::PlanError;
use crate::plan::legs;
use crate::plan::score::{Aim, Score, counts};
use crate::plan::{Planner, Solution};
use crate::query::Query;
use crate::world::{Cell, Corners, Lattice};
use serde::{Deserialize, Serialize};

/// The best lattice path between two cells.
#[derive(Debug, Clone, PartialEq)]
pub struct Optimum {
    /// All cells, start and goal included.
    pub cells: Vec<Cell>,
    /// Cost in cells (length or energy) and turns.
    pub score: Score,
    /// Steps along rows and columns.
    pub straight: u32,
    /// Diagonal steps.
    pub diagonal: u32,
    /// States expanded.
    pub expansions: u64,
}

/// The caller stopped a search.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Stopped;

/// The lattice path between two cells (start, goal) with the least cost under `aim` and, of these, the fewest turns; exact, without tolerances. `None` if a cell is blocked or
/// outside, or there is no path. `stop` is asked every few thousand expansions.
/// # Errors
/// [`Stopped`] if `stop` said so.
pub fn lexicographic(
    lattice: &Lattice,
    ends: [Cell; 2],
    corners: Corners,
    aim: Aim,
    stop: &mut dyn FnMut() -> bool,
) -> Result<Option<Optimum>, Stopped> {
    if !ends.iter().all(|&[x, y]| lattice.is_free(i64::from(x), i64::from(y))) {
        return Ok(None);
    }
    let mut ask = Ask { lattice, start: ends[0], goal: ends[1], corners, stop };
    let shortest = shortest(&mut ask)?;
    let found = match (shortest, aim) {
        (Some((cells, expansions)), Aim::LeastEnergy) => {
            let [_, _, turns] = counts(&cells);
            let (cells, more) = if turns == 0 { (cells, 0) } else { least_energy::search(&mut ask, cells, turns)? };
            Some((cells, expansions + more))
        }
        (found, _) => found,
    };
    Ok(found.map(|(cells, expansions)| {
        let [straight, diagonal, _] = counts(&cells);
        Optimum { score: aim.of_cells(&cells), cells, straight, diagonal, expansions }
    }))
}

/// All cells of a path and the states expanded; `None`: there is no path.
type Found = Option<(Vec<Cell>, u64)>;

fn shortest(ask: &mut Ask) -> Result<Found, Stopped> {
    if ask.lattice.width().max(ask.lattice.height()) < 16384
        && let Some(found) = with::<u32>(ask)?
    {
        return Ok(found);
    }
    Ok(with::<u64>(ask)?.flatten())
}

/// `None`: costs got too large.
fn with<C: Cost>(ask: &mut Ask) -> Result<Option<Found>, Stopped> {
    let mut open = ask.lattice.pool().take::<Open<C>>();
    let found = grow(ask, C::default(), &mut open).map(|grown| match grown {
        Grown::Tree(tree) => Some(Some((fewest_turns(ask, &tree), tree.expansions))),
        Grown::Exhausted => Some(None),
        Grown::Overflow => None,
    });
    ask.lattice.pool().give(open);
    found
}

/// What is known of a cell on a shortest path.
#[derive(Clone, Copy)]
struct Entry {
    /// Fewest turns of a shortest path to it.
    turns: u32,
    /// Headings, a bit each, with which it is entered with so few.
    headings: u8,
}

const UNSEEN: Entry = Entry { turns: u32::MAX, headings: 0 };

impl Entry {
    /// Turns after leaving in direction `k`.
    #[inline]
    fn leaving(self, k: usize) -> u32 {
        self.turns + u32::from(self.headings >> k & 1 == 0)
    }
}

/// The path with the fewest turns among the shortest ones.
fn fewest_turns<C: Cost>(ask: &Ask, tree: &Tree<C>) -> Vec<Cell> {
    let mut known = vec![UNSEEN; tree.open.nodes.len()];
    for id in on_shortest(ask, tree) {
        if tree.cell(id) == ask.start {
            known[id as usize] = Entry { turns: 0, headings: u8::MAX };
            continue;
        }
        let mut entry = UNSEEN;
        for (k, before) in before(ask, tree, id) {
            let turns = known[before as usize].leaving(k);
            if turns < entry.turns {
                entry = Entry { turns, headings: 0 };
            }
            entry.headings |= u8::from(turns == entry.turns) << k;
        }
        known[id as usize] = entry;
    }
    trail(ask, tree, &known)
}

/// Nodes on shortest paths in the order of their cost.
fn on_shortest<C: Cost>(ask: &Ask, tree: &Tree<C>) -> Vec<u32> {
    let mut seen = vec![false; tree.open.nodes.len()];
    let mut found: Vec<u32> = tree.at(ask.goal).map(|(id, _)| id).into_iter().collect();
    for &id in &found {
        seen[id as usize] = true;
    }
    let mut next = 0;
    while let Some(&id) = found.get(next) {
        next += 1;
        for (_, before) in before(ask, tree, id) {
            if !std::mem::replace(&mut seen[before as usize], true) {
                found.push(before);
            }
        }
    }
    found.sort_unstable_by_key(|&id| (tree.open.nodes[id as usize].g, id));
    found
}

/// Last steps of the shortest paths to a node: the heading and the node before.
fn before<'a, C: Cost>(ask: &Ask<'a, '_>, tree: &'a Tree<C>, id: u32) -> impl Iterator<Item = (usize, u32)> + use<'a, C> {
    let (cell, g) = (tree.cell(id), tree.open.nodes[id as usize].g);
    let back = ways(ask.lattice, ask.corners, cell);
    (0..8).filter(move |k| back >> (k ^ 4) & 1 != 0).filter_map(move |k| {
        let (before, node) = tree.at(beside(cell, k ^ 4))?;
        (node.g + price(k) == g).then_some((k, before))
    })
}

/// Back from the goal, straight on wherever that costs no turn.
fn trail<C: Cost>(ask: &Ask, tree: &Tree<C>, known: &[Entry]) -> Vec<Cell> {
    let (mut cell, mut heading) = (ask.goal, None);
    let mut cells = vec![cell];
    while cell != ask.start {
        let headings = tree.at(cell).map_or(0, |(id, _)| known[id as usize].headings);
        let k = heading.filter(|k| headings >> k & 1 != 0).unwrap_or(headings.trailing_zeros() as usize & 7);
        heading = Some(k);
        cell = beside(cell, k ^ 4);
        cells.push(cell);
    }
    cells.reverse();
    cells
}

/// Exact lattice path: shortest with the fewest turns, or of the least energy where the query's material is heavy; each leg by itself.
///
/// Source: \[hart1968\]; ours in the bookkeeping of headings.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Lexicographic {}

impl Planner for Lexicographic {
    fn plan(&self, query: &Query, ctx: &mut Context) -> Result<Solution, PlanError> {
        let aim = Aim::of(query.material);
        let mut expansions = 0;
        let route = legs::plan(query, ctx, |leg, ctx| {
            let found = solve(leg, aim, ctx)?;
            expansions += found.expansions;
            Ok(found.cells)
        })?;
        let found = Solution::of_search(route.path(), route.length, expansions, ctx);
        Ok(Solution { cells: Some(route.cells), ..found })
    }
}

/// One leg, or why there is none.
pub(super) fn solve(asked: &legs::Leg, aim: Aim, ctx: &mut Context) -> Result<Optimum, PlanError> {
    let mut stopped = None;
    let mut stop = || {
        stopped = ctx.poll();
        stopped.is_some()
    };
    match lexicographic(asked.lattice, [asked.start, asked.goal], asked.query.corners, aim, &mut stop) {
        Ok(Some(found)) => Ok(found),
        Ok(None) => Err(leg::no_way(asked, ctx)),
        Err(Stopped) if stopped == Some(Stop::Cancelled) => Err(PlanError::Cancelled),
        Err(Stopped) => Err(leg::out_of_time(asked.query)),
    }
}

/// Times that a reference may ask for the time before it is given up: so many thousand expansions, the same on every machine.
const PATIENCE: u32 = 2000;

/// What lattice planners are measured against beside the shortest length: the path of a query that is best under `aim`, or `None` where it has via points (turns at them belong to
/// two legs), there is no path, or the search would take more than some million expansions.
/// # Errors
/// Those of [`Query::validate`], and [`PlanError::Cancelled`].
pub fn grid_best(query: &Query, aim: Aim, ctx: &mut Context) -> Result<Option<Solution>, PlanError> {
    if !query.via.is_empty() {
        return Ok(None);
    }
    let mut expansions = 0;
    let route = legs::plan(query, ctx, |leg, ctx| {
        let (mut asked, mut cancelled) = (0, false);
        let mut stop = || {
            asked += 1;
            cancelled = ctx.poll() == Some(Stop::Cancelled);
            cancelled || asked > PATIENCE
        };
        let found = lexicographic(leg.lattice, [leg.start, leg.goal], query.corners, aim, &mut stop);
        if cancelled {
            return Err(PlanError::Cancelled);
        }
        let found = found.ok().flatten().ok_or_else(|| leg::out_of_time(query))?;
        expansions += found.expansions;
        Ok(found.cells)
    });
    match route {
        Ok(route) => {
            let found = Solution::of_search(route.path(), route.length, expansions, ctx);
            Ok(Some(Solution { cells: Some(route.cells), ..found }))
        }
        Err(PlanError::NoPath(_)) => Ok(None),
        Err(other) => Err(other),
    }
}

/// The exact path of a query, if `found` costs more than it under the aim of the query's material, or nothing was found: the fallback of heuristic lattice
/// planners. `None`: `found` is as good.
/// # Errors
/// As [`Planner::plan`].
pub fn exact_instead(query: &Query, found: Option<&Solution>, ctx: &mut Context) -> Result<Option<Solution>, PlanError> {
    let exact = Lexicographic {}.plan(query, ctx)?;
    let cost = |solution: &Solution| solution.cells.as_ref().map(|cells| Aim::of(query.material).of_cells(cells).cost);
    Ok(match found.and_then(cost) {
        Some(known) if cost(&exact).is_none_or(|best| best >= known) => None,
        _ => Some(exact),
    })
}
