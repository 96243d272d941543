//! A plan on its way from the global layer: what is asked, what comes of it, and when it is there.

use super::ask::Ask;
use super::{Course, Guide, Robot};
use crate::context::Context;
use crate::error::PlanError;
use crate::timing::Trajectory;
use std::sync::Arc;
use std::time::Instant;

/// When a plan that was asked for can be driven.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub enum Delivery {
    /// In the step that asks for it, which takes as long as the planner: a simulated world stands still meanwhile.
    #[default]
    AtOnce,
    /// In the first step that comes so long after the one that asked, s.
    After(f64),
    /// When somebody has made it: see [`Pilot::request`](super::Pilot::request).
    Elsewhere,
}

/// A plan that is asked for.
#[derive(Debug, Clone)]
pub struct Request {
    /// Radius of the disc that is to fit, m, and what is asked with it; tried in order.
    pub(super) asks: Vec<(f64, Ask)>,
    /// A course that is longer is not wanted, m.
    pub(super) most: f64,
    pub(super) robot: Robot,
    pub(super) seed: u64,
    pub(super) threads: usize,
    /// Which request of the run it is.
    pub(super) number: u64,
}

/// What came of a [`Request`].
#[derive(Debug)]
pub struct Found {
    /// The guide and the radius of its disc, m; `None` where it is longer than wanted.
    pub(super) guide: Result<Option<(Guide, f64)>, PlanError>,
    /// Wall-clock time that it took, s.
    pub(super) seconds: f64,
    pub(super) number: u64,
}

impl Request {
    /// Makes the plan, with all that a step would else have to compute for it.
    pub fn solve(&self, plan: impl Fn(&Ask, &mut Context) -> Result<Trajectory, PlanError>) -> Found {
        let started = Instant::now();
        let mut ctx = Context::new(self.seed).with_threads(self.threads);
        let mut found = Err(PlanError::bad("world", "what the robot knows", "a world to plan in"));
        for (radius, ask) in &self.asks {
            found = plan(ask, &mut ctx).and_then(|trajectory| Course::new(&trajectory)).map(|course| (course, *radius, ask));
            if matches!(found, Ok(_) | Err(PlanError::Cancelled)) {
                break;
            }
        }
        let wanted = |course: &Course| course.length() <= self.most;
        let guide = found.map(|(course, radius, ask)| wanted(&course).then(|| (Guide::within(Arc::new(course), &ask.query, &self.robot), radius)));
        Found { guide, seconds: started.elapsed().as_secs_f64(), number: self.number }
    }
}
