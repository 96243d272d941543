//! What the source leaves open, as choices.

use serde::{Deserialize, Serialize};

/// What the critic `dist` of an arc is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Room {
    /// The free distance along it, as in the classic window.
    Free,
    /// The smallest distance to an obstacle over the arc.
    Least,
    /// The mean over the arc of the distance to the nearest obstacle.
    Mean,
    /// The distance to the nearest obstacle at its end.
    End,
}

/// What the scores of a critic are divided by.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Divide {
    /// Their sum over the candidates.
    Sum,
    /// What they can be at most: half a turn, `far`, the top speed.
    Scale,
}
