//! What the joints can do.

use crate::error::PlanError;
use serde::{Deserialize, Serialize};

/// One value for all joints, or one for each.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum PerJoint {
    /// For all joints.
    All(f64),
    /// Joint by joint.
    Each(Vec<f64>),
}

/// Limits of the joints, each positive; what is left out does not bind. Torque and its rate are limits of the rows that are called for, not read here.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct JointLimits {
    /// rad/s.
    pub speed: Option<PerJoint>,
    /// Acceleration in the direction of motion of the joint, rad/s2.
    pub acceleration: Option<PerJoint>,
    /// Acceleration against the direction of motion of the joint, rad/s2; left out: as `acceleration`.
    pub deceleration: Option<PerJoint>,
    /// rad/s3.
    pub jerk: Option<PerJoint>,
    /// N m.
    pub torque: Option<PerJoint>,
    /// N m/s.
    pub torque_rate: Option<PerJoint>,
}

/// Limits joint by joint; what does not bind is infinite.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Bounds {
    pub speed: Vec<f64>,
    pub acceleration: Vec<f64>,
    pub deceleration: Vec<f64>,
    pub jerk: Vec<f64>,
}

impl JointLimits {
    /// For each of `joints`.
    /// # Errors
    /// [`PlanError::BadParameter`] names the limit that is not positive or not as many as the joints.
    pub(super) fn bounds(&self, joints: usize) -> Result<Bounds, PlanError> {
        let each = |name: &str, limit: &Option<PerJoint>| {
            let values = match limit {
                None => return Ok(None),
                Some(PerJoint::All(v)) => vec![*v; joints],
                Some(PerJoint::Each(values)) => values.clone(),
            };
            if values.len() != joints {
                return Err(PlanError::bad(
                    format!("limits.{name}"),
                    format!("{} values", values.len()),
                    format!("one value, or one for each of {joints} joints"),
                ));
            }
            match values.iter().position(|v| v.is_nan() || *v <= 0.0) {
                Some(i) => Err(PlanError::bad(format!("limits.{name}"), values[i], format!("a positive number (joint {})", i + 1))),
                None => Ok(Some(values)),
            }
        };
        let free = || vec![f64::INFINITY; joints];
        let acceleration = each("acceleration", &self.acceleration)?.unwrap_or_else(free);
        each("torque", &self.torque)?;
        each("torque_rate", &self.torque_rate)?;
        Ok(Bounds {
            speed: each("speed", &self.speed)?.unwrap_or_else(free),
            deceleration: each("deceleration", &self.deceleration)?.unwrap_or_else(|| acceleration.clone()),
            acceleration,
            jerk: each("jerk", &self.jerk)?.unwrap_or_else(free),
        })
    }
}

impl Bounds {
    /// Acceleration bounds of joint `i` where its speed per path speed goes from `q[0]` to `q[1]`.
    pub fn acceleration(&self, i: usize, q: [f64; 2]) -> [f64; 2] {
        let (a, d) = (self.acceleration[i], self.deceleration[i]);
        if q[0] >= 0.0 && q[1] >= 0.0 {
            [-d, a]
        } else if q[0] <= 0.0 && q[1] <= 0.0 {
            [-a, d]
        } else {
            [-a.min(d), a.min(d)]
        }
    }
}
