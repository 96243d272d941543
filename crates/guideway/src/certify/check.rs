//! One line of a certificate.

use serde::Serialize;

/// One property that was checked over a whole result.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Check {
    /// What was checked, e.g. `speed`.
    pub name: &'static str,
    /// Whether it holds.
    pub ok: bool,
    /// The worst value that was seen, in the unit of the limit.
    pub worst: f64,
    /// What it was held against; `None`: unlimited.
    pub limit: Option<f64>,
    /// Where the worst value is: time in s along a motion, arc length in m along a path.
    pub at: f64,
}

impl Check {
    /// A check of an upper limit, with the worst value still at its start.
    pub fn below(name: &'static str, limit: Option<f64>) -> Self {
        Self { name, ok: true, worst: f64::NEG_INFINITY, limit, at: 0.0 }
    }

    /// Takes a value seen at `at` into account; `slack` is what rounding may add to the limit. Not a number is never right.
    pub fn see(&mut self, value: f64, at: f64, slack: f64) {
        if value > self.worst || value.is_nan() {
            (self.worst, self.at) = (value, at);
        }
        if value.is_nan() || self.limit.is_some_and(|limit| value > limit + slack) {
            self.ok = false;
        }
    }
}
