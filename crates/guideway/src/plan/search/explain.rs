//! Why there is no path: a proof, the widest disc that would pass, and the narrowest place of its way.

use super::bottleneck::{Bottleneck, Widest};
use super::visibility::{Leg, Route};
use crate::Point;
use crate::context::Context;
use crate::error::NoPath;
use crate::query::Query;
use crate::world::{Bits, Footprint, World};

/// Circles and expansions of the exact searches that sharpen the widest radius.
const EFFORT: u64 = 20_000;
/// The widest radius is found at least as sharp as that, cells.
const FINE: f64 = 1.0 / 60.0;

/// Proves that no path exists, if that is so, and finds the widest disc that would pass.
///
/// `widest` passes for certain; no disc wider by more than a sixtieth of a cell (and mostly far less) does, unless the budget of `ctx` ends first. `None`: the ends are not connected for any
/// disc. `proved` is false where a path for the query's disc exists after all, where the answer depends on the heading of a footprint that is not a disc, or
/// where the budget of `ctx` was spent before (`reason` tells). Cost: seconds at most on maps of some million cells.
pub fn explain(query: &Query, ctx: &mut Context) -> NoPath {
    let mut answer = NoPath { needed: query.radius(), ..NoPath::default() };
    // What fits in every heading at least; for discs both are the same.
    let least = query.footprint.inscribed() + query.clearance;
    let mut narrowest: Option<Bottleneck> = None;
    for ends in query.stops().windows(2) {
        let ends = [ends[0], ends[1]];
        let upper = if connected(&query.world, ends) {
            Widest::new(&query.world, ends).and_then(|mut w| Some((w.solve(&mut || ctx.poll().is_some())?, w.tolerance())))
        } else {
            None
        };
        let Some((upper, tolerance)) = upper else {
            return NoPath { proved: true, ..answer };
        };
        let found = Bottleneck { radius: sharpen(query, ends, (upper.radius, tolerance), ctx), ..upper };
        answer.proved |= upper.radius < least || found.radius < least && !passes(query, ends, least, ctx).0;
        if narrowest.is_none_or(|n| found.radius < n.radius) {
            narrowest = Some(found);
        }
    }
    answer.widest = narrowest.map(|n| n.radius);
    answer.narrowest = narrowest.map(|n| n.place);
    if ctx.poll().is_some() {
        answer.proved = false;
        answer.reason = Some("the budget of time was spent before a proof".into());
    } else if !answer.proved {
        let fits = narrowest.is_some_and(|n| n.radius >= query.radius());
        let reason = if fits {
            "a path for the circumscribed disc exists; the visibility planner finds it"
        } else {
            "the circumscribed disc cannot pass; a planner that minds the heading of the footprint still might"
        };
        answer.reason = Some(reason.into());
    }
    answer
}

/// Are the ends connected by free cells that share edges? No disc of any positive radius passes otherwise. True without a grid.
fn connected(world: &World, ends: [Point; 2]) -> bool {
    let Some(grid) = world.grid() else { return true };
    let (Some(start), Some(goal)) = (grid.cell_at(ends[0]), grid.cell_at(ends[1])) else { return false };
    let mut seen = Bits::new(grid.width(), grid.height());
    let mut todo = vec![start];
    seen.set(start[0], start[1], true);
    while let Some(cell) = todo.pop() {
        if cell == goal {
            return true;
        }
        for (dx, dy) in [(-1, 0), (1, 0), (0, -1), (0, 1)] {
            let (Some(x), Some(y)) = (cell[0].checked_add_signed(dx), cell[1].checked_add_signed(dy)) else { continue };
            if x < grid.width() && y < grid.height() && !seen.at(x, y) && !grid.blocked().at(x, y) {
                seen.set(x, y, true);
                todo.push([x, y]);
            }
        }
    }
    false
}

/// Does a disc of that radius pass, by the exact planner? And the circles and expansions it took. False if it was stopped.
fn passes(query: &Query, ends: [Point; 2], radius: f64, ctx: &mut Context) -> (bool, u64) {
    let disc = Query { footprint: Footprint::Disc(radius), clearance: 0.0, ..query.clone() };
    let mut leg = Leg::new(&disc);
    let passed = matches!(leg.solve(ends, ctx), Route::Path { .. });
    (passed, leg.expansions + leg.circles)
}

/// The largest radius that is proved to pass, less than [`FINE`] cells below one that is proved not to.
fn sharpen(query: &Query, ends: [Point; 2], (upper, tolerance): (f64, f64), ctx: &mut Context) -> f64 {
    let (mut low, mut high, mut step, mut effort) = (0.0, upper, 1.5 * tolerance, 0);
    let fine = FINE * query.world.resolution();
    // Down in growing steps until one passes, then halving while that is cheap or still coarse.
    while high - low > 1e-7 * upper && !(high - low <= fine && (low == 0.0 || effort > EFFORT)) && ctx.poll().is_none() {
        let middle = if low == 0.0 && upper > step { upper - step } else { f64::midpoint(low, high) };
        let (passed, expansions) = passes(query, ends, middle, ctx);
        effort += expansions;
        if passed {
            low = middle;
        } else {
            high = middle;
            step *= 3.0;
        }
    }
    low
}

#[cfg(test)]
mod tests;
