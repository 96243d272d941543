//! Independent checkers: they share no code with what they check, and sample finer.

mod check;
pub mod motion;

pub use check::Check;
