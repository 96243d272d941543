//! What the robot knows about movers. Here: the truth about those that are present; a lidar is another producer of the same tracks.

use super::Outline;
use crate::Point;
use crate::world::{Appears, Mover};
use serde::{Deserialize, Serialize};

/// A mover as a sensor reports it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Track {
    /// The same for the same mover throughout a run.
    pub id: usize,
    /// Around its reference point, axes of the map frame.
    pub outline: Outline,
    /// m, map frame.
    pub position: Point,
    /// m/s, map frame.
    pub velocity: Point,
    /// The largest speed it may ever have, m/s.
    pub bound: f64,
    /// The true mover is within the outline grown by this, m.
    pub doubt: f64,
}

impl Track {
    /// Distance from `p` (m) to the mover after `t` s at constant velocity, m.
    #[inline]
    pub fn distance(&self, p: Point, t: f64) -> f64 {
        self.outline.distance([p[0] - self.position[0] - self.velocity[0] * t, p[1] - self.position[1] - self.velocity[1] * t])
    }
}

/// Keeps which movers are present. A mover with a trigger is absent until it fires, then present for good; its motion runs on the clock of the run all along.
#[derive(Debug, Clone)]
pub(super) struct Stage {
    movers: Vec<Mover>,
    outlines: Vec<Outline>,
    /// Time at which each became present, s.
    pub since: Vec<Option<f64>>,
}

impl Stage {
    pub fn new(movers: &[Mover]) -> Self {
        let since = movers.iter().map(|m| m.appears.is_none().then_some(0.0)).collect();
        Self { movers: movers.to_vec(), outlines: movers.iter().map(|m| Outline::of(&m.shape)).collect(), since }
    }

    /// Fires the triggers for a robot at `p` at time `t`.
    pub fn trigger(&mut self, p: Point, t: f64) {
        for (mover, since) in self.movers.iter().zip(&mut self.since) {
            let fired = match mover.appears {
                None => true,
                Some(Appears::At(start)) => t >= start,
                Some(Appears::Within(reach)) => {
                    let at = mover.at(t).0;
                    (at[0] - p[0]).hypot(at[1] - p[1]) <= reach
                }
            };
            if fired && since.is_none() {
                *since = Some(t);
            }
        }
    }

    /// Movers, outlines and indices of those present.
    pub fn present(&self) -> impl Iterator<Item = (usize, &Mover, &Outline)> {
        self.movers.iter().zip(&self.outlines).enumerate().filter(|(i, _)| self.since[*i].is_some()).map(|(i, (m, o))| (i, m, o))
    }

    /// The true tracks of the movers present at time `t`.
    pub fn tracks(&self, t: f64) -> Vec<Track> {
        self.present()
            .map(|(id, mover, outline)| {
                let (position, velocity) = mover.at(t);
                Track { id, outline: outline.clone(), position, velocity, bound: mover.top_speed(), doubt: 0.0 }
            })
            .collect()
    }
}

/// The true tracks at time `t` (s) of all movers that need no trigger or whose time has come.
pub fn visible(movers: &[Mover], t: f64) -> Vec<Track> {
    let mut stage = Stage::new(movers);
    stage.trigger([f64::INFINITY; 2], t);
    stage.tracks(t)
}
