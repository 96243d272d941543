//! One axis: its shortest duration, the durations it cannot have, and its motion for any other.

use super::Axis;
use super::brake::brake;
use super::exactly::{amid, exactly};
use super::line::{Line, settled};
use super::motion::flown;
use super::speed_goal::SpeedGoal;
use super::widest::{Place, Widest};
use crate::timing::scurve::Phase;

/// Relative slack of durations.
const SAME: f64 = 1e-13;

/// Relative excess over limits that counts as rounding.
pub(super) const ROUNDING: f64 = 1e-11;

/// One axis, solved for its shortest duration.
#[derive(Debug, Clone)]
pub(super) struct Solo {
    /// Motions to the goal without a brake from a start that could not go on within the limits, or to a goal that could not be come
    /// from within them. Their acceleration keeps its sign.
    early: Option<Box<Way>>,
    brake: Vec<Phase>,
    /// Duration of the brake, s.
    delay: f64,
    /// After the brake.
    task: Option<Task>,
}

#[derive(Debug, Clone)]
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
    /// The longest of those, s.
    longest: f64,
    usual: Option<Part>,
}

/// A component of the motions of an axis: the fastest of them.
#[derive(Debug, Clone, Copy)]
struct Part {
    place: Place,
    /// The mirror image of the family it is from.
    flipped: bool,
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
        let brake = brake((start.velocity, start.acceleration), limits, goal.position.is_some()).phases().to_vec();
        let Some(position) = goal.position else {
            let from = flown(*start, brake.iter().copied(), limits, |_| ());
            let goal = SpeedGoal::new((from.velocity, from.acceleration), end, limits.acceleration, limits.jerk);
            return Ok(Self::with(None, brake, Some(Task::Speed { goal, shortest: goal.shortest() })));
        };
        let size = 8.0 * f64::EPSILON * (start.position.abs() + position.abs()) + 1e-16;
        let before = settled((end.0, -end.1), limits.jerk);
        let viable = inside(before, limits.velocity);
        let within = inside(start.velocity, limits.velocity) && inside(start.acceleration, limits.acceleration);
        let early = (within && (!viable || !brake.is_empty()))
            .then(|| Way::new(Line::new((start.velocity, start.acceleration), end, limits), position - start.position, size, true))
            .filter(|way| way.brief.is_some())
            .map(Box::new);
        if !viable {
            return if early.is_some() { Ok(Self::with(early, Vec::new(), None)) } else { Err(Refusal::Unreachable(before)) };
        }
        let from = flown(*start, brake.iter().copied(), limits, |_| ());
        let line = Line::new((from.velocity, from.acceleration), end, limits);
        let way = Way::new(line, position - from.position, size, false);
        let task = (way.brief.is_some() || way.usual.is_some()).then_some(Task::Position(way));
        if task.is_none() && early.is_none() { Err(Refusal::Forbidden) } else { Ok(Self::with(early, brake, task)) }
    }

    fn with(early: Option<Box<Way>>, brake: Vec<Phase>, task: Option<Task>) -> Self {
        Self { early, delay: brake.iter().map(|p| p.duration).sum(), brake, task }
    }

    /// Shortest duration, s.
    pub(super) fn shortest(&self) -> f64 {
        self.early.as_ref().map_or_else(|| self.delay + self.task.as_ref().map_or(f64::INFINITY, Task::shortest), |way| way.shortest())
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

    /// Appends the phases of the motion of the duration `time`, one that [`Solo::next`] allows, s.
    pub(super) fn phases(&self, time: f64, phases: &mut Vec<Phase>) {
        match (&self.early, &self.task) {
            (Some(way), _) if time <= way.longest * (1.0 + SAME) => way.extend(time, phases),
            (_, Some(task)) => {
                phases.extend_from_slice(&self.brake);
                match task {
                    Task::Position(way) => way.extend(time - self.delay, phases),
                    Task::Speed { goal, .. } => phases.extend_from_slice(goal.lasting(time - self.delay).phases()),
                }
            }
            (Some(way), None) => way.extend(time, phases),
            (None, None) => {}
        }
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
        let speed = line.start.0.abs().max(line.end.0.abs());
        let slack = |time: f64, speed: f64| size + 1e-12 * (speed * time + distance.abs());
        let mut way = Self { line, distance, slack: size, brief: None, longest: f64::INFINITY, usual: None };
        if let Some(upper) = Widest::brief(&line, false) {
            way.slack = slack(upper.least().1, speed);
            way.longest = upper.longest().max(upper.least().1);
            way.brief = Part::new(&upper, || Widest::brief(&line, true), distance, way.slack);
        }
        if way.brief.is_none() {
            way.longest = f64::INFINITY;
        }
        if only_brief {
            return way;
        }
        if line.speed.1.is_infinite() {
            line.speed.1 = Widest::new(&line, false).capped(distance).1;
        }
        if line.speed.0.is_infinite() {
            line.speed.0 = -Widest::new(&line, true).capped(distance).1;
        }
        let upper = Widest::new(&line, false);
        let rests = line.rests();
        way.slack = slack(upper.least().1, speed.max(rests[0].abs()).max(rests[1].abs()));
        way.line = line;
        way.usual = Part::new(&upper, || Some(Widest::new(&line, true)), distance, way.slack);
        way
    }

    /// The families of the brief motions, or of the others.
    fn families(&self, brief: bool) -> Option<[Widest; 2]> {
        if brief {
            Some([Widest::brief(&self.line, false)?, Widest::brief(&self.line, true)?])
        } else {
            Some([Widest::new(&self.line, false), Widest::new(&self.line, true)])
        }
    }

    /// s.
    fn shortest(&self) -> f64 {
        self.brief.or(self.usual).map_or(f64::INFINITY, |part| part.place.time)
    }

    fn next(&self, time: f64) -> f64 {
        for (brief, part) in [(true, self.brief), (false, self.usual)] {
            let Some(part) = part else { continue };
            let next = if time <= part.place.time {
                part.place.time
            } else {
                let Some(families) = self.families(brief) else { continue };
                past(time, families.map(|family| family.blocked(self.distance, self.slack)))
            };
            if !brief || next <= self.longest * (1.0 + SAME) {
                return next;
            }
        }
        f64::INFINITY
    }

    fn extend(&self, time: f64, phases: &mut Vec<Phase>) {
        let in_brief = self.brief.is_some() && time <= self.longest * (1.0 + SAME);
        let Some(part) = (if in_brief { self.brief } else { self.usual }) else { return };
        let fastest = time <= part.place.time * (1.0 + SAME);
        match self.families(in_brief) {
            Some(families) if fastest => phases.extend_from_slice(families[usize::from(part.flipped)].shape(&part.place).phases()),
            Some(families) if in_brief => phases.extend(amid(&families, self.distance, time)),
            _ => exactly(&self.line, self.distance, time, phases),
        }
    }
}

impl Part {
    fn new(upper: &Widest, lower: impl Fn() -> Option<Widest>, distance: f64, slack: f64) -> Option<Self> {
        let least = upper.least().0;
        if (distance - least).abs() <= slack {
            return Some(Self { place: upper.fastest(), flipped: false });
        }
        let flipped = distance < least;
        let place = if flipped { lower()?.first(distance, slack)? } else { upper.first(distance, slack)? };
        Some(Self { place, flipped })
    }
}
