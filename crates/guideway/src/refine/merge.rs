//! One bend for several corners that turn the same way, where that is wider.

use super::belt::{Mode, Pulley, SHARPEST, heading};
use super::fit::Fit;
use super::smooth::room;
use crate::world::shape::distance;

/// Gain in radius that makes one bend out of several.
const GAIN: f64 = 1.3;
/// Most corners that are tried together.
const RUN: usize = 8;

/// One pulley for several, with the length of the legs that its bend has to itself, m.
struct Merged {
    pulley: Pulley,
    room: f64,
}

impl Fit<'_> {
    /// Makes one bend of neighbours that turn the same way, where that is wider and no longer than bends may be.
    pub fn merge(&mut self) {
        let mut i = 1;
        while i + 2 < self.chain.len() {
            let mut best: Option<(f64, Vec<Pulley>)> = None;
            let mut last = i + 1;
            while last + 1 < self.chain.len() && last - i < RUN {
                let Some(merged) = self.union(i, last) else { break };
                if let Some(pulley) = self.fits(i, last, merged)
                    && best.as_ref().is_none_or(|(r, _)| pulley.radius > *r)
                {
                    best = Some((pulley.radius, [vec![pulley], self.chain[last + 1..].to_vec()].concat()));
                }
                last += 1;
            }
            if let Some((_, rest)) = best {
                self.chain.truncate(i);
                self.chain.extend(rest);
            }
            i += 1;
        }
    }

    /// The merged pulley with the largest radius that is proved, if that is worth it. The chain is as before afterwards.
    fn fits(&mut self, i: usize, last: usize, merged: Merged) -> Option<Pulley> {
        let tightest = self.chain[i..=last].iter().map(|p| p.radius).fold(f64::INFINITY, f64::min);
        let least = GAIN * tightest.max(self.smallest);
        let (low, high) = (i.saturating_sub(2), (last + 2).min(self.chain.len() - 1));
        let allowed = self.belt(low, high) + self.smooth.stretch * merged.room;
        let kept: Vec<Pulley> = self.chain.splice(i..=last, [merged.pulley]).collect();
        let mut radius = self.chain[i].cap;
        let mut found = None;
        while found.is_none() && radius > least {
            if self.try_radius(i, radius) && self.belt(low, high + i - last) <= allowed {
                found = Some(self.chain[i].clone());
            }
            self.chain[i].radius = 0.0;
            radius *= 0.8;
        }
        self.chain.splice(i..=i, kept);
        found
    }

    /// One pulley, not yet with a radius, for the way points of pulleys `i` to `last`; `None` if they do not turn alike or too far.
    fn union(&self, i: usize, last: usize) -> Option<Merged> {
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
        pulley.cap = self.smooth.cap(turn, rooms, false);
        Some(Merged { pulley, room: rooms[0] + rooms[1] })
    }
}
