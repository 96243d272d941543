//! The motions that a search may choose from: turns in place and profiles from rest to rest.

use super::safety::{duration, state};
use crate::path::Path;
use crate::query::Limits;
use crate::timing::ceiling::Ceiling;
use crate::timing::correction::{correct, first_pass};
use crate::timing::method::steps;
use crate::timing::scurve::{Bounds, SCurve};
use crate::timing::{Piece, TimingOptions, Trajectory};
use std::collections::HashMap;
use std::rc::Rc;

/// Wanted spacing of stations, m, and the most of them on a path.
const STATIONS: (f64, f64) = (0.25, 48.0);
/// Speeds as shares of the limit; the slow ones only over a distance (m) that makes a difference.
const SHARES: [f64; 4] = [1.0, 0.7, 0.5, 0.35];
const WORTH: f64 = 0.75;

/// A place where the robot may rest.
#[derive(Debug, Clone, Copy)]
pub(super) struct Station {
    /// Arc length, m.
    pub s: f64,
    /// Stretch between stops to which it belongs.
    stretch: usize,
    /// Heading at rest, rad.
    pub heading: f64,
    /// Time that at least remains from here, s.
    pub remaining: f64,
}

/// Pieces from rest to rest; their times begin at 0.
pub(super) type Motion = Rc<Vec<Piece>>;

/// Stations, and the motions between them as they are asked for.
pub(super) struct Motions<'a> {
    pub plain: &'a Trajectory,
    options: &'a TimingOptions<'a>,
    pub stations: Vec<Station>,
    /// By the station before: the turn in place that leads from it to the next.
    turns: HashMap<usize, Motion>,
    known: HashMap<(usize, usize, usize), Option<Motion>>,
}

impl<'a> Motions<'a> {
    /// Stations at the stops of the plain motion and between them.
    pub fn new(plain: &'a Trajectory, options: &'a TimingOptions<'a>) -> Self {
        let mut out = Self { plain, options, stations: Vec::new(), turns: HashMap::new(), known: HashMap::new() };
        let path = &plain.path;
        let spacing = STATIONS.0.max(path.length() / STATIONS.1);
        let (mut stretch, mut k) = (0, 0);
        while k < plain.pieces.len() {
            let turning = |p: &Piece| matches!(p, Piece::Turn { .. });
            let begin = k;
            if let Piece::Turn { s, from, turn, .. } = plain.pieces[k] {
                // Two turns in a row, or one at an end, need stations of their own.
                let lonely = out.stations.last().is_none_or(|last| last.stretch != stretch || last.s < s);
                if lonely {
                    out.add(s, stretch, from);
                }
                out.turns.insert(out.stations.len() - 1, Rc::new(at_zero(&plain.pieces[k..=k])));
                stretch += 1;
                out.add(s, stretch, from + turn);
                k += 1;
                continue;
            }
            while k < plain.pieces.len() && !turning(&plain.pieces[k]) {
                k += 1;
            }
            let run = &plain.pieces[begin..k];
            let (from, to) = (state(run, 0.0).0, state(run, duration(run)).0);
            out.line(path, (from, to), spacing, stretch);
            let (first, last) = (out.stations.iter().rposition(|p| p.s <= from).unwrap_or(0), out.stations.len() - 1);
            out.known.insert((first, last, 0), Some(Rc::new(at_zero(run))));
        }
        out
    }

    fn line(&mut self, path: &Path, (from, to): (f64, f64), spacing: f64, stretch: usize) {
        let n = ((to - from) / spacing).ceil().max(1.0) as usize;
        let begun = self.stations.last().is_some_and(|last| last.stretch == stretch);
        for i in usize::from(begun)..=n {
            let s = if i == n { to } else { from + (to - from) * i as f64 / n as f64 };
            let inside = s.clamp(from + 1e-9 * (to - from), to - 1e-9 * (to - from));
            self.add(s, stretch, path.planar(inside).heading);
        }
    }

    /// The plain motion needs that long from here, or a motion without ceiling longer.
    fn add(&mut self, s: f64, stretch: usize, heading: f64) {
        let plain = self.plain;
        let passed = plain.pieces.partition_point(|p| state(std::slice::from_ref(p), p.duration()).0 <= s);
        let when = plain.pieces.get(passed).map_or(plain.duration(), |p| {
            let (mut low, mut high) = (0.0, p.duration());
            for _ in 0..40 {
                let x = 0.5 * (low + high);
                if state(std::slice::from_ref(p), x).0 <= s { low = x } else { high = x }
            }
            p.start() + high
        });
        let alone = first_pass(plain.path.length() - s, &plain.limits).map_or(0.0, |p| p.duration());
        self.stations.push(Station { s, stretch, heading, remaining: (plain.duration() - when).max(alone) });
    }

    /// Every motion from a station: where it ends and its pieces.
    pub fn from(&mut self, i: usize) -> Vec<(usize, Motion)> {
        if let Some(turn) = self.turns.get(&i) {
            return vec![(i + 1, turn.clone())];
        }
        let here = self.stations[i];
        let mine = self.stations[i + 1..].iter().take_while(|p| p.stretch == here.stretch).count();
        let mut out = Vec::new();
        for j in (i + 1..=i + mine).rev() {
            let worth = self.stations[j].s - here.s >= WORTH;
            for (k, share) in SHARES.into_iter().enumerate().take(if worth { SHARES.len() } else { 1 }) {
                let motion = self.known.get(&(i, j, k)).cloned().unwrap_or_else(|| {
                    let made = self.make((here.s, self.stations[j].s), share);
                    self.known.insert((i, j, k), made.clone());
                    made
                });
                out.extend(motion.map(|m| (j, m)));
            }
        }
        out
    }

    /// Rest to rest under the ceiling and a share of the speed limit: one S-curve, or as many as the ceiling asks for.
    fn make(&self, (from, to): (f64, f64), share: f64) -> Option<Motion> {
        let limits = &self.plain.limits;
        let bounds = Bounds { speed: limits.speed * share, ..Bounds::from(limits) };
        let slower = Limits { speed: bounds.speed, ..*limits };
        let ceiling = Ceiling::of_path(&self.plain.path, (from, to), &slower, self.options.clearance_ceiling.map(|f| f as &dyn Fn(f64) -> f64));
        let whole = SCurve { distance: to - from, start: (0.0, 0.0), end: (0.0, 0.0), bounds }.plan().ok()?;
        let chain = if ceiling.first_excess(0.0, &whole).is_none() { vec![(0.0, whole)] } else { correct(&ceiling, &bounds, (0.0, 0.0)).ok()?.chain };
        let mut t = 0.0;
        let pieces = chain.iter().flat_map(|(s, profile)| steps(from + s, profile)).map(|step| {
            let piece = Piece::Along { t, s: step.s, speed: step.speed, acceleration: step.acceleration, jerk: step.jerk, duration: step.duration };
            t += step.duration;
            piece
        });
        Some(Rc::new(pieces.collect()))
    }
}

/// The same pieces with times that begin at 0.
fn at_zero(pieces: &[Piece]) -> Vec<Piece> {
    let start = pieces.first().map_or(0.0, Piece::start);
    pieces.iter().map(|p| p.shifted(-start)).collect()
}
