//! What a continuous planner minimises, and over which curves.

use super::curves::Judged;
use crate::error::PlanError;
use crate::query::Query;
use serde::{Deserialize, Serialize};

/// Weight of the share of overspeed.
const OVERSPEED: f64 = 0.5;
/// Least clearance in the literal objective, m: one over it stays finite.
const LEAST: f64 = 1e-3;

/// Form of the objective (section 5.2 of the page on paths as splines).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Form {
    /// Every term is a share of a reference, so that units cancel and none runs away.
    #[default]
    Repaired,
    /// As printed: the sum of heading accelerations at 10 Hz in rad/s2, and one over the clearance in 1/m.
    Literal,
}

/// Encoding and objective. `None` in a reference takes the rule of its description.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Settings {
    /// Free control points `n_c` of each leg, 3 to 1000; 0: as many as the route needs.
    pub points: usize,
    /// Three scales of speed, acceleration and jerk, 0.3 to 1, are searched as well.
    pub scales: bool,
    /// Form of the objective.
    pub objective: Form,
    /// Weights `w1..w4` of length, time, turning and clearance, each at least 0.
    pub weights: [f64; 4],
    /// `L_max`, m; `None`: half of the perimeter of the world.
    pub length_ref: Option<f64>,
    /// `T_max`, s; `None`: 1.5 `L_max` at the speed limit.
    pub time_ref: Option<f64>,
    /// `Theta_ref`, rad/s.
    pub turn_ref: f64,
    /// `d_safe` of the clearance term, m; `None`: what the query keeps free around the reference point.
    pub safe: Option<f64>,
    /// Candidates along exact routes are in the first population.
    pub hints: bool,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            points: 0,
            scales: false,
            objective: Form::Repaired,
            weights: [0.4, 0.3, 0.2, 0.1],
            length_ref: None,
            time_ref: None,
            turn_ref: 40.0,
            safe: None,
            hints: true,
        }
    }
}

impl Settings {
    /// Settings of the source: five control points, three scales, no hints.
    pub fn paper() -> Self {
        Self { points: 5, scales: true, hints: false, ..Self::default() }
    }

    pub(in crate::plan::swarm) fn check(&self) -> Result<(), PlanError> {
        if !(self.points == 0 || (3..=1000).contains(&self.points)) {
            return Err(PlanError::bad("points", self.points, "3 to 1000 control points of a leg, or 0: as many as the route needs"));
        }
        let weights = self.weights;
        if !(weights.iter().all(|w| w.is_finite() && (0.0..=1e6).contains(w)) && weights.iter().sum::<f64>() > 0.0) {
            return Err(PlanError::bad("weights", format!("{weights:?}"), "four numbers from 0 to 1e6, not all 0"));
        }
        let named = [("length_ref", self.length_ref), ("time_ref", self.time_ref), ("turn_ref", Some(self.turn_ref))];
        for (name, value) in named.into_iter().filter_map(|(n, v)| v.map(|v| (n, v))) {
            if !(1e-6..=1e9).contains(&value) {
                return Err(PlanError::bad(name, value, "a number from 1e-6 to 1e9"));
            }
        }
        match self.safe {
            Some(safe) if !(0.0..=1e6).contains(&safe) => Err(PlanError::bad("safe", safe, "0 to 1e6 m")),
            _ => Ok(()),
        }
    }

    /// The objective, of terms that are known.
    pub(super) fn value(&self, judged: &Judged, to: References) -> f64 {
        let [w1, w2, w3, w4] = self.weights;
        let near = judged.clearance.max(0.0);
        let (turning, clearance) = match self.objective {
            Form::Repaired => ((judged.turning / to.turn).min(1.0), if to.safe > near { 1.0 } else { to.safe / near.max(1e-300) }),
            Form::Literal => (judged.turning, 1.0 / near.max(LEAST)),
        };
        w1 * judged.length / to.length + w2 * judged.time / to.time + w3 * turning + w4 * clearance + OVERSPEED * judged.overspeed // (4)
    }

    /// The objective of terms that are known.
    pub(in crate::plan::swarm) fn worth(&self, judged: &Judged, query: &Query) -> f64 {
        self.value(judged, self.scale(query))
    }

    pub(super) fn scale(&self, query: &Query) -> References {
        let [x0, y0, x1, y1] = query.world.bounds();
        let length = self.length_ref.unwrap_or(x1 - x0 + y1 - y0);
        let time = self.time_ref.unwrap_or(1.5 * length / query.limits.speed);
        References { length, time, turn: self.turn_ref, safe: self.safe.unwrap_or_else(|| query.radius()) }
    }
}

/// What the terms of the objective are shares of.
#[derive(Debug, Clone, Copy)]
pub(super) struct References {
    pub length: f64,
    pub time: f64,
    pub turn: f64,
    pub safe: f64,
}
