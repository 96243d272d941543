//! What is asked of the global layer when a new plan is needed.

use super::{Course, Observation, Robot};
use crate::Point;
use crate::context::Context;
use crate::error::PlanError;
use crate::plan::search::Visibility;
use crate::plan::{Planner, Solution};
use crate::query::{Limits, Query};
use crate::refine::{Refiner, Smooth};
use crate::timing::{self, TimingOptions, Trajectory};
use crate::world::shape::distance;
use crate::world::{Footprint, Shape, SpeedMap, World};
use std::sync::{Arc, Mutex, PoisonError};

/// Room to obstacles below which no plan is asked for where the covering disc does not fit, m beyond the inscribed circle.
const TIGHT: f64 = 0.02;
/// Movers in the way are grown by this for planning, m: controllers keep off them, and they do not stand quite still.
const GROWN: f64 = 0.15;
/// A robot is at rest below this, m/s.
const SLOW: f64 = 0.05;
/// Room left around the robot's own place and the goal, m.
const SPARE: f64 = 1e-6;

/// A new plan from where the robot is, in the world as it knows it, with what is in the way.
#[derive(Debug, Clone)]
pub struct Ask {
    /// From where to where. The start heading is set if the robot is at rest.
    pub query: Query,
    /// Speed of the robot, m/s.
    pub speed: f64,
}

/// Plans and times a new motion.
pub type Replanner<'a> = dyn Fn(&Ask, &mut Context) -> Result<Trajectory, PlanError> + Sync + 'a;

/// A planner, the smoothing and the timing in one, with what the planner remembers from plan to plan.
pub struct Planning {
    planner: Box<dyn Planner>,
    limits: Limits,
    speed_map: Option<Arc<SpeedMap>>,
    previous: Mutex<Option<Solution>>,
}

impl Planning {
    /// Plans with `planner` and moves within `limits`.
    pub fn new(planner: Box<dyn Planner>, limits: Limits) -> Self {
        Self { planner, limits, speed_map: None, previous: Mutex::new(None) }
    }

    /// Motions keep to the speeds of a map as well.
    #[must_use]
    pub fn with_speed_map(mut self, map: Option<Arc<SpeedMap>>) -> Self {
        self.speed_map = map;
        self
    }

    /// A motion for what is asked: the planner repairs its last plan if it can, where it finds none the exact one is asked, a path that cannot be smoothed is driven as it is, and one that cannot be entered at the
    /// robot's speed is entered from rest.
    /// # Errors
    /// Those of the planner and of the timing.
    pub fn motion(&self, ask: &Ask, ctx: &mut Context) -> Result<Trajectory, PlanError> {
        let query = &ask.query;
        let mut previous = self.previous.lock().unwrap_or_else(PoisonError::into_inner);
        let found = match previous.as_ref() {
            Some(known) => self.planner.replan(known, query, ctx),
            None => self.planner.plan(query, ctx),
        };
        let found = match found {
            // Beside an obstacle the cell of the robot's own place may be none that is free.
            Err(error @ (PlanError::NoPath(_) | PlanError::StartBlocked { .. })) => Visibility::default().plan(query, ctx).map_err(|_| error)?.path,
            found => {
                let solution = found?;
                let path = solution.path.clone();
                *previous = Some(solution);
                path
            }
        };
        let path = Smooth::default().refine(&found, query, ctx).map_or(found, |refined| refined.path);
        let start_speed = ask.speed.clamp(0.0, self.limits.speed);
        let zones = self.speed_map.as_deref().map(|map| |s: f64| map.around(path.planar(s).point));
        let clearance_ceiling = zones.as_ref().map(|f| f as &dyn Fn(f64) -> f64);
        let options =
            TimingOptions { clearance_ceiling, start_yaw: query.start_yaw, goal_yaw: query.goal_yaw, start_speed, ..TimingOptions::default() };
        match timing::time(&path, &self.limits, &options, ctx) {
            Err(_) if start_speed > 0.0 => timing::time(&path, &self.limits, &TimingOptions { start_speed: 0.0, ..options }, ctx),
            result => result,
        }
    }
}

/// What is asked where a disc of some radius is to fit, the largest first: the disc that covers the robot with its clearance and without, then the inscribed one
/// and a little. Each shrinks as far as the robot's own place needs it, so that it can leave. A robot that keeps `rolling` starts at its speed.
pub(super) fn asks(
    (query, robot): (&Query, &Robot),
    (seen, rolling): (&Observation, bool),
    world: &World,
    (course, s): (&Course, f64),
    extra: &[(Point, f64)],
) -> Vec<(f64, Ask)> {
    let start = [seen.pose[0], seen.pose[1]];
    let (body, core) = (robot.footprint.circumscribed(), robot.footprint.inscribed());
    let room = world.clearance(start) - SPARE;
    let mut radii: Vec<f64> = [body + query.clearance, body, (core + TIGHT).min(body)].map(|r| r.min(room).max(0.0)).to_vec();
    radii.dedup();
    let ahead = |p: &&Point| course.project(**p, 0.0, course.length()).0 > s + 0.1;
    let via: Vec<Point> = query.via.iter().filter(ahead).copied().collect();
    let resting = seen.v < SLOW || !rolling;
    let ask = |radius: f64| {
        let (footprint, clearance) = if radius >= body { (robot.footprint.clone(), radius - body) } else { (Footprint::Disc(radius), 0.0) };
        let shapes = extra.iter().filter_map(|&(center, r)| around(center, r + GROWN, radius, [start, query.goal]));
        let start_yaw = resting.then_some(seen.pose[2]);
        let query = Query { world: Arc::new(world.extended(shapes)), start, start_yaw, via: via.clone(), clearance, footprint, ..query.clone() };
        (radius, Ask { query, speed: if resting { 0.0 } else { seen.v } })
    };
    radii.into_iter().map(ask).collect()
}

/// A disc as an obstacle that leaves the robot's own place and the goal free, if anything is left of it.
fn around(center: Point, radius: f64, body: f64, free: [Point; 2]) -> Option<Shape> {
    let radius = free.iter().map(|p| distance(center, *p) - body - SPARE).fold(radius, f64::min);
    (radius > 0.0).then_some(Shape::Disc { center, radius })
}

#[cfg(test)]
mod tests {
    use super::super::testing::limits;
    use super::*;
    use crate::plan;
    use serde_json::Value;

    /// Between the cells: the robot has come beside a disc that covers the middle of the only cell it could begin in.
    #[test]
    fn where_a_planner_on_cells_cannot_begin_the_exact_one_is_asked() {
        let walls = [[0.0, 0.0, 6.0, 2.0], [0.0, 3.0, 6.0, 4.0]];
        let wall = |[x0, y0, x1, y1]: [f64; 4]| Shape::polygon(vec![[x0, y0], [x1, y0], [x1, y1], [x0, y1]]).unwrap();
        let disc = Shape::Disc { center: [2.5, 2.5], radius: 0.2 };
        let world = Arc::new(World::from_shapes([0.0, 0.0, 6.0, 4.0], walls.map(wall).into_iter().chain([disc]).collect(), 1.0).unwrap());
        let query = Query { footprint: Footprint::Disc(0.1), ..Query::new(world, [2.9, 2.5], [5.5, 2.5]) };
        let astar = || plan::planner("astar", Value::Null).unwrap();
        assert!(astar().plan(&query, &mut Context::new(0)).is_err());
        let motion = |query: &Query| Planning::new(astar(), limits()).motion(&Ask { query: query.clone(), speed: 0.0 }, &mut Context::new(0));
        assert!((motion(&query).unwrap().path.length() - 2.6).abs() < 1e-6);
        let closed = Query { world: Arc::new(query.world.extended([wall([4.0, 1.0, 4.5, 3.5])])), ..query };
        assert!(matches!(motion(&closed), Err(PlanError::NoPath(_))), "the planner's own error");
    }
}
