//! RRT*: a tree whose paths tend to the shortest one as samples are added.
//!
//! Source: \[karaman2011\]. Departures: exact tests of edges; a step that is not free is tried again at half its length; better paths are shortened
//! and their points put into the tree. A gap in the proof of that source was closed later with a radius that shrinks more slowly; `rewire` makes room.

use super::star::Star;
use crate::context::Context;
use crate::error::PlanError;
use crate::plan::{Planner, Solution};
use crate::query::Query;
use serde::{Deserialize, Serialize};

/// A short path by RRT*.
///
/// `trace.tree` has edges of the tree, [x, y, x of the parent, y of the parent] in m, 3000 a leg at most.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct RrtStar(pub Star);

impl RrtStar {
    /// As in the source.
    pub fn paper() -> Self {
        Self(Star::paper())
    }
}

impl Planner for RrtStar {
    fn plan(&self, query: &Query, ctx: &mut Context) -> Result<Solution, PlanError> {
        self.0.solve(false, query, ctx)
    }
}
