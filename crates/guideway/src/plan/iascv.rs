//! The shortest path with rounded corners and a corrected S-curve along it: the inner half of A-I-DE as a method of its own.
//!
//! Source: \[zhang2025\], whose method IASCV times a path that another method plans. | symbol | field |: `A`, `B`, `J`, `v_m` are the limits of the query.
//! Departures: the source does not say where its path comes from. Here it is the exact shortest one, rounded by the checked B-spline; the speed is a seven-phase plan
//! of each stretch between stops, corrected at nodes until the ceiling is kept ([`crate::timing::correct`]). There is no search. The start acceleration of the source
//! (0.5 m/s2 at rest) is a step of acceleration and is not offered.

use super::among::{WAYS, among_movers, at_least};
use super::homotopy::{Class, classes};
use super::search::Visibility;
use super::{Planner, Solution};
use crate::context::{Context, Stop};
use crate::error::PlanError;
use crate::path::Path;
use crate::query::Query;
use crate::refine::{Refined, Refiner, Smooth};
use crate::timing::{self, Loop, Method, SpeedTrace, TimingOptions, Trajectory, overspeed};
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

/// Shortest path, rounded corners, corrected S-curves.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Iascv {
    /// How the speed is found: `Iascv`, or `TimeOptimal` on the same path. The loop is in the trace either way.
    pub timing: Method,
    /// Largest curvature, 1/m; met where there is room ([`Smooth`]).
    pub max_curvature: Option<f64>,
    /// Length that a bend may add, share of its legs.
    pub stretch: f64,
    /// Bends with a smaller radius stay corners, cells.
    pub smallest: f64,
    /// The motion keeps the radius of the query to the movers of the world, by waiting, slowing down or another way past the obstacles, wherever that is possible
    /// ([`crate::timing::movers`]).
    pub movers: bool,
}

impl Default for Iascv {
    fn default() -> Self {
        let Smooth { max_curvature, stretch, smallest } = Smooth::default();
        Self { timing: Method::Iascv, max_curvature, stretch, smallest, movers: true }
    }
}

impl Planner for Iascv {
    fn plan(&self, query: &Query, ctx: &mut Context) -> Result<Solution, PlanError> {
        let Self { timing, max_curvature, stretch, smallest, movers } = *self;
        if timing == Method::Trapezoid {
            return Err(PlanError::bad(
                "iascv.timing",
                "trapezoid",
                "iascv or time-optimal: a motion with steps of acceleration passes no certificate",
            ));
        }
        let raw = Visibility::default().plan(query, ctx)?;
        if raw.stop == Stop::Cancelled {
            return Ok(raw);
        }
        let smooth = Smooth { max_curvature, stretch, smallest };
        let options = TimingOptions { start_yaw: query.start_yaw, goal_yaw: query.goal_yaw, method: timing, ..TimingOptions::default() };
        let (first, plain) = Way::new(&raw.path, &smooth, query, &options, ctx)?;
        let (way, trajectory, around) = if movers {
            let mut known: Option<Vec<Class>> = None;
            let mut make = |k: usize, below: f64, ctx: &mut Context| {
                let all = known.get_or_insert_with(|| classes(query, WAYS, ctx).unwrap_or_default());
                let class = all.get(k).filter(|class| at_least(class.length, query) < below)?;
                Way::new(&Path::polyline(&class.points), &smooth, query, &options, ctx).ok()
            };
            among_movers(query, (first, plain), &options, &mut make, ctx)?
        } else {
            (first, plain, Value::Null)
        };
        let Way { refined, loops, by_nodes } = way;
        let (length, duration) = (refined.path.length(), trajectory.duration());
        let mut trace = trace(&loops, length, &trajectory);
        trace["speed"]["movers"] = around;
        trace["unmet"] = json!(refined.unmet);
        trace["durations"] = json!({"nodes": by_nodes, "result": duration});
        Ok(Solution { path: refined.path, cells: None, cost: length, trajectory: Some(trajectory), seconds: ctx.seconds(), trace, ..raw })
    }
}

/// A rounded path and the loop on its speed.
struct Way {
    refined: Refined,
    loops: Vec<Loop>,
    /// Duration of the corrected motion, s.
    by_nodes: f64,
}

impl Way {
    /// With its motion.
    fn new(raw: &Path, smooth: &Smooth, query: &Query, options: &TimingOptions, ctx: &mut Context) -> Result<(Self, Trajectory), PlanError> {
        let refined = smooth.refine(raw, query, ctx)?;
        let (mut trajectory, loops) = timing::corrected(&refined.path, &query.limits, options, ctx)?;
        let by_nodes = trajectory.duration();
        if options.method == Method::TimeOptimal {
            trajectory = timing::time(&refined.path, &query.limits, options, ctx)?;
        }
        Ok((Self { refined, loops, by_nodes }, trajectory))
    }
}

/// The loop on speed and its curves, in the words that all continuous planners use.
fn trace(loops: &[Loop], length: f64, trajectory: &Trajectory) -> Value {
    let speed = SpeedTrace::of(loops);
    let nodes: usize = loops.iter().map(|part| part.corrected.nodes.len()).sum();
    let passes = loops.iter().map(|part| part.corrected.passes).max();
    let (found, remaining) = (&speed.regions_before, &speed.regions_after);
    json!({
        "loop": [{"stage": 0, "value": trajectory.duration(), "found": found, "corrected": found.len() - remaining.len().min(found.len()), "nodes": nodes,
                  "passes": passes, "overspeed": overspeed(found, length), "remaining": remaining, "fed_back": []}],
        "speed": speed,
    })
}
