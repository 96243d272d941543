//! The record of a run, as `run.json` holds it, and the figures made from it.

use super::{Course, Outline, Robot, Trace};
use crate::Point;
use crate::world::shape::{distance, wrap};
use serde::{Deserialize, Serialize};

/// How a run ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Outcome {
    /// Within the arrival distance of the goal and, for a final stop, at rest.
    Arrived,
    /// The footprint met an obstacle, a mover or the border.
    Collision,
    /// The time limit passed, or the caller cancelled.
    Timeout,
    /// No progress for too long.
    Stuck,
}

/// A run. SI units, radians; everything but `step_seconds` and `plan_seconds` follows from the job and the seed.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Run {
    /// How it ended.
    pub outcome: Outcome,
    /// From the first motion to the end, s.
    pub time: f64,
    /// True states [t, x, y, yaw, v, w], one per control step and one at the end; t from the start of the run.
    pub driven: Vec<[f64; 6]>,
    /// Movers over time.
    pub movers: Vec<MoverRecord>,
    /// New plans that were driven.
    pub replans: u32,
    /// Smallest distances of the true footprint, continuous in time.
    pub min_separation: Separation,
    /// Time in places that are only forbidden, s: no collision; `None` where nothing is.
    pub forbidden: Option<f64>,
    /// Times a controller stopped or replanned while the base moved faster than 0.2 m/s.
    pub emergency_stops: u32,
    /// Command period, s.
    pub period: f64,
    /// Wall-clock time of one decision, s.
    pub step_seconds: Percentiles,
    /// Wall-clock time of one new plan, s.
    pub plan_seconds: Percentiles,
    /// How well the motion was followed.
    pub tracking: Tracking,
    /// Energy of a nominal robot on this drive.
    pub energy: Energy,
    /// Stops, replans and their reasons.
    pub events: Vec<Event>,
    /// What was hit.
    pub collision: Option<Collision>,
    /// The caller cancelled; the record is partial.
    pub cancelled: bool,
    /// What reports show of single steps, where it was asked for.
    pub trace: Option<Trace>,
}

/// One mover over time.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct MoverRecord {
    /// Around its position, axes of the map frame.
    pub outline: Outline,
    /// Present from this time on, s; `None`: never was.
    pub since: Option<f64>,
    /// [t, x, y] every 0.1 s and at each corner of its motion, so that straight lines between rows are exact.
    pub track: Vec<[f64; 3]>,
}

/// Smallest distances, m; `None` where there is nothing to be distant from.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Separation {
    /// To static obstacles.
    #[serde(rename = "static")]
    pub still: Option<f64>,
    /// To movers.
    pub movers: Option<f64>,
}

/// Classes of [`Percentiles::counts`].
const CLASSES: usize = 24;

/// Distribution of the time of a control step, s.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Percentiles {
    /// Mean.
    pub mean: f64,
    /// Median.
    pub p50: f64,
    /// 95th percentile.
    pub p95: f64,
    /// 99th percentile.
    pub p99: f64,
    /// How many times fell into each of 24 classes, four a decade from 1 us on; what is shorter or longer is in the first or last one.
    pub counts: [u32; CLASSES],
}

/// How well the plan was followed (metrics, sections 1.3, 2 and 2.1). Distances are to the path in force at the time.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Tracking {
    /// Root mean square over time of the orthogonal distance to the planned path, m.
    pub tte: f64,
    /// Mean of the same distance at 10 Hz, m.
    pub path_error: f64,
    /// Largest of the same distance, m.
    pub worst: f64,
    /// Distance to the goal at the end, m.
    pub tpe: f64,
    /// Length driven, m.
    pub length: f64,
    /// Length driven minus the length first planned, absolute, m.
    pub length_deviation: f64,
    /// Turning per length of the driven path, headings over 0.1 m windows, deg/m.
    pub ts: f64,
    /// Runs of commanded speed steps above 0.6 of the acceleration limit; commands are sampled at the command period.
    pub ssf: u32,
    /// Runs of commanded acceleration steps above 1.05 of the jerk limit, same sampling.
    pub asf: u32,
    /// Time at rest between first motion and end, s.
    pub stopped: f64,
}

/// Energy that a nominal robot takes for the drive: 40 kg, rolling resistance 0.015, drive efficiency 0.75 without regeneration, copper losses
/// 1.2 W/(m/s2)2, electronics 35 W. Our own model; good for comparing drives with each other.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Energy {
    /// Trajectory tracking energy per length, J/m.
    pub ttec: f64,
    /// Drive and electronics over the run, W h.
    pub moec: f64,
}

/// Something that happened.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Event {
    /// s since the start of the run.
    pub t: f64,
    /// `stop`, `go`, `replan`, `no-plan`, `collision`, `cancel`, and what leads to them: `blocked`, `sub-goal missed`, `dear`, `tabu`, `expired`, `blind`, `appeared`;
    /// `asked` and `late` where plans take time.
    pub kind: String,
    /// For people.
    pub reason: String,
}

/// What a controller had in mind in its last step, for pictures; positions in the map frame, m.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Sketch {
    /// Some of the candidates, the best first, as polylines.
    pub fan: Vec<Vec<Point>>,
    /// What was chosen; empty where nothing was.
    pub chosen: Vec<Point>,
    /// Centre and radius of discs that hold all that movers could reach before the robot stands after its next command.
    pub discs: Vec<[f64; 3]>,
    /// Where the heading leads to, if anywhere.
    pub sub_goal: Option<Point>,
}

/// What was hit, and whether a parked robot would have been hit as well.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Collision {
    /// s since the start of the run.
    pub t: f64,
    /// `static`, `border` or `mover N`.
    pub with: String,
    /// The mover ran into a robot at rest, or appeared on top of it.
    pub unavoidable: bool,
}

impl Percentiles {
    pub(super) fn of(mut all: Vec<f64>) -> Self {
        if all.is_empty() {
            return Self::default();
        }
        all.sort_by(f64::total_cmp);
        let at = |q: f64| all[((all.len() - 1) as f64 * q).round() as usize];
        let mut counts = [0; CLASSES];
        for t in &all {
            let class = (4.0 * (t.max(1e-9).log10() + 6.0)).floor();
            counts[(class.max(0.0) as usize).min(CLASSES - 1)] += 1;
        }
        Self { mean: all.iter().sum::<f64>() / all.len() as f64, p50: at(0.5), p95: at(0.95), p99: at(0.99), counts }
    }
}

/// What the loop keeps for the figures.
#[derive(Debug, Default)]
pub(super) struct Log {
    pub driven: Vec<[f64; 6]>,
    pub commands: Vec<f64>,
    /// Row of `driven` from which each course is in force.
    pub courses: Vec<(usize, std::sync::Arc<Course>)>,
}

impl Log {
    pub fn tracking(&self, goal: Point, jerk: f64, robot: &Robot, period: f64) -> Tracking {
        let errors = self.path_errors();
        let points: Vec<Point> = self.driven.iter().map(|r| [r[1], r[2]]).collect();
        let length: f64 = points.windows(2).map(|w| distance(w[0], w[1])).sum();
        let planned = self.courses.first().map_or(0.0, |c| c.1.length());
        let n = errors.len().max(1) as f64;
        let every = (0.1 / period).round().max(1.0) as usize;
        let coarse: Vec<f64> = errors.iter().copied().step_by(every).collect();
        let speeds: Vec<f64> = self.commands.windows(2).map(|w| (w[1] - w[0]) / period).collect();
        let jerks: Vec<f64> = speeds.windows(2).map(|w| (w[1] - w[0]) / period).collect();
        let first = self.driven.iter().position(moving).unwrap_or(self.driven.len());
        Tracking {
            tte: (errors.iter().map(|e| e * e).sum::<f64>() / n).sqrt(),
            path_error: coarse.iter().sum::<f64>() / coarse.len().max(1) as f64,
            worst: errors.iter().copied().fold(0.0, f64::max),
            tpe: points.last().map_or(0.0, |p| distance(*p, goal)),
            length,
            length_deviation: (length - planned).abs(),
            ts: turning_per_metre(&points),
            ssf: runs(&speeds, 0.6 * robot.acceleration),
            asf: runs(&jerks, 1.05 * jerk),
            stopped: self.driven[first..].iter().filter(|r| !moving(r)).count() as f64 * period,
        }
    }

    /// Distance to the path in force, one per row, by closest point with monotone arc length.
    fn path_errors(&self) -> Vec<f64> {
        let mut errors = Vec::with_capacity(self.driven.len());
        for (k, (from, course)) in self.courses.iter().enumerate() {
            let to = self.courses.get(k + 1).map_or(self.driven.len(), |c| c.0);
            let mut s = 0.0;
            for row in &self.driven[(*from).min(to)..to] {
                let (at, error) = course.project([row[1], row[2]], s, s + 1.0);
                s = at;
                errors.push(error);
            }
        }
        errors
    }

    /// Energy of the drive so far.
    pub fn energy(&self) -> Energy {
        let (mut drive, mut length, mut time) = (0.0, 0.0, 0.0);
        for w in self.driven.windows(2) {
            let dt = w[1][0] - w[0][0];
            if dt <= 0.0 {
                continue;
            }
            let (a, v) = ((w[1][4] - w[0][4]) / dt, 0.5 * (w[0][4] + w[1][4]));
            let rolling = if v.abs() > 1e-6 { 40.0 * 9.81 * 0.015 * v.signum() } else { 0.0 };
            drive += (((40.0 * a + rolling) * v).max(0.0) / 0.75 + 1.2 * a * a) * dt;
            length += distance([w[0][1], w[0][2]], [w[1][1], w[1][2]]);
            time += dt;
        }
        Energy { ttec: if length > 0.0 { drive / length } else { 0.0 }, moec: (drive + 35.0 * time) / 3600.0 }
    }
}

/// Is the base in motion in this row?
pub(super) fn moving(row: &[f64; 6]) -> bool {
    row[4].abs() > 0.01 || row[5].abs() > 0.01
}

/// Maximal runs of values whose size exceeds `limit`.
fn runs(values: &[f64], limit: f64) -> u32 {
    let over = |v: f64| v.abs() > limit;
    values.iter().enumerate().filter(|(i, v)| over(**v) && (*i == 0 || !over(values[i - 1]))).count() as u32
}

/// Total turning over length, headings over windows of 0.1 m, deg/m.
fn turning_per_metre(points: &[Point]) -> f64 {
    let Some(mut last) = points.first().copied() else { return 0.0 };
    let (mut headings, mut length) = (Vec::new(), 0.0);
    for p in points {
        let d = distance(last, *p);
        if d >= 0.1 {
            headings.push((p[1] - last[1]).atan2(p[0] - last[0]));
            length += d;
            last = *p;
        }
    }
    let turning: f64 = headings.windows(2).map(|w| wrap(w[1] - w[0]).abs()).sum();
    if length > 0.0 { turning.to_degrees() / length } else { 0.0 }
}
