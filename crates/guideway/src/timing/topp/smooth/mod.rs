//! The jerk-limited motion from the second-order optimum.
//!
//! Between two stops the second-order optimum, averaged over time, is a reference whose time is the variable; the squared speed `y` of that time is found by
//! a barrier method ([`barrier`]) with the limits of speed, acceleration and jerk at the ends of the cells on which the jerk is constant. The result is
//! turned into pieces of constant path jerk ([`pieces`]); these are checked densely, the limits tightened where they exceed, and what is left is removed by
//! slowing the stretch down as a whole, which divides the jerk by the cube of the factor.

mod barrier;
mod lines;
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
    /// [`PlanError::BadParameter`] for windows on the way, [`PlanError::Infeasible`] for an end that cannot be reached in time.
    pub fn wait(&mut self, windows: &[Window], length: f64) -> Result<(), PlanError> {
        for window in windows {
            if window.s < length {
                return Err(PlanError::bad("windows", window.s, format!("{length} rad, the end of the path, where the limits of jerk are kept")));
            }
            let time = self.pieces.last().map_or(0.0, |p| p.start() + p.duration());
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
}

impl Task<'_, '_, '_> {
    /// The jerk-limited motion along the whole path.
    pub fn solve(&mut self, solved: &Solved, spans: &[Span]) -> Result<Smooth, PlanError> {
        let total: f64 = solved.legs.iter().map(|leg| leg.duration).sum();
        let mut smooth =
            Smooth { pieces: Vec::new(), used: Vec::new(), prices: vec![0.0; self.bounds.jerk.len()], steps: 0, tightenings: 0, slowed: 1.0 };
        let all = self.cells.unwrap_or(CELLS) as f64;
        smooth.prices.resize(self.bounds.jerk.len() + self.rates.as_ref().map_or(0, Table::count), 0.0);
        for stretch in turns::stretches(self.course, solved, total / all) {
            let cells = ((all * stretch.duration() / total).round() as usize).max(FEWEST);
            self.stretch(&stretch, (spans, cells), &mut smooth)?;
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

    /// One stretch from rest to rest, added to `smooth`.
    fn stretch(&mut self, stretch: &Stretch, (spans, cells): (&[Span], usize), smooth: &mut Smooth) -> Result<(), PlanError> {
        let ends = stretch.ends;
        let mut walker = Walker::new(self.course, spans, ends);
        let coarse = cells.min(COARSE);
        let mut posed = self.first(stretch, coarse, &mut walker)?;
        let mut tight = vec![[1.0; 5]; posed.step.len()];
        let mut best: Option<Told> = None;
        let called = self.demands.rows.is_some() || self.rates.is_some();
        let mut prices = smooth.prices.clone();
        for round in 0..if self.rates.is_some() { RATE_ROUNDS } else { ROUNDS } {
            let asked = Called { demands: &mut *self.demands, rates: self.rates.as_mut() };
            posed.limits(self.bounds, &tight, asked, round > 0 && !called)?;
            let per_cell = posed.step.iter().sum::<f64>() / posed.step.len() as f64;
            let [first, most] = if round == 0 { [FIRST, 0.95] } else { AGAIN };
            let Some(mut y) = posed.start(most) else { break };
            smooth.steps += Barrier { step: &posed.step, lines: &posed.lines, top: &posed.top }.minimise(&mut y, first * per_cell, LAST * per_cell);
            let Some(pieces) = pieces::through(&posed.states(&y)) else { break };
            let told = self.told(pieces, self.check.min(FEW), &mut walker)?;
            smooth.tightenings += 1;
            prices.copy_from_slice(&smooth.prices);
            posed.sensitivities(&y, LAST * per_cell, &mut prices);
            let good = told.slower <= 1.0 + if round < FEW_ROUNDS || called { GOOD } else { FAIR };
            let parts = if round == 0 { cells.div_ceil(coarse) } else { 1 };
            let (lengths, cells) = told.cells(parts);
            if round > 0 {
                for (tight, used) in tight.iter_mut().zip(&told.used) {
                    for (tight, share) in tight.iter_mut().zip(used.share) {
                        *tight = (*tight * if share > 1.0 { share * (1.0 + EXTRA) } else { 1.0 }).min(MOST);
                    }
                }
            } else {
                tight = vec![[1.0; 5]; lengths.len()];
            }
            if best.as_ref().is_none_or(|b| told.time * told.slower < b.time * b.slower) {
                best = Some(told);
            }
            if good {
                break;
            }
            posed = Posed::new(lengths, cells, &mut walker);
        }
        let Some(told) = best else {
            let reason = format!("no jerk-limited motion was found between s = {:.6} and {:.6} rad", ends[0], ends[1]);
            return Err(PlanError::Infeasible { reason, best_end_speed: None });
        };
        smooth.prices = prices;
        let told = self.kept(told.pieces, &mut walker, smooth)?;
        let t0 = smooth.pieces.last().map_or(0.0, |p| p.start() + p.duration());
        smooth.pieces.extend(told.pieces.into_iter().map(|piece| piece.shifted(t0)));
        smooth.used.extend(told.used);
        Ok(())
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
        let reference = Reference::new(stretch.legs, [ramp, 0.5 * even * stretch.finest()]);
        let even = reference.duration() / cells as f64;
        let mut times = vec![0.0];
        for k in 0..cells {
            stretch.cut(&reference, [even * k as f64, even * (k + 1) as f64], 0, &mut times);
        }
        let junctions: Vec<Kinetic> = times.iter().map(|t| reference.at(*t)).map(|[s, v, a, j]| [(ends[0] + s).min(ends[1]), v, a, j]).collect();
        let mut cells: Vec<[Kinetic; 2]> = junctions.windows(2).map(|w| [w[0], w[1]]).collect();
        let last = cells.len() - 1;
        cells[0][0][3] = cells[0][1][3];
        cells[last][1][3] = cells[last][0][3];
        cells[last][1][0] = ends[1];
        Ok(Posed::new(times.windows(2).map(|w| w[1] - w[0]).collect(), cells, walker))
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
