//! Planners: from a query to a path.

mod among;
pub mod colony;
pub mod front;
pub mod homotopy;
mod iascv;
mod legs;
mod recommended;
pub(crate) mod refusal;
mod registry;
pub mod sample;
pub mod score;
pub mod search;
pub mod swarm;
pub mod tour;

pub use crate::optimize::Parameter;
pub use iascv::Iascv;
pub use recommended::{ADVICE, Advice, recommended};
pub use registry::REGISTRY;

use crate::Point;
use crate::context::{Context, Stop};
use crate::error::PlanError;
use crate::path::Path;
use crate::query::Query;
use crate::timing::Trajectory;
use crate::world::Cell;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::any::Any;
use std::sync::Arc;

/// What a planner returns.
#[derive(Clone)]
pub struct Solution {
    /// The planner's raw path from start to goal.
    pub path: Path,
    /// Cells of a lattice planner, start cell to goal cell, every step to a neighbour (`None` for planners that are not on the lattice).
    pub cells: Option<Vec<Cell>>,
    /// Cost of the path in the planner's own model; its length in m, the length weighed by
    /// the soft clearance where `trace.soft_clearance` names one, or the value of its objective where `trace.objective` describes one.
    pub cost: f64,
    /// Motion, for planners that plan path and speed at once.
    pub trajectory: Option<Trajectory>,
    /// Why it stopped.
    pub stop: Stop,
    /// Iterations of the method's loop (expansions for searches).
    pub iterations: u64,
    /// Candidates costed.
    pub evaluations: u64,
    /// Wall-clock time of the call, s.
    pub seconds: f64,
    /// (iteration, best cost) at each improvement.
    pub history: Vec<(u64, f64)>,
    /// For pictures and reports; the planner's page documents it.
    pub trace: Value,
    /// What `replan` of the same planner reads.
    pub memory: Option<Arc<dyn Any + Send + Sync>>,
}

impl Solution {
    /// Length of the raw path, m, as exactly as the planner knows it.
    pub fn length(&self) -> f64 {
        if ["objective", "soft_clearance"].iter().any(|key| self.trace.get(*key).is_some()) { self.path.length() } else { self.cost }
    }

    /// What a search found that ran to its end: `cost` in m, `expansions` nodes expanded; no cells.
    fn of_search(path: Path, cost: f64, expansions: u64, ctx: &Context) -> Self {
        Self {
            path,
            cells: None,
            cost,
            trajectory: None,
            stop: Stop::Converged,
            iterations: expansions,
            evaluations: 0,
            seconds: ctx.seconds(),
            history: vec![(expansions, cost)],
            trace: Value::Object(serde_json::Map::new()),
            memory: None,
        }
    }
}

/// Plans a path. A planner is a plain struct of public parameters; all search state is local to the call.
pub trait Planner: Send + Sync {
    /// Solves the query.
    /// # Errors
    /// Those of [`Query::validate`], [`PlanError::NoPath`], [`PlanError::Cancelled`].
    fn plan(&self, query: &Query, ctx: &mut Context) -> Result<Solution, PlanError>;

    /// Solves a changed query, reusing what `previous` remembers.
    /// # Errors
    /// As [`Planner::plan`].
    fn replan(&self, _previous: &Solution, query: &Query, ctx: &mut Context) -> Result<Solution, PlanError> {
        self.plan(query, ctx)
    }
}

/// One line of the registry.
pub struct Entry {
    /// Name on the command line and in files.
    pub name: &'static str,
    /// One line for people.
    pub about: &'static str,
    /// Where the method comes from (keys of `refs.bib`).
    pub source: &'static str,
    /// Works on the 8-connected lattice and returns `cells`.
    pub lattice: bool,
    /// Parameters in order.
    pub parameters: &'static [Parameter],
    /// Default parameters as JSON.
    pub defaults: fn() -> Value,
    /// Parameters of `preset=paper` as JSON, where the method has presets.
    pub paper: Option<fn() -> Value>,
    /// Builds the planner from parameters as JSON.
    pub build: fn(Value) -> Result<Box<dyn Planner>, serde_json::Error>,
}

/// An [`Entry`] for a planner type: `entry!("name", Type, lattice, "source", "about", [("parameter", "about"), ...])`, with a last argument `paper` if the
/// type has a field `preset` and `Type::paper()` gives the settings of its source. The parameters may also be a constant `&[Parameter]`.
#[macro_export]
macro_rules! entry {
    ($name:literal, $type:ty, $lattice:literal, $source:literal, $about:literal, $parameters:tt, paper) => {
        $crate::plan::Entry {
            paper: Some(|| serde_json::to_value(<$type>::paper()).unwrap_or_default()),
            ..$crate::entry!($name, $type, $lattice, $source, $about, $parameters)
        }
    };
    ($name:literal, $type:ty, $lattice:literal, $source:literal, $about:literal, $parameters:path, paper) => {
        $crate::plan::Entry { parameters: $parameters, ..$crate::entry!($name, $type, $lattice, $source, $about, [], paper) }
    };
    ($name:literal, $type:ty, $lattice:literal, $source:literal, $about:literal, [$(($p:literal, $a:literal)),* $(,)?]) => {
        $crate::plan::Entry {
            name: $name,
            about: $about,
            source: $source,
            lattice: $lattice,
            parameters: &[$($crate::plan::Parameter { name: $p, about: $a }),*],
            defaults: || serde_json::to_value(<$type>::default()).unwrap_or_default(),
            paper: None,
            build: |value| Ok(Box::new(serde_json::from_value::<$type>(value)?)),
        }
    };
}

/// Settings of a method: the product's, those of its source, or those that the map asks for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Preset {
    /// Ours: what wins is switched on.
    #[default]
    Default,
    /// The settings of the source, without seeding by other searches, loop cutting and fallback.
    Paper,
    /// Ours, with what [`ADVICE`] has for the map of the query.
    Recommended,
}

/// Builds a planner by name with parameters as a JSON object (missing ones take the values of the preset).
/// # Errors
/// [`PlanError::BadParameter`] for an unknown planner or parameter, naming the valid ones.
pub fn planner(name: &str, parameters: Value) -> Result<Box<dyn Planner>, PlanError> {
    let (entry, all) = resolve(name, parameters.clone())?;
    let built = (entry.build)(all.clone()).map_err(|e| refusal::refused(name, &all, |value| (entry.build)(value).map(drop), &e))?;
    Ok(if recommended::asked(&parameters) { Box::new(recommended::Recommended { name: entry.name, given: parameters }) } else { built })
}

/// Every parameter of a planner by name: those given, the others as the preset has them.
/// # Errors
/// As [`planner`].
pub fn parameters(name: &str, given: Value) -> Result<Value, PlanError> {
    Ok(resolve(name, given)?.1)
}

/// Every parameter as the planner takes it for this query: as [`parameters`], with what `preset=recommended` means on its map.
/// # Errors
/// As [`planner`].
pub fn parameters_for(name: &str, given: Value, query: &Query) -> Result<Value, PlanError> {
    let (entry, _) = resolve(name, given.clone())?;
    parameters(name, recommended::settled(entry.name, given, query))
}

fn resolve(name: &str, given: Value) -> Result<(&'static Entry, Value), PlanError> {
    let Some(entry) = REGISTRY.iter().find(|e| e.name == name) else {
        let names: Vec<_> = REGISTRY.iter().map(|e| e.name).collect();
        return Err(PlanError::bad("planner", name, format!("one of {}", names.join(", "))));
    };
    let given = match given {
        Value::Null => serde_json::Map::new(),
        Value::Object(map) => map,
        other => return Err(PlanError::bad(name, other, "a table of parameters")),
    };
    if let Some(key) = given.keys().find(|k| !entry.parameters.iter().any(|p| p.name == **k)) {
        let names: Vec<_> = entry.parameters.iter().map(|p| p.name).collect();
        let known = if names.is_empty() { "it has none".into() } else { names.join(", ") };
        return Err(PlanError::bad(format!("{name}.{key}"), "an unknown parameter", format!("parameters of {name}: {known}")));
    }
    let base = match (entry.paper, given.get("preset").and_then(Value::as_str)) {
        (Some(paper), Some("paper")) => paper(),
        _ => (entry.defaults)(),
    };
    let mut all = base.as_object().cloned().unwrap_or_default();
    all.extend(given);
    Ok((entry, Value::Object(all)))
}

/// Plans leg by leg through the via points: `leg(from, to)` solves one, the result is one polyline.
/// # Errors
/// Those of `leg`.
pub fn through(query: &Query, mut leg: impl FnMut(Point, Point) -> Result<Vec<Point>, PlanError>) -> Result<Vec<Point>, PlanError> {
    let stops = query.stops();
    let mut points = vec![query.start];
    for pair in stops.windows(2) {
        let part = leg(pair[0], pair[1])?;
        points.extend(part.into_iter().skip(1));
    }
    Ok(points)
}
