//! What the global layer hands to the local one: the motion, its turning points and the cost-to-go.

use super::{CostToGo, Course, Robot};
use crate::Point;
use crate::query::Query;
use crate::world::shape::{distance, point_segment};
use std::sync::Arc;

/// The path stays within this of the chain of its turning points, m.
const BEND: f64 = 0.1;
/// Samples of a course that are looked at for turning points are so far apart, m.
const APART: f64 = 0.05;
/// A sub-goal this near is reached, m.
const REACHED: f64 = 0.5;
/// The robot is projected on the path so far before and beyond a sub-goal, m.
const AROUND: f64 = 2.0;
/// It is before a sub-goal again once it is so much before it, m: noise makes no passing.
const BACK: f64 = 0.3;
/// One passed at a greater distance is missed, m.
const MISSED: f64 = 1.0;
/// Maps of more cells get no cost-to-go.
const MOST_CELLS: u64 = 1 << 20;

/// A motion to follow and what helps to leave it and come back.
#[derive(Debug, Clone)]
pub struct Guide {
    /// The timed motion.
    pub course: Arc<Course>,
    /// Turning points of the path in order, the goal last, m.
    pub sub_goals: Vec<Point>,
    /// Cost-to-go to the goal, if the global layer made one.
    pub to_go: Option<Arc<CostToGo>>,
    /// Arc length at which the robot joins it, m: a plan that took time begins behind the robot.
    pub from: f64,
}

impl Guide {
    /// A motion with its turning points, without cost-to-go.
    pub fn along(course: Arc<Course>) -> Self {
        Self { sub_goals: corners(&course).into_iter().map(|c| c.0).collect(), course, to_go: None, from: 0.0 }
    }

    /// As [`Guide::along`], with the cost-to-go in the world of the query that the motion was planned for.
    pub(super) fn within(course: Arc<Course>, query: &Query, robot: &Robot) -> Self {
        let [w, h] = query.world.cells().map(u64::from);
        let body = [robot.footprint.inscribed(), robot.footprint.circumscribed()];
        // A tour leads through its via points; a field knows one goal.
        let wanted = query.via.is_empty() && w * h <= MOST_CELLS;
        let to_go = wanted.then(|| Arc::new(CostToGo::new(&query.world, query.goal, body, query.soft.unwrap_or_default())));
        Self { to_go, ..Self::along(course) }
    }
}

/// Corners of the chain of fewest splits from which the path of a course is nowhere farther than 0.1 m, with their arc lengths (m); the start left out, the
/// end last.
fn corners(course: &Course) -> Vec<(Point, f64)> {
    let mut points: Vec<(Point, f64)> = Vec::new();
    for state in course.states() {
        let p = [state.pose[0], state.pose[1]];
        if points.last().is_none_or(|last| distance(last.0, p) >= APART) {
            points.push((p, state.s));
        }
    }
    let end = course.end();
    points.push(([end.pose[0], end.pose[1]], end.s));
    let (mut kept, mut spans) = (Vec::new(), vec![(0, points.len() - 1)]);
    while let Some((a, b)) = spans.pop() {
        let off = |k: &usize| point_segment(points[*k].0, points[a].0, points[b].0);
        match (a + 1..b).max_by(|i, k| off(i).total_cmp(&off(k))).filter(|k| off(k) > BEND) {
            Some(k) => spans.extend([(k, b), (a, k)]),
            None => kept.push(points[b]),
        }
    }
    kept
}

/// What became of a sub-goal in a step.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Passing {
    /// It still lies ahead.
    Ahead,
    /// It was reached (within 0.5 m) or passed at no more than 1 m; the next one counts.
    Reached,
    /// It was passed at more than 1 m, that many times in a row by now.
    Missed(u32),
}

/// Which sub-goal comes next.
///
/// Source: \[lu2025\]: switched within 0.5 m or when the projection of the robot on the path has passed it. One that was missed stays the next until the robot
/// has passed the one after it.
#[derive(Debug, Clone)]
pub struct SubGoals {
    course: Arc<Course>,
    /// Places and their arc lengths, m.
    places: Vec<(Point, f64)>,
    next: usize,
    /// Was the robot clearly before the sub-goal since it last passed it?
    before: bool,
    misses: u32,
}

impl SubGoals {
    /// Those of a guide, from its start on.
    pub fn new(guide: &Guide) -> Self {
        Self { places: corners(&guide.course), course: Arc::clone(&guide.course), next: 0, before: true, misses: 0 }
    }

    /// The next one, m; the last stays for good. `None` without any.
    pub fn next(&self) -> Option<Point> {
        self.places.get(self.next).map(|place| place.0)
    }

    /// The robot is at `p` (m) now and has come to arc length `s` (m).
    pub fn advance(&mut self, p: Point, s: f64) -> Passing {
        let Some(&(_, after)) = self.places.get(self.next + 1) else { return Passing::Ahead };
        let (goal, at) = self.places[self.next];
        if s + AROUND < at {
            self.before = true;
            return Passing::Ahead;
        }
        let (here, off) = self.course.project(p, at - AROUND, at + AROUND);
        self.before |= here < at - BACK;
        let passed = self.before && here >= at - APART;
        if distance(p, goal) <= REACHED || s >= after || (passed && off <= MISSED) {
            (self.next, self.misses, self.before) = (self.next + 1, 0, true);
            return Passing::Reached;
        }
        if passed {
            (self.misses, self.before) = (self.misses + 1, false);
            return Passing::Missed(self.misses);
        }
        Passing::Ahead
    }
}

#[cfg(test)]
mod tests {
    use super::super::testing::{legs, limits};
    use super::*;

    fn guide(points: &[Point]) -> Guide {
        Guide::along(Arc::new(Course::new(&legs(points, limits())).unwrap()))
    }

    #[test]
    fn corners_are_turning_points_and_straight_lines_have_none() {
        let bends = [[0.0, 0.0], [5.0, 0.0], [5.0, 4.0], [9.0, 4.0]];
        let found = guide(&bends).sub_goals;
        assert_eq!(found.len(), 3);
        assert!(found.iter().zip(&bends[1..]).all(|(a, b)| distance(*a, *b) < 0.06), "{found:?}");
        assert_eq!(guide(&[[0.0, 0.0], [7.0, 3.0]]).sub_goals, [[7.0, 3.0]]);
    }

    #[test]
    fn sub_goals_are_reached_passed_or_missed() {
        let guide = guide(&[[0.0, 0.0], [5.0, 0.0], [5.0, 4.0], [9.0, 4.0]]);
        let nearly = |next: Option<Point>, p: Point| next.is_some_and(|q| distance(p, q) < 0.06);
        let mut all = SubGoals::new(&guide);
        assert_eq!(all.advance([1.0, 0.0], 1.0), Passing::Ahead);
        assert!(all.advance([4.6, 0.2], 4.6) == Passing::Reached && nearly(all.next(), [5.0, 4.0]));
        assert_eq!((all.advance([5.5, 3.2], 8.2), all.advance([5.8, 4.1], 9.8)), (Passing::Ahead, Passing::Reached), "passed beside it");
        assert!(all.advance([9.0, 4.0], 13.0) == Passing::Ahead && nearly(all.next(), [9.0, 4.0]), "the goal stays");
        let mut all = SubGoals::new(&guide);
        for round in 1..=3 {
            assert_eq!(all.advance([4.5, -1.5], 5.0), Passing::Ahead);
            assert_eq!(all.advance([5.1, -1.5], 5.0), Passing::Missed(round));
            assert_eq!((all.advance([4.98, -1.5], 5.0), all.advance([5.02, -1.5], 5.0)), (Passing::Ahead, Passing::Ahead), "noise");
        }
        assert!(all.advance([6.5, 4.5], 9.1) == Passing::Reached && nearly(all.next(), [5.0, 4.0]), "the one after it was passed");
    }

    #[test]
    fn a_leg_beside_another_passes_no_sub_goal_of_it() {
        let guide = guide(&[[0.0, 0.0], [8.0, 0.0], [8.0, 1.5], [4.0, 1.5], [4.0, 6.0]]);
        let mut all = SubGoals::new(&guide);
        let mut missed = 0;
        for k in 0..=175 {
            let s = 0.1 * f64::from(k);
            let pose = guide.course.at_length(s).pose;
            missed += u32::from(matches!(all.advance([pose[0], pose[1]], s), Passing::Missed(_)));
        }
        assert!(missed == 0 && distance(all.next().unwrap(), [4.0, 6.0]) < 0.06);
    }
}
