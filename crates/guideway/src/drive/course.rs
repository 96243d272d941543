//! A trajectory as controllers read it: sampled finely once, then looked up by time, by arc length and by nearest point.

use crate::Point;
use crate::error::PlanError;
use crate::timing::{State, Trajectory};
use crate::world::shape::wrap;

/// Sampling step, s.
const STEP: f64 = 0.01;
/// Most samples of one course.
const MOST: f64 = 2e6;

/// A planned motion, sampled every 0.01 s and at the ends. Between samples positions are chords, headings and speeds linear.
#[derive(Debug, Clone, PartialEq)]
pub struct Course {
    states: Vec<State>,
}

impl Course {
    /// Samples a trajectory.
    /// # Errors
    /// [`PlanError::BadParameter`] for an empty, endless or not finite trajectory, or one whose path is not planar.
    pub fn new(trajectory: &Trajectory) -> Result<Self, PlanError> {
        let duration = trajectory.duration();
        if trajectory.pieces.is_empty() || trajectory.path.dimension() != 2 || !(0.0..=STEP * MOST).contains(&duration) {
            let shown = format!("{} pieces, {duration} s, dimension {}", trajectory.pieces.len(), trajectory.path.dimension());
            return Err(PlanError::bad("trajectory", shown, format!("at least one piece, a planar path and at most {} s", STEP * MOST)));
        }
        let n = (duration / STEP).ceil().max(1.0);
        Self::from_states((0..=n as usize).map(|i| trajectory.at(duration * i as f64 / n)).collect())
    }

    /// A course from states in time order, at least one.
    /// # Errors
    /// [`PlanError::BadParameter`] if there is none, times or arc lengths decrease, or values are not finite.
    pub fn from_states(states: Vec<State>) -> Result<Self, PlanError> {
        let finite = states.iter().all(|s| s.pose.iter().chain([&s.t, &s.s, &s.speed, &s.turn_rate, &s.curvature]).all(|v| v.is_finite()));
        if states.is_empty() || !finite || !states.windows(2).all(|w| w[0].t <= w[1].t && w[0].s <= w[1].s + 1e-9) {
            return Err(PlanError::bad(
                "course",
                format!("{} states", states.len()),
                "finite states with times and arc lengths that do not decrease",
            ));
        }
        Ok(Self { states })
    }

    /// All samples.
    pub fn states(&self) -> &[State] {
        &self.states
    }
    /// First state.
    pub fn start(&self) -> &State {
        &self.states[0]
    }
    /// Last state.
    pub fn end(&self) -> &State {
        &self.states[self.states.len() - 1]
    }
    /// Arc length, m.
    pub fn length(&self) -> f64 {
        self.end().s
    }
    /// s.
    pub fn duration(&self) -> f64 {
        self.end().t
    }

    /// State at time `t` (s), clamped to the ends.
    pub fn at(&self, t: f64) -> State {
        let i = self.states.partition_point(|s| s.t <= t);
        self.between(i, |s| s.t, t)
    }

    /// State at arc length `s` (m), clamped; where the motion stays (turns in place), the last.
    pub fn at_length(&self, s: f64) -> State {
        let i = self.states.partition_point(|q| q.s <= s);
        self.between(i, |q| q.s, s)
    }

    /// The states at arc lengths that do not decrease, as [`Course::at_length`] has them.
    pub fn at_lengths(&self, lengths: impl IntoIterator<Item = f64>) -> Vec<State> {
        self.before(lengths).map(|(i, s)| self.between(i, |q| q.s, s)).collect()
    }

    /// Arc lengths (m) and places of these states.
    pub fn places(&self, lengths: impl IntoIterator<Item = f64>) -> impl Iterator<Item = (f64, Point)> {
        self.before(lengths).map(|(i, s)| {
            let (a, b) = (&self.states[i.saturating_sub(1)], &self.states[i.min(self.states.len() - 1)]);
            let r = if i == 0 || i == self.states.len() { 0.0 } else { (s - a.s) / (b.s - a.s).max(1e-300) };
            let mix = |p: f64, q: f64| p + r * (q - p);
            (mix(a.s, b.s), [mix(a.pose[0], b.pose[0]), mix(a.pose[1], b.pose[1])])
        })
    }

    /// Arc lengths that do not decrease, each with the number of the states up to it.
    fn before(&self, lengths: impl IntoIterator<Item = f64>) -> impl Iterator<Item = (usize, f64)> {
        let mut i = None;
        lengths.into_iter().map(move |s| {
            let mut next = i.unwrap_or_else(|| self.states.partition_point(|q| q.s <= s));
            while self.states.get(next).is_some_and(|q| q.s <= s) {
                next += 1;
            }
            i = Some(next);
            (next, s)
        })
    }

    fn between(&self, i: usize, key: impl Fn(&State) -> f64, x: f64) -> State {
        if i == 0 {
            return self.states[0];
        }
        if i == self.states.len() {
            return *self.end();
        }
        let (a, b) = (&self.states[i - 1], &self.states[i]);
        let r = (x - key(a)) / (key(b) - key(a)).max(1e-300);
        let mix = |p: f64, q: f64| p + r * (q - p);
        let yaw = wrap(a.pose[2] + r * wrap(b.pose[2] - a.pose[2]));
        State {
            t: mix(a.t, b.t),
            s: mix(a.s, b.s),
            pose: [mix(a.pose[0], b.pose[0]), mix(a.pose[1], b.pose[1]), yaw],
            speed: mix(a.speed, b.speed),
            acceleration: mix(a.acceleration, b.acceleration),
            jerk: a.jerk,
            curvature: mix(a.curvature, b.curvature),
            turn_rate: mix(a.turn_rate, b.turn_rate),
        }
    }

    /// Nearest point of the path to `p` among arc lengths `from..=to` (m): its arc length and its distance to `p`, m.
    pub fn project(&self, p: Point, from: f64, to: f64) -> (f64, f64) {
        let first = self.states.partition_point(|q| q.s <= from).saturating_sub(1);
        let last = self.states.partition_point(|q| q.s < to).min(self.states.len() - 1);
        let start = &self.states[first];
        let mut best = (start.s, (p[0] - start.pose[0]).hypot(p[1] - start.pose[1]));
        // What is farther by squares is farther, and there are many.
        let farther = |[x, y]: Point, than: f64| x * x + y * y > than * than * (1.0 + 1e-9);
        for w in self.states[first..=last].windows(2) {
            let e = [w[1].pose[0] - w[0].pose[0], w[1].pose[1] - w[0].pose[1]];
            let l2 = e[0] * e[0] + e[1] * e[1];
            let v = [p[0] - w[0].pose[0], p[1] - w[0].pose[1]];
            let r = if l2 > 0.0 { ((v[0] * e[0] + v[1] * e[1]) / l2).clamp(0.0, 1.0) } else { 0.0 };
            let off = [v[0] - r * e[0], v[1] - r * e[1]];
            if farther(off, best.1) {
                continue;
            }
            let d = off[0].hypot(off[1]);
            if d < best.1 {
                best = (w[0].s + r * (w[1].s - w[0].s), d);
            }
        }
        (best.0.max(from.min(self.length())), best.1)
    }
}
