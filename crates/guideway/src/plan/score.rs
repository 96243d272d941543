//! What a lattice path is worth to a heuristic planner: its cost, and of equal costs the fewer turns.

use crate::path::ENERGY;
use crate::query::Material;
use crate::world::Cell;
use std::cmp::Ordering;
use std::f64::consts::SQRT_2;

/// Worth of a path; less is better. Lattice costs come from counts of steps, so that equal paths compare equal exactly.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Score {
    /// Cost, cells (length, or energy in units of a cell of travel).
    pub cost: f64,
    /// Changes of heading.
    pub turns: u32,
}

impl Score {
    /// Worse than every path.
    pub const WORST: Self = Self { cost: f64::INFINITY, turns: u32::MAX };

    /// Is it better than the other?
    pub fn beats(self, other: Self) -> bool {
        self.order(other) == Ordering::Less
    }

    /// Cost first, then turns.
    pub fn order(self, other: Self) -> Ordering {
        self.cost.total_cmp(&other.cost).then(self.turns.cmp(&other.turns))
    }
}

/// What the planner minimises.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Aim {
    /// Length.
    Shortest,
    /// Energy: length and turns weighed (`metrics` 5.1: one unit per cell, half a unit per turn).
    LeastEnergy,
}

impl Aim {
    /// The aim of a transported material.
    pub fn of(material: Material) -> Self {
        match material {
            Material::Standard | Material::Long => Self::Shortest,
            Material::Heavy => Self::LeastEnergy,
        }
    }

    /// Worth of a path of that length, cells, with that many turns.
    pub fn score(self, length: f64, turns: u32) -> Score {
        let cost = match self {
            Self::Shortest => length,
            Self::LeastEnergy => ENERGY[0] * length + ENERGY[1] * f64::from(turns),
        };
        Score { cost, turns }
    }

    /// Worth of a path of neighbouring cells.
    pub fn of_cells(self, cells: &[Cell]) -> Score {
        let [straight, diagonal, turns] = counts(cells);
        self.score(f64::from(straight) + f64::from(diagonal) * SQRT_2, turns)
    }
}

/// Straight steps, diagonal steps and turns of a path of neighbouring cells.
pub fn counts(cells: &[Cell]) -> [u32; 3] {
    let way = |a: Cell, b: Cell| [b[0].wrapping_sub(a[0]), b[1].wrapping_sub(a[1])];
    let (mut straight, mut diagonal, mut turns, mut before) = (0, 0, 0, None);
    for pair in cells.windows(2) {
        let now = way(pair[0], pair[1]);
        *if now[0] == 0 || now[1] == 0 { &mut straight } else { &mut diagonal } += 1;
        turns += u32::from(before.is_some_and(|b| b != now));
        before = Some(now);
    }
    [straight, diagonal, turns]
}

#[cfg(test)]
mod tests {
    use super::*;

    const STAIRS: [Cell; 6] = [[0, 0], [1, 1], [2, 2], [3, 2], [4, 2], [4, 1]];

    #[test]
    fn steps_and_turns_are_counted() {
        assert_eq!(counts(&STAIRS), [3, 2, 2]);
        assert_eq!((counts(&STAIRS[..1]), counts(&[])), ([0; 3], [0; 3]));
    }

    #[test]
    fn energy_weighs_turns_and_equal_lengths_are_decided_by_turns() {
        assert_eq!(Aim::LeastEnergy.of_cells(&STAIRS).cost, 3.0 + 2.0 * SQRT_2 + 1.0);
        let (a, b) = (Score { cost: 3.0, turns: 1 }, Score { cost: 3.0, turns: 2 });
        assert!(a.beats(b) && !b.beats(a) && !a.beats(a) && b.beats(Score::WORST));
    }
}
