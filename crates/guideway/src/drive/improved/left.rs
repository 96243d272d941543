//! What is left to the goal, and how a robot gets going that stands without a reason.

use crate::Point;
use crate::drive::local::Local;
use crate::drive::ways::Sim;
use crate::drive::{Command, CostToGo, Observation};
use crate::world::shape::distance;

/// The last metre counts so much more, m.
const LAST: f64 = 0.6;
/// What places cost that cannot be reached by the cost-to-go, more than the present one, m.
const BLOCKED: f64 = 1.5;
/// Nearer to the end than this the path leads, m.
pub(super) const NEAR_END: f64 = 0.6;
/// Smaller commands are none, m/s and rad/s.
const NOTHING: [f64; 2] = [0.02, 0.05];
/// A robot that has been told to stand for so long, s, with nothing that moves in view, does not wait for anything.
const WAITED: f64 = 0.4;
/// What is faster than this moves, m/s.
const LIVELY: f64 = 0.1;
/// A plan gets nearer if so much less is left at its end, m.
pub(super) const NEARER: f64 = 0.2;

/// Is a command too small to be one?
pub(super) fn nothing(command: Command) -> bool {
    command.v.abs() < NOTHING[0] && command.w.abs() < NOTHING[1]
}

/// Distance to the goal that is left, m, by the cost-to-go of the global layer where there is one and the end is not near; the last bit counts more, so that
/// it is worth driving.
pub(super) fn left(sim: &Sim, local: &Local, to_go: Option<(&CostToGo, f64)>) -> f64 {
    let [s, lateral] = local.relative(sim.mark, sim.pose);
    let p = [sim.pose[0], sim.pose[1]];
    if let Some((field, now)) = to_go
        && local.length - s > NEAR_END
    {
        // Cells that the field counts as blocked may be crossed by what is predicted to be free.
        return field.at(p).min(now + BLOCKED) + LAST;
    }
    let mark = local.mark(sim.mark);
    let off = if s < local.length { lateral.abs() } else { distance(p, mark.point) };
    let left = (local.length - s).max(0.0) + 0.7 * off;
    left + LAST * left.min(1.0).sqrt()
}

/// The cost-to-go of a field, and its value at a place, where it can be reached.
pub(super) fn known(field: Option<&CostToGo>, p: Point) -> Option<(&CostToGo, f64)> {
    field.map(|field| (field, field.at(p))).filter(|known| known.1.is_finite())
}

/// How long the robot has been told to stand. Scores can prefer to begin a moment later, each time anew: then plans that get nearer go first for a while.
#[derive(Debug, Clone, Copy)]
pub(super) struct Idle {
    since: f64,
    urged_until: f64,
}

impl Idle {
    pub fn new() -> Self {
        Self { since: f64::NAN, urged_until: f64::NEG_INFINITY }
    }

    /// After a decision at time `seen.time` that asks for `next`; urges for `span` s where the robot has stood for long.
    pub fn note(&mut self, seen: &Observation, next: Command, span: f64) {
        if !nothing(next) || lively(seen) {
            self.since = f64::NAN;
        } else if self.since.is_nan() {
            self.since = seen.time;
        } else if seen.time - self.since >= WAITED {
            (self.since, self.urged_until) = (seen.time, seen.time + span);
        }
    }

    /// Do plans that get nearer go first?
    pub fn urges(self, seen: &Observation) -> bool {
        seen.time <= self.urged_until && !lively(seen)
    }
}

/// Does anything move?
fn lively(seen: &Observation) -> bool {
    seen.tracks.iter().any(|track| track.velocity[0].hypot(track.velocity[1]) > LIVELY)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::drive::{Outline, Track};
    use crate::world::Footprint;

    #[test]
    fn who_stands_for_long_with_nothing_that_moves_is_urged_for_a_while() {
        let at = |time: f64| Observation::new(time, [0.0; 3], 0.0, 0.0);
        let (stand, go) = (Command::default(), Command { v: 0.5, w: 0.0 });
        let mut idle = Idle::new();
        (0..8).for_each(|k| idle.note(&at(0.05 * f64::from(k)), stand, 4.0));
        assert!(!idle.urges(&at(0.4)));
        idle.note(&at(0.41), stand, 4.0);
        idle.note(&at(0.46), go, 4.0);
        assert!(idle.urges(&at(0.5)) && idle.urges(&at(4.4)) && !idle.urges(&at(4.5)));
        let mut busy = at(0.5);
        let outline = Outline::of(&Footprint::Disc(0.3));
        busy.tracks.push(Track { id: 0, outline, position: [3.0, 0.0], velocity: [0.5, 0.0], bound: 1.0, doubt: 0.0 });
        assert!(!idle.urges(&busy), "it may wait for what moves");
        let mut waits = Idle::new();
        for k in 0..40 {
            busy.time = 0.05 * f64::from(k);
            waits.note(&busy, stand, 4.0);
        }
        assert!(!waits.urges(&at(2.0)));
    }
}
