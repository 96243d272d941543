//! What the global layer hands to the local one: the motion, its turning points and the cost-to-go.

use super::{CostToGo, Course};
use crate::Point;
use std::sync::Arc;

/// A motion to follow and what helps to leave it and come back.
#[derive(Debug, Clone)]
pub struct Guide {
    /// The timed motion.
    pub course: Arc<Course>,
    /// Turning points of the path in order, the goal last, m.
    pub sub_goals: Vec<Point>,
    /// Cost-to-go to the goal, if the global layer made one.
    pub to_go: Option<Arc<CostToGo>>,
}

impl Guide {
    /// A motion alone; its end is the only sub-goal.
    pub fn along(course: Arc<Course>) -> Self {
        let end = course.end().pose;
        Self { course, sub_goals: vec![[end[0], end[1]]], to_go: None }
    }
}
