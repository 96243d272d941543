//! What part of the floor the robot covers.

use super::shape::{Shape, norm};
use crate::Point;
use crate::error::PlanError;
use serde::{Deserialize, Serialize};

/// Footprint in the robot's frame: x forward, y left, reference point at the origin, m.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Footprint {
    /// Radius; 0 is a point.
    Disc(f64),
    /// Length (x) and width (y), centred on the reference point.
    Box([f64; 2]),
    /// Convex, counter-clockwise, holds the reference point.
    Polygon(Vec<Point>),
}

impl Default for Footprint {
    fn default() -> Self {
        Self::Disc(0.0)
    }
}

impl Footprint {
    /// Checks ranges and normalises a polygon's sense.
    /// # Errors
    /// [`PlanError::BadParameter`] for sizes that are negative or not finite, or a polygon that is not convex or does not hold the reference point.
    pub fn validated(self) -> Result<Self, PlanError> {
        let size = |v: f64| v.is_finite() && (0.0..=1e6).contains(&v);
        match self {
            Self::Disc(r) if size(r) => Ok(self),
            Self::Disc(r) => Err(PlanError::bad("footprint.disc", r, "a radius from 0 to 1e6 m")),
            Self::Box([l, w]) if size(l) && size(w) && l > 0.0 && w > 0.0 => Ok(self),
            Self::Box(b) => Err(PlanError::bad("footprint.box", format!("{b:?}"), "length and width above 0, at most 1e6 m")),
            Self::Polygon(points) => match Shape::polygon(points)? {
                shape @ Shape::Polygon { .. } if shape.distance([0.0, 0.0]) > 0.0 => {
                    Err(PlanError::bad("footprint.polygon", "its corners", "a polygon that holds the reference point (0, 0)"))
                }
                Shape::Polygon { points } => Ok(Self::Polygon(points)),
                Shape::Disc { .. } => unreachable!("Shape::polygon returns polygons"),
            },
        }
    }

    /// Corners counter-clockwise; `None` for a disc.
    pub fn corners(&self) -> Option<Vec<Point>> {
        match self {
            Self::Disc(_) => None,
            Self::Box([l, w]) => Some(vec![[-l / 2.0, -w / 2.0], [l / 2.0, -w / 2.0], [l / 2.0, w / 2.0], [-l / 2.0, w / 2.0]]),
            Self::Polygon(points) => Some(points.clone()),
        }
    }

    /// Radius of the smallest disc around the reference point that covers the footprint, m: enough for every heading.
    pub fn circumscribed(&self) -> f64 {
        match self {
            Self::Disc(r) => *r,
            _ => self.corners().into_iter().flatten().map(norm).fold(0.0, f64::max),
        }
    }

    /// Radius of the largest disc around the reference point inside the footprint, m: needed for every heading.
    pub fn inscribed(&self) -> f64 {
        match self {
            Self::Disc(r) => *r,
            Self::Box([l, w]) => l.min(*w) / 2.0,
            Self::Polygon(points) => -Shape::Polygon { points: points.clone() }.distance([0.0, 0.0]),
        }
    }

    /// Corners at a pose (x, y in m, yaw in rad), counter-clockwise; `None` for a disc.
    pub fn at(&self, pose: [f64; 3]) -> Option<Vec<Point>> {
        let (s, c) = pose[2].sin_cos();
        self.corners().map(|points| points.into_iter().map(|p| [pose[0] + c * p[0] - s * p[1], pose[1] + s * p[0] + c * p[1]]).collect())
    }
}
