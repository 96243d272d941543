//! Limits at the points of a fixed grid: what the kernel takes, and what callbacks give.

use super::strips::Columns;
use crate::error::PlanError;

/// Limits `low <= a u + b x + d sqrt(x) + c <= high` at places, in the path acceleration `u` (rad/s2) and the squared path speed `x` (rad2/s2): arrays of
/// `places * count` values, place after place.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Rows {
    /// Rows per place.
    pub count: usize,
    /// Coefficient of the path acceleration.
    pub a: Vec<f64>,
    /// Coefficient of the squared path speed.
    pub b: Vec<f64>,
    /// Constant part.
    pub c: Vec<f64>,
    /// Coefficient of the path speed (viscous friction); empty: none.
    pub d: Vec<f64>,
    /// Lower bound, may be minus infinity.
    pub low: Vec<f64>,
    /// Upper bound, may be infinity.
    pub high: Vec<f64>,
}

impl Rows {
    /// Rows of one place.
    pub(super) fn at(&self, k: usize) -> Columns<'_> {
        let range = k * self.count..(k + 1) * self.count;
        Columns {
            a: &self.a[range.clone()],
            b: &self.b[range.clone()],
            c: &self.c[range.clone()],
            bottom: &self.low[range.clone()],
            top: &self.high[range],
        }
    }

    /// Rows of some of the places.
    pub(super) fn only(&self, places: &[usize]) -> Self {
        let pick = |values: &[f64]| places.iter().flat_map(|k| values[k * self.count..(k + 1) * self.count].iter().copied()).collect();
        Self {
            count: self.count,
            a: pick(&self.a),
            b: pick(&self.b),
            c: pick(&self.c),
            d: pick(&self.d),
            low: pick(&self.low),
            high: pick(&self.high),
        }
    }

    /// Itself, if it has values for so many places that are numbers.
    /// # Errors
    /// [`PlanError::BadParameter`] names the array.
    pub fn checked(self, places: usize) -> Result<Self, PlanError> {
        let size = places * self.count;
        for (name, values) in [("a", &self.a), ("b", &self.b), ("c", &self.c), ("d", &self.d)] {
            let fits = values.len() == size || (name == "d" && values.is_empty());
            if !fits || !values.iter().all(|v| v.is_finite()) {
                return Err(PlanError::bad(
                    format!("rows.{name}"),
                    format!("{} values", values.len()),
                    format!("{places} x {} finite values", self.count),
                ));
            }
        }
        let ordered = self.low.len() == size && self.high.len() == size && self.low.iter().zip(&self.high).all(|(l, h)| l <= h);
        if !ordered {
            let shown = format!("{} and {} values", self.low.len(), self.high.len());
            return Err(PlanError::bad("rows.low, rows.high", shown, format!("{places} x {} values, low <= high", self.count)));
        }
        Ok(self)
    }
}
