//! Ants on a sparse graph with any-angle edges, instead of the lattice.
//!
//! Nodes are the convex corners of the obstacles, the start and the goal; edges are free straight ways that can be part of a shortest path
//! \[lozano1979\] (`corners.rs`). The best way over them is the any-angle optimum, and a map of 250 000 cells has some thousand of them at most. The colony
//! (`colony.rs`) is that of the lattice methods with their own parameters; what is ours is what its ants learn: every node keeps the shortest rest to the
//! goal and to the start that is known (`tails.rs`, \[li2023\]), which takes the place of the straight distance in the heuristic.
//!
//! A robot with a radius, and worlds of shapes, are planned over squares of a fraction of a cell every point of which is clear (`ground.rs`). Where a way is tighter
//! than that, the colony walks the lattice.

mod colony;
mod corners;
mod ground;
mod scan;
mod tails;

use super::improved::{Conversion, Reading};
use super::walk::Trail;
use super::{Found, Task, lost};
use crate::Point;
use crate::context::{Context, Stop};
use crate::error::PlanError;
use crate::path::{ENERGY, Path};
use crate::plan::legs::Leg;
use crate::plan::score::Aim;
use crate::plan::search::{self, Engine, anchor};
use crate::plan::{Solution, through};
use crate::query::Query;
use crate::world::Lattice;
use crate::world::shape::distance;
use colony::Run;
use corners::Corners;
use ground::Ground;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

/// What ants walk on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Graph {
    /// The 8-connected lattice.
    #[default]
    Lattice,
    /// Convex corners of the obstacles with straight free edges: paths at any angle.
    Corners,
}

/// A colony on the sparse graph.
#[derive(Debug, Clone, Copy)]
pub(super) struct Settings {
    pub ants: usize,
    /// Iterations, if the budget names none.
    pub iterations: u64,
    /// Iterations without improvement after which it stops.
    pub patience: u64,
    /// Exponents of the pheromone and the heuristic, first and last.
    pub alpha: [f64; 2],
    pub beta: [f64; 2],
    /// How soldiers become kings, with division of labour.
    pub labour: Option<Conversion>,
    pub evaporation: f64,
    pub deposit: f64,
    pub initial: f64,
    /// Form and mean of the initial concentration, if it falls with the distance from the straight line.
    pub cone: Option<(Reading, f64)>,
    pub bounds: [f64; 2],
    pub elitist: bool,
    pub restart: f64,
    /// Learn the rests of ways?
    pub learning: bool,
    /// See [`super::rule::Choices::with_focus`].
    pub focus: f64,
}

/// Iterations without improvement after which colonies stop that have no such parameter.
pub(super) const PATIENCE: u64 = 15;

/// Share of the shortest way that counts in the choice of an exit.
pub(super) const FOCUS: f64 = 0.02;

/// What is common to the legs of a query.
struct Tour<'a> {
    query: &'a Query,
    settings: Settings,
    aim: Aim,
    lattice: &'a Lattice,
    ground: Ground,
    /// Length so far, m.
    before: f64,
    stop: Stop,
    traces: Vec<Value>,
}

/// Plans a query leg by leg: first the proof that there is a way, then the colony. `lattice` is the colony for legs that only the lattice can solve.
pub(super) fn plan(
    aim: Aim,
    settings: Settings,
    query: &Query,
    ctx: &mut Context,
    mut lattice: impl FnMut(&Task, &mut Context) -> Result<Found, PlanError>,
) -> Result<Solution, PlanError> {
    query.validate()?;
    let cells = query.world.lattice(query.radius());
    let ground = Ground::new(query, &cells);
    let mut tour = Tour { query, settings, aim, lattice: &cells, ground, before: 0.0, stop: Stop::Converged, traces: Vec::new() };
    let points = through(query, |from, to| {
        let points = tour.leg([from, to], ctx, &mut lattice)?;
        tour.before += length(&points);
        Ok(points)
    })?;
    let history = ctx.take_history();
    Ok(Solution {
        path: Path::polyline(&points),
        cost: length(&points),
        cells: None,
        trajectory: None,
        stop: tour.stop,
        iterations: ctx.iterations(),
        evaluations: ctx.evaluations(),
        seconds: ctx.seconds(),
        history,
        trace: json!({ "legs": tour.traces }),
        memory: None,
    })
}

fn length(points: &[Point]) -> f64 {
    points.windows(2).map(|w| distance(w[0], w[1])).sum()
}

impl Tour<'_> {
    fn leg(
        &mut self,
        ends: [Point; 2],
        ctx: &mut Context,
        lattice: &mut impl FnMut(&Task, &mut Context) -> Result<Found, PlanError>,
    ) -> Result<Vec<Point>, PlanError> {
        if ends[0] == ends[1] {
            return Ok(ends.to_vec());
        }
        let query = self.query;
        let (Some(start), Some(goal)) = (anchor(query, self.lattice, ends[0]), anchor(query, self.lattice, ends[1])) else {
            return Err(search::no_path(query, false, Some("no free cell centre of the lattice is in reach of the start or the goal".into())));
        };
        let leg = Leg { query, lattice: self.lattice, start, goal, ends, before: self.before };
        // Ants would walk for ever in a closed room. The path of this search is not looked at.
        search::search(Engine::JumpPoint, &leg, ctx)?;
        let feet = ends.map(|p| self.ground.foot(query, p));
        if let [Some(a), Some(b)] = feet
            && self.ground.joined([a, b])
        {
            return self.corners(ends, [a, b], ctx);
        }
        let roads = super::Streets::new(self.lattice, query.corners);
        let task = Task { leg: &leg, roads: &roads, aim: self.aim, start: roads.node(start), goal: roads.node(goal) };
        let found = lattice(&task, ctx)?;
        self.note(found.stop, json!({ "graph": "lattice" }));
        let Some(trail) = found.best else { return Err(self.nothing(found.stop)) };
        let cells = search::turns(&roads.cells(&trail.nodes));
        Ok(self.pulled(std::iter::once(ends[0]).chain(cells.into_iter().map(|c| self.lattice.center(c))).chain([ends[1]]).collect()))
    }

    /// A leg over corners. `feet` are where the ends stand on the ground, in its cells.
    fn corners(&mut self, ends: [Point; 2], feet: [Point; 2], ctx: &mut Context) -> Result<Vec<Point>, PlanError> {
        let toll = if self.aim == Aim::LeastEnergy { ENERGY[1] / ENERGY[0] * self.ground.fine() } else { 0.0 };
        let sees = |a: Point, b: Point| self.ground.sees(self.query, a, b);
        let roads = Corners::new(self.ground.free(), self.ground.squeeze, feet, toll, sees);
        let mut run = Run::new(&self.settings, &roads, ctx);
        let scale = self.query.world.resolution() / self.ground.fine();
        let before = self.before;
        let stop = run.run(ctx, |best: Option<&Trail>| best.map_or(f64::INFINITY, |t| before + t.score.cost * scale));
        let trace = json!({ "graph": "corners", "corners": roads.count(), "expanded": roads.expanded(), "restarts": run.restarts });
        let best = run.best.take();
        drop(run);
        let way = best.map(|trail| {
            use super::roads::Roads;
            let inner = trail.nodes.iter().map(|n| self.ground.to_map(self.query, roads.position(*n)));
            std::iter::once(ends[0]).chain(inner).chain([ends[1]]).collect()
        });
        self.note(stop, trace);
        way.map_or_else(|| Err(self.nothing(stop)), |points| Ok(self.pulled(points)))
    }

    fn note(&mut self, stop: Stop, trace: Value) {
        if stop != Stop::Converged {
            self.stop = stop;
        }
        self.traces.push(trace);
    }

    fn nothing(&self, stop: Stop) -> PlanError {
        if stop == Stop::Cancelled { PlanError::Cancelled } else { search::no_path(self.query, false, Some(lost(stop).into())) }
    }

    /// Without repeated points, and without those whose neighbours see each other where the graph was only an approximation.
    fn pulled(&self, mut points: Vec<Point>) -> Vec<Point> {
        let inner: Vec<Point> = points[1..points.len() - 1].to_vec();
        let last = points[points.len() - 1];
        points.truncate(1);
        for p in inner {
            if p != points[points.len() - 1] && p != last {
                points.push(p);
            }
        }
        points.push(last);
        let radius = self.query.radius();
        let mut k = 1;
        while !self.ground.exact() && k + 1 < points.len() {
            if self.query.world.segment_free(points[k - 1], points[k + 1], radius) {
                points.remove(k);
                k = k.saturating_sub(1).max(1);
            } else {
                k += 1;
            }
        }
        points
    }
}

#[cfg(test)]
mod tests;
