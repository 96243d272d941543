//! The search for the largest bends that can be proved free.

use super::belt::{Form, Guide, Mode, Pulley, heading, tangent};
use super::chords::prove;
use super::smooth::{Smooth, room};
use super::spline::spline;
use crate::Point;
use crate::error::PlanError;
use crate::path::Path;
use crate::query::Query;
use crate::world::shape::distance;

/// Factor by which a bend shrinks when its proof fails.
const SHRINK: f64 = 0.6;
/// Factors by which bends try to grow, coarse to fine.
const GROWTH: [f64; 3] = [2.0, 1.3, 1.1];
/// Rounds of shrinking; the smallest bends are corners long before.
const ROUNDS: usize = 80;
/// Gain in radius that makes one bend out of two.
const GAIN: f64 = 1.3;

/// A chain of pulleys in its world.
pub(super) struct Fit<'a> {
    smooth: Smooth,
    query: &'a Query,
    chain: Vec<Pulley>,
    /// m.
    radius: f64,
    /// m.
    smallest: f64,
}

/// Why a chain has no proved spline: the pulleys to blame.
type Blame = Vec<usize>;

impl<'a> Fit<'a> {
    pub fn new(smooth: Smooth, query: &'a Query, mut chain: Vec<Pulley>) -> Self {
        let smallest = smooth.smallest * query.world.resolution();
        for pulley in &mut chain {
            if pulley.radius < smallest {
                pulley.radius = 0.0;
            }
        }
        Self { smooth, query, chain, radius: query.radius(), smallest }
    }

    /// Shrinks bends until the whole spline is proved. Also returns the raw legs that are not free as the planner gave them.
    pub fn settle(&mut self) -> Result<(Path, Vec<[Point; 2]>), PlanError> {
        for _ in 0..ROUNDS {
            self.refresh();
            let blame = match self.whole()? {
                Ok(result) => return Ok(result),
                Err(blame) => blame,
            };
            let mut shrunk = false;
            for &i in &blame {
                shrunk |= self.shrink(i);
            }
            self.split();
            if !shrunk {
                break;
            }
        }
        for i in 0..self.chain.len() {
            (self.chain[i].radius, self.chain[i].cap) = (0.0, 0.0);
        }
        self.split();
        self.whole()?.map_err(|_| PlanError::CertificateFailed { stage: "smoothing", detail: "the raw path cannot be represented".into() })
    }

    fn shrink(&mut self, i: usize) -> bool {
        let smallest = self.smallest;
        let Some(pulley) = self.chain.get_mut(i).filter(|p| p.radius > 0.0) else { return false };
        pulley.radius *= SHRINK;
        if pulley.radius < smallest {
            pulley.radius = 0.0;
        }
        if pulley.mode == Mode::Through {
            pulley.cap = pulley.radius;
        }
        true
    }

    /// A merged bend that shrank to nothing becomes its corners again.
    fn split(&mut self) {
        if self.chain.iter().all(|p| p.radius > 0.0 || p.contacts.len() == 1) {
            return;
        }
        let chain = std::mem::take(&mut self.chain);
        for pulley in chain {
            if pulley.radius > 0.0 || pulley.contacts.len() == 1 {
                self.chain.push(pulley);
            } else {
                self.chain.extend(pulley.contacts.iter().map(|p| Pulley::point(*p, Mode::Outside)));
            }
        }
    }

    /// Turns the bends at via points to face their neighbours.
    fn refresh(&mut self) {
        for i in 1..self.chain.len().saturating_sub(1) {
            if self.chain[i].mode != Mode::Through {
                continue;
            }
            let mut pulley = Pulley::point(self.chain[i].at(), Mode::Through);
            pulley.cap = self.chain[i].cap;
            if let (Some(a), Some(b)) = (tangent(&self.chain[i - 1], &pulley), tangent(&pulley, &self.chain[i + 1])) {
                pulley.face(a.heading, b.heading);
                let ends = [i == 1, i + 2 == self.chain.len()];
                let cap = self.smooth.cap(pulley.turn, [room(distance(a.from, a.to), ends[0]), room(distance(b.from, b.to), ends[1])], true);
                let radius = cap.min(pulley.cap);
                pulley.radius = if pulley.turn.abs() < 1e-7 || radius < self.smallest { 0.0 } else { radius };
            }
            self.chain[i] = pulley;
        }
    }

    /// The spline of the whole chain, proved, with the raw legs that are taken as given; or the pulleys to blame.
    #[expect(clippy::type_complexity, reason = "outer errors are bugs, inner ones steer the search")]
    fn whole(&self) -> Result<Result<(Path, Vec<[Point; 2]>), Blame>, PlanError> {
        let guide = match Guide::around(&self.chain, [false, false]) {
            Ok(guide) => guide,
            Err(i) => return Ok(Err(vec![i.saturating_sub(1), i, i + 1])),
        };
        let path = spline(&guide)?;
        let (mut blame, mut given) = (Vec::new(), Vec::new());
        for piece in path.beziers() {
            let Err(u) = prove(&piece, &self.query.world, self.radius) else { continue };
            let part = guide.parts.partition_point(|part| part.start <= u).max(1) - 1;
            let i = guide.parts[part].pulley;
            match guide.parts[part].form {
                Form::Arc { .. } => blame.push(i),
                Form::Line { .. } if self.chain[i].radius == 0.0 && self.chain[i + 1].radius == 0.0 => {
                    given.push([self.chain[i].at(), self.chain[i + 1].at()]);
                }
                Form::Line { .. } => blame.extend([i, i + 1]),
            }
        }
        blame.sort_unstable();
        blame.dedup();
        given.dedup();
        Ok(if blame.is_empty() { Ok((path, given)) } else { Err(blame) })
    }

    /// Is the belt proved around pulley `i` and its two neighbours on either side?
    fn near(&self, i: usize) -> bool {
        let (low, high) = (i.saturating_sub(2), (i + 2).min(self.chain.len() - 1));
        let open = [low > 0, high + 1 < self.chain.len()];
        let Ok(guide) = Guide::around(&self.chain[low..=high], open) else { return false };
        let Ok(path) = spline(&guide) else { return false };
        path.beziers().iter().all(|piece| prove(piece, &self.query.world, self.radius).is_ok())
    }

    /// Lets every bend grow as far as it can be proved.
    pub fn grow(&mut self) {
        for i in 1..self.chain.len().saturating_sub(1) {
            if self.chain[i].mode == Mode::Through {
                continue;
            }
            self.enlarge(i);
            if self.chain[i].mode == Mode::Inside && self.chain[i].radius < 0.5 * self.chain[i].cap {
                self.turn_out(i);
            }
        }
    }

    fn enlarge(&mut self, i: usize) {
        let cap = self.chain[i].cap;
        if cap >= self.smallest && self.chain[i].radius == 0.0 {
            let smallest = self.smallest;
            let first = (1..10).map(|k| cap * 0.5f64.powi(k)).take_while(|r| *r >= smallest).find(|r| self.try_radius(i, *r));
            if first.is_none() {
                return;
            }
        }
        for factor in GROWTH {
            while self.chain[i].radius > 0.0 && self.chain[i].radius < cap && self.try_radius(i, (self.chain[i].radius * factor).min(cap)) {}
        }
    }

    fn try_radius(&mut self, i: usize, radius: f64) -> bool {
        let kept = std::mem::replace(&mut self.chain[i].radius, radius);
        let good = self.near(i);
        if !good {
            self.chain[i].radius = kept;
        }
        good
    }

    /// Goes around the outside of a corner that could only be cut tightly, if that gives a wider bend.
    fn turn_out(&mut self, i: usize) {
        let kept = self.chain[i].radius;
        self.chain[i].mode = Mode::Outside;
        let mut radius = self.chain[i].cap;
        while radius > (1.5 * kept).max(self.smallest) {
            if self.try_radius(i, radius) {
                return;
            }
            radius *= 0.7;
        }
        self.chain[i].mode = Mode::Inside;
        self.chain[i].radius = kept;
    }

    /// Makes one bend of neighbours that turn the same way, where that is wider.
    pub fn merge(&mut self) {
        let mut i = 1;
        while i + 2 < self.chain.len() {
            let [a, b] = [&self.chain[i], &self.chain[i + 1]];
            let alike = a.mode == Mode::Outside && b.mode == Mode::Outside && a.sign() == b.sign();
            let merged = if alike { self.union(i) } else { None };
            let Some(merged) = merged else {
                i += 1;
                continue;
            };
            let least = a.radius.min(b.radius);
            let pair: Vec<Pulley> = self.chain.splice(i..=i + 1, [merged]).collect();
            let mut radius = self.chain[i].cap;
            while radius > GAIN * least.max(self.smallest) && !self.try_radius(i, radius) {
                radius *= 0.8;
            }
            if self.chain[i].radius == 0.0 {
                self.chain.splice(i..=i, pair);
                i += 1;
            } // else the merged one may take in the next
        }
    }

    /// One pulley, not yet with a radius, for the way points of pulleys `i` and `i + 1`; `None` if they turn too far.
    fn union(&self, i: usize) -> Option<Pulley> {
        let (a, b) = (&self.chain[i], &self.chain[i + 1]);
        let turn = a.turn + b.turn;
        if turn.abs() > 0.9 * super::belt::SHARPEST {
            return None;
        }
        let (before, after) = (*self.chain[i - 1].contacts.last()?, *self.chain[i + 2].contacts.first()?);
        let mut merged = Pulley::point(a.at(), Mode::Outside);
        merged.contacts = a.contacts.iter().chain(&b.contacts).copied().collect();
        let (first, last) = (*merged.contacts.first()?, *merged.contacts.last()?);
        let heading_in = heading(before, first);
        merged.face(heading_in, heading_in + turn);
        let ends = [i == 1, i + 3 == self.chain.len()];
        merged.cap = self.smooth.cap(turn, [room(distance(before, first), ends[0]), room(distance(last, after), ends[1])], false);
        Some(merged)
    }
}
