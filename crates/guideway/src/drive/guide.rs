//! What the global layer hands to the local one: the motion, its turning points and the cost-to-go.

use super::{CostToGo, Course};
use crate::Point;
use crate::world::shape::{distance, point_segment, sub};
use std::sync::Arc;

/// The path stays within this of the chain of its turning points, m.
const BEND: f64 = 0.1;
/// Samples of a course that are looked at for turning points are so far apart, m.
const APART: f64 = 0.05;
/// A sub-goal this near is reached, m.
const REACHED: f64 = 0.5;
/// One passed at a greater distance is missed, m.
const MISSED: f64 = 1.0;

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
    /// A motion with its turning points, without cost-to-go.
    pub fn along(course: Arc<Course>) -> Self {
        Self { sub_goals: turning_points(&course), course, to_go: None }
    }
}

/// Corners of the chain of fewest splits from which the path of a course is nowhere farther than 0.1 m, the start left out, the end last.
fn turning_points(course: &Course) -> Vec<Point> {
    let mut points: Vec<Point> = Vec::new();
    for state in course.states() {
        let p = [state.pose[0], state.pose[1]];
        if points.last().is_none_or(|last| distance(*last, p) >= APART) {
            points.push(p);
        }
    }
    let end = course.end().pose;
    points.push([end[0], end[1]]);
    let (mut kept, mut spans) = (Vec::new(), vec![(0, points.len() - 1)]);
    while let Some((a, b)) = spans.pop() {
        let off = |k: &usize| point_segment(points[*k], points[a], points[b]);
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
/// is nearer to the one after it.
#[derive(Debug, Clone)]
pub struct SubGoals {
    places: Vec<Point>,
    /// Unit vectors of the path on the way to them.
    along: Vec<Point>,
    next: usize,
    /// Was the robot before the line across the path at the sub-goal?
    before: bool,
    misses: u32,
}

impl SubGoals {
    /// Those of a guide, from its start on.
    pub fn new(guide: &Guide) -> Self {
        let start = guide.course.start().pose;
        let start = [start[0], start[1]];
        let from = std::iter::once(&start).chain(&guide.sub_goals);
        let unit = |(a, b): (&Point, &Point)| {
            let (d, l) = (sub(*b, *a), distance(*a, *b).max(1e-12));
            [d[0] / l, d[1] / l]
        };
        let along = from.zip(&guide.sub_goals).map(unit).collect();
        Self { places: guide.sub_goals.clone(), along, next: 0, before: true, misses: 0 }
    }

    /// The next one, m; the last stays for good. `None` without any.
    pub fn next(&self) -> Option<Point> {
        self.places.get(self.next).copied()
    }

    /// The robot is at `p` (m) now.
    pub fn advance(&mut self, p: Point) -> Passing {
        let last = self.places.len().saturating_sub(1);
        if self.next >= last {
            return Passing::Ahead;
        }
        let (off, ahead) = self.place(self.next, p);
        let crossed = std::mem::replace(&mut self.before, ahead > 0.0) && ahead <= 0.0;
        let lateral = (off * off - ahead * ahead).max(0.0).sqrt();
        let beyond = off > MISSED && self.place(self.next + 1, p).0 < off.min(distance(self.places[self.next], self.places[self.next + 1]));
        if off <= REACHED || (crossed && lateral <= MISSED) || (beyond && !crossed && ahead <= 0.0) {
            (self.next, self.misses) = (self.next + 1, 0);
            self.before = self.place(self.next, p).1 > 0.0;
            return Passing::Reached;
        }
        if crossed {
            self.misses += 1;
            return Passing::Missed(self.misses);
        }
        Passing::Ahead
    }

    /// Distance to a sub-goal and how far it lies ahead along its path, m.
    fn place(&self, i: usize, p: Point) -> (f64, f64) {
        let to = sub(self.places[i], p);
        (to[0].hypot(to[1]), to[0] * self.along[i][0] + to[1] * self.along[i][1])
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
        let mut all = SubGoals::new(&guide);
        assert_eq!(all.advance([1.0, 0.0]), Passing::Ahead);
        let nearly = |next: Option<Point>, p: Point| next.is_some_and(|q| distance(p, q) < 0.06);
        assert!(all.advance([4.6, 0.2]) == Passing::Reached && nearly(all.next(), [5.0, 4.0]));
        assert_eq!((all.advance([5.8, 3.9]), all.advance([5.8, 4.1])), (Passing::Ahead, Passing::Reached), "passed beside it");
        assert!(all.advance([9.0, 4.0]) == Passing::Ahead && nearly(all.next(), [9.0, 4.0]), "the goal stays");
        let mut all = SubGoals::new(&guide);
        for round in 1..=3 {
            assert_eq!(all.advance([4.9, -1.5]), Passing::Ahead);
            assert_eq!(all.advance([5.1, -1.5]), Passing::Missed(round));
            assert_eq!(all.advance([5.1, -1.6]), Passing::Ahead);
        }
        assert!(all.advance([5.6, 3.0]) == Passing::Reached && nearly(all.next(), [5.0, 4.0]), "the one after it is nearer");
    }
}
