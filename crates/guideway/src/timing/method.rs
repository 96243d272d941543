//! The ways to put a path into time under its ceiling.

use super::ceiling::Ceiling;
use super::correction::correct;
use super::profile::fastest;
use super::scurve::{Bounds, Profile, advance};
use super::trapezoid::trapezoid;
use crate::error::PlanError;
use serde::{Deserialize, Serialize};

/// How the speed along a path is found.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Method {
    /// Jerk-limited, near the time optimum and never slower than `Iascv`: [`fastest`].
    #[default]
    TimeOptimal,
    /// Seven-phase S-curves between nodes, corrected until the ceiling is kept: [`correct`].
    Iascv,
    /// Acceleration-limited only: the acceleration jumps, which no certificate passes. The baseline that methods without jerk limit drive.
    Trapezoid,
}

impl Method {
    /// Names in files and on the command line.
    pub const NAMES: [&'static str; 3] = ["time-optimal", "iascv", "trapezoid"];

    /// From its name.
    /// # Errors
    /// [`PlanError::BadParameter`] names the valid ones.
    pub fn named(name: &str) -> Result<Self, PlanError> {
        match name {
            "time-optimal" => Ok(Self::TimeOptimal),
            "iascv" => Ok(Self::Iascv),
            "trapezoid" => Ok(Self::Trapezoid),
            other => Err(PlanError::bad("method", other, format!("one of {}", Self::NAMES.join(", ")))),
        }
    }

    /// The motion under a ceiling that starts at arc length `from` (m), from and to the given speeds (m/s).
    pub(super) fn stretch(self, from: f64, ceiling: &Ceiling, bounds: &Bounds, ends: (f64, f64)) -> Result<Vec<Step>, PlanError> {
        let chain = match self {
            Self::TimeOptimal => fastest(ceiling, bounds, ends)?,
            Self::Iascv => correct(ceiling, bounds, ends)?.chain,
            Self::Trapezoid => {
                let mut steps = trapezoid(ceiling, bounds, ends)?;
                for step in &mut steps {
                    step.s += from;
                }
                return Ok(steps);
            }
        };
        Ok(chain.iter().flat_map(|(s, profile)| steps(from + s, profile)).collect())
    }
}

/// A stretch of constant jerk; values at its start.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Step {
    /// m.
    pub s: f64,
    /// m/s.
    pub speed: f64,
    /// m/s2.
    pub acceleration: f64,
    /// m/s3.
    pub jerk: f64,
    /// s.
    pub duration: f64,
}

/// The phases of a profile that starts at arc length `from` (m), without the empty ones.
pub(super) fn steps(from: f64, profile: &Profile) -> Vec<Step> {
    let (v, a) = profile.start();
    let mut state = (from, v, a);
    let phases = profile.phases().iter().filter(|p| p.duration > 0.0);
    phases
        .map(|p| {
            let (s, speed, acceleration) = state;
            state = advance(state, p.jerk, p.duration);
            Step { s, speed, acceleration, jerk: p.jerk, duration: p.duration }
        })
        .collect()
}
