//! Motion planning for industrial robots: a map in, a motion out.
//!
//! Data flows one way, and the modules stand in that order:
//!
//! ```text
//! World --Query--> Path --Limits--> Trajectory --Plant--> Run
//! ```

pub mod certify;
pub mod context;
pub mod drive;
pub mod error;
pub mod path;
pub mod plan;
pub mod query;
pub mod refine;
pub mod timing;
pub mod world;

/// A point in the plane, m, map frame: x forward or east, y left or north.
pub type Point = [f64; 2];
