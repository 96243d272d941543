//! Ranges of the parameters that colonies share.

use crate::error::PlanError;

/// A number of ants.
pub fn count(name: &str, value: usize) -> Result<(), PlanError> {
    if (1..=100_000).contains(&value) { Ok(()) } else { Err(PlanError::bad(name, value, "1 to 100000")) }
}

/// Exponents of pheromone and heuristic.
pub fn exponents(alpha: f64, beta: f64) -> Result<(), PlanError> {
    for (name, value) in [("alpha", alpha), ("beta", beta)] {
        if !(0.0..=100.0).contains(&value) {
            return Err(PlanError::bad(name, value, "0 to 100"));
        }
    }
    Ok(())
}

/// A share that may be 0 but not 1.
pub fn share(name: &str, value: f64) -> Result<(), PlanError> {
    if (0.0..1.0).contains(&value) { Ok(()) } else { Err(PlanError::bad(name, value, "0 to 1, 1 excluded")) }
}

/// A positive number.
pub fn positive(name: &str, value: f64) -> Result<(), PlanError> {
    if value > 0.0 && value <= 1e9 { Ok(()) } else { Err(PlanError::bad(name, value, "a number above 0, up to 1e9")) }
}

/// A probability that is neither 0 nor 1.
pub fn probability(name: &str, value: f64) -> Result<(), PlanError> {
    if (1e-9..1.0).contains(&value) { Ok(()) } else { Err(PlanError::bad(name, value, "1e-9 to 1, 1 excluded")) }
}

/// Two values in order.
pub fn order(low: &str, least: f64, high: &str, most: f64) -> Result<(), PlanError> {
    if least <= most { Ok(()) } else { Err(PlanError::bad(low, least, format!("at most `{high}` = {most}"))) }
}

/// Steps of an ant in steps of the best trail.
pub fn leash(value: f64) -> Result<(), PlanError> {
    if value == 0.0 || (1.0..=1e6).contains(&value) { Ok(()) } else { Err(PlanError::bad("leash", value, "0 (none) or 1 to 1e6")) }
}

/// A distance in cells.
pub fn horizon(value: f64) -> Result<(), PlanError> {
    if (0.0..=1e6).contains(&value) { Ok(()) } else { Err(PlanError::bad("horizon", value, "0 (none) to 1e6 cells")) }
}
