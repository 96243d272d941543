//! Where a jerk-limited motion stops: at both ends unless speeds are asked for, where the path turns back, and in turns too sharp for its cells.
//!
//! A path that all but stops by its parameter is, seen from a little further, one that turns back. Pieces of constant path jerk pass such a turn only if they
//! are shorter than the turn takes (the path jerk there is that of a fall that turns round), so a turn that takes less than a cell is a stop.

use super::reference::Reference;
use crate::timing::topp::course::{Course, Shape};
use crate::timing::topp::motion::Leg;
use crate::timing::topp::solve::Solved;

/// Way on a cell near a turn, as a share of its distance from the turn (or of the radius of the turn if that is larger).
const SHARE: f64 = 0.5;
/// Times that cells are halved there.
const HALVINGS: u32 = 3;
/// Most by which the speed may grow on a cell at an end that is passed, as a factor, and times that the cell is halved for it.
const GAIN: f64 = 4.0;
const END_HALVINGS: u32 = 16;
/// Share of the duration by which the last cell may end elsewhere.
const ROUNDING: f64 = 1e-12;

/// A part of the path between stops, or ends of the path.
pub(super) struct Stretch<'a> {
    /// The second-order motion.
    pub legs: &'a [Leg],
    /// Arc lengths.
    pub ends: [f64; 2],
    /// Path speeds asked for there; 0 at stops.
    pub speeds: [f64; 2],
    /// Turns on it, and where it ends in one: way from its start, radius.
    pub turns: Vec<[f64; 2]>,
    /// Whether it starts or ends in a turn.
    pub cut: bool,
}

impl Stretch<'_> {
    /// Time of the second-order motion.
    pub fn duration(&self) -> f64 {
        self.legs.iter().map(|leg| leg.duration).sum()
    }

    /// The smallest cell, as a share of the others.
    pub fn finest(&self) -> f64 {
        if self.cut { 0.5f64.powi(HALVINGS as i32) } else { 1.0 }
    }

    /// Cuts a cell between two times of a reference until it is short beside its distance from the turns; adds the ends of the parts.
    pub fn cut(&self, reference: &Reference, [from, to]: [f64; 2], halved: u32, times: &mut Vec<f64>) {
        let [a, b] = [from, to].map(|t| reference.at(t)[0]);
        let room = |[at, radius]: &[f64; 2]| radius.max(at - b).max(a - at);
        let room = self.turns.iter().map(room).fold(f64::INFINITY, f64::min);
        if (halved < HALVINGS && b - a > SHARE * room) || (halved < END_HALVINGS && self.gains(reference, [from, to])) {
            let middle = 0.5 * (from + to);
            self.cut(reference, [from, middle], halved + 1, times);
            self.cut(reference, [middle, to], halved + 1, times);
        } else {
            times.push(to);
        }
    }
}

impl Stretch<'_> {
    /// Whether the speed between two times, one of them that of an end which is passed slowly, changes so much that this is a motion from rest, seen from afar.
    fn gains(&self, reference: &Reference, times: [f64; 2]) -> bool {
        let [v, w] = times.map(|t| reference.at(t)[1]);
        (self.speeds[0] > 0.0 && times[0] == 0.0 && w > GAIN * v)
            || (self.speeds[1] > 0.0 && times[1] >= reference.duration() * (1.0 - ROUNDING) && v > GAIN * w)
    }
}

/// The path cut where the second-order motion stops and where it turns in less than `least` s.
pub(super) fn stretches<'a>(course: &Course, solved: &'a Solved, speeds: [f64; 2], least: f64) -> Vec<Stretch<'a>> {
    let (s, x) = (&solved.problem.s, &solved.x);
    let last = s.len() - 1;
    let turns = turns(course, s);
    let sharp = |node: usize| turns.iter().any(|(k, radius)| *k == node && *radius < least * x[node].sqrt());
    let stops: Vec<usize> = (0..s.len()).filter(|k| x[*k] == 0.0 || *k == 0 || *k == last || sharp(*k)).collect();
    let stretch = |w: &[usize]| {
        let (from, to) = (w[0], w[1]);
        let within = turns.iter().filter(|(k, _)| (from..=to).contains(k) && x[*k] > 0.0);
        Stretch {
            legs: &solved.legs[from..to],
            ends: [s[from], s[to]],
            speeds: [if from == 0 { speeds[0] } else { 0.0 }, if to == last { speeds[1] } else { 0.0 }],
            turns: within.map(|(k, radius)| [s[*k] - s[from], *radius]).collect(),
            cut: (from > 0 && x[from] > 0.0) || (to < last && x[to] > 0.0),
        }
    };
    stops.windows(2).map(stretch).collect()
}

/// Nodes where the path slows down by its parameter, and the radius there.
fn turns(course: &Course, s: &[f64]) -> Vec<(usize, f64)> {
    let mut shape = Shape::new(course.dimension);
    let mut turns = Vec::new();
    for piece in 0..course.count() {
        for t in course.breaks(piece, false) {
            course.shape(piece, t, &mut shape);
            let bend = shape.second.iter().map(|q| q * q).sum::<f64>().sqrt();
            turns.push((nearest(s, course.place(piece, t).s), 1.0 / bend));
        }
    }
    turns
}

/// Number of the node nearest to an arc length.
fn nearest(s: &[f64], at: f64) -> usize {
    let k = s.partition_point(|s| *s < at).clamp(1, s.len() - 1);
    if at - s[k - 1] < s[k] - at { k - 1 } else { k }
}
