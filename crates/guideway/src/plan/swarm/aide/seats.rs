//! One candidate for each homotopy class, brought downhill before the search begins.

use super::polish::{Candidate, polish};
use super::{Aide, bound};
use crate::Point;
use crate::context::{Context, Stop};
use crate::error::PlanError;
use crate::optimize::Objective;
use crate::plan::Solution;
use crate::plan::homotopy::{Atlas, Class};
use crate::plan::swarm::Curves;
use crate::plan::swarm::spline::{layout, legs, lines, seed};
use crate::query::Query;

/// Steps that bring a first candidate into free space, and that improve the best ones, as a multiple of those of the polish.
const REPAIR: u64 = 2;
/// Control points of a leg besides one for each quarter turn.
const LEAST: usize = 4;
/// Numbers of control points are tried in turn, as multiples of the first.
const GROWTH: [f64; 3] = [1.0, 1.5, 2.25];

/// Classes that are tried again with more control points each time, the shortest first.
const AGAIN: usize = 3;

/// Classes whose candidates are polished longer.
const FAVOURITES: usize = 3;

/// A class and its candidate.
pub(super) struct Seat {
    pub class: usize,
    pub curves: Curves,
    pub best: Candidate,
}

/// What the search begins with.
pub(super) struct Seats {
    /// Best first.
    pub seats: Vec<Seat>,
    pub stop: Option<Stop>,
}

/// Places a candidate in every class that can still win, and polishes it; with more control points where it is not free.
pub(super) fn place(aide: &Aide, query: &Query, (atlas, exact): (&Atlas, &Solution), ctx: &mut Context) -> Result<Seats, PlanError> {
    let mut all = Seats { seats: Vec::new(), stop: None };
    let open = query.stops().into_iter().map(|p| query.world.clearance(p)).fold(f64::INFINITY, f64::min);
    for (round, growth) in GROWTH.into_iter().enumerate() {
        let mut again = if round == 0 { usize::MAX } else { AGAIN };
        for (i, class) in atlas.classes.iter().enumerate() {
            all.stop = all.stop.or_else(|| ctx.spent());
            // The shortest path of the class in the least time, as far away as its ends are: no curve of the class is better.
            let worth = again > 0 && !all.free(i) && bound::at_least(query, &aide.settings, class.length * (1.0 - 1e-9), open) < all.value();
            if all.stop.is_none() && worth {
                again -= 1;
                all.take(aide, i, along(aide, query, (&class.points, growth), ctx.seed())?, ctx)?;
            }
        }
        if all.stop.is_some() || aide.settings.points > 0 {
            break;
        }
    }
    if !all.value().is_finite() && all.stop.is_none() {
        // Wider routes, smoothed, and still more control points.
        let ways = lines(query, exact, ctx);
        let wide = layout(query, &aide.settings, &ways, ctx)?;
        all.take(aide, 0, wide.curves, ctx)?;
    }
    all.sort();
    all.improve(aide, ctx)?;
    Ok(all)
}

/// The seat of a class with a free candidate; made if there is none so far.
pub(super) fn of_class<'a>(
    aide: &Aide,
    query: &Query,
    (number, class): (usize, &Class),
    seats: &'a mut Seats,
    ctx: &mut Context,
) -> Option<&'a Seat> {
    for growth in GROWTH {
        if seats.free(number) || ctx.spent().is_some() {
            break;
        }
        let curves = along(aide, query, (&class.points, growth), ctx.seed()).ok()?;
        seats.take(aide, number, curves, ctx).ok()?;
    }
    seats.seats.iter().find(|s| s.class == number && s.best.cost.feasible())
}

/// Curves for a line, with a candidate along it.
fn along(aide: &Aide, query: &Query, (line, growth): (&[Point], f64), number: u64) -> Result<Curves, PlanError> {
    let points = |bends: usize| if aide.settings.points > 0 { aide.settings.points } else { (growth * (LEAST + bends) as f64).ceil() as usize };
    let counts: Vec<(usize, f64)> = legs(query, line).into_iter().map(|(length, bends)| (points(bends).min(1000), length)).collect();
    let mut curves = Curves::along(query, &aide.settings, &counts)?;
    let x = curves.fit(line);
    seed(&mut curves, &aide.settings, vec![x], number)?;
    Ok(curves)
}

impl Seats {
    /// The best value so far; infinite if no candidate is free.
    fn value(&self) -> f64 {
        self.seats.iter().filter(|s| s.best.cost.feasible()).map(|s| s.best.cost.value).fold(f64::INFINITY, f64::min)
    }

    fn sort(&mut self) {
        self.seats.sort_by(|a, b| a.best.cost.order(b.best.cost).then(a.class.cmp(&b.class)));
    }

    /// More steps for the best, whose order they may change.
    fn improve(&mut self, aide: &Aide, ctx: &mut Context) -> Result<(), PlanError> {
        for seat in self.seats.iter_mut().take(FAVOURITES) {
            if self.stop.is_none() {
                (seat.best, self.stop) = polish(&seat.curves, seat.best.clone(), REPAIR * aide.polish, ctx)?;
            }
        }
        self.sort();
        Ok(())
    }

    /// Does the class have a free candidate?
    fn free(&self, class: usize) -> bool {
        self.seats.iter().any(|s| s.class == class && s.best.cost.feasible())
    }

    fn take(&mut self, aide: &Aide, class: usize, curves: Curves, ctx: &mut Context) -> Result<(), PlanError> {
        let Some(x) = curves.hints().first().cloned() else { return Ok(()) };
        let from = Candidate { cost: curves.judge(&x).cost(), x };
        ctx.count_evaluations(1);
        let (mut best, mut stop) = polish(&curves, from, aide.polish, ctx)?;
        if !best.cost.feasible() && stop.is_none() {
            (best, stop) = polish(&curves, best, REPAIR * aide.polish, ctx)?;
        }
        self.stop = self.stop.or(stop);
        match self.seats.iter_mut().find(|s| s.class == class) {
            Some(seat) if best.cost.beats(seat.best.cost) => *seat = Seat { class, curves, best },
            Some(_) => {}
            None => self.seats.push(Seat { class, curves, best }),
        }
        Ok(())
    }
}
