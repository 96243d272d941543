//! One axis: its shortest duration, the durations it cannot have, and its motion for any other.

use super::brake::brake;
use super::exactly::{amid, exactly};
use super::leg::Shape;
use super::line::{Line, settled};
use super::speed_goal::SpeedGoal;
use super::widest::Widest;
use super::{Axis, AxisState};
use crate::timing::scurve::{Phase, advance};

/// Relative slack of durations.
const SAME: f64 = 1e-13;

/// Relative excess over limits that counts as rounding.
pub(super) const ROUNDING: f64 = 1e-11;

/// One axis, solved for its shortest duration.
#[derive(Debug, Clone)]
pub(super) struct Solo {
    /// Motions to the goal without a brake from a start that could not go on within the limits, or to a goal that could not be come
    /// from within them. Their acceleration keeps its sign.
    early: Option<Way>,
    brake: Shape,
    /// Duration of the brake, s.
    delay: f64,
    /// After the brake.
    task: Option<Task>,
}

#[derive(Debug, Clone)]
#[expect(clippy::large_enum_variant, reason = "nearly always the large one")]
enum Task {
    Position(Way),
    Speed { goal: SpeedGoal, shortest: f64 },
}

/// From one state to another over a distance.
#[derive(Debug, Clone)]
struct Way {
    line: Line,
    distance: f64,
    slack: f64,
    /// Motions whose acceleration keeps its sign, all shorter than the others.
    brief: Option<Part>,
    usual: Option<Part>,
}

/// A component of the motions of an axis.
#[derive(Debug, Clone)]
struct Part {
    /// Those that cover most and least for their duration.
    families: [Widest; 2],
    best: Shape,
    /// s.
    shortest: f64,
}

/// Why there is no motion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Refusal {
    /// The velocity at which the axis would have been without acceleration just before its goal is outside the limits.
    Unreachable(f64),
    /// A velocity limit of zero forbids the direction.
    Forbidden,
}

/// Whether `x` is in a range, but for rounding.
pub(super) fn inside(x: f64, (low, high): (f64, f64)) -> bool {
    x >= low - ROUNDING * low.abs() && x <= high + ROUNDING * high.abs()
}

impl Solo {
    pub(super) fn new(axis: &Axis) -> Result<Self, Refusal> {
        let (start, goal, limits) = (&axis.start, &axis.goal, &axis.limits);
        let end = (goal.velocity, goal.acceleration);
        let brake = brake((start.velocity, start.acceleration), limits, goal.position.is_some());
        let Some(position) = goal.position else {
            let from = after(start, brake.phases());
            let goal = SpeedGoal::new((from.velocity, from.acceleration), end, limits.acceleration, limits.jerk);
            return Ok(Self::with(None, brake, Some(Task::Speed { goal, shortest: goal.shortest() })));
        };
        let size = 8.0 * f64::EPSILON * (start.position.abs() + position.abs()) + 1e-16;
        let before = settled((end.0, -end.1), limits.jerk);
        let viable = inside(before, limits.velocity);
        let within = inside(start.velocity, limits.velocity) && inside(start.acceleration, limits.acceleration);
        let early = (within && (!viable || !brake.phases().is_empty()))
            .then(|| Way::new(Line::new((start.velocity, start.acceleration), end, limits), position - start.position, size, true))
            .filter(|way| way.brief.is_some());
        if !viable {
            return if early.is_some() { Ok(Self::with(early, Shape::new(), None)) } else { Err(Refusal::Unreachable(before)) };
        }
        let from = after(start, brake.phases());
        let line = Line::new((from.velocity, from.acceleration), end, limits);
        let way = Way::new(line, position - from.position, size, false);
        let task = (way.brief.is_some() || way.usual.is_some()).then_some(Task::Position(way));
        if task.is_none() && early.is_none() { Err(Refusal::Forbidden) } else { Ok(Self::with(early, brake, task)) }
    }

    fn with(early: Option<Way>, brake: Shape, task: Option<Task>) -> Self {
        Self { early, delay: brake.phases().iter().map(|p| p.duration).sum(), brake, task }
    }

    /// Shortest duration, s.
    pub(super) fn shortest(&self) -> f64 {
        self.early.as_ref().map_or_else(|| self.delay + self.task.as_ref().map_or(f64::INFINITY, Task::shortest), Way::shortest)
    }

    /// The first duration from `time` on that the axis can have, s; infinite if there is none.
    pub(super) fn next(&self, time: f64) -> f64 {
        if let Some(way) = &self.early {
            let next = if time <= way.shortest() * (1.0 + SAME) { way.shortest() } else { way.next(time) };
            if next.is_finite() {
                return next;
            }
        }
        let Some(task) = &self.task else { return f64::INFINITY };
        let (shortest, wanted) = (task.shortest(), time - self.delay);
        if wanted <= shortest * (1.0 + SAME) {
            return self.delay + shortest;
        }
        self.delay
            + match task {
                Task::Position(way) => way.next(wanted),
                Task::Speed { goal, .. } => past(wanted, goal.blocked()),
            }
    }

    /// The phases of the motion of the duration `time`, one that [`Solo::next`] allows, s.
    pub(super) fn phases(&self, time: f64) -> Vec<Phase> {
        let mut phases = Vec::with_capacity(8);
        match (&self.early, &self.task) {
            (Some(way), _) if time <= way.longest() * (1.0 + SAME) => way.extend(time, &mut phases),
            (_, Some(task)) => {
                phases.extend_from_slice(self.brake.phases());
                match task {
                    Task::Position(way) => way.extend(time - self.delay, &mut phases),
                    Task::Speed { goal, .. } => phases.extend_from_slice(goal.lasting(time - self.delay).phases()),
                }
            }
            (Some(way), None) => way.extend(time, &mut phases),
            (None, None) => {}
        }
        phases
    }
}

impl Task {
    fn shortest(&self) -> f64 {
        match self {
            Self::Position(way) => way.shortest(),
            Self::Speed { shortest, .. } => *shortest,
        }
    }
}

/// The state after some phases.
fn after(start: &AxisState, phases: &[Phase]) -> AxisState {
    let state = phases.iter().fold((start.position, start.velocity, start.acceleration), |s, p| advance(s, p.jerk, p.duration));
    AxisState { position: state.0, velocity: state.1, acceleration: state.2 }
}

/// The first duration from `time` on that is in none of two blocked intervals.
fn past(mut time: f64, blocked: [Option<(f64, f64)>; 2]) -> f64 {
    for _ in 0..2 {
        for (from, to) in blocked.iter().flatten() {
            if time > from * (1.0 + SAME) && time < to * (1.0 - SAME) {
                time = *to;
            }
        }
    }
    time
}

impl Way {
    /// `only_brief`: the motions that pass through zero acceleration are no choice.
    fn new(mut line: Line, distance: f64, size: f64, only_brief: bool) -> Self {
        let brief = Widest::brief(&line, false).zip(Widest::brief(&line, true));
        let speed = line.start.0.abs().max(line.end.0.abs());
        let slack = |time: f64, speed: f64| size + 1e-12 * (speed * time + distance.abs());
        let brief = brief.and_then(|(upper, lower)| Part::new([upper, lower], distance, slack(upper.least().1, speed)));
        let mut way = Self { line, distance, slack: size, brief, usual: None };
        if only_brief {
            return way;
        }
        if line.speed.1.is_infinite() {
            line.speed.1 = Widest::new(&line, false).capped(distance).1;
        }
        if line.speed.0.is_infinite() {
            line.speed.0 = -Widest::new(&line, true).capped(distance).1;
        }
        let families = [Widest::new(&line, false), Widest::new(&line, true)];
        let rests = line.rests();
        way.slack = slack(families[0].least().1, speed.max(rests[0].abs()).max(rests[1].abs()));
        way.line = line;
        way.usual = Part::new(families, distance, way.slack);
        way
    }

    /// s.
    fn shortest(&self) -> f64 {
        self.brief.as_ref().or(self.usual.as_ref()).map_or(f64::INFINITY, |part| part.shortest)
    }

    /// The longest duration of the first component, s.
    fn longest(&self) -> f64 {
        self.brief.as_ref().map_or(f64::INFINITY, |part| part.families[0].longest())
    }

    fn next(&self, time: f64) -> f64 {
        if let Some(part) = &self.brief
            && let next = part.next(time, self.distance, self.slack)
            && next <= self.longest() * (1.0 + SAME)
        {
            return next;
        }
        self.usual.as_ref().map_or(f64::INFINITY, |part| part.next(time, self.distance, self.slack))
    }

    fn extend(&self, time: f64, phases: &mut Vec<Phase>) {
        for part in self.brief.iter().chain(&self.usual) {
            if time <= part.shortest * (1.0 + SAME) {
                return phases.extend_from_slice(part.best.phases());
            }
            if time <= self.longest() * (1.0 + SAME) {
                break;
            }
        }
        match &self.brief {
            Some(part) if time <= self.longest() * (1.0 + SAME) => phases.extend(amid(&part.families, self.distance, time)),
            _ => phases.extend(exactly(&self.line, self.distance, time)),
        }
    }
}

impl Part {
    fn new(families: [Widest; 2], distance: f64, slack: f64) -> Option<Self> {
        let upper = &families[0];
        let (least, time) = upper.least();
        if (distance - least).abs() <= slack {
            return Some(Self { best: upper.shape(&upper.fastest()), shortest: time, families });
        }
        let family = &families[usize::from(distance < least)];
        let place = family.first(distance, slack)?;
        Some(Self { best: family.shape(&place), shortest: place.time, families })
    }

    fn next(&self, time: f64, distance: f64, slack: f64) -> f64 {
        if time <= self.shortest { self.shortest } else { past(time, self.families.map(|family| family.blocked(distance, slack))) }
    }
}
