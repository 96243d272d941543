//! The next metres of a course, as predictions read them.

use super::Course;
use crate::Point;

/// Spacing, m.
const STEP: f64 = 0.05;
/// Reference speeds are the largest within this distance ahead, m: a motion that starts at rest would never leave it else.
const AHEAD: f64 = 0.15;

/// One point of the path ahead.
#[derive(Debug, Clone, Copy)]
pub(super) struct Mark {
    /// Arc length, m.
    pub s: f64,
    pub point: Point,
    /// Heading (rad) as its cosine and sine, too.
    pub yaw: f64,
    pub along: Point,
    /// 1/m.
    pub curvature: f64,
    /// Reference speed, m/s.
    pub speed: f64,
}

/// Marks every 0.05 m.
pub(super) struct Local {
    marks: Vec<Mark>,
    /// Length of the whole course, m.
    pub length: f64,
    /// Largest reference speed, m/s.
    pub top: f64,
}

impl Local {
    /// The course from `s` on for `reach` m.
    pub fn new(course: &Course, s: f64, reach: f64) -> Self {
        let n = (reach / STEP).ceil().max(1.0) as usize;
        let k = (AHEAD / STEP) as usize;
        let states = course.at_lengths((0..=n + k).map(|i| s + STEP * i as f64));
        let mark = |i: usize| {
            let (at, ahead) = (&states[i], states[i..=i + k].iter().map(|q| q.speed).fold(0.0, f64::max));
            let (sin, cos) = at.pose[2].sin_cos();
            Mark { s: at.s, point: [at.pose[0], at.pose[1]], yaw: at.pose[2], along: [cos, sin], curvature: at.curvature, speed: ahead }
        };
        let marks: Vec<Mark> = (0..=n).map(mark).collect();
        let top = marks.iter().map(|m| m.speed).fold(0.0, f64::max);
        Self { marks, length: course.length(), top }
    }

    /// Index of the nearest mark, found by going on or back from `i`.
    #[inline]
    pub fn nearest(&self, mut i: usize, p: Point) -> usize {
        let marks = &self.marks[..];
        let d2 = |m: &Mark| (m.point[0] - p[0]).powi(2) + (m.point[1] - p[1]).powi(2);
        let (from, mut here) = (i, d2(&marks[i]));
        while let Some(next) = marks.get(i + 1).map(d2)
            && next <= here
        {
            (i, here) = (i + 1, next);
        }
        // Who has gone on need not go back.
        while i <= from
            && let Some(next) = i.checked_sub(1).map(|k| d2(&marks[k]))
            && next < here
        {
            (i, here) = (i - 1, next);
        }
        i
    }

    /// The mark that is `far` m beyond mark `i`, or the last before the end of the path.
    #[inline]
    pub fn beyond(&self, i: usize, far: f64) -> &Mark {
        &self.marks[(i + (far / STEP) as usize).min(self.marks.len() - 1)]
    }

    /// The mark at index `i`.
    #[inline]
    pub fn mark(&self, i: usize) -> &Mark {
        &self.marks[i]
    }

    /// Arc length (m) and distance to the left (m) of a pose relative to mark `i`.
    #[inline]
    pub fn relative(&self, i: usize, pose: [f64; 3]) -> [f64; 2] {
        let m = &self.marks[i];
        let (dx, dy) = (pose[0] - m.point[0], pose[1] - m.point[1]);
        let along = (m.along[0] * dx + m.along[1] * dy).clamp(-STEP, STEP);
        [(m.s + along).min(self.length), m.along[0] * dy - m.along[1] * dx]
    }
}
