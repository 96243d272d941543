//! Motion planning for industrial robots: a map in, a motion out.
//!
//! Data flows one way, and the modules stand in that order:
//!
//! ```text
//! World --Query--> Path --Limits--> Trajectory --Plant--> Run
//! ```
//!
//! ```
//! use guideway::{context::Context, drive, plan, query::{Limits, Query}, refine::{Refiner, Smooth}, timing, world::{Footprint, Shape, World}};
//! # fn main() -> Result<(), guideway::error::PlanError> {
//! let pillar = Shape::disc([3.0, 2.0], 0.5)?;
//! let world = World::from_shapes([0.0, 0.0, 6.0, 4.0], vec![pillar], 0.05)?;
//! let mut query = Query::new(world.into(), [1.0, 2.0], [5.0, 2.0]);
//! (query.footprint, query.clearance) = (Footprint::Disc(0.2), 0.1);
//!
//! let mut ctx = Context::new(7); // the seed
//! let solution = plan::planner("visibility", serde_json::Value::Null)?.plan(&query, &mut ctx)?; // the exact shortest path
//! let path = Smooth::default().refine(&solution.path, &query, &mut ctx)?.path; // a spline, proved free
//! let motion = timing::time(&path, &Limits::default(), &timing::TimingOptions::default(), &mut ctx)?;
//!
//! let job = drive::Job::new(&query, &motion)?;
//! let setup = drive::Setup { world: query.world.clone(), robot: job.robot.clone(), clearance: query.clearance };
//! let mut controller = drive::controller("tracker", serde_json::Value::Null, &setup)?;
//! let run = drive::execute(&job, controller.as_mut(), &mut ctx)?;
//! assert_eq!(run.outcome, drive::Outcome::Arrived);
//! # Ok(())
//! # }
//! ```

#![warn(missing_docs)]

pub mod certify;
pub mod context;
pub mod drive;
pub mod error;
pub mod optimize;
pub mod path;
pub mod plan;
pub mod query;
pub mod refine;
pub mod timing;
pub mod world;

/// A point in the plane, m, map frame: x forward or east, y left or north.
pub type Point = [f64; 2];
