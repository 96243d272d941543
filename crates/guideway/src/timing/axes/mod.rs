//! Several axes from one state to another in minimum time, each for itself or all together.
//!
//! Every axis goes from (position, velocity, acceleration) to (position, velocity, acceleration), or to a velocity and acceleration
//! alone, under limits of velocity and acceleration that may differ by direction, and of jerk. It may reverse on its way. A start
//! outside the limits is brought back into them first, as fast as they allow. The problem is that of \[berscheid2021\]; the
//! derivation is our own: for a fixed duration the motions of an axis form a convex set, whose extremes are one-parameter families
//! (`widest`), so everything is a bracketed root of a monotone function and nothing can fail to be found.

mod brake;
mod check;
mod exactly;
mod leg;
mod line;
mod motion;
mod root;
mod solo;
mod speed_goal;
mod straight;
mod widest;

pub use motion::{AxisMotion, AxisPiece, AxisSample, Motion};

use crate::error::PlanError;
use crate::timing::scurve::Phase;
use solo::Solo;
use straight::Straight;

/// State of one axis; units are m or rad, and s.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct AxisState {
    /// m or rad.
    pub position: f64,
    /// Per s.
    pub velocity: f64,
    /// Per s2.
    pub acceleration: f64,
}

/// What one axis is to reach.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct AxisGoal {
    /// m or rad; `None`: anywhere, only velocity and acceleration count.
    pub position: Option<f64>,
    /// Per s.
    pub velocity: f64,
    /// Per s2.
    pub acceleration: f64,
}

/// Limits of one axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AxisLimits {
    /// Lowest (<= 0) and highest (>= 0) velocity, per s; may be infinite. Without meaning for a goal without position.
    pub velocity: (f64, f64),
    /// Lowest (< 0) and highest (> 0) acceleration, per s2; may be infinite.
    pub acceleration: (f64, f64),
    /// Largest jerk (> 0), per s3.
    pub jerk: f64,
}

impl AxisLimits {
    /// The same limits in both directions.
    pub const fn symmetric(velocity: f64, acceleration: f64, jerk: f64) -> Self {
        Self { velocity: (-velocity, velocity), acceleration: (-acceleration, acceleration), jerk }
    }
}

/// One axis of a problem.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Axis {
    /// Where it is.
    pub start: AxisState,
    /// Where it is to go.
    pub goal: AxisGoal,
    /// Its limits.
    pub limits: AxisLimits,
    /// Whether it takes part; an axis that does not stays where it is.
    pub enabled: bool,
}

/// How the axes go together.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Sync {
    /// All arrive at the same time: the shortest duration that every axis can have.
    #[default]
    Time,
    /// On a straight line where states and goals allow one, else as [`Sync::Time`].
    Phase,
    /// Each as fast as it can.
    None,
}

/// A problem.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Input {
    /// The axes.
    pub axes: Vec<Axis>,
    /// How they go together.
    pub sync: Sync,
    /// The motion takes at least this long, s.
    pub minimum_duration: f64,
    /// Durations are whole multiples of this, s.
    pub cycle: Option<f64>,
}

/// The fastest motion.
/// # Errors
/// [`PlanError::BadParameter`] for a number that is not finite, limits of the wrong sign, or a goal outside the limits;
/// [`PlanError::Infeasible`] where a velocity limit of zero forbids the direction.
pub fn plan(input: &Input) -> Result<Motion, PlanError> {
    check::check(input)?;
    if input.sync == Sync::Phase
        && let Some(motion) = on_a_line(input)
    {
        return motion;
    }
    let mut solos = Vec::with_capacity(input.axes.len());
    for (i, axis) in input.axes.iter().enumerate() {
        solos.push(if axis.enabled { Some(Solo::new(axis).map_err(|why| check::refused(i, axis, why))?) } else { None });
    }
    let common = if input.sync == Sync::None { None } else { Some(input.duration(&solos.iter().flatten().collect::<Vec<_>>())?) };
    let mut axes = Vec::with_capacity(input.axes.len());
    let mut phases = Vec::with_capacity(16);
    for (axis, solo) in input.axes.iter().zip(&solos) {
        let Some(solo) = solo else {
            axes.push(AxisMotion::idle(axis.start.position));
            continue;
        };
        let time = match common {
            Some(time) => time,
            None => input.duration(&[solo])?,
        };
        phases.clear();
        solo.phases(time, &mut phases);
        axes.push(AxisMotion::new(axis, phases.iter().copied(), time));
    }
    Motion::new(axes, &input.axes, false)
}

/// The motion on a straight line, if there is one.
fn on_a_line(input: &Input) -> Option<Result<Motion, PlanError>> {
    let taking_part: Vec<&Axis> = input.axes.iter().filter(|a| a.enabled).collect();
    let line = Straight::new(&taking_part)?;
    let whole = Input { axes: vec![line.axis], ..Input::default() };
    check::check(&whole).ok()?;
    let solo = Solo::new(&line.axis).ok()?;
    let time = input.duration(&[&solo]).ok()?;
    let mut phases = Vec::with_capacity(16);
    solo.phases(time, &mut phases);
    let mut shares = line.shares.iter();
    let axes = input.axes.iter().map(|axis| {
        if !axis.enabled {
            return AxisMotion::idle(axis.start.position);
        }
        let share = shares.next().copied().unwrap_or(0.0);
        AxisMotion::new(axis, phases.iter().map(|p| Phase { duration: p.duration, jerk: share * p.jerk }), time)
    });
    Some(Motion::new(axes.collect(), &input.axes, true))
}

impl Input {
    /// The shortest duration that all of these axes can have, s.
    fn duration(&self, solos: &[&Solo]) -> Result<f64, PlanError> {
        let whole = |time: f64| match self.cycle {
            Some(cycle) => {
                let count = time / cycle;
                (count - 1e-12 * count.max(1.0)).ceil() * cycle
            }
            None => time,
        };
        let mut time = whole(solos.iter().fold(self.minimum_duration, |longest, solo| longest.max(solo.shortest())));
        loop {
            let next = whole(solos.iter().fold(time, |longest, solo| longest.max(solo.next(time))));
            if next <= time * (1.0 + 1e-13) {
                return Ok(time);
            }
            if next.is_infinite() {
                let reason = format!("no motion of {time} s or longer: an axis that cannot go on beyond its goal has to be there before");
                return Err(PlanError::Infeasible { reason, best_end_speed: None });
            }
            time = next;
        }
    }
}
