//! The motion of a planner among the movers of its world.

use crate::context::Context;
use crate::error::PlanError;
use crate::query::{Limits, Query};
use crate::timing::movers::{Among, among};
use crate::timing::{TimingOptions, Trajectory};
use serde_json::{Value, json};

/// The motion along the path of `plain` that keeps the query's radius to every mover, and what there is to say about it; null without movers. Where there is
/// none, `plain` and the reason: whoever drives it has to look out.
pub(super) fn among_movers(query: &Query, plain: Trajectory, options: &TimingOptions, ctx: &mut Context) -> Result<(Trajectory, Value), PlanError> {
    let movers = query.world.movers();
    if movers.is_empty() {
        return Ok((plain, Value::Null));
    }
    let limits: Limits = plain.limits;
    let untimed = |reason: String| json!({"timed": false, "movers": movers.len(), "reason": reason});
    match among(&plain.path, &limits, options, &Among::new(movers, query.radius()), ctx) {
        Ok(timed) => {
            let mut record = json!(timed.record);
            record["timed"] = true.into();
            Ok((timed.trajectory, record))
        }
        Err(PlanError::Infeasible { reason, .. }) => Ok((plain, untimed(reason))),
        Err(PlanError::Cancelled) => Ok((plain, untimed("cancelled".into()))),
        Err(error) => Err(error),
    }
}
