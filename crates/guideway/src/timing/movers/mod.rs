//! Timing a path among movers whose motion is known: in space and time.
//!
//! Where the plain motion meets a mover, a search finds the earliest arrival over a graph of places, speeds and times: jerk-limited profiles between places that
//! are passed at one speed without acceleration, turns in place, and waiting. When each short part of the path is taken is worked out beforehand, by steps that no
//! mover can outrun, so that nothing is sampled; two bounds from below lead the search, the least time of the graph without movers and the earliest arrival with
//! movers but without inertia. What it finds is proved once more, by halving intervals of time until the way in them and the distance to every course leave no doubt.

mod bound;
mod course;
mod motions;
mod safety;
mod search;
mod table;

use super::{TimingOptions, Trajectory, time};
use crate::context::Context;
use crate::error::PlanError;
use crate::path::Path;
use crate::query::Limits;
use crate::world::Mover;
use motions::Motions;
use safety::Safety;
use search::{Found, Search};
use serde::Serialize;
use table::Table;

/// Delay between a brake being called for and its first effect, s, where nobody says otherwise.
pub const DEFAULT_LATENCY: f64 = 0.1;

/// A search looks for a motion that is longer than the plain one by no more than that first, s.
const SOON: f64 = 15.0;
/// Most motions that are tested with, and without, passive safety.
const MOST: u64 = 400_000;
/// Cells of the last attempt are so many times as short.
const FINER: f64 = 4.0;

/// What a motion among movers has to keep. Time 0 of the motion is time 0 of the movers.
#[derive(Debug, Clone, Copy)]
pub struct Among<'a> {
    /// Present all the time, whenever they appear; except before the time of [`crate::world::Appears::At`].
    pub movers: &'a [Mover],
    /// Distance of the reference point to their outlines, m: circumscribed footprint plus clearance.
    pub radius: f64,
    /// Delay of a brake, s.
    pub latency: f64,
    /// Wherever the robot is, a full brake along the path ends before any mover could be there that leaves its course at its top speed. Dropped where no motion
    /// has it, which [`Timed::passive`] says.
    pub passive: bool,
}

impl<'a> Among<'a> {
    /// These movers at that distance (m), with passive safety after [`DEFAULT_LATENCY`].
    pub fn new(movers: &'a [Mover], radius: f64) -> Self {
        Self { movers, radius, latency: DEFAULT_LATENCY, passive: true }
    }

    fn validate(&self) -> Result<(), PlanError> {
        for (name, value) in [("radius", self.radius), ("latency", self.latency)] {
            if !(value.is_finite() && (0.0..=1e6).contains(&value)) {
                return Err(PlanError::bad(name, value, "0 to 1e6"));
            }
        }
        Ok(())
    }
}

/// A motion among movers.
#[derive(Debug, Clone)]
pub struct Timed {
    /// The motion.
    pub trajectory: Trajectory,
    /// How it came to be.
    pub record: Record,
}

/// How a motion among movers came to be.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Record {
    /// Movers that were looked at.
    pub movers: usize,
    /// Every state can be followed by a full brake that ends out of reach of the movers.
    pub passive: bool,
    /// Longer than the motion without movers, s.
    pub delay: f64,
    /// Time at rest between its ends except for turns in place, s.
    pub waiting: f64,
    /// Motions that were tested.
    pub tested: u64,
}

/// The motion along a path that keeps its distance to movers at all times, near the earliest arrival.
///
/// The plain motion ([`time`]) where that is enough. Near the earliest arrival, as far as the graph of the search and its bound on tests go. What happens after the
/// arrival is not looked at.
/// # Errors
/// As [`time`]; [`PlanError::Infeasible`] names the mover and the place where no motion was found; [`PlanError::BadParameter`] for a radius or latency that is
/// negative, or speeds at the ends that are not zero where the plain motion will not do.
pub fn among(path: &Path, limits: &Limits, options: &TimingOptions, around: &Among, ctx: &mut Context) -> Result<Timed, PlanError> {
    let asked = |passive: bool| Wanted { around: Among { passive, ..*around }, until: f64::INFINITY };
    match before(path, limits, options, &asked(around.passive), ctx) {
        Err(PlanError::Infeasible { .. }) if around.passive => before(path, limits, options, &asked(false), ctx),
        other => other,
    }
}

/// What a motion has to keep, passive safety with no way around it if it is asked for; and it arrives before `until` (s).
pub(crate) struct Wanted<'a> {
    pub around: Among<'a>,
    pub until: f64,
}

/// As [`among`], and [`PlanError::Infeasible`] where the motion found would have no passive safety or be too late.
pub(crate) fn before(path: &Path, limits: &Limits, options: &TimingOptions, wanted: &Wanted, ctx: &mut Context) -> Result<Timed, PlanError> {
    let Wanted { around, until } = *wanted;
    around.validate()?;
    let plain = time(path, limits, options, ctx)?;
    if plain.duration() >= until {
        return Err(PlanError::Infeasible { reason: format!("the motion needs {:.2} s without movers", plain.duration()), best_end_speed: None });
    }
    let safety = Safety::new(path, plain.limits, around);
    let record = Record { movers: around.movers.len(), passive: around.passive, delay: 0.0, waiting: 0.0, tested: 1 };
    let Some(meeting) = safety.meeting(&plain.pieces, 0.0) else {
        return Ok(Timed { trajectory: plain, record });
    };
    if options.start_speed > 0.0 || options.end_speed > 0.0 {
        return Err(PlanError::bad(
            "start_speed, end_speed",
            format!("{}, {}", options.start_speed, options.end_speed),
            "0 among movers that are in the way",
        ));
    }
    let horizon = (4.0 * plain.duration() + 60.0).min(until);
    if let Some(closed) = safety.closed(horizon) {
        return Err(safety.hopeless(&closed, horizon));
    }
    if path.length() <= 0.0 {
        return Err(safety.hopeless(&meeting, horizon));
    }
    let (mut motions, mut tested) = (Motions::new(&plain, options), 1);
    match earliest(&mut motions, &safety, (horizon, until), (ctx, &mut tested))? {
        Some(Found { trajectory, waiting }) => {
            let delay = trajectory.duration() - plain.duration();
            Ok(Timed { trajectory, record: Record { delay, waiting, tested, ..record } })
        }
        None => Err(safety.hopeless(&meeting, horizon)),
    }
}

/// The search with cells of the path and moments that are coarse first: near in time, then up to the horizon (s), then, unless it is about being early, fine.
fn earliest<'a>(
    motions: &mut Motions<'a>,
    safety: &Safety<'a>,
    (horizon, until): (f64, f64),
    (ctx, tested): (&mut Context, &mut u64),
) -> Result<Option<Found>, PlanError> {
    let most = *tested + MOST;
    let soon = (motions.plain.duration() + SOON).min(horizon);
    let rounds = [(soon, 1.0, true), (horizon, 1.0, soon < horizon), (horizon, FINER, until.is_infinite())];
    for (until, finer, _) in rounds.into_iter().filter(|round| round.2) {
        let table = Table::new(safety.path, &safety.courses, safety.around.radius, until, finer);
        let found = Search::new(motions, safety, &table).run(ctx, tested, most)?;
        // The proof that does not rest on the table.
        if let Some(found) = found.filter(|f| safety.meeting(&f.trajectory.pieces, 0.0).is_none()) {
            return Ok(Some(found));
        }
    }
    Ok(None)
}
