//! Sampling planners: trees of random points, with exact tests of every edge.

mod ground;
mod informed_rrt_star;
mod kd;
mod rrt_connect;
mod rrt_star;
mod run;
mod shortcut;
mod star;
mod tree;

pub use informed_rrt_star::InformedRrtStar;
pub use rrt_connect::RrtConnect;
pub use rrt_star::RrtStar;
pub use star::Star;

use crate::error::PlanError;

/// Name, value and range of a parameter.
type Named = (&'static str, f64, [f64; 2]);

fn halvings(value: u32) -> Named {
    ("halvings", f64::from(value), [0.0, 20.0])
}

/// Checks the parameters of a planner.
fn check(planner: &str, step: Option<f64>, named: &[Named]) -> Result<(), PlanError> {
    let step = ("step", step.unwrap_or(1.0), [1e-6, 1e6]);
    match named.iter().chain([&step]).find(|(_, value, range)| !(range[0]..=range[1]).contains(value)) {
        Some((name, value, range)) => Err(PlanError::bad(format!("{planner}.{name}"), value, format!("{} to {}", range[0], range[1]))),
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests;
