//! Homotopy classes: the different ways past the obstacles, each with its shortest path.
//!
//! Paths with the same ends belong to one class if one can be deformed into the other without crossing an obstacle, that is, if they pass obstacles on the
//! same sides in the same order (`rays.rs`). The shortest path of a class is taut: tangents and arcs around inflated obstacles. One search finds them all in
//! order of length (`search/visibility/classes.rs`); sources: \[bhattacharya2012\], tangents as in the exact planner.
//! With via points a class is one choice of class for each leg.

pub(in crate::plan) mod rays;

use super::search::{Classes, ExactLeg, Inflated, Route, Taut, explain, no_path};
use crate::Point;
use crate::context::{Context, Stop};
use crate::error::PlanError;
use crate::query::Query;
use crate::world::shape::distance;
use rays::Rays;

/// Bounds on the length that are tried in turn, relative to the shortest path.
const GROWTH: [f64; 3] = [1.1, 1.4, 2.0];
/// Expansions after which the search for further classes of a leg ends.
const EFFORT: u64 = 20_000;

/// A homotopy class.
#[derive(Debug, Clone, PartialEq)]
pub struct Class {
    /// Its shortest path as a polyline from start to goal, m, longer than `length` by less than 1e-6 of it.
    pub points: Vec<Point>,
    /// Exact length of the shortest path, m.
    pub length: f64,
    /// Which rays above obstacles it crosses: numbers of obstacles, from left to right, negative from right to left; legs are set apart by `|`.
    pub signature: String,
}

/// The shortest paths of up to `k` homotopy classes for the query's disc, shortest first; the first is the shortest path of all.
///
/// Classes whose shortest path is more than twice as long as the shortest one are left out. The work is bounded: on crowded maps there may be fewer.
/// # Errors
/// Those of [`Query::validate`], [`PlanError::NoPath`] (proved, or because the budget of time is spent), [`PlanError::Cancelled`].
pub fn classes(query: &Query, k: usize, ctx: &mut Context) -> Result<Vec<Class>, PlanError> {
    Ok(atlas(query, k, ctx)?.classes)
}

/// The classes of a query, and what tells the class of any other path.
pub(in crate::plan) struct Atlas {
    pub classes: Vec<Class>,
    via: Vec<Point>,
    legs: Vec<Rays>,
}

impl Atlas {
    /// The signature of a polyline from start to goal that has the via points among its points.
    pub fn signature(&self, points: &[Point]) -> String {
        let mut from = 0;
        let mut words = Vec::new();
        for (i, rays) in self.legs.iter().enumerate() {
            let near = |p: &Point| self.via.get(i).map_or(0.0, |via| distance(*p, *via));
            let to = if i < self.via.len() {
                (from..points.len()).min_by(|&a, &b| near(&points[a]).total_cmp(&near(&points[b]))).unwrap_or(from)
            } else {
                points.len().saturating_sub(1)
            };
            words.push(text(&rays.word(points.get(from..=to).unwrap_or_default())));
            from = to;
        }
        words.join(" | ")
    }
}

/// As [`classes`], and what tells the class of other paths.
pub(in crate::plan) fn atlas(query: &Query, k: usize, ctx: &mut Context) -> Result<Atlas, PlanError> {
    query.validate()?;
    let points = rays::inside(&query.world);
    let mut exact = ExactLeg::new(query);
    let mut atlas = Atlas { classes: Vec::new(), via: query.via.clone(), legs: Vec::new() };
    for ends in query.stops().windows(2) {
        let (rays, leg) = of_leg(query, (&mut exact, &points), [ends[0], ends[1]], k.max(1), ctx)?;
        atlas.classes = if atlas.legs.is_empty() { leg } else { joined(&atlas.classes, &leg, k.max(1)) };
        atlas.legs.push(rays);
    }
    Ok(atlas)
}

/// The classes of one leg and its rays.
fn of_leg(
    query: &Query,
    (exact, points): (&mut ExactLeg, &[Point]),
    ends: [Point; 2],
    k: usize,
    ctx: &mut Context,
) -> Result<(Rays, Vec<Class>), PlanError> {
    let shortest = match exact.solve(ends, ctx) {
        Route::Path { points, length } => (points, length),
        Route::Nothing => return Err(PlanError::NoPath(Box::new(explain(query, ctx)))),
        Route::Stopped { .. } if ctx.poll() == Some(Stop::Cancelled) => return Err(PlanError::Cancelled),
        Route::Stopped { .. } => return Err(no_path(query, false, Some("the budget of time was spent".into()))),
    };
    let reach = shortest.1 * GROWTH[GROWTH.len() - 1] + 2.0 * query.radius();
    let rays = Rays::new(points, |p| distance(ends[0], p) + distance(p, ends[1]) <= reach);
    let first = Taut { word: rays.word(&shortest.0), points: shortest.0, length: shortest.1 };
    let mut found = vec![first];
    if k > 1 && shortest.1 > 0.0 {
        further(query, (&rays, ends), k, &mut found, ctx);
    }
    Ok((rays, found.into_iter().map(named).collect()))
}

/// Adds further classes to the shortest one.
fn further(query: &Query, (rays, ends): (&Rays, [Point; 2]), k: usize, found: &mut Vec<Taut>, ctx: &mut Context) {
    let inflated = Inflated { world: &query.world, robot: query.radius() };
    let shortest = found[0].length;
    let mut left = EFFORT;
    for growth in GROWTH {
        let mut search = Classes::new(&inflated, ends, shortest * growth, rays, k);
        let more = search.solve(&mut |expansions| expansions >= left || ctx.poll().is_some());
        let first = found[0].word.clone();
        let mut more: Vec<Taut> = more.into_iter().filter(|taut| taut.word != first).collect();
        more.truncate(k - 1);
        // A longer bound finds the same ones first, unless the effort ends before.
        if more.len() >= found.len() {
            found.truncate(1);
            found.extend(more);
        }
        left = left.saturating_sub(search.expansions);
        if found.len() >= k || left == 0 || ctx.poll().is_some() {
            return;
        }
    }
}

fn named(taut: Taut) -> Class {
    Class { points: taut.points, length: taut.length, signature: text(&taut.word) }
}

fn text(word: &[i32]) -> String {
    word.iter().map(i32::to_string).collect::<Vec<_>>().join(" ")
}

/// The `k` shortest continuations of the classes so far by those of the next leg.
fn joined(before: &[Class], leg: &[Class], k: usize) -> Vec<Class> {
    let mut pairs: Vec<(usize, usize)> = (0..before.len()).flat_map(|i| (0..leg.len()).map(move |j| (i, j))).collect();
    let length = |p: &(usize, usize)| before[p.0].length + leg[p.1].length;
    pairs.sort_by(|a, b| length(a).total_cmp(&length(b)).then(a.cmp(b)));
    pairs.truncate(k);
    let join = |(i, j): (usize, usize)| {
        let points = before[i].points.iter().chain(&leg[j].points[1..]).copied().collect();
        Class { points, length: length(&(i, j)), signature: format!("{} | {}", before[i].signature, leg[j].signature) }
    };
    pairs.into_iter().map(join).collect()
}

#[cfg(test)]
mod tests;
