//! Whether a motion keeps its distance to movers, and whether it can be broken off.

use super::Among;
use super::course::Course;
use super::motions::Motion;
use crate::Point;
use crate::error::PlanError;
use crate::path::Path;
use crate::query::Limits;
use crate::timing::Piece;
use crate::timing::scurve::{Bounds, State1, advance, transition};
use crate::world::shape::{dot, sub};

/// Intervals shorter than this are not halved again, s: what is not proved by then counts as too near.
const MOMENT: f64 = 1e-4;
/// Spacing of the states from which a brake is tried, s, and the places looked at along a brake.
const BRAKES: (f64, usize) = (0.05, 6);
/// A search keeps that much more to movers wherever it brakes, m, for what lies between the states that it looks at.
const SPARE: f64 = 0.02;

/// Wanted spacing of points of the path that a search looks up, m, and most of them.
const PLACE: (f64, f64) = (0.01, 20_000.0);

/// Spacing of the places (m) and moments (s) that are looked at for a place that is never free.
const PLACES: f64 = 0.05;
const MOMENTS: f64 = 0.1;

/// The judge of motions.
pub(super) struct Safety<'a> {
    pub path: &'a Path,
    pub limits: Limits,
    pub around: Among<'a>,
    pub courses: Vec<Course<'a>>,
    places: Places,
}

/// Points of a path at even spacing (m): quick to look up.
struct Places {
    step: f64,
    points: Vec<Point>,
}

impl Places {
    fn new(path: &Path) -> Self {
        let n = (path.length() / PLACE.0).ceil().clamp(1.0, PLACE.1);
        let step = path.length() / n;
        Self { step, points: (0..=n as usize).map(|k| path.planar(step * k as f64).point).collect() }
    }

    /// The nearest one to an arc length (m): no farther than half a step.
    fn near(&self, s: f64) -> Point {
        let k = if self.step > 0.0 { (s / self.step + 0.5) as usize } else { 0 };
        self.points[k.min(self.points.len() - 1)]
    }
}

/// A brake that is called for at one time of a motion.
#[derive(Debug, Clone)]
pub(super) struct Brake {
    /// When it is called for, s after the start of the motion.
    called: f64,
    /// Where the brake takes effect and some places on the way to rest: time since it was called for (s), arc length (m), place (m).
    marks: [(f64, f64, Point); BRAKES.1 + 1],
}

/// Where and when a motion is too near to a mover.
#[derive(Debug, Clone, Copy)]
pub(super) struct Meeting {
    mover: usize,
    s: f64,
    t: f64,
}

/// Arc length (m), speed (m/s), acceleration (m/s2).
type Kinetic = (f64, f64, f64);

/// State `x` seconds after the start of pieces whose own times begin anywhere.
pub(super) fn state(pieces: &[Piece], x: f64) -> Kinetic {
    let Some(first) = pieces.first() else { return (0.0, 0.0, 0.0) };
    let t = first.start() + x;
    match &pieces[pieces.partition_point(|p| p.start() <= t).saturating_sub(1)] {
        Piece::Along { t: from, s, speed, acceleration, jerk, duration } => {
            advance((*s, *speed, *acceleration), *jerk, (t - from).clamp(0.0, *duration))
        }
        Piece::Turn { s, .. } => (*s, 0.0, 0.0),
    }
}

/// States of a motion of that duration (s) from which a brake is tried.
fn brakes(total: f64) -> usize {
    (total / BRAKES.0).ceil().max(1.0) as usize
}

/// Total time of pieces, s.
pub(super) fn duration(pieces: &[Piece]) -> f64 {
    pieces.first().zip(pieces.last()).map_or(0.0, |(a, b)| b.start() + b.duration() - a.start())
}

impl<'a> Safety<'a> {
    pub fn new(path: &'a Path, limits: Limits, around: Among<'a>) -> Self {
        Self { path, limits, around, courses: around.movers.iter().map(Course::new).collect(), places: Places::new(path) }
    }

    fn point(&self, s: f64) -> Point {
        self.path.planar(s.clamp(0.0, self.path.length())).point
    }

    /// The mover that comes too near to a point at rest between two times (s), if any; `reach` (m) more is kept.
    fn nearby(&self, p: Point, (t0, t1): (f64, f64), reach: f64) -> Option<usize> {
        let kept = self.around.radius + reach;
        let near = |course: &Course| {
            let from = t0.max(course.from);
            // The point cannot be reached by whoever is that far away.
            course.present(t1) && (course.far(p, from, t1) < kept && course.mover.least_distance(p, from, t1) < kept)
        };
        self.courses.iter().position(near)
    }

    /// As [`Safety::nearby`], at one time (s).
    fn touched(&self, p: Point, t: f64, reach: f64) -> Option<usize> {
        self.courses.iter().position(|c| c.present(t) && c.distance(p, t) < self.around.radius + reach)
    }

    /// A place on the path that is never free at the moments looked at until the horizon (s): no motion passes it.
    pub fn closed(&self, horizon: f64) -> Option<Meeting> {
        let places = (self.path.length() / PLACES).ceil().max(1.0) as usize;
        let moments = (horizon / MOMENTS).ceil() as usize;
        (0..=places).find_map(|k| {
            let s = self.path.length() * k as f64 / places as f64;
            let p = self.point(s);
            // Half a step apart from a moment, a mover is nearer by no more than its way since.
            let taken = |k: usize| self.touched(p, MOMENTS * k as f64, -0.5 * MOMENTS * self.top_speed());
            let mover = taken(0)?;
            (1..=moments).all(|k| taken(k).is_some()).then_some(Meeting { mover, s, t: horizon })
        })
    }

    fn top_speed(&self) -> f64 {
        self.courses.iter().map(|c| c.speed).fold(0.0, f64::max)
    }

    /// Where pieces that begin at time `start` (s) first fail, `None` if nowhere.
    pub fn meeting(&self, pieces: &[Piece], start: f64) -> Option<Meeting> {
        let total = duration(pieces);
        // Most motions that fail do so at one of a few instants.
        let n = 8;
        let instants = (0..=n).map(|k| total * f64::from(k) / f64::from(n));
        let quick = instants.into_iter().find_map(|x| {
            let s = state(pieces, x).0;
            self.touched(self.point(s), start + x, 0.0).map(|mover| Meeting { mover, s, t: start + x })
        });
        quick.or_else(|| self.too_near(pieces, start, (0.0, total))).or_else(|| self.stranded(pieces, start, total))
    }

    /// By halves: the middle of an interval, the motion around it, and the course of every mover.
    fn too_near(&self, pieces: &[Piece], start: f64, (from, to): (f64, f64)) -> Option<Meeting> {
        let middle = 0.5 * (from + to);
        let at = |x: f64| state(pieces, x).0;
        let (first, s, last) = (at(from), at(middle), at(to));
        let p = self.point(s);
        let slack = (s - first).max(last - s).max(0.0);
        let mover = self.nearby(p, (start + from, start + to), slack)?;
        if to - from < MOMENT || self.touched(p, start + middle, 0.0).is_some() {
            return Some(Meeting { mover, s, t: start + middle });
        }
        self.too_near(pieces, start, (from, middle)).or_else(|| self.too_near(pieces, start, (middle, to)))
    }

    /// A state from which a brake would not end in time.
    fn stranded(&self, pieces: &[Piece], start: f64, total: f64) -> Option<Meeting> {
        if !self.around.passive {
            return None;
        }
        let at = |x: f64| state(pieces, x);
        let brakes = (0..brakes(total)).filter_map(|k| self.brake(BRAKES.0 * k as f64, (&at, total), &|s| self.point(s)));
        brakes.into_iter().find_map(|brake| {
            let mover = self.unsafe_of(&brake, start, 0.0)?;
            Some(Meeting { mover, s: brake.marks[0].1, t: start + brake.called })
        })
    }

    /// The brakes of a motion that has another one before and after it, at the nearest places that can be looked up.
    pub fn brakes(&self, motion: &Motion) -> Vec<Brake> {
        let at = |x: f64| motion.state(x);
        (0..brakes(motion.duration)).filter_map(|k| self.brake(BRAKES.0 * k as f64, (&at, motion.duration), &|s| self.places.near(s))).collect()
    }

    /// A brake called for `x` seconds after the start of a motion that lasts `total` (s): the motion goes on for the latency, at its last speed if it ends, then comes to
    /// rest as fast as it can. `None` if it is at rest by then: a robot that stands has done what it can.
    fn brake(&self, x: f64, (at, total): (&dyn Fn(f64) -> Kinetic, f64), point: &dyn Fn(f64) -> Point) -> Option<Brake> {
        let latency = self.around.latency;
        let (s, v, a) = at((x + latency).min(total));
        let s = s + v * (x + latency - total).max(0.0);
        let profile = transition(State1 { v, a }, State1 { v: 0.0, a: 0.0 }, &Bounds::from(&self.limits)).filter(|_| v > 0.0)?;
        let time = profile.duration();
        let mark = |k: usize| {
            let part = time * k as f64 / BRAKES.1 as f64;
            let s = s + profile.at(part).0;
            (latency + part, s, point(s))
        };
        Some(Brake { called: x, marks: std::array::from_fn(mark) })
    }

    /// Whether a brake of a motion that begins at time `start` (s) ends out of reach of the movers, with something to spare.
    pub fn ends_well(&self, brake: &Brake, start: f64) -> bool {
        self.unsafe_of(brake, start, SPARE + 0.5 * self.places.step).is_none()
    }

    /// The mover that might be nearer than allowed somewhere along a brake. Seen from when the brake is called for, it may go anywhere at its top speed.
    fn unsafe_of(&self, brake: &Brake, start: f64, spare: f64) -> Option<usize> {
        let now = start + brake.called;
        let (first, last) = (brake.marks[0], brake.marks[BRAKES.1]);
        let kept = self.around.radius + spare;
        self.courses.iter().position(|course| {
            let apart = sub(first.2, course.at(now));
            let far = kept + course.reach + (last.1 - first.1) + course.speed * last.0;
            course.present(now + last.0) && dot(apart, apart) < far * far && {
                // Between two marks the distance is no less than what both allow.
                let left: [f64; BRAKES.1 + 1] = std::array::from_fn(|k| {
                    let (t, _, p) = brake.marks[k];
                    course.distance(p, now) - course.speed * t
                });
                let between = |k: usize| {
                    let ((t0, s0, _), (t1, s1, _)) = (brake.marks[k], brake.marks[k + 1]);
                    0.5 * (left[k] + left[k + 1] - (s1 - s0) - course.speed * (t1 - t0))
                };
                (0..BRAKES.1).any(|k| between(k) < kept)
            }
        })
    }

    /// The error where there is no motion.
    pub fn hopeless(&self, meeting: &Meeting, horizon: f64) -> PlanError {
        let ([x, y], s, mover, kept) = (self.point(meeting.s), meeting.s, meeting.mover + 1, self.around.radius);
        let place = format!("near ({x:.3}, {y:.3}), arc length {s:.3} m");
        let advice = "take a path that leads elsewhere (a via point), a smaller clearance, or movers that are not there all the time";
        let reason = if meeting.t >= horizon {
            format!(
                "mover {mover} or another one is in the way {place}, at all times up to {horizon:.0} s: this path is closed for a robot that keeps {kept:.3} m to movers; \
                 {advice}"
            )
        } else {
            format!(
                "mover {mover} is in the way {place}, at {:.2} s, and no motion along this path that waits or slows down was found that keeps {kept:.3} m to all movers \
                 within {horizon:.0} s; {advice}, or another time of departure",
                meeting.t
            )
        };
        PlanError::Infeasible { reason, best_end_speed: None }
    }
}
