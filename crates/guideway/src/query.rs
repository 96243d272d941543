//! What is asked: from where to where, with which robot, how close to obstacles.

use crate::Point;
use crate::error::PlanError;
use crate::world::{Corners, Footprint, World};
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// Points nearer to an obstacle than this take the security marking off, m.
const LEAST_MARKING: f64 = 1e-6;

/// Transported material; it picks the product (shortest, safest, least energy).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Material {
    /// Shortest path.
    #[default]
    Standard,
    /// Safest path: no contact with obstacles, room for the load.
    Long,
    /// Least energy: few turns, smooth.
    Heavy,
}

/// Limits of a motion along a path. SI units; `None` is unlimited.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Limits {
    /// Largest speed, m/s.
    pub speed: f64,
    /// Largest acceleration, m/s2.
    pub acceleration: f64,
    /// Largest deceleration, m/s2, positive.
    pub deceleration: f64,
    /// Largest jerk, m/s3.
    pub jerk: f64,
    /// Largest turn rate, rad/s.
    pub turn_rate: Option<f64>,
    /// Largest turn acceleration, rad/s2 (turns in place).
    pub turn_acceleration: Option<f64>,
    /// Largest lateral acceleration, m/s2.
    pub lateral_acceleration: Option<f64>,
}

impl Default for Limits {
    fn default() -> Self {
        Self { speed: 1.0, acceleration: 0.5, deceleration: 0.5, jerk: 2.0, turn_rate: None, turn_acceleration: None, lateral_acceleration: None }
    }
}

impl Limits {
    /// Checks that every limit is positive and finite.
    /// # Errors
    /// [`PlanError::BadParameter`] names the first that is not.
    pub fn validated(self) -> Result<Self, PlanError> {
        let named = [("speed", self.speed), ("acceleration", self.acceleration), ("deceleration", self.deceleration), ("jerk", self.jerk)];
        let optional =
            [("turn_rate", self.turn_rate), ("turn_acceleration", self.turn_acceleration), ("lateral_acceleration", self.lateral_acceleration)];
        for (name, value) in named.into_iter().chain(optional.into_iter().filter_map(|(n, v)| v.map(|v| (n, v)))) {
            if !(value.is_finite() && (1e-6..=1e6).contains(&value)) {
                return Err(PlanError::bad(format!("limits.{name}"), value, "a number from 1e-6 to 1e6"));
            }
        }
        Ok(self)
    }
}

/// Soft clearance: a metre nearer to obstacles than `clearance` beyond what the robot needs costs more, up to `1 + weight` times.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Soft {
    /// m beyond the radius that is kept free.
    pub clearance: f64,
    /// Additional cost of a metre where that radius touches.
    pub weight: f64,
}

impl Default for Soft {
    fn default() -> Self {
        Self { clearance: 0.3, weight: 2.0 }
    }
}

impl Soft {
    /// No soft clearance.
    pub const NONE: Self = Self { clearance: 0.0, weight: 0.0 };

    /// The same if it makes sense.
    /// # Errors
    /// [`PlanError::BadParameter`] for a negative, huge or not finite value.
    pub fn validated(self) -> Result<Self, PlanError> {
        let named = [("soft_clearance", self.clearance, 1e3), ("soft_clearance.weight", self.weight, 100.0)];
        match named.into_iter().find(|(_, v, most)| !(0.0..=*most).contains(v)) {
            Some((name, v, most)) => Err(PlanError::bad(name, v, format!("0 to {most}"))),
            None => Ok(self),
        }
    }

    /// Cost of a metre where `spare` (m) is left beyond the radius that is kept free: 1 in the open.
    #[inline]
    pub fn price(self, spare: f64) -> f64 {
        1.0 + self.weight * (1.0 - spare / self.clearance.max(1e-9)).clamp(0.0, 1.0)
    }
}

/// A planning query. Build with [`Query::new`], refine with the public fields, and every method validates once with [`Query::validate`].
#[derive(Debug, Clone)]
pub struct Query {
    /// The shared world.
    pub world: Arc<World>,
    /// Start, m.
    pub start: Point,
    /// Heading at the start, rad (`None`: any).
    pub start_yaw: Option<f64>,
    /// Goal, m.
    pub goal: Point,
    /// Heading at the goal, rad (`None`: any).
    pub goal_yaw: Option<f64>,
    /// Points to pass in order, m.
    pub via: Vec<Point>,
    /// What the robot covers.
    pub footprint: Footprint,
    /// Distance to keep between footprint and obstacles, m.
    pub clearance: f64,
    /// Soft clearance: planners on the lattice that can (`astar`, `dijkstra`) minimise the length weighed by it, and refinement keeps to it.
    pub soft: Option<Soft>,
    /// Half the width of the load, m; it counts where [`Material::Long`] is carried.
    pub half_width: f64,
    /// When a diagonal step on a grid is allowed.
    pub corners: Corners,
    /// Transported material.
    pub material: Material,
    /// What a motion may do; read by planners that plan path and speed at once.
    pub limits: Limits,
}

impl Query {
    /// A point robot without clearance.
    pub fn new(world: Arc<World>, start: Point, goal: Point) -> Self {
        Self {
            world,
            start,
            start_yaw: None,
            goal,
            goal_yaw: None,
            via: Vec::new(),
            footprint: Footprint::default(),
            clearance: 0.0,
            soft: None,
            half_width: 0.0,
            corners: Corners::default(),
            material: Material::default(),
            limits: Limits::default(),
        }
    }

    /// Radius of the disc that planners keep free around the reference point, m: circumscribed footprint plus clearance, enough for every heading.
    ///
    /// For long loads the half-width counts where it exceeds the footprint, and, with the corner rule `clear`, the security marking: at least half a
    /// cell, which is what a lattice path under that rule keeps anyway (proof at `refine::SecurityMarking`). Where a start, goal or via point is
    /// nearer to an obstacle than half a cell, as much as the nearest of them has; so the marking never blocks a point. It looks the points up: keep
    /// the value in loops.
    pub fn radius(&self) -> f64 {
        let long = self.material == Material::Long;
        let body = self.footprint.circumscribed();
        let needed = if long { body.max(self.half_width) } else { body } + self.clearance;
        let marked = 0.5 * self.world.resolution();
        if !long || self.corners != Corners::Clear || needed >= marked {
            return needed;
        }
        let admitted = self.stops().into_iter().map(|p| self.world.clearance_within(p, marked)).fold(marked, f64::min);
        // A point that touches an obstacle admits nothing.
        if admitted > LEAST_MARKING { needed.max(admitted) } else { needed }
    }

    /// Start, via points and goal, in order.
    pub fn stops(&self) -> Vec<Point> {
        let mut stops = Vec::with_capacity(self.via.len() + 2);
        stops.push(self.start);
        stops.extend_from_slice(&self.via);
        stops.push(self.goal);
        stops
    }

    /// Checks the query against its world.
    /// # Errors
    /// [`PlanError::BadParameter`], [`PlanError::OutsideMap`], [`PlanError::StartBlocked`], [`PlanError::GoalBlocked`].
    pub fn validate(&self) -> Result<(), PlanError> {
        if !(self.clearance.is_finite() && (0.0..=1e6).contains(&self.clearance)) {
            return Err(PlanError::bad("clearance", self.clearance, "0 to 1e6 m"));
        }
        if !(self.half_width.is_finite() && (0.0..=1e6).contains(&self.half_width)) {
            return Err(PlanError::bad("half_width", self.half_width, "0 to 1e6 m"));
        }
        for (name, yaw) in [("start yaw", self.start_yaw), ("goal yaw", self.goal_yaw)] {
            if let Some(yaw) = yaw.filter(|yaw| !yaw.is_finite()) {
                return Err(PlanError::bad(name, yaw, "a finite angle, rad"));
            }
        }
        self.limits.validated()?;
        self.soft.map_or(Ok(Soft::NONE), Soft::validated)?;
        let needed = self.radius();
        let stops = 1 + self.via.len();
        for (i, point) in std::iter::once(&self.start).chain(&self.via).chain(std::iter::once(&self.goal)).enumerate() {
            let what = if i == 0 {
                "start"
            } else if i == stops {
                "goal"
            } else {
                "via point"
            };
            if !point.iter().all(|v| v.is_finite()) {
                return Err(PlanError::bad(what, format!("({}, {})", point[0], point[1]), "two finite coordinates in m"));
            }
            if !self.world.contains(*point) {
                return Err(PlanError::OutsideMap { what: what.into(), point: *point, bounds: self.world.bounds() });
            }
            if !self.world.fits(*point, needed) {
                let clearance = self.world.clearance(*point);
                return Err(if i == 0 {
                    PlanError::StartBlocked { point: *point, clearance, needed }
                } else {
                    PlanError::GoalBlocked { point: *point, clearance, needed }
                });
            }
        }
        Ok(())
    }
}
