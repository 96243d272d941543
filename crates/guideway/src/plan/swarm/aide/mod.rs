//! Differential evolution in a closed loop with the asymmetric S-curve.
//!
//! Source: \[zhang2025\], made consistent: an optimizer over spline curves (outer loop) and a jerk-limited profile along the best of them (inner loop) take
//! turns. Symbols: `K_loop` `stages`, `g_max` `generations`, `NP` `population`, `n_c` `points`.
//! Departures of our settings: one candidate for each homotopy class in the first population, brought downhill by quasi-Newton steps before and after;
//! covariance matrix adaptation as the engine; no scales; the time-optimal profile in the end; a lower bound of the objective with the gap to it.

mod bound;
mod engine;
mod polish;
mod record;
mod seats;
mod speed;
mod stages;
#[cfg(test)]
mod tests;
mod ways;

pub use engine::Engine;

use super::spline::{follow, nothing};
use super::{Curves, Settings};
use crate::context::{Context, Stop};
use crate::error::PlanError;
use crate::path::Path;
use crate::plan::homotopy::{self, Atlas};
use crate::plan::{Parameter, Planner, Preset, Solution};
use crate::query::Query;
use crate::timing::Method;
use seats::Seats;
use serde::{Deserialize, Serialize};
use stages::Outcome;
use ways::Driven;

/// A part of the trace.
type Seen = serde_json::Value;

/// Limits of the parameters that count things.
const MOST: (u64, u64, u64, u64) = (1000, 64, 10_000, 1_000_000);

/// The closed loop of optimizer and speed profile.
///
/// `Solution.cost` is the objective `f`; `Solution.trajectory` the motion. `trace` has `objective`, `convergence`, `population`, `encoding` as the other
/// continuous planners, `classes` (homotopy classes with their shortest path, the best `f` there and whether it was chosen), `loop` (per stage: overspeed
/// regions found, corrected by nodes, remaining, fed back), `speed` (ceiling, profile before and after), and `bound` (lower bound of `f` and gap).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Aide {
    /// Settings: ours or those of the source.
    pub preset: Preset,
    /// Encoding and objective.
    #[serde(flatten)]
    pub settings: Settings,
    /// The optimizer.
    pub engine: Engine,
    /// Individuals `NP`; 0: as many as the engine likes.
    pub population: usize,
    /// Generations `g_max` of all stages together.
    pub generations: u64,
    /// Stages `K_loop`, 1 to 1000.
    pub stages: u64,
    /// Homotopy classes that get a candidate, at most 64; 0: none, and no exact search behind the first population.
    pub classes: usize,
    /// Quasi-Newton steps at a time, at most 10000; 0: none.
    pub polish: u64,
    /// What was too fast narrows the next stage's search.
    pub feedback: bool,
    /// How the speed along the result is found.
    pub profile: Method,
    /// The lower bound is computed.
    pub bound: bool,
    /// The motion keeps the radius of the query to the movers of the world, by waiting, slowing down or another way past the obstacles, wherever that is possible
    /// ([`crate::timing::movers`]).
    pub movers: bool,
}

/// The parameters, for the registry.
pub const PARAMETERS: &[Parameter] = &[
    Parameter { name: "preset", about: "default | paper: our settings or those of the source" },
    Parameter { name: "points", about: "free control points n_c of a leg, 3 to 1000; 0: as many as the route needs" },
    Parameter { name: "scales", about: "scales of speed, acceleration and jerk, 0.3 to 1, are searched as well" },
    Parameter { name: "objective", about: "form of the objective: repaired | literal" },
    Parameter { name: "weights", about: "weights of length, time, turning and clearance" },
    Parameter { name: "length_ref", about: "L_max, m; null: half of the perimeter of the world" },
    Parameter { name: "time_ref", about: "T_max, s; null: 1.5 L_max at the speed limit" },
    Parameter { name: "turn_ref", about: "Theta_ref, rad/s" },
    Parameter { name: "safe", about: "d_safe of the clearance term, m; null: what is kept free around the reference point" },
    Parameter { name: "hints", about: "candidates along exact routes are in the first population" },
    Parameter { name: "engine", about: "the optimizer: improved-de | de | l-shade | cma-es | firefly" },
    Parameter { name: "population", about: "individuals NP; 0: as many as the engine likes" },
    Parameter { name: "generations", about: "generations g_max of all stages together" },
    Parameter { name: "stages", about: "stages K_loop, 1 to 1000" },
    Parameter { name: "classes", about: "homotopy classes that get a candidate, at most 64; 0: none" },
    Parameter { name: "polish", about: "quasi-Newton steps at a time, at most 10000; 0: none" },
    Parameter { name: "feedback", about: "what was too fast narrows the next stage's search" },
    Parameter { name: "profile", about: "speed along the result: time-optimal | iascv | trapezoid" },
    Parameter { name: "bound", about: "a lower bound of the objective is computed" },
    Parameter { name: "movers", about: "the motion is timed among the movers of the world, in space and time" },
];

impl Default for Aide {
    fn default() -> Self {
        Self {
            preset: Preset::Default,
            settings: Settings::default(),
            engine: Engine::CmaEs,
            population: 0,
            generations: 200,
            stages: 2,
            classes: 8,
            polish: 20,
            feedback: true,
            profile: Method::TimeOptimal,
            bound: true,
            movers: true,
        }
    }
}

impl Aide {
    /// Settings of \[zhang2025\]: no candidates of ours, no polish, profiles corrected by nodes.
    pub fn paper() -> Self {
        Self {
            preset: Preset::Paper,
            settings: Settings::paper(),
            engine: Engine::ImprovedDe,
            population: 40,
            generations: 4000,
            stages: 20,
            classes: 0,
            polish: 0,
            profile: Method::Iascv,
            movers: false,
            ..Self::default()
        }
    }

    fn check(&self) -> Result<(), PlanError> {
        self.settings.check()?;
        let bad = |name: &str, value: u64, least: u64, most: u64| Err(PlanError::bad(name, value, format!("{least} to {most}")));
        match self {
            _ if !(1..=MOST.0).contains(&self.stages) => bad("stages", self.stages, 1, MOST.0),
            _ if self.classes as u64 > MOST.1 => bad("classes", self.classes as u64, 0, MOST.1),
            _ if self.polish > MOST.2 => bad("polish", self.polish, 0, MOST.2),
            _ if !(self.stages..=MOST.3).contains(&self.generations) => bad("generations", self.generations, self.stages, MOST.3),
            _ => Ok(()),
        }
    }

    /// Where the search begins: candidates by class, or what the curves have by themselves.
    fn begin(&self, query: &Query, (atlas, exact): (&Atlas, &Solution), ctx: &mut Context) -> Result<Seats, PlanError> {
        if self.classes > 0 && self.settings.hints {
            return seats::place(self, query, (atlas, exact), ctx);
        }
        Ok(Seats { seats: Vec::new(), stop: None })
    }
}

impl Planner for Aide {
    fn plan(&self, query: &Query, ctx: &mut Context) -> Result<Solution, PlanError> {
        self.check()?;
        let before = ctx.evaluations();
        // Also the proof that there is no path, if there is none.
        let atlas = homotopy::atlas(query, self.classes.max(1), ctx)?;
        let shortest = &atlas.classes[0];
        let exact = Solution::of_search(Path::polyline(&shortest.points), shortest.length, 0, ctx);
        if exact.cost == 0.0 {
            return self.follow(query, &exact, ctx);
        }
        let mut seats = self.begin(query, (&atlas, &exact), ctx)?;
        let plain = if seats.seats.is_empty() { Some(Curves::new(query, &self.settings)?) } else { None };
        let mut outcome = stages::run(self, &seats, plain.as_ref(), ctx)?;
        if let Some(solution) = self.solution(query, &atlas, &mut seats, &mut outcome, ctx)? {
            return Ok(Solution { evaluations: ctx.evaluations() - before, ..solution });
        }
        let evaluations = ctx.evaluations() - before;
        if self.settings.hints && self.classes > 0 && outcome.stop != Stop::Cancelled {
            let (stop, iterations) = (outcome.stop, ctx.iterations());
            return Ok(Solution { stop, iterations, evaluations, ..self.follow(query, &exact, ctx)? });
        }
        Err(nothing(query, outcome.stop, evaluations))
    }
}

impl Aide {
    /// The exact route, where no curve is better.
    fn follow(&self, query: &Query, exact: &Solution, ctx: &mut Context) -> Result<Solution, PlanError> {
        let mut solution = follow(query, &self.settings, exact, ctx)?;
        if let Some(plain) = solution.trajectory.take() {
            let (trajectory, told) = if self.movers { ways::alone(self, query, plain, ctx)? } else { (plain, Seen::Null) };
            solution.trajectory = Some(trajectory);
            if !told.is_null() {
                solution.trace["speed"] = serde_json::json!({ "movers": told });
            }
        }
        Ok(solution)
    }

    /// The result, if a free curve was found and can be driven.
    fn solution(
        &self,
        query: &Query,
        atlas: &Atlas,
        seats: &mut Seats,
        outcome: &mut Outcome,
        ctx: &mut Context,
    ) -> Result<Option<Solution>, PlanError> {
        let Some(first) = Driven::best(self, query, outcome, ctx) else { return Ok(None) };
        let (driven, trajectory, around) =
            if self.movers { ways::among(self, query, first, (atlas, seats), ctx)? } else { (first.0, first.1, Seen::Null) };
        let Driven { curves, best, track, speed } = driven;
        outcome.curves = curves;
        let bound = self.bound.then(|| bound::bound(query, &self.settings, atlas.classes[0].length, ctx));
        let history: Vec<(u64, f64)> = ctx.take_history().into_iter().filter(|h| h.1.is_finite()).collect();
        let mut trace = record::trace(outcome, (&best, &history), (atlas, seats), &speed, bound.as_ref());
        trace["speed"]["movers"] = around;
        Ok(Some(Solution {
            path: track.path,
            cells: None,
            cost: best.cost.value,
            trajectory: Some(trajectory),
            stop: outcome.stop,
            iterations: ctx.iterations(),
            evaluations: 0,
            seconds: ctx.seconds(),
            history,
            trace,
            memory: None,
        }))
    }
}
