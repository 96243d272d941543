//! The closed loop: search, look at the speed, feed back, until nothing is too fast and nothing improves.

use super::Aide;
use super::engine::Engine;
use super::polish::{Candidate, polish};
use super::seats::Seats;
use super::speed::{Speed, Track};
use crate::context::{Context, Stop};
use crate::error::PlanError;
use crate::optimize::{Cost, Minimum, Objective};
use crate::plan::swarm::Curves;
use crate::plan::swarm::spline::Watch;
use crate::timing::Region;
use crate::world::shape::distance;
use serde_json::Value;

/// Half the side of the box around control points near an overspeed region, m.
const NEAR: f64 = 0.3;
/// Factor of the scales' upper bounds where nodes alone do not help, and the least upper bound.
const SHRINK: (f64, f64) = (0.9, 0.35);
/// The objective has settled once a stage improves it by less than that share.
const SETTLED: f64 = 1e-4;
/// Numbers of a candidate up to which a covariance is cheap beside the objective.
const MANY: usize = 60;

/// What one stage did.
pub(super) struct Stage {
    pub value: f64,
    pub found: Vec<Region>,
    pub remaining: Vec<Region>,
    pub nodes: usize,
    pub passes: u32,
    pub fed_back: Vec<String>,
}

/// How the loop ended.
pub(super) struct Outcome {
    pub curves: Curves,
    pub best: Option<Candidate>,
    pub stages: Vec<Stage>,
    pub population: Value,
    pub stop: Stop,
    /// That of the candidate that was looked at last.
    pub track: Option<Track>,
}

/// Runs the loop on the curves of the best class, or on plain ones.
pub(super) fn run(aide: &Aide, seats: &Seats, plain: Option<&Curves>, ctx: &mut Context) -> Result<Outcome, PlanError> {
    let curves = seats.seats.first().map(|s| &s.curves).or(plain).ok_or_else(|| PlanError::bad("seats", 0, "at least one"))?.clone();
    let mut state = State { aide, box_of_all: curves.bounds().to_vec(), best: seats.seats.first().map(|s| s.best.clone()), hints: Vec::new() };
    state.hints = hints(seats, &curves);
    let mut outcome =
        Outcome { curves, best: None, stages: Vec::new(), population: Value::Null, stop: seats.stop.unwrap_or(Stop::Converged), track: None };
    if seats.stop.is_none() {
        state.turns(&mut outcome, ctx)?;
    }
    if let (Some(best), Stop::Converged, true) = (&state.best, outcome.stop, aide.polish > 0) {
        let (best, stop) = polish(&outcome.curves, best.clone(), aide.polish, ctx)?;
        state.best = Some(best);
        outcome.stop = stop.unwrap_or(outcome.stop);
    }
    outcome.best = state.best;
    Ok(outcome)
}

/// Candidates of all classes that fit the curves, best first, then what the curves had.
fn hints(seats: &Seats, curves: &Curves) -> Vec<Vec<f64>> {
    let within = |x: &[f64]| x.len() == curves.bounds().len() && x.iter().zip(curves.bounds()).all(|(v, b)| (b.0..=b.1).contains(v));
    let own = seats.seats.iter().map(|s| s.best.x.clone()).filter(|x| within(x));
    own.chain(curves.hints().iter().skip(1).cloned()).collect()
}

struct State<'a> {
    aide: &'a Aide,
    box_of_all: Vec<(f64, f64)>,
    best: Option<Candidate>,
    hints: Vec<Vec<f64>>,
}

impl State<'_> {
    fn turns(&mut self, outcome: &mut Outcome, ctx: &mut Context) -> Result<(), PlanError> {
        let engine = self.aide.engine.build(self.aide.population);
        let share = self.share(outcome.curves.bounds().len());
        for turn in 0..self.aide.stages {
            let before = self.value();
            outcome.curves.set_hints(self.hints.clone());
            let watch = Watch::new(&outcome.curves);
            let minimum = ctx.portion(Some(share), None, |ctx| engine.minimize(&watch, ctx))?;
            if turn == 0 {
                outcome.population = watch.picture(&minimum);
            }
            self.take(minimum);
            let spent = ctx.spent();
            outcome.stop = spent.unwrap_or(Stop::Converged);
            let Some(best) = self.best.as_ref().filter(|b| b.cost.value.is_finite()) else {
                if spent.is_some() {
                    break;
                }
                continue;
            };
            let track = match outcome.track.take() {
                Some(track) if track.is_of(&best.x) => track,
                _ => Track::new(&outcome.curves, &best.x)?,
            };
            let speed = track.look()?;
            outcome.track = Some(track);
            let settled = best.cost.feasible() && before - best.cost.value <= SETTLED * best.cost.value.abs();
            let done = spent.is_some() || turn + 1 == self.aide.stages || settled && speed.remaining.is_empty() && self.aide.polish > 0;
            let fed_back = if done || !self.aide.feedback { Vec::new() } else { self.feed_back(&mut outcome.curves, &speed)? };
            let value = self.value();
            let Speed { found, remaining, nodes, passes } = speed;
            outcome.stages.push(Stage { value, found, remaining, nodes, passes, fed_back });
            if done {
                break;
            }
        }
        outcome.curves.set_bounds(self.box_of_all.clone())
    }

    /// Generations of a stage. On long routes a covariance is dear, its work grows with the cube of the numbers, while the polish has done most: fewer then.
    fn share(&self, numbers: usize) -> u64 {
        let share = self.aide.generations / self.aide.stages;
        if self.aide.engine != Engine::CmaEs || numbers <= MANY {
            return share;
        }
        let part = (MANY as f64 / numbers as f64).powi(2);
        ((share as f64 * part) as u64).max(1)
    }

    fn value(&self) -> f64 {
        self.best.as_ref().map_or(f64::INFINITY, |b| b.cost.value)
    }

    /// Keeps what a stage found: the best, and the population to begin the next stage with.
    fn take(&mut self, minimum: Minimum) {
        if minimum.best.is_empty() {
            return;
        }
        if self.best.as_ref().is_none_or(|b| minimum.cost.beats(b.cost)) {
            self.best = Some(Candidate { x: minimum.best, cost: minimum.cost });
        }
        let mut order: Vec<(Cost, Vec<f64>)> = minimum.costs.into_iter().zip(minimum.population).collect();
        order.sort_by(|a, b| a.0.order(b.0));
        self.hints = self.best.iter().map(|b| b.x.clone()).chain(order.into_iter().map(|o| o.1)).collect();
    }

    /// Line 12: regions count in the objective already; boxes around the control points near the worst one, and lower scales where nodes do not help.
    fn feed_back(&mut self, curves: &mut Curves, speed: &Speed) -> Result<Vec<String>, PlanError> {
        let Some(best) = &self.best else { return Ok(Vec::new()) };
        let worst = speed.found.iter().max_by(|a, b| a.excess.total_cmp(&b.excess));
        let Some(worst) = worst else {
            curves.set_bounds(self.box_of_all.clone())?;
            return Ok(Vec::new());
        };
        let mut words = vec![format!("penalty for {} regions", speed.found.len())];
        let numbers = 2 * curves.points();
        if !speed.remaining.is_empty() && best.x.len() > numbers {
            for b in &mut self.box_of_all[numbers..] {
                b.1 = (b.1 * SHRINK.0).max(SHRINK.1);
            }
            words.push(format!("scales x {}", SHRINK.0));
        }
        let place = curves.path(&best.x)?.planar(worst.worst).point;
        let mut order: Vec<usize> = (0..curves.points()).collect();
        let apart = |i: usize| distance([best.x[2 * i], best.x[2 * i + 1]], place);
        order.sort_by(|&a, &b| apart(a).total_cmp(&apart(b)));
        let mut bounds = self.box_of_all.clone();
        for &i in order.iter().take(2) {
            for k in [2 * i, 2 * i + 1] {
                let (low, high) = (bounds[k].0.max(best.x[k] - NEAR), bounds[k].1.min(best.x[k] + NEAR));
                if low < high {
                    bounds[k] = (low, high);
                }
            }
            words.push(format!("box around point {}", i + 1));
        }
        curves.set_bounds(bounds)?;
        Ok(words)
    }
}
