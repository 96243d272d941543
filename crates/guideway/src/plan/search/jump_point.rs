//! Jump point search, bit-parallel; the engine is described in the module jump.
//!
//! Source: \[harabor2011\], \[harabor2014\]. No parameters. Departures: costs are exact integers (see `open.rs`); of equal estimates the youngest
//! node goes first.

use super::leg::{Engine, plan};
use crate::context::Context;
use crate::error::PlanError;
use crate::plan::{Planner, Solution};
use crate::query::Query;
use serde::{Deserialize, Serialize};

/// Exact shortest path on the 8-connected lattice under the query's corner rule.
/// `trace.engine` names the search that ran, if it is another one.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct JumpPoint {}

impl Planner for JumpPoint {
    fn plan(&self, query: &Query, ctx: &mut Context) -> Result<Solution, PlanError> {
        plan(Engine::JumpPoint, query, ctx)
    }
}
