//! Stretches that begin or end in motion.
//!
//! The speed at an end is a limit, and reaching it is worth more than any time. Such a motion cannot be slowed down as a whole until all limits are kept, as
//! one from rest to rest is: that would change the speed. So its rounds go on until tightening alone leaves no excess. The acceleration at such an end is free
//! within its limits.

use super::pieces::Walker;
use super::rows::Posed;
use super::turns::Stretch;
use super::{LAST, Smooth, Task, Told};
use crate::error::PlanError;
use crate::timing::topp::motion::Leg;

/// Most by which a guide is sped up.
const FASTER: f64 = 20.0;
/// Fewest cells: the largest speeds beside a stop want more than its motion does.
const FEWEST: usize = 250;
/// Rounds, the excess of speeds that counts as none, and the change of those reached.
const ROUNDS: usize = 12;
const NONE: f64 = 1e-7;
const SETTLED: f64 = 1e-6;
/// Squared speeds of the guide with which it is near enough to the motion for what exceeds a limit to be the limit's, not the guide's.
const NEAR: std::ops::Range<f64> = 0.8..1.25;

impl Task<'_, '_, '_> {
    /// One stretch with speeds at its ends: in the time of the second-order motion or, where that is no guide (the stretch is hardly longer than it takes to
    /// build up an acceleration), of one that changes its speed evenly.
    pub(super) fn passed(&mut self, stretch: &Stretch, cells: usize, walker: &mut Walker, smooth: &mut Smooth) -> Result<Told, PlanError> {
        let cells = cells.max(FEWEST);
        let even = [even(stretch)];
        let mut most = [0.0; 2];
        let guides = [stretch.legs, &even];
        for legs in &guides[..if even[0].duration < FASTER * stretch.duration() { 2 } else { 1 }] {
            let stretch = Stretch { legs, turns: stretch.turns.clone(), ..*stretch };
            match self.guided(&stretch, cells, walker, smooth)? {
                Ok(told) => return Ok(told),
                Err(reached) => [0, 1].into_iter().for_each(|end| most[end] = f64::max(most[end], reached[end])),
            }
        }
        Err(refusal(stretch, most))
    }

    /// The motion, or the shares of the speeds at both ends that were reached.
    fn guided(&mut self, stretch: &Stretch, cells: usize, walker: &mut Walker, smooth: &mut Smooth) -> Result<Result<Told, [f64; 2]>, PlanError> {
        let mut rounds = self.rounds(stretch, cells, walker)?;
        let mut most = [0.0; 2];
        for _ in 0..ROUNDS {
            let Some((y, told)) = self.attempt(&mut rounds, self.check.div_ceil(2), walker, smooth)? else { break };
            let reached = rounds.posed.reached(&y);
            if reached == [1.0; 2] && told.slower <= 1.0 + NONE {
                let mut prices = smooth.prices.clone();
                rounds.posed.sensitivities(&y, LAST * rounds.per_cell(), &mut prices);
                smooth.prices = prices;
                return Ok(Ok(told));
            }
            let before = most;
            most = [0, 1].map(|end| f64::max(most[end], reached[end] / told.slower));
            if told.slower <= 1.0 + NONE && (0..2).all(|end| most[end] <= before[end] * (1.0 + SETTLED)) {
                break;
            }
            let next = rounds.next(&told, y.iter().all(|y| NEAR.contains(y)));
            rounds.posed = Posed::new(next, stretch.speeds, walker);
        }
        Ok(Err(most))
    }
}

/// A motion along a stretch that changes its speed evenly.
fn even(stretch: &Stretch) -> Leg {
    let ([from, to], [start, end]) = (stretch.ends, stretch.speeds);
    let duration = 2.0 * (to - from) / (start + end);
    Leg { speed: start, acceleration: (end - start) / duration, jerk: 0.0, duration }
}

/// That a speed at an end is too high, from the shares of both that were reached: that at the end counts more.
fn refusal(stretch: &Stretch, most: [f64; 2]) -> PlanError {
    let short = |end: &usize| stretch.speeds[*end] > 0.0 && most[*end] < 1.0;
    let Some(end) = [1, 0].into_iter().find(short) else {
        let [from, to] = stretch.ends;
        let reason = format!("no jerk-limited motion with the speeds asked for was found between s = {from:.6} and {to:.6} rad");
        return PlanError::Infeasible { reason, best_end_speed: None };
    };
    let (place, most) = (["start", "end"][end], most[end] * stretch.speeds[end]);
    let reason = format!("the path speed at the {place} can be at most {most:.6} rad/s under the limits of jerk");
    PlanError::Infeasible { reason, best_end_speed: (end == 1).then_some(most) }
}
