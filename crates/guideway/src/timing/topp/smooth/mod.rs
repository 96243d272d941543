//! The jerk-limited motion from the second-order optimum.
//!
//! Between two stops the second-order optimum, averaged over time, is a reference whose time is the variable; the squared speed `y` of that time is found by
//! a barrier method ([`barrier`]) with the limits of speed, acceleration and jerk at the ends of the cells on which the jerk is constant. The result is
//! turned into pieces of constant path jerk ([`pieces`]); these are checked densely, the limits tightened where they exceed, and what is left is removed by
//! slowing the stretch down as a whole, which divides the jerk by the cube of the factor, but where it begins or ends in motion ([`passing`]).

mod barrier;
mod lines;
mod passing;
mod pieces;
mod rates;
mod reference;
mod rows;
mod turns;
mod used;

use super::course::{Course, Span};
use super::limits::Bounds;
use super::problem::Demands;
use super::solve::Solved;
use super::table::Table;
use super::windows::Window;
use crate::error::PlanError;
use crate::timing::Piece;
use crate::timing::scurve::advance;
use barrier::Barrier;
use pieces::Walker;
use rates::RATE;
use reference::Reference;
use rows::{Called, Kinetic, Posed};
use turns::Stretch;
pub(super) use used::{CEILING, Used};

/// Cells if no number is asked for, and fewest per stretch.
const CELLS: usize = 500;
const FEWEST: usize = 40;
/// Weights of the barrier, per node: first, and last as the share of the duration that it may give away.
const FIRST: f64 = 0.05;
const LAST: f64 = 3e-4;
/// First weight once the reference is a solution itself.
const AGAIN: [f64; 2] = [1e-3, 0.99];
/// Cells of the first round.
const COARSE: usize = 250;
/// Rounds, each in the time of the solution before; they end when the slow-down that is left is below `GOOD`, after some below `FAIR` if no rows are called
/// for.
const ROUNDS: usize = 7;
/// Rounds with limits of rates: the reference may be far from their motion.
const RATE_ROUNDS: usize = 12;
const FEW_ROUNDS: usize = 3;
const GOOD: f64 = 1e-3;
const FAIR: f64 = 5e-3;
/// Most by which the limits of a cell are tightened: from rest into a turn far shorter than the cell the jerk is exceeded about ten times.
const MOST: f64 = 100.0;
/// Times that the motion is slowed down at last.
const SLOWINGS: usize = 6;
/// Places per piece of the checks before the last one.
const FEW: usize = 3;
/// Room kept within the limits when the motion is slowed down, and when they are tightened.
const ROOM: f64 = 1e-9;
const EXTRA: f64 = 1e-3;

/// A jerk-limited motion.
pub(super) struct Smooth {
    pub pieces: Vec<Piece>,
    /// Use of speed, acceleration, jerk, demands and rates of every pair of pieces.
    pub used: Vec<Used>,
    /// Sensitivity of the duration to each limit of jerk, then to each of rates, s per relative change.
    pub prices: Vec<f64>,
    /// Newton steps, rounds of tightening, factor of the slow-down at the end.
    pub steps: usize,
    pub tightenings: usize,
    pub slowed: f64,
}

impl Smooth {
    /// Slows the motion down as a whole until the windows at its end are met.
    /// # Errors
    /// [`PlanError::BadParameter`] for windows on the way and for waiting in motion, [`PlanError::Infeasible`] for an end that cannot be reached in time.
    pub fn wait(&mut self, windows: &[Window], length: f64, speeds: [f64; 2]) -> Result<(), PlanError> {
        for window in windows {
            if window.s < length {
                return Err(PlanError::bad("windows", window.s, format!("{length} rad, the end of the path, where the limits of jerk are kept")));
            }
            let time = self.pieces.last().map_or(0.0, |p| p.start() + p.duration());
            if time < window.earliest && speeds != [0.0; 2] {
                let allowed =
                    format!("at most {time} s, the fastest motion: where the limits of jerk are kept, only one from rest to rest can be slowed down");
                return Err(PlanError::bad("windows", window.earliest, allowed));
            }
            if time < window.earliest {
                self.slow(window.earliest / time);
            }
            window.met(time.max(window.earliest))?;
        }
        Ok(())
    }

    /// The whole in slower time.
    fn slow(&mut self, factor: f64) {
        pieces::slowed(&mut self.pieces, factor);
        for u in &mut self.used {
            *u = u.slowed(factor);
        }
    }
}

/// What the problem of a stretch is made of.
pub(super) struct Task<'a, 'd, 't> {
    pub course: &'a Course,
    pub bounds: &'a Bounds,
    pub demands: &'a mut Demands<'d>,
    /// Rows whose rates by time are limited.
    pub rates: Option<Table<'t>>,
    /// Where rows may jump: the breaks of the path, arc lengths.
    pub breaks: Vec<f64>,
    /// Cells, all stretches together.
    pub cells: Option<usize>,
    pub check: usize,
    /// Path speeds at the start and the end of the path.
    pub speeds: [f64; 2],
}

impl Task<'_, '_, '_> {
    /// The jerk-limited motion along the whole path.
    pub fn solve(&mut self, solved: &Solved, spans: &[Span]) -> Result<Smooth, PlanError> {
        let total: f64 = solved.legs.iter().map(|leg| leg.duration).sum();
        let mut smooth =
            Smooth { pieces: Vec::new(), used: Vec::new(), prices: vec![0.0; self.bounds.jerk.len()], steps: 0, tightenings: 0, slowed: 1.0 };
        let all = self.cells.unwrap_or(CELLS) as f64;
        smooth.prices.resize(self.bounds.jerk.len() + self.rates.as_ref().map_or(0, Table::count), 0.0);
        for stretch in turns::stretches(self.course, solved, self.speeds, total / all) {
            let cells = ((all * stretch.duration() / total).round() as usize).max(FEWEST);
            let mut walker = Walker::new(self.course, spans, stretch.ends);
            let told = if stretch.speeds == [0.0; 2] {
                self.stretch(&stretch, cells, &mut walker, &mut smooth)?
            } else {
                self.passed(&stretch, cells, &mut walker, &mut smooth)?
            };
            let t0 = smooth.pieces.last().map_or(0.0, |p| p.start() + p.duration());
            smooth.pieces.extend(told.pieces.into_iter().map(|piece| piece.shifted(t0)));
            smooth.used.extend(told.used);
        }
        Ok(smooth)
    }

    /// Slows the whole down until the rates are kept: where gravity and inertia change the torque in opposite ways, a slower motion may need more.
    /// # Errors
    /// [`PlanError::CertificateFailed`] if they are not kept even so.
    pub fn again(&mut self, smooth: &mut Smooth) -> Result<(), PlanError> {
        let Some(table) = &mut self.rates else { return Ok(()) };
        for _ in 0..SLOWINGS {
            for used in &mut smooth.used {
                (used.share[RATE], used.slower) = (0.0, 1.0);
            }
            rates::used(table, &smooth.pieces, self.check.div_ceil(2), &self.breaks, &mut smooth.used)?;
            let slower = smooth.used.iter().map(|used| used.slower).fold(1.0, f64::max);
            if slower <= 1.0 {
                return Ok(());
            }
            smooth.slow(slower * (1.0 + ROOM));
        }
        let detail = "the limits of the rates of rows are exceeded by the motion slowed down for its windows".to_owned();
        Err(PlanError::CertificateFailed { stage: "timing of the joints", detail })
    }

    /// One stretch from rest to rest.
    fn stretch(&mut self, stretch: &Stretch, cells: usize, walker: &mut Walker, smooth: &mut Smooth) -> Result<Told, PlanError> {
        let mut rounds = self.rounds(stretch, cells, walker)?;
        let mut best: Option<Told> = None;
        let mut prices = smooth.prices.clone();
        // Where gravity and inertia cancel, a slower motion may need more of a rate: its rounds go on until nothing is left to slow down.
        let rated = self.rates.is_some();
        let places = if rated { self.check.div_ceil(2) } else { self.check.min(FEW) };
        for round in 0..if rated { RATE_ROUNDS } else { ROUNDS } {
            let Some((y, told)) = self.attempt(&mut rounds, places, walker, smooth)? else { break };
            prices.copy_from_slice(&smooth.prices);
            rounds.posed.sensitivities(&y, LAST * rounds.per_cell(), &mut prices);
            let left = if round < FEW_ROUNDS || self.calls() { GOOD } else { FAIR };
            let good = told.slower <= 1.0 + if rated { 0.0 } else { left };
            let next = rounds.next(&told, true);
            if best.as_ref().is_none_or(|b| told.time * told.slower < b.time * b.slower) {
                best = Some(told);
            }
            if good {
                break;
            }
            rounds.posed = Posed::new(next, [0.0; 2], walker);
        }
        let Some(told) = best else {
            let [from, to] = stretch.ends;
            let reason = format!("no jerk-limited motion was found between s = {from:.6} and {to:.6} rad");
            return Err(PlanError::Infeasible { reason, best_end_speed: None });
        };
        smooth.prices = prices;
        self.kept(told.pieces, walker, smooth)
    }

    /// Whether rows or their rates are called for.
    fn calls(&self) -> bool {
        self.demands.rows.is_some() || self.rates.is_some()
    }

    /// The first round of a stretch.
    fn rounds(&mut self, stretch: &Stretch, cells: usize, walker: &mut Walker) -> Result<Rounds, PlanError> {
        let coarse = cells.min(COARSE);
        let posed = self.first(stretch, coarse, walker)?;
        Ok(Rounds { tight: vec![[1.0; 5]; posed.count()], posed, done: 0, parts: cells.div_ceil(coarse) })
    }

    /// The solution of a round and its pieces, checked at `places` of each; none if there is no motion within its limits.
    fn attempt(
        &mut self,
        rounds: &mut Rounds,
        places: usize,
        walker: &mut Walker,
        smooth: &mut Smooth,
    ) -> Result<Option<(Vec<f64>, Told)>, PlanError> {
        let first = rounds.done == 0;
        let prune = !first && !self.calls();
        let per_cell = rounds.per_cell();
        let posed = &mut rounds.posed;
        let asked = Called { demands: &mut *self.demands, rates: self.rates.as_mut() };
        posed.limits(self.bounds, &rounds.tight, asked, prune)?;
        let [weight, most] = if first { [FIRST, 0.95] } else { AGAIN };
        let weight = weight * posed.worth();
        let Some(mut y) = posed.start(most) else { return Ok(None) };
        let pull = posed.pull();
        let barrier = Barrier { step: &posed.step, lines: &posed.lines, top: &posed.top, pull: &pull };
        smooth.steps += barrier.minimise(&mut y, weight * per_cell, LAST * per_cell);
        let Some(pieces) = pieces::through(&posed.states(&y)) else { return Ok(None) };
        let told = self.told(pieces, places, walker)?;
        smooth.tightenings += 1;
        Ok(Some((y, told)))
    }

    /// Pieces slowed down until the dense check finds all limits kept.
    fn kept(&mut self, pieces: Vec<Piece>, walker: &mut Walker, smooth: &mut Smooth) -> Result<Told, PlanError> {
        let count = self.check.div_ceil(2);
        let mut told = self.told(pieces, count, walker)?;
        let mut slowed = 1.0;
        for _ in 0..SLOWINGS {
            if told.slower <= 1.0 {
                break;
            }
            slowed *= told.slower;
            told = told.slow();
            if self.demands.rows.is_none() && self.rates.is_none() {
                break;
            }
            told = self.told(told.pieces, count, walker)?;
        }
        smooth.slowed = smooth.slowed.max(slowed);
        let excess = told.used.iter().map(|used| used.share[3].max(used.share[RATE]) - 1.0).fold(0.0, f64::max);
        if excess > 1e-6 {
            let detail = format!("a limit other than those of the joints is exceeded by {excess:.1e} of its size by the jerk-limited motion");
            return Err(PlanError::CertificateFailed { stage: "timing of the joints", detail });
        }
        Ok(told)
    }

    /// The problem in the time of the averaged second-order motion, cells of equal length but at sharp turns.
    fn first(&mut self, stretch: &Stretch, cells: usize, walker: &mut Walker) -> Result<Posed, PlanError> {
        let (duration, ends) = (stretch.duration(), stretch.ends);
        let rated = self.rates.as_mut().map_or(Ok(0.0), |table| rates::ramp(table, stretch))?;
        let ramp = self.bounds.acceleration.iter().zip(&self.bounds.jerk).map(|(a, j)| a / j).filter(|w| w.is_finite()).fold(rated, f64::max);
        let ramp = if ramp > 0.0 { ramp.min(0.5 * duration) } else { 0.5 * duration };
        let even = (duration + ramp) / cells as f64;
        // The jerk of the reference grows from nothing in half of the first cell.
        let moving = stretch.speeds.map(|v| v > 0.0);
        let reference = Reference::new(stretch.legs, [ramp, 0.5 * even * stretch.finest()], moving);
        let even = reference.duration() / cells as f64;
        let mut times = vec![0.0];
        for k in 0..cells {
            stretch.cut(&reference, [even * k as f64, even * (k + 1) as f64], 0, &mut times);
        }
        let junctions: Vec<Kinetic> = times.iter().map(|t| reference.at(*t)).map(|[s, v, a, j]| [(ends[0] + s).min(ends[1]), v, a, j]).collect();
        let mut cells: Vec<[Kinetic; 2]> = junctions.windows(2).map(|w| [w[0], w[1]]).collect();
        let last = cells.len() - 1;
        if !moving[0] {
            cells[0][0][3] = cells[0][1][3];
        }
        if !moving[1] {
            cells[last][1][3] = cells[last][0][3];
        }
        cells[last][1][0] = ends[1];
        Ok(Posed::new((times.windows(2).map(|w| w[1] - w[0]).collect(), cells), stretch.speeds, walker))
    }

    /// Pieces and the use of the limits on them, by `places` places per piece.
    fn told(&mut self, pieces: Vec<Piece>, places: usize, walker: &mut Walker) -> Result<Told, PlanError> {
        let mut used = used::joints(walker, &pieces, self.bounds, places);
        used::demands(self.demands, &pieces, places, &self.breaks, &mut used)?;
        if let Some(table) = &mut self.rates {
            rates::used(table, &pieces, places, &self.breaks, &mut used)?;
        }
        let slower = used.iter().map(Used::slower).fold(1.0, f64::max);
        let time = pieces.last().map_or(0.0, |p| p.start() + p.duration());
        Ok(Told { pieces, used, slower, time })
    }
}

/// The rounds of a stretch, each in the time of the motion before.
struct Rounds {
    posed: Posed,
    /// By how much the limits of every cell are tightened.
    tight: Vec<[f64; 5]>,
    done: usize,
    /// Parts that each cell of the first round is cut into after it.
    parts: usize,
}

impl Rounds {
    /// Mean length of a cell, s.
    fn per_cell(&self) -> f64 {
        self.posed.step.iter().sum::<f64>() / self.posed.step.len() as f64
    }

    /// Tightens, if asked, the limits of cells that exceed them; lengths of the cells of the next round, and the motion at their ends.
    fn next(&mut self, told: &Told, tighten: bool) -> (Vec<f64>, Vec<[Kinetic; 2]>) {
        let (lengths, cells) = told.cells(if self.done == 0 { self.parts } else { 1 });
        if self.done == 0 {
            self.tight = vec![[1.0; 5]; lengths.len()];
        } else if tighten {
            for (tight, used) in self.tight.iter_mut().zip(&told.used) {
                for (tight, share) in tight.iter_mut().zip(used.share) {
                    *tight = (*tight * if share > 1.0 { share * (1.0 + EXTRA) } else { 1.0 }).min(MOST);
                }
            }
        }
        self.done += 1;
        (lengths, cells)
    }
}

/// Pieces, two per cell, the use of the limits on every cell, and how much slower they must become to keep them.
struct Told {
    pieces: Vec<Piece>,
    used: Vec<Used>,
    slower: f64,
    time: f64,
}

impl Told {
    /// Lengths of the cells, each cut into `parts`, and the motion at their ends.
    fn cells(&self, parts: usize) -> (Vec<f64>, Vec<[Kinetic; 2]>) {
        let (mut lengths, mut cells) = (Vec::new(), Vec::new());
        for pair in self.pieces.chunks_exact(2) {
            let whole = pair[0].duration() + pair[1].duration();
            for i in 0..parts {
                let at = |i: usize, before: bool| {
                    let t = whole * i as f64 / parts as f64;
                    let first = t < pair[0].duration() || (before && 2 * i == parts);
                    let Piece::Along { s, speed, acceleration, jerk, duration, .. } = pair[usize::from(!first)] else { return [0.0; 4] };
                    let (s, v, a) = advance((s, speed, acceleration), jerk, if first { t } else { t - pair[0].duration() }.min(duration));
                    [s, v, a, jerk]
                };
                cells.push([at(i, false), at(i + 1, true)]);
                lengths.push(whole / parts as f64);
            }
        }
        (lengths, cells)
    }

    /// Slowed down until the limits are kept.
    fn slow(mut self) -> Self {
        let factor = self.slower * (1.0 + ROOM);
        pieces::slowed(&mut self.pieces, factor);
        let used = self.used.into_iter().map(|used| used.slowed(factor)).collect();
        Self { used, slower: 1.0, time: self.time * factor, ..self }
    }
}
