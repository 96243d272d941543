//! Trajectory correction by nodes: from a profile that overruns the ceiling of its path to one that keeps it.
//!
//! Source: the closed loop of \[zhang2025\], completed: nodes at the minima of the ceiling, a seven-phase plan between neighbours, one more node in each
//! overspeed region, until there is none. Departures: between two nodes the speed limit is the highest ceiling there (nothing faster is of use); a place
//! too near to a node gets its node at some distance, and where two nodes are too near for a third one, they or the limit between them are lowered. So
//! every step adds a node on a finite grid or lowers a speed to that of a cell, and the loop ends.

use super::ceiling::Ceiling;
use super::overspeed::{ROUNDING, Region, merged, parts, regions};
use super::scurve::{Bounds, Jerks, Profile, SCurve, reachable};
use crate::error::PlanError;
use crate::query::Limits;
use serde::{Deserialize, Serialize};

/// Smallest distance of nodes, m.
const SPACING: f64 = 0.01;
/// Most passes per cell of the ceiling; far more than the proof of termination needs in practice.
const PASSES: usize = 16;

/// The seven-phase profile over a whole length (m), rest to rest, that knows nothing of curvature.
/// # Errors
/// [`PlanError::BadParameter`] for a length or limits that are not positive.
pub fn first_pass(length: f64, limits: &Limits) -> Result<Profile, PlanError> {
    SCurve { distance: length, start: (0.0, 0.0), end: (0.0, 0.0), bounds: (&limits.validated()?).into() }.plan()
}

impl From<&Limits> for Bounds {
    fn from(limits: &Limits) -> Self {
        Self { speed: limits.speed, acceleration: limits.acceleration, deceleration: limits.deceleration, jerk: Jerks::all(limits.jerk) }
    }
}

/// One pass of the correction.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Pass {
    /// Overspeed regions that it found.
    pub regions: u32,
    /// Largest speed over ceiling in them (1: none).
    pub worst: f64,
    /// Nodes that it had.
    pub nodes: u32,
    /// Time of its profile, s.
    pub duration: f64,
}

/// A corrected profile and how it came about.
#[derive(Debug, Clone, PartialEq)]
pub struct Corrected {
    /// The first pass: one S-curve over the whole length.
    pub first: [(f64, Profile); 1],
    /// S-curves, each with its start (m).
    pub chain: Vec<(f64, Profile)>,
    /// Nodes of zero acceleration: arc length (m), speed (m/s). Both ends are nodes.
    pub nodes: Vec<(f64, f64)>,
    /// Plans of the whole profile that were judged.
    pub passes: u32,
    /// Regions of the first pass, the plan without nodes.
    pub before: Vec<Region>,
    /// Regions of the result; none.
    pub after: Vec<Region>,
    /// Every pass with nodes.
    pub log: Vec<Pass>,
}

impl Corrected {
    /// s.
    pub fn duration(&self) -> f64 {
        self.chain.iter().map(|(_, p)| p.duration()).sum()
    }
}

/// The profile from `(0, ends.0)` to `(length, ends.1)` (m, m/s), without acceleration at both ends, corrected by nodes until it keeps the ceiling.
/// # Errors
/// [`PlanError::Infeasible`] if the end speeds do not fit the ceiling or the length, [`PlanError::BadParameter`] for bad bounds.
pub fn correct(ceiling: &Ceiling, bounds: &Bounds, ends: (f64, f64)) -> Result<Corrected, PlanError> {
    let length = ceiling.length();
    let whole = SCurve { distance: length, start: (ends.0, 0.0), end: (ends.1, 0.0), bounds: *bounds }.plan()?;
    let first = [(0.0, whole)];
    let before = regions(&first, ceiling);
    if before.is_empty() {
        return Ok(Corrected {
            first,
            chain: first.to_vec(),
            nodes: vec![(0.0, ends.0), (length, ends.1)],
            passes: 1,
            before,
            after: Vec::new(),
            log: Vec::new(),
        });
    }
    let mut loops = Loop { ceiling, bounds, nodes: Vec::new(), segments: Vec::new() };
    loops.start(ends);
    let mut log = Vec::new();
    for _ in 0..PASSES * ceiling.cells().len() + 100 {
        loops.lower(ends)?;
        loops.plan().ok_or_else(|| unkept(ends))?;
        let found = merged(&loops.segments.iter().flat_map(|s| &s.above).copied().collect::<Vec<_>>(), ceiling, ROUNDING);
        let worst = found.iter().map(|r| r.ratio).fold(1.0, f64::max);
        let duration = loops.segments.iter().map(|s| s.profile.duration()).sum();
        log.push(Pass { regions: found.len() as u32, worst, nodes: loops.nodes.len() as u32, duration });
        if found.is_empty() {
            let chain = loops.segments.iter().map(|s| (s.ends[0].s, s.profile)).collect();
            let nodes = loops.nodes.iter().map(|n| (n.s, n.v)).collect();
            return Ok(Corrected { first, chain, nodes, passes: 1 + log.len() as u32, before, after: found, log });
        }
        for region in &found {
            loops.repair(region);
        }
    }
    Err(unkept(ends))
}

fn unkept((start, end): (f64, f64)) -> PlanError {
    let reason = format!("start speed {start} m/s or end speed {end} m/s cannot be kept under the speed ceiling of the path");
    PlanError::Infeasible { reason, best_end_speed: None }
}

/// A place of zero acceleration and the speed limit from there to the next.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Node {
    s: f64,
    v: f64,
    cap: f64,
}

/// The plan between two nodes and what of it lies above the ceiling.
struct Segment {
    ends: [Node; 2],
    profile: Profile,
    above: Vec<Region>,
}

struct Loop<'a> {
    ceiling: &'a Ceiling,
    bounds: &'a Bounds,
    nodes: Vec<Node>,
    segments: Vec<Segment>,
}

impl Loop<'_> {
    /// The ends, and a node at either end of every ground of the ceiling below the speed limit.
    fn start(&mut self, (first, last): (f64, f64)) {
        let (cells, h, length) = (self.ceiling.cells(), self.ceiling.step(), self.ceiling.length());
        let mut nodes = vec![Node { s: 0.0, v: first, cap: 0.0 }];
        let mut i = 0;
        while i < cells.len() {
            let j = i + cells[i..].iter().take_while(|c| **c == cells[i]).count();
            let c = cells[i];
            let ground = (i == 0 || cells[i - 1] > c) && (j == cells.len() || cells[j] > c);
            if ground && c < self.bounds.speed {
                let (middle, half) = (0.5 * h * (i + j) as f64, (0.5 * h * (j - i) as f64).max(0.5 * SPACING));
                for s in [middle - half, middle + half] {
                    let room = s - nodes[nodes.len() - 1].s >= SPACING * (1.0 - 1e-9) && length - s >= SPACING;
                    if room {
                        nodes.push(Node { s, v: c, cap: 0.0 });
                    }
                }
            }
            i = j;
        }
        nodes.push(Node { s: length, v: last, cap: 0.0 });
        self.nodes = nodes;
        for i in 0..self.nodes.len() - 1 {
            self.nodes[i].cap = self.highest(i);
        }
    }

    /// Highest ceiling between a node and the next, m/s.
    fn highest(&self, i: usize) -> f64 {
        self.ceiling.highest(self.nodes[i].s, self.nodes[i + 1].s).min(self.bounds.speed)
    }

    /// Lowers node speeds, backward and forward, until a plan between neighbours exists.
    fn lower(&mut self, ends: (f64, f64)) -> Result<(), PlanError> {
        let last = self.nodes.len() - 1;
        let nodes = &mut self.nodes;
        for i in (0..last).rev() {
            nodes[i].v = reachable(nodes[i + 1].v, nodes[i].v, nodes[i + 1].s - nodes[i].s, self.bounds, false);
        }
        for i in 0..last {
            nodes[i + 1].v = reachable(nodes[i].v, nodes[i + 1].v, nodes[i + 1].s - nodes[i].s, self.bounds, true);
        }
        if self.nodes[0].v < ends.0 || self.nodes[last].v < ends.1 { Err(unkept(ends)) } else { Ok(()) }
    }

    /// The seven-phase plans between neighbours; those that are as before are kept. `None` if there is none somewhere.
    fn plan(&mut self) -> Option<()> {
        let mut old = std::mem::take(&mut self.segments).into_iter().peekable();
        for w in self.nodes.windows(2) {
            while old.next_if(|s| s.ends[0].s < w[0].s).is_some() {}
            let kept = old.next_if(|s| s.ends[0] == w[0] && (s.ends[1].s, s.ends[1].v) == (w[1].s, w[1].v));
            let segment = match kept {
                Some(segment) => segment,
                None => self.segment([w[0], w[1]])?,
            };
            self.segments.push(segment);
        }
        Some(())
    }

    fn segment(&self, ends: [Node; 2]) -> Option<Segment> {
        let [a, b] = ends;
        let bounds = Bounds { speed: a.cap.max(a.v).max(b.v), ..*self.bounds };
        let profile = SCurve { distance: b.s - a.s, start: (a.v, 0.0), end: (b.v, 0.0), bounds }.between_troughs()?;
        Some(Segment { ends, profile, above: parts(&[(a.s, profile)], self.ceiling) })
    }

    /// One step against a region: a node at its worst point, or near it; or lower speeds where nodes are dense.
    fn repair(&mut self, region: &Region) {
        let (s, last) = (region.worst, self.nodes.len() - 1);
        let i = self.nodes.partition_point(|n| n.s < s).clamp(1, last) - 1;
        let (a, b) = (self.nodes[i], self.nodes[i + 1]);
        // On a boundary of cells the lower one is meant.
        let tiny = 1e-6 * self.ceiling.step();
        let c = self.ceiling.lowest((s - tiny).max(0.0), s + tiny);
        let gap = SPACING.max(self.reaction(c));
        if s - a.s >= gap && b.s - s >= gap {
            self.insert(i, s, c);
        } else if b.s - a.s >= 2.0 * gap {
            // Too near to one of them: level with it at some distance.
            let (place, node) = if s - a.s < gap { (a.s + gap, a.s) } else { (b.s - gap, b.s) };
            self.insert(i, place, self.ceiling.lowest(place.min(node), place.max(node)));
        } else if region.ratio * c > a.v.max(b.v) * (1.0 + 1e-9) {
            self.nodes[i].cap = self.nodes[i].cap.min(c.max(a.v).max(b.v));
        } else {
            let faster = if a.v >= b.v { i } else { i + 1 };
            self.nodes[faster].v = self.nodes[faster].v.min(c);
        }
    }

    fn insert(&mut self, i: usize, s: f64, v: f64) {
        let cap = self.nodes[i].cap;
        self.nodes.insert(i + 1, Node { s, v, cap });
        for k in [i, i + 1] {
            self.nodes[k].cap = cap.min(self.highest(k));
        }
    }

    /// Distance that matters when the acceleration changes its sign at speed `v`, m.
    fn reaction(&self, v: f64) -> f64 {
        let j = &self.bounds.jerk;
        let jerk = j.build.min(j.release).min(j.brake).min(j.unbrake);
        0.25 * v * (self.bounds.acceleration.min(self.bounds.deceleration) / jerk).min((v / jerk).sqrt())
    }
}
