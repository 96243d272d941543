//! The motions that a search may choose from: a graph of places with speeds, joined by turns in place and jerk-limited profiles.
//!
//! A node is a place on the path that is passed at one speed without acceleration. Profiles lead from node to node: as fast as the ceiling lets to the next
//! places where the plain motion is slowest, changes of speed in the shortest distance, and steps at constant speed.

use super::safety::state;
use super::table::{Passage, Table};
use crate::timing::ceiling::Ceiling;
use crate::timing::method::steps;
use crate::timing::profile::fastest;
use crate::timing::scurve::{Bounds, Profile, SCurve};
use crate::timing::turn::{SAME_HEADING, turn_time};
use crate::timing::{Piece, TimingOptions, Trajectory};
use crate::world::shape::wrap;

/// Wanted spacing of stations, m, and the most of them on a path.
const STATIONS: (f64, f64) = (0.2, 64.0);
/// Speeds as shares of the limit, from rest up.
const SHARES: [f64; 6] = [0.0, 0.2, 0.4, 0.6, 0.8, 1.0];
/// Level of the speed of the plain motion where it is slowest.
const SLOWEST: usize = SHARES.len();
/// Stations so near to a place where the plain motion is slowest are left out, shares of the spacing.
const CROWDED: f64 = 0.3;
/// Halvings of the duration of a piece until the time at which it passes a place is known well enough.
const HALVES: usize = 24;
/// From rest to rest over that many stations.
const HOPS: [usize; 4] = [1, 2, 4, 8];

/// A place that is passed at one speed, without acceleration.
#[derive(Debug, Clone)]
pub(super) struct Node {
    /// Arc length, m.
    pub s: f64,
    /// m/s.
    pub speed: f64,
    /// Heading at rest, rad.
    pub heading: f64,
    /// Nodes at the same place have the same station; stations are numbered along the path.
    pub station: usize,
    level: usize,
    /// Nodes that can be reached directly, and the number of the motion.
    pub next: Vec<(usize, usize)>,
    /// No motion needs less from here to the goal, s.
    pub remaining: f64,
}

/// From node to node; times begin at 0.
#[derive(Debug, Clone)]
pub(super) struct Motion {
    /// Arc length where it begins, m.
    from: f64,
    pub pieces: Vec<Piece>,
    /// s; of a motion that is not made yet a bound from below.
    pub duration: f64,
    /// What is needed to make it: the stretch and both nodes.
    unmade: Option<(usize, usize, usize)>,
}

/// All nodes, later ones farther along, and the motions between them. The first node is the start and the last one the goal.
pub(super) struct Motions<'a> {
    pub plain: &'a Trajectory,
    pub nodes: Vec<Node>,
    pub made: Vec<Motion>,
    stretches: Vec<Stretch>,
    bounds: Bounds,
}

/// A stretch of a path between stops: its start (m) and its ceiling.
struct Stretch {
    from: f64,
    ceiling: Ceiling,
}

impl<'a> Motions<'a> {
    /// The graph for the path of a plain motion.
    pub fn new(plain: &'a Trajectory, options: &TimingOptions) -> Self {
        let mut out = Self { plain, nodes: Vec::new(), made: Vec::new(), stretches: Vec::new(), bounds: Bounds::from(&plain.limits) };
        let (path, corners) = (&plain.path, plain.path.corners());
        let length = path.length();
        let stops: Vec<f64> = std::iter::once(0.0).chain(corners.iter().map(|c| c.s)).chain([length]).collect();
        let (first, last) = (path.planar(0.0).heading, path.planar(length).heading);
        out.add(0.0, 0, options.start_yaw.unwrap_or(first));
        let spacing = STATIONS.0.max(length / STATIONS.1);
        for (i, pair) in stops.windows(2).enumerate() {
            let turned_to = if i == 0 { first } else { corners[i - 1].heading_out };
            let leaving = corners.get(i).map_or(last, |c| c.heading_in);
            out.turn(turned_to);
            let extra = options.clearance_ceiling.map(|f| f as &dyn Fn(f64) -> f64);
            let stretch = Stretch { from: pair[0], ceiling: Ceiling::of_path(path, (pair[0], pair[1]), &plain.limits, extra) };
            out.stretch(&stretch, pair[1], spacing, leaving);
            out.stretches.push(stretch);
        }
        out.turn(options.goal_yaw.unwrap_or(last));
        out.look_back();
        out
    }

    /// The first node of a station of its own.
    fn add(&mut self, s: f64, station: usize, heading: f64) {
        self.nodes.push(Node { s, speed: 0.0, heading, station, level: 0, next: Vec::new(), remaining: f64::INFINITY });
    }

    /// A station where the robot has turned to a heading (rad), reached from the last one.
    fn turn(&mut self, heading: f64) {
        let from = self.nodes.len() - 1;
        let Node { s, station, heading: before, .. } = self.nodes[from];
        let turn = wrap(heading - before);
        let mut motion = Motion { from: s, pieces: Vec::new(), duration: 0.0, unmade: None };
        if turn.abs() > SAME_HEADING {
            motion.duration = turn_time(turn, &self.plain.limits);
            motion.pieces.push(Piece::Turn { turn, t: 0.0, duration: motion.duration, s, from: before });
        }
        self.add(s, station + 1, heading);
        self.join(from, from + 1, motion);
    }

    fn join(&mut self, from: usize, to: usize, motion: Motion) {
        self.nodes[from].next.push((to, self.made.len()));
        self.made.push(motion);
    }

    /// Nodes from the last one, at the start of a stretch, to its end (m), where the path has the heading `leaving` (rad); and their motions.
    fn stretch(&mut self, stretch: &Stretch, to: f64, spacing: f64, leaving: f64) {
        let first = self.nodes.len() - 1;
        let from = stretch.from;
        let slowest = self.slowest((from, to));
        let n = ((to - from) / spacing).ceil().max(1.0) as usize;
        let even = (1..n).map(|k| (from + (to - from) * k as f64 / n as f64, None));
        let apart = |s: &f64| slowest.iter().all(|(at, _)| (s - at).abs() > CROWDED * spacing);
        let mut places: Vec<(f64, Option<f64>)> = even.filter(|p| apart(&p.0)).collect();
        places.extend(slowest.iter().map(|&(s, v)| (s, Some(v))));
        places.sort_by(|a, b| a.0.total_cmp(&b.0));
        for (s, v) in places {
            let station = self.nodes[self.nodes.len() - 1].station + 1;
            self.levels(stretch, (s, v), station);
        }
        let station = self.nodes[self.nodes.len() - 1].station + 1;
        self.add(to, station, leaving);
        for i in first..self.nodes.len() - 1 {
            self.leave(stretch, i);
        }
    }

    /// Nodes at a place inside a stretch, by rising level.
    fn levels(&mut self, stretch: &Stretch, (s, own): (f64, Option<f64>), station: usize) {
        let heading = self.plain.path.planar(s).heading;
        let top = stretch.ceiling.at(s - stretch.from);
        let shares = SHARES.iter().map(|share| share * self.bounds.speed).enumerate().filter(|(_, v)| *v <= top);
        let all: Vec<(usize, f64)> = shares.chain(own.map(|v| (SLOWEST, v))).collect();
        for (level, speed) in all {
            self.nodes.push(Node { s, speed, heading, station, level, next: Vec::new(), remaining: f64::INFINITY });
        }
    }

    /// Where the plain motion is slowest for the moment, inside a stretch: arc length (m) and speed (m/s).
    fn slowest(&self, (from, to): (f64, f64)) -> Vec<(f64, f64)> {
        let troughs = self.plain.pieces.iter().filter_map(|piece| match *piece {
            Piece::Along { s, speed, acceleration, jerk, .. } if acceleration.abs() < 1e-9 && jerk > 0.0 && speed > 1e-3 => Some((s, speed)),
            _ => None,
        });
        troughs.filter(|(s, _)| *s > from + 1e-3 && *s < to - 1e-3).collect()
    }

    /// The motions that leave a node inside a stretch.
    fn leave(&mut self, stretch: &Stretch, i: usize) {
        let end = self.nodes.len() - 1;
        let Node { s, speed, station, .. } = self.nodes[i];
        let ahead: Vec<usize> = (i + 1..=end).filter(|&j| self.nodes[j].station > station).collect();
        for (level, share) in SHARES.into_iter().enumerate() {
            let top = speed.max(share * self.bounds.speed);
            if top > 0.0 {
                let to: Vec<usize> = ahead.iter().copied().filter(|&j| self.nodes[j].level == level).collect();
                self.change(stretch, i, &to, top);
            }
        }
        let resting: Vec<usize> = ahead.iter().copied().filter(|&j| self.nodes[j].level == 0).collect();
        for j in HOPS.iter().filter(|_| speed == 0.0).filter_map(|hop| resting.get(hop - 1)) {
            let profile = self.profile(s, speed, *j, self.bounds.speed);
            self.take(i, *j, profile.filter(|p| stretch.ceiling.allows(s - stretch.from, p)));
        }
        // As fast as can be to the next places where the plain motion is slow, and to the end.
        let slow = ahead.iter().copied().filter(|&j| self.nodes[j].level == SLOWEST || j == end);
        let reached = slow.map(|j| (j, self.profile(s, speed, j, self.bounds.speed))).find_map(|(j, p)| p.map(|p| (j, p)));
        match reached {
            Some((j, p)) if stretch.ceiling.allows(s - stretch.from, &p) => self.take(i, j, Some(p)),
            Some((j, p)) => {
                let unmade = Some((self.stretches.len(), i, j));
                self.join(i, j, Motion { from: s, pieces: Vec::new(), duration: p.duration(), unmade });
            }
            None => {}
        }
    }

    /// A change to another speed, or the same one, at the first of the nodes where there is room for it.
    fn change(&mut self, stretch: &Stretch, i: usize, to: &[usize], top: f64) {
        let Node { s, speed, .. } = self.nodes[i];
        let found = to.iter().map(|&j| (j, self.profile(s, speed, j, top))).find_map(|(j, p)| p.map(|p| (j, p)));
        if let Some((j, profile)) = found.filter(|(_, p)| stretch.ceiling.allows(s - stretch.from, p)) {
            self.take(i, j, Some(profile));
        }
    }

    /// From a speed at `s` to a node, never faster than `top` (m/s).
    fn profile(&self, s: f64, speed: f64, to: usize, top: f64) -> Option<Profile> {
        let bounds = Bounds { speed: top, ..self.bounds };
        SCurve { distance: self.nodes[to].s - s, start: (speed, 0.0), end: (self.nodes[to].speed, 0.0), bounds }.between_troughs()
    }

    fn take(&mut self, i: usize, j: usize, profile: Option<Profile>) {
        if let Some(profile) = profile {
            let motion = chained(&[(self.nodes[i].s, profile)]);
            self.join(i, j, motion);
        }
    }

    /// Makes a motion that is not made yet: the fastest under the ceiling, which a single profile would exceed. One that cannot be made lasts for ever.
    pub fn make(&mut self, motion: usize) {
        let Some((stretch, i, j)) = self.made[motion].unmade.take() else { return };
        let (a, b, stretch) = (&self.nodes[i], &self.nodes[j], &self.stretches[stretch]);
        let (from, length) = (a.s - stretch.from, b.s - a.s);
        let n = (length / stretch.ceiling.step()).ceil().clamp(1.0, 4000.0);
        let at = |k: usize| (from + length * k as f64 / n).min(stretch.ceiling.length());
        let cells = (0..n as usize).map(|k| stretch.ceiling.lowest(at(k), at(k + 1))).collect();
        let chain = fastest(&Ceiling::from_cells(length, cells), &self.bounds, (a.speed, b.speed)).unwrap_or_default();
        let chain: Vec<(f64, Profile)> = chain.into_iter().map(|(s, p)| (a.s + s, p)).collect();
        self.made[motion] = if chain.is_empty() { Motion { duration: f64::INFINITY, ..self.made[motion].clone() } } else { chained(&chain) };
    }

    /// Least times to the goal over the motions there are.
    fn look_back(&mut self) {
        let goal = self.nodes.len() - 1;
        self.nodes[goal].remaining = 0.0;
        for i in (0..goal).rev() {
            let through = |&(to, motion): &(usize, usize)| self.nodes[to].remaining + self.made[motion].duration;
            self.nodes[i].remaining = self.nodes[i].next.iter().map(through).fold(f64::INFINITY, f64::min);
        }
    }

    /// Arc length of every station, m.
    pub fn stations(&self) -> Vec<f64> {
        self.nodes.iter().filter(|n| n.level == 0).map(|n| n.s).collect()
    }
}

/// A chain of profiles, each with its start (m), as pieces.
fn chained(chain: &[(f64, Profile)]) -> Motion {
    let mut duration = 0.0;
    let pieces = chain.iter().flat_map(|(s, profile)| steps(*s, profile)).map(|step| {
        let piece =
            Piece::Along { t: duration, s: step.s, speed: step.speed, acceleration: step.acceleration, jerk: step.jerk, duration: step.duration };
        duration += step.duration;
        piece
    });
    let pieces = pieces.collect();
    Motion { from: chain.first().map_or(0.0, |c| c.0), pieces, duration, unmade: None }
}

impl Motion {
    /// Arc length (m), speed (m/s) and acceleration (m/s2) `x` seconds after the start.
    pub fn state(&self, x: f64) -> (f64, f64, f64) {
        if self.pieces.is_empty() { (self.from, 0.0, 0.0) } else { state(&self.pieces, x) }
    }

    /// The cells of a table that it passes. Times are widened by what halving leaves open.
    pub fn passage(&self, table: &Table) -> Passage {
        let last = table.cell(self.state(self.duration).0);
        let mut cell = table.cell(self.from);
        let (mut out, mut entered) = (Passage::new(), 0.0);
        for piece in self.pieces.iter().filter(|p| matches!(p, Piece::Along { .. })) {
            let (start, own) = (piece.start(), piece.duration());
            let at = |x: f64| state(std::slice::from_ref(piece), x).0;
            let mut low = 0.0;
            while cell < last && at(own) >= table.end(cell) {
                let mut high = own;
                for _ in 0..HALVES {
                    let middle = 0.5 * (low + high);
                    if at(middle) < table.end(cell) { low = middle } else { high = middle }
                }
                out.push((cell as u32, entered, start + high));
                entered = start + low;
                cell += 1;
            }
        }
        out.push((cell as u32, entered, self.duration));
        out.extend((cell + 1..=last).map(|c| (c as u32, entered, self.duration)));
        out
    }
}
