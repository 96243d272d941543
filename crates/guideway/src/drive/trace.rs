//! What reports show of single steps, bounded.

use super::{Course, Observation, Pilot, Step};
use crate::Point;
use serde::{Deserialize, Serialize};

/// Rows are this far apart, s, until there are too many.
const EVERY: f64 = 0.1;
/// Most rows; beyond, every second one is left out.
const MOST: usize = 2000;
/// Most rays of a row, candidates of a fan and points of a path.
const RAYS: usize = 180;
const FAN: usize = 12;
const POINTS: usize = 400;

/// Steps and plans of a run, for pictures. Positions in the map frame, m, to a millimetre.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Trace {
    /// In time order.
    pub steps: Vec<StepRow>,
    /// Plans that were driven, the first one at time 0.
    pub plans: Vec<PlanRow>,
}

/// What was known and thought in a step.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct StepRow {
    /// s.
    pub t: f64,
    /// Observed x, y (m) and heading (rad).
    pub pose: [f64; 3],
    /// m/s.
    pub v: f64,
    /// rad/s.
    pub w: f64,
    /// Speed (m/s) and turn rate (rad/s) that were commanded.
    pub command: [f64; 2],
    /// Angles against the heading (rad) of the first and from ray to ray, of those kept in `ranges`.
    pub rays: Option<[f64; 2]>,
    /// Some of the ranges of the newest scan, m; `None` (null) where nothing was within range or measured.
    pub ranges: Option<Vec<Option<f64>>>,
    /// x, y, radius (m) and velocity (m/s) of the movers that are seen.
    pub tracks: Vec<[f64; 5]>,
    /// x, y, radius (m) of discs that hold all that movers could reach before the robot stands.
    pub discs: Vec<[f64; 3]>,
    /// Some candidates as polylines.
    pub fan: Vec<Vec<Point>>,
    /// The chosen one.
    pub chosen: Vec<Point>,
    /// Where the robot heads for.
    pub sub_goal: Option<Point>,
    /// `drive`, or why it is to stop.
    pub state: String,
}

/// A plan that was driven.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PlanRow {
    /// s.
    pub t: f64,
    /// m.
    pub path: Vec<Point>,
    /// Why it was made.
    pub reason: String,
}

/// Collects a trace.
#[derive(Debug)]
pub(super) struct Tracer {
    trace: Trace,
    every: f64,
    next: f64,
}

impl Tracer {
    pub fn new(course: &Course) -> Self {
        let mut tracer = Self { trace: Trace::default(), every: EVERY, next: 0.0 };
        tracer.plan(0.0, course, "start");
        tracer
    }

    pub fn plan(&mut self, t: f64, course: &Course, reason: &str) {
        let n = POINTS.min((course.length() / 0.05).ceil() as usize + 1).max(1);
        let at = |k: usize| course.at_length(course.length() * k as f64 / n as f64).pose;
        self.trace.plans.push(PlanRow { t, path: (0..=n).map(|k| [short(at(k)[0]), short(at(k)[1])]).collect(), reason: reason.into() });
    }

    pub fn step(&mut self, seen: &Observation, step: &Step, pilot: &Pilot) {
        if seen.time + 1e-9 < self.next {
            return;
        }
        self.next = seen.time + self.every;
        if self.trace.steps.len() >= MOST {
            let mut k = 0;
            self.trace.steps.retain(|_| {
                k += 1;
                k % 2 == 1
            });
            self.every *= 2.0;
        }
        self.trace.steps.push(row(seen, step, pilot));
    }

    pub fn finish(self) -> Trace {
        self.trace
    }
}

fn row(seen: &Observation, step: &Step, pilot: &Pilot) -> StepRow {
    let sketch = pilot.sketch().unwrap_or_default();
    let line = |points: &Vec<Point>| points.iter().map(|p| p.map(short)).collect::<Vec<_>>();
    let (rays, ranges) = seen.scan.as_ref().map_or((None, None), |scan| {
        let each = scan.ranges.len().div_ceil(RAYS).max(1);
        let kept = scan.ranges.iter().step_by(each).map(|r| r.is_finite().then(|| short(*r))).collect();
        (Some([scan.first, scan.step * each as f64]), Some(kept))
    });
    StepRow {
        t: short(seen.time),
        pose: seen.pose.map(short),
        v: short(seen.v),
        w: short(seen.w),
        command: [short(step.command.v), short(step.command.w)],
        rays,
        ranges,
        tracks: seen
            .tracks
            .iter()
            .map(|t| [t.position[0], t.position[1], t.outline.circumscribed(), t.velocity[0], t.velocity[1]].map(short))
            .collect(),
        discs: sketch.discs.iter().map(|d| d.map(short)).collect(),
        fan: sketch.fan.iter().take(FAN).map(line).collect(),
        chosen: line(&sketch.chosen),
        sub_goal: sketch.sub_goal.or_else(|| pilot.sub_goal()).map(|p| p.map(short)),
        state: step.stop.clone().unwrap_or_else(|| "drive".into()),
    }
}

/// To a thousandth; what is not finite becomes 0, which JSON can hold.
fn short(v: f64) -> f64 {
    if v.is_finite() { (1e3 * v).round() / 1e3 } else { 0.0 }
}
