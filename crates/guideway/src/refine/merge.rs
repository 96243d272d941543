//! One bend for several corners that turn the same way, where that is wider.

use super::belt::{Mode, Pulley, SHARPEST, heading};
use super::fit::Fit;
use super::smooth::room;
use crate::world::shape::distance;

/// Gain in radius that makes one bend out of two.
const GAIN: f64 = 1.3;
/// Smallest gain that makes one out of more: an even bend is better than a row of them.
const EVEN: f64 = 0.95;
/// Numbers of corners that are tried together, less one.
const RUNS: [usize; 9] = [1, 2, 3, 5, 8, 13, 21, 34, 55];

impl Fit<'_> {
    /// Makes one bend of neighbours that turn the same way, where that is wider and no longer than bends may be.
    pub fn merge(&mut self) {
        let mut i = 1;
        while i + 2 < self.chain.len() {
            let mut best: Option<(f64, Vec<Pulley>)> = None;
            let alike = (i..self.chain.len() - 2)
                .take_while(|&k| self.chain[k + 1].mode == Mode::Outside && self.chain[k + 1].sign() == self.chain[i].sign());
            let longest = alike.count();
            let mut runs: Vec<usize> = RUNS.into_iter().filter(|n| *n < longest).collect();
            runs.extend((longest > 0).then_some(longest));
            for last in runs.into_iter().map(|n| i + n) {
                let Some(merged) = self.union(i, last) else { break };
                if let Some(pulley) = self.fits(i, last, merged)
                    && best.as_ref().is_none_or(|(r, _)| pulley.radius > *r)
                {
                    best = Some((pulley.radius, [vec![pulley], self.chain[last + 1..].to_vec()].concat()));
                }
            }
            if let Some((_, rest)) = best {
                self.chain.truncate(i);
                self.chain.extend(rest);
            }
            i += 1;
        }
    }

    /// The merged pulley with the largest radius that is proved, if that is worth it. The chain is as before afterwards.
    fn fits(&mut self, i: usize, last: usize, merged: Pulley) -> Option<Pulley> {
        let tightest = self.chain[i..=last].iter().map(|p| p.radius).fold(f64::INFINITY, f64::min);
        let worth = if last == i + 1 { GAIN } else { EVEN } * tightest.max(self.smallest);
        // A bend that keeps the limit on the curvature is not given away for one that does not.
        let kept = |p: &Pulley| self.smooth.wanted(p.turn, p.fine).filter(|r| p.radius >= *r);
        let least = self.chain[i..=last].iter().filter_map(kept).fold(worth, f64::max);
        let (low, high) = (i.saturating_sub(2), (last + 2).min(self.chain.len() - 1));
        let allowed = self.belt(low, high) * (1.0 + self.smooth.stretch);
        let kept: Vec<Pulley> = self.chain.splice(i..=last, [merged]).collect();
        let mut radius = self.chain[i].cap;
        let mut found = None;
        while found.is_none() && radius > least {
            if self.try_radius(i, radius) && self.belt(low, high + i - last) <= allowed {
                found = Some(self.chain[i].clone());
            }
            self.chain[i].radius = 0.0;
            radius *= 0.7;
        }
        self.chain.splice(i..=i, kept);
        found
    }

    /// One pulley, not yet with a radius, for the way points of pulleys `i` to `last`; `None` if they do not turn alike or too far.
    fn union(&self, i: usize, last: usize) -> Option<Pulley> {
        let run = &self.chain[i..=last];
        let turn: f64 = run.iter().map(|p| p.turn).sum();
        if run.iter().any(|p| p.mode != Mode::Outside || p.held || p.sign() != run[0].sign()) || turn.abs() > 0.9 * SHARPEST {
            return None;
        }
        let mut pulley = Pulley::point(run[0].at(), Mode::Outside);
        pulley.contacts = run.iter().flat_map(|p| &p.contacts).copied().collect();
        let (before, after) = (*self.chain[i - 1].contacts.last()?, *self.chain[last + 1].contacts.first()?);
        let (first, end) = (*pulley.contacts.first()?, *pulley.contacts.last()?);
        let heading_in = heading(before, first);
        pulley.face(heading_in, heading_in + turn);
        let rooms = [room(distance(before, first), i == 1), room(distance(end, after), last + 2 == self.chain.len())];
        pulley.cap = self.smooth.generous().cap(turn, rooms, false);
        Some(pulley)
    }
}
