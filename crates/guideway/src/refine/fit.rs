//! The search for the largest bends that can be proved free.

use super::belt::{Form, Guide, Mode, Pulley, tangent};
use super::chords::prove;
use super::smooth::{Smooth, peaks, room};
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
/// Rounds of shrinking; the smallest bends are corners long before. What is still in the way then becomes a corner at once.
const ROUNDS: usize = 80;

/// Factors on the number of knot spans of a bend that has little room beside its arc.
const FINE: [f64; 4] = [1.0, 2.0, 4.0, 8.0];

/// Curvatures that differ by less than this factor count as equal: knots on a leg move a little with the bends at its ends.
const SAME: f64 = 1.01;

/// A bend through a via point goes the other way round only where the path turns back: up to this much of a turn, rad.
const ROUND: f64 = 4.2;

/// Most neighbours on either side that a trial looks at.
const WINDOW: usize = 12;

/// A chain of pulleys in its world.
pub(super) struct Fit<'a> {
    pub(super) smooth: Smooth,
    query: &'a Query,
    pub(super) chain: Vec<Pulley>,
    /// m.
    radius: f64,
    /// m.
    pub(super) smallest: f64,
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
        for round in 0..ROUNDS + self.chain.len() {
            self.refresh();
            let blame = match self.whole()? {
                Ok(result) => return Ok(result),
                Err(blame) => blame,
            };
            let mut shrunk = false;
            for &i in &blame {
                shrunk |= self.shrink(i, if round < ROUNDS { SHRINK } else { 0.0 });
            }
            if !shrunk {
                for &i in &blame {
                    shrunk |= !std::mem::replace(&mut self.chain[i].held, true);
                }
            }
            self.split();
            if !shrunk {
                break;
            }
        }
        for i in 0..self.chain.len() {
            (self.chain[i].radius, self.chain[i].cap, self.chain[i].held) = (0.0, 0.0, true);
        }
        self.split();
        self.whole()?.map_err(|_| PlanError::CertificateFailed { stage: "smoothing", detail: "the raw path cannot be represented".into() })
    }

    fn shrink(&mut self, i: usize, factor: f64) -> bool {
        let smallest = self.smallest;
        let Some(pulley) = self.chain.get_mut(i).filter(|p| p.radius > 0.0) else { return false };
        pulley.radius *= factor;
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
            if self.chain[i].mode == Mode::Through {
                let cap = self.chain[i].cap;
                self.face(i, self.chain[i].round);
                let radius = self.chain[i].radius.min(cap);
                (self.chain[i].cap, self.chain[i].radius) = (cap, if radius < self.smallest { 0.0 } else { radius });
            }
        }
    }

    /// Makes via point `i` face its neighbours, `round` the other way, with the largest sensible radius, which is its cap too.
    fn face(&mut self, i: usize, round: bool) {
        let mut pulley = Pulley::point(self.chain[i].at(), Mode::Through);
        pulley.round = round;
        let leg = |a: &Pulley, b: &Pulley| tangent(a.wheel(a.turn.abs())?, b.wheel(b.turn.abs())?);
        if let (Some(a), Some(b)) = (leg(&self.chain[i - 1], &pulley), leg(&pulley, &self.chain[i + 1])) {
            pulley.face(a.heading, b.heading);
            let ends = [i == 1, i + 2 == self.chain.len()];
            let rooms = [room(distance(a.from, a.to), ends[0]), room(distance(b.from, b.to), ends[1])];
            let cap = self.smooth.generous().cap(pulley.turn, rooms, false);
            pulley.cap = if pulley.turn.abs() < 1e-7 { 0.0 } else { cap };
            pulley.radius = pulley.cap;
        }
        self.chain[i] = pulley;
    }

    /// The widest bend through via point `i` that can be proved; where the path turns back, to either side. None fits: a corner.
    fn bend_through(&mut self, i: usize) {
        let mut best = self.chain[i].clone();
        for round in [false, true] {
            self.face(i, round);
            if round && self.chain[i].turn.abs() > ROUND {
                break;
            }
            let mut radius = self.chain[i].cap;
            while radius > best.radius.max(self.smallest) {
                if self.try_radius(i, radius) {
                    best = self.chain[i].clone();
                    best.cap = radius;
                    break;
                }
                radius *= 0.8;
            }
        }
        self.chain[i] = best;
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
            let [i, next] = guide.parts[part].pulleys;
            let bent = |i: usize| self.chain[i].radius > 0.0;
            match guide.parts[part].form {
                Form::Line { .. } if bent(i) || bent(next) || next > i + 1 => blame.extend(i..=next),
                Form::Line { .. } => given.push([self.chain[i].at(), self.chain[next].at()]),
                Form::Arc { .. } => blame.push(i),
            }
        }
        blame.sort_unstable();
        blame.dedup();
        given.dedup();
        Ok(if blame.is_empty() { Ok((path, given)) } else { Err(blame) })
    }

    /// The stretch of the chain that pulley `i` can move: two neighbours on either side, more where they are near.
    fn stretch(&self, i: usize) -> [usize; 2] {
        let (at, reach) = (self.chain[i].at(), 4.0 * self.chain[i].radius);
        let (mut low, mut high) = (i.saturating_sub(2), (i + 2).min(self.chain.len() - 1));
        while low > 0 && i - low < WINDOW && distance(self.chain[low].at(), at) < reach {
            low -= 1;
        }
        while high + 1 < self.chain.len() && high - i < WINDOW && distance(self.chain[high].at(), at) < reach {
            high += 1;
        }
        [low, high]
    }

    /// Is the belt proved around pulley `i`?
    fn near(&self, i: usize) -> bool {
        self.proved(self.stretch(i))
    }

    /// Is the belt proved from one pulley to another?
    fn proved(&self, window: [usize; 2]) -> bool {
        self.part(window).is_some_and(|path| path.beziers().iter().all(|piece| prove(piece, &self.query.world, self.radius).is_ok()))
    }

    /// The spline from one pulley to another; without those at the ends of the window, unless they are those of the chain.
    fn part(&self, [low, high]: [usize; 2]) -> Option<Path> {
        let open = [low > 0, high + 1 < self.chain.len()];
        Guide::around(&self.chain[low..=high], open).ok().and_then(|guide| spline(&guide).ok())
    }

    /// Largest curvature there that matters, 1/m: at least the limit.
    fn tightest(&self, window: [usize; 2]) -> f64 {
        let limit = self.smooth.max_curvature.unwrap_or(f64::INFINITY);
        self.part(window).map_or(f64::INFINITY, |path| peaks(&path, limit).into_iter().map(|peak| peak.1).fold(limit, f64::max))
    }

    /// Length of the belt between two pulleys, m; not a number if there is none.
    pub(super) fn belt(&self, low: usize, high: usize) -> f64 {
        Guide::around(&self.chain[low..=high], [false, false]).map_or(f64::NAN, |guide| guide.length)
    }

    /// Lets every bend grow as far as it can be proved.
    pub fn grow(&mut self) {
        for i in 1..self.chain.len().saturating_sub(1) {
            if self.chain[i].mode == Mode::Through {
                self.bend_through(i);
                continue;
            }
            self.enlarge(i);
            if self.chain[i].mode == Mode::Inside && self.chain[i].radius < 0.5 * self.chain[i].cap {
                self.turn_out(i);
            }
            self.reach(i);
        }
    }

    /// Keeps the limit on the curvature at a single corner where that can be proved: around the outside or cutting it, whichever has room, with knots as fine
    /// as it takes.
    fn reach(&mut self, i: usize) {
        let kept = self.chain[i].clone();
        if kept.contacts.len() > 1 || self.smooth.wanted(kept.turn, kept.fine).is_none_or(|r| kept.radius >= r) {
            return;
        }
        let window = [i.saturating_sub(2), (i + 2).min(self.chain.len() - 1)];
        let before = self.tightest(window);
        for (fine, mode) in FINE.into_iter().flat_map(|fine| [(fine, kept.mode), (fine, Mode::Inside)]) {
            let Some(radius) = self.smooth.wanted(kept.turn, fine).filter(|r| *r <= kept.cap) else { continue };
            let pulley = &mut self.chain[i];
            (pulley.mode, pulley.fine, pulley.radius) = (mode, fine, radius);
            if (self.near(i) || self.proved(window)) && self.tightest(window) <= SAME * before {
                return;
            }
        }
        self.chain[i] = kept;
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

    pub(super) fn try_radius(&mut self, i: usize, radius: f64) -> bool {
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
}
