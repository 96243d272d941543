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

use super::Parameter;
use crate::error::PlanError;

/// Parameters of [`RrtConnect`].
pub const CONNECT: &[Parameter] = &[
    Parameter { name: "preset", about: "default | paper: our settings or those of the source" },
    Parameter { name: "step", about: "longest edge, m; null: a tenth of the diagonal of the world" },
    Parameter { name: "patience", about: "samples per leg after which it gives up" },
    Parameter { name: "halvings", about: "how often a step that is not free is halved and tried again, 0 to 20" },
    Parameter { name: "shortcuts", about: "shortcuts that are tried on the path; 0: it stays as it was found" },
];

/// Parameters of [`RrtStar`] and [`InformedRrtStar`].
pub const STAR: &[Parameter] = &[
    Parameter { name: "preset", about: "default | paper: our settings or those of the source" },
    Parameter { name: "step", about: "longest edge, m; null: a tenth of the diagonal of the world" },
    Parameter { name: "samples", about: "samples per leg, if the budget does not end it" },
    Parameter { name: "patience", about: "samples per leg without a path after which it gives up" },
    Parameter { name: "goal_bias", about: "share of samples at the goal until it is reached, 0 to 1" },
    Parameter { name: "rewire", about: "radius of rewiring, times the least that is proved to lead to the optimum" },
    Parameter { name: "halvings", about: "how often a step that is not free is halved and tried again, 0 to 20" },
    Parameter { name: "shortcuts", about: "shortcuts that are tried on each better path; 0: paths are those of the tree" },
];

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
