//! Every critic of the dynamic windows, one line each; a weight of 0 switches it off.

use crate::world::shape::wrap;
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// Weights by critic.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Weights {
    pub heading: f64,
    pub dist: f64,
    pub velocity: f64,
    pub path: f64,
    pub to_go: f64,
    pub deviation: f64,
    pub near: f64,
    pub exposed: f64,
    pub turned: f64,
    pub change: f64,
    pub keep_on: f64,
}

/// What is known about a candidate: a command, or the first command of a plan.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Candidate {
    /// m/s.
    pub v: f64,
    /// rad/s.
    pub w: f64,
    /// Where it leads to: at the end of the next interval, or of the plan.
    pub end: [f64; 3],
    /// Target that the heading is judged by, m.
    pub target: [f64; 2],
    /// Direction of the path where it leads to, rad.
    pub along: f64,
    /// Free distance along the arc, m, capped.
    pub dist: f64,
    /// Time that is left at the end, s.
    pub left: f64,
    /// Integral of the distance from the path, m s.
    pub aside: f64,
    /// Integral of the nearness to movers (0 to 1), s.
    pub close: f64,
    /// Integral of the exposure to movers (0 to 1) where the robot would stand if it stopped, s.
    pub exposed: f64,
    /// The same to movers that turn around when it stops, s.
    pub turned: f64,
    /// Change of the command, m/s.
    pub change: f64,
    /// Keeps to the side chosen before.
    pub kept: bool,
}

/// Name, weight, score; larger is better.
pub(super) type Critic = (&'static str, fn(&Weights) -> f64, fn(&Candidate) -> f64);

/// The first four are those of the sources and never negative; the others are ours.
pub(super) const CRITICS: [Critic; 11] = [
    ("heading", |w| w.heading, |c| PI - wrap((c.target[1] - c.end[1]).atan2(c.target[0] - c.end[0]) - c.end[2]).abs()),
    ("dist", |w| w.dist, |c| c.dist),
    ("velocity", |w| w.velocity, |c| c.v.max(0.0)),
    ("path", |w| w.path, |c| PI - wrap(c.along - c.end[2]).abs()),
    ("to_go", |w| w.to_go, |c| -c.left),
    ("deviation", |w| w.deviation, |c| -c.aside),
    ("near", |w| w.near, |c| -c.close),
    ("exposed", |w| w.exposed, |c| -c.exposed),
    ("turned", |w| w.turned, |c| -c.turned),
    ("change", |w| w.change, |c| -c.change),
    ("keep_on", |w| w.keep_on, |c| f64::from(u8::from(c.kept))),
];

impl Weights {
    /// The weighted sum of all scores.
    pub fn total(&self, c: &Candidate) -> f64 {
        CRITICS.iter().map(|(_, weight, score)| (weight(self), score)).filter(|(w, _)| *w > 0.0).map(|(w, score)| w * score(c)).sum()
    }

    /// The candidate with the highest weighted sum of scores, each divided by its sum over all candidates; the faster of equals.
    pub fn best<'c>(&self, all: &'c [Candidate]) -> Option<&'c Candidate> {
        let mut total = vec![0.0; all.len()];
        for (_, weight, score) in CRITICS {
            let weight = weight(self);
            if weight > 0.0 {
                let sum = all.iter().map(score).sum::<f64>().abs().max(1e-12);
                total.iter_mut().zip(all).for_each(|(t, c)| *t += weight * score(c) / sum);
            }
        }
        let order = |a: &(usize, &Candidate), b: &(usize, &Candidate)| total[a.0].total_cmp(&total[b.0]).then(a.1.v.total_cmp(&b.1.v));
        all.iter().enumerate().max_by(order).map(|(_, c)| c)
    }

    /// As [`Weights::best`], by the weighted sum of the scores as they are.
    pub fn best_total<'c>(&self, all: &'c [Candidate]) -> Option<&'c Candidate> {
        all.iter().max_by(|a, b| self.total(a).total_cmp(&self.total(b)).then(a.v.total_cmp(&b.v)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_weight_of_zero_switches_a_critic_off_and_every_name_is_there_once() {
        let slow = Candidate { v: 0.2, dist: 2.0, ..Candidate::default() };
        let fast = Candidate { v: 1.0, dist: 0.5, ..Candidate::default() };
        let pick = |w: Weights| w.best(&[slow, fast]).unwrap().v;
        assert_eq!(pick(Weights { dist: 1.0, ..Weights::default() }), 0.2);
        assert_eq!(pick(Weights { velocity: 1.0, ..Weights::default() }), 1.0);
        assert_eq!(pick(Weights { dist: 1.0, velocity: 1.0, ..Weights::default() }), 1.0);
        assert!((Weights { velocity: 2.0, ..Weights::default() }.total(&fast) - 2.0).abs() < 1e-12);
        let mut names: Vec<_> = CRITICS.iter().map(|c| c.0).collect();
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), CRITICS.len());
    }
}
