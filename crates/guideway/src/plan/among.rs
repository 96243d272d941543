//! The motion of a planner among the movers of its world.

use crate::context::{Context, Stop};
use crate::error::PlanError;
use crate::query::Query;
use crate::timing::movers::{Among, Timed, Wanted, before};
use crate::timing::{TimingOptions, Trajectory, first_pass};
use serde_json::{Value, json};

/// Ways past the obstacles that are tried where the first one is not free of movers.
pub(super) const WAYS: usize = 8;
/// Motions that are later than the first one without movers by no more than that are looked for first, on all ways, s.
const PATIENCE: f64 = 4.0;

/// A way that a planner may take: what it needs to know of it, and the motion as if there were no movers.
pub(super) type Way<W> = (W, Trajectory);

/// Makes the way of a number from 1, if there is one that may take less than so many seconds.
pub(super) type Make<'a, W> = &'a mut dyn FnMut(usize, f64, &mut Context) -> Option<Way<W>>;

/// The way and its motion that keeps the query's radius to every mover and arrives first, and what there is to say about it; null without movers. The first way, if
/// movers do not delay it; else others are tried as well. One with passive safety is better than one without. Where no way can be timed, the first one without a look
/// at movers, and the reason: whoever drives it has to look out.
pub(super) fn among_movers<W>(
    query: &Query,
    (way, plain): Way<W>,
    options: &TimingOptions,
    make: Make<W>,
    ctx: &mut Context,
) -> Result<(W, Trajectory, Value), PlanError> {
    let movers = query.world.movers();
    if movers.is_empty() {
        return Ok((way, plain, Value::Null));
    }
    let around = Among::new(movers, query.radius());
    let soon = plain.duration() + PATIENCE;
    let mut ways = Ways { options, known: vec![Some((way, plain))], tried: 1, reason: String::new() };
    ways.known.resize_with(WAYS, || None);
    let rounds = [(true, soon), (true, f64::INFINITY), (false, f64::INFINITY)];
    for (passive, until) in rounds {
        let wanted = Wanted { around: Among { passive, ..around }, until };
        match ways.best(wanted, make, ctx) {
            Ok(Some((k, timed))) => {
                let Some((way, _)) = ways.known[k].take() else { continue };
                let mut record = json!(timed.record);
                record["timed"] = true.into();
                (record["way"], record["ways"]) = (k.into(), ways.tried.into());
                return Ok((way, timed.trajectory, record));
            }
            Ok(None) => {}
            Err(PlanError::Cancelled) => {
                ways.reason = "cancelled".into();
                break;
            }
            Err(error) => return Err(error),
        }
    }
    let more = if ways.tried > 1 { format!("; {} other ways past the obstacles have no such motion either", ways.tried - 1) } else { String::new() };
    let told = json!({"timed": false, "movers": movers.len(), "ways": ways.tried, "reason": ways.reason + &more});
    let first = ways.known.swap_remove(0);
    first.map(|(way, plain)| (way, plain, told)).ok_or(PlanError::Cancelled)
}

/// Ways as they become known.
struct Ways<'a, W> {
    options: &'a TimingOptions<'a>,
    known: Vec<Option<Way<W>>>,
    /// How many have been looked at.
    tried: usize,
    /// Why the first way has no motion.
    reason: String,
}

impl<W> Ways<'_, W> {
    /// The way with the earliest arrival and its motion, if there is one that is wanted.
    fn best(&mut self, mut wanted: Wanted, make: Make<W>, ctx: &mut Context) -> Result<Option<(usize, Timed)>, PlanError> {
        let mut best: Option<(usize, Timed)> = None;
        for k in 0..WAYS {
            if k > 0 && ctx.spent().is_some_and(|stop| stop == Stop::Cancelled || best.is_some()) {
                break;
            }
            if self.known[k].is_none() {
                self.known[k] = make(k, wanted.until, ctx);
                self.tried += usize::from(self.known[k].is_some());
            }
            let Some((_, plain)) = self.known[k].as_ref().filter(|way| way.1.duration() < wanted.until) else { continue };
            match before(&plain.path, &plain.limits, self.options, &wanted, ctx) {
                Ok(timed) => {
                    wanted.until = timed.trajectory.duration();
                    let alone = k == 0 && timed.record.delay <= 0.0;
                    best = Some((k, timed));
                    if alone {
                        break;
                    }
                }
                Err(PlanError::Infeasible { reason, .. }) if k == 0 => self.reason = reason,
                Err(PlanError::Infeasible { .. }) => {}
                Err(error) => return Err(error),
            }
        }
        Ok(best)
    }
}

/// No motion over that length (m) takes less, s.
pub(super) fn at_least(length: f64, query: &Query) -> f64 {
    first_pass(length * (1.0 - 1e-9), &query.limits).map_or(0.0, |p| p.duration())
}
