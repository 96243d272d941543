//! Independent checkers: they share no code with what they check, and sample finer.

mod check;
mod collision;
mod curvature;
mod ground;
pub mod motion;
mod zones;

pub use check::Check;
pub use collision::{Collision, collision, marking};
pub use curvature::curvature;
pub use zones::zones;
