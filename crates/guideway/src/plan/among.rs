//! The motion of a planner among the movers of its world.

use crate::context::{Context, Stop};
use crate::error::PlanError;
use crate::query::Query;
use crate::timing::movers::{Among, Timed, among};
use crate::timing::{TimingOptions, Trajectory, first_pass};
use serde_json::{Value, json};

/// Ways past the obstacles that are tried where the first one is not free of movers.
pub(super) const WAYS: usize = 8;

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
    let untimed = |ways: usize, reason: String| json!({"timed": false, "movers": movers.len(), "ways": ways, "reason": reason});
    let reason = match among(&plain.path, &plain.limits, options, &around, ctx) {
        Ok(timed) if timed.record.delay <= 0.0 && timed.record.passive => return Ok(told((way, timed), 0, 1)),
        Ok(timed) => {
            let (found, number, tried) = others(Some((way, timed)), options, &around, make, ctx)?;
            return found.map(|f| told(f, number, tried)).ok_or(PlanError::Cancelled);
        }
        Err(PlanError::Infeasible { reason, .. }) => reason,
        Err(PlanError::Cancelled) => return Ok((way, plain, untimed(1, "cancelled".into()))),
        Err(error) => return Err(error),
    };
    match others(None, options, &around, make, ctx)? {
        (Some(found), number, tried) => Ok(told(found, number, tried)),
        (None, _, 1) => Ok((way, plain, untimed(1, reason))),
        (None, _, tried) => {
            Ok((way, plain, untimed(tried, format!("{reason}; {} other ways past the obstacles have no such motion either", tried - 1))))
        }
    }
}

fn told<W>((way, timed): (W, Timed), number: usize, tried: usize) -> (W, Trajectory, Value) {
    let mut record = json!(timed.record);
    record["timed"] = true.into();
    (record["way"], record["ways"]) = (number.into(), tried.into());
    (way, timed.trajectory, record)
}

/// A way with its motion, its number, and how many were looked at.
type Others<W> = (Option<(W, Timed)>, usize, usize);

/// The best of one way, if it is one, and the others.
fn others<W>(
    mut best: Option<(W, Timed)>,
    options: &TimingOptions,
    around: &Among,
    make: Make<W>,
    ctx: &mut Context,
) -> Result<Others<W>, PlanError> {
    let (mut number, mut tried) = (0, 1);
    for k in 1..WAYS {
        if ctx.spent().is_some_and(|stop| stop == Stop::Cancelled || best.is_some()) {
            break;
        }
        // A motion without passive safety gives way to any that has it.
        let below = best.as_ref().filter(|b| b.1.record.passive).map_or(f64::INFINITY, |b| b.1.trajectory.duration());
        let Some((way, plain)) = make(k, below, ctx) else { continue };
        if plain.duration() >= below {
            continue;
        }
        tried += 1;
        match among(&plain.path, &plain.limits, options, around, ctx) {
            Ok(timed) if best.as_ref().is_none_or(|b| better(&timed, &b.1)) => (best, number) = (Some((way, timed)), k),
            Ok(_) | Err(PlanError::Infeasible { .. }) => {}
            Err(PlanError::Cancelled) => break,
            Err(error) => return Err(error),
        }
    }
    Ok((best, number, tried))
}

fn better(a: &Timed, b: &Timed) -> bool {
    (a.record.passive, -a.trajectory.duration()) > (b.record.passive, -b.trajectory.duration())
}

/// No motion over that length (m) takes less, s.
pub(super) fn at_least(length: f64, query: &Query) -> f64 {
    first_pass(length * (1.0 - 1e-9), &query.limits).map_or(0.0, |p| p.duration())
}
