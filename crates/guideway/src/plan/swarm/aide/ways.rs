//! The other ways past the obstacles, where movers are on the best one.

use super::polish::Candidate;
use super::seats::{self, Seats};
use super::speed::Track;
use super::stages::Outcome;
use super::{Aide, Seen};
use crate::context::Context;
use crate::error::PlanError;
use crate::plan::among::{Way, among_movers, at_least};
use crate::plan::homotopy::{Atlas, Class};
use crate::plan::swarm::Curves;
use crate::query::Query;
use crate::timing::{SpeedTrace, TimingOptions, Trajectory};

/// A candidate that can be driven.
pub(super) struct Driven {
    pub curves: Curves,
    pub best: Candidate,
    pub track: Track,
    pub speed: SpeedTrace,
}

impl Driven {
    /// The best candidate of the search with its motion, if it is feasible.
    pub fn best(aide: &Aide, query: &Query, outcome: &mut Outcome, ctx: &mut Context) -> Option<Way<Self>> {
        let best = outcome.best.as_ref().filter(|best| best.cost.feasible())?.clone();
        let own = outcome.track.take().filter(|track| track.is_of(&best.x));
        Self::new(aide, query, (&outcome.curves, best), own, ctx)
    }

    fn new(aide: &Aide, query: &Query, (curves, best): (&Curves, Candidate), own: Option<Track>, ctx: &mut Context) -> Option<Way<Self>> {
        let track = own.or_else(|| Track::new(curves, &best.x).ok())?;
        let (trajectory, speed) = track.motion(query, aide.profile, ctx).ok()?;
        Some((Self { curves: curves.clone(), best, track, speed }, trajectory))
    }
}

/// The best way or another one, timed among the movers.
pub(super) fn among(
    aide: &Aide,
    query: &Query,
    first: Way<Driven>,
    (atlas, seats): (&Atlas, &mut Seats),
    ctx: &mut Context,
) -> Result<(Driven, Trajectory, Seen), PlanError> {
    let signature = |curves: &Curves, best: &Candidate| atlas.signature(&curves.chain(&best.x, 2000));
    let taken = signature(&first.0.curves, &first.0.best);
    let further: Vec<(usize, &Class)> = atlas.classes.iter().enumerate().filter(|(_, class)| class.signature != taken).collect();
    let options = options(aide, query);
    let mut make = |k: usize, below: f64, ctx: &mut Context| {
        let (number, class) = further.get(k - 1).filter(|(_, class)| at_least(class.length, query) < below)?;
        let seat = seats::of_class(aide, query, (*number, class), seats, ctx)?;
        Driven::new(aide, query, (&seat.curves, seat.best.clone()), None, ctx)
    };
    among_movers(query, first, &options, &mut make, ctx)
}

/// A motion timed among the movers, with no other way.
pub(super) fn alone(aide: &Aide, query: &Query, plain: Trajectory, ctx: &mut Context) -> Result<(Trajectory, Seen), PlanError> {
    let ((), trajectory, told) = among_movers(query, ((), plain), &options(aide, query), &mut |_, _, _| None, ctx)?;
    Ok((trajectory, told))
}

fn options<'a>(aide: &Aide, query: &Query) -> TimingOptions<'a> {
    TimingOptions { start_yaw: query.start_yaw, goal_yaw: query.goal_yaw, method: aide.profile, ..TimingOptions::default() }
}
