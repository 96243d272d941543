//! Alternatives of which none is better than another in every respect: shorter, with fewer turns, farther from obstacles.

use super::score::{Aim, counts};
use crate::world::Cell;
use std::f64::consts::SQRT_2;

/// A lattice path and what it is worth.
#[derive(Debug, Clone, PartialEq)]
pub struct Alternative {
    /// All cells, start and goal included.
    pub cells: Vec<Cell>,
    /// Length from centre to centre, cells.
    pub length: f64,
    /// Changes of heading.
    pub turns: u32,
    /// Smallest distance of the way between the centres from an obstacle, m; infinite without obstacles.
    pub clearance: f64,
}

impl Alternative {
    /// A path of neighbouring cells with that clearance, m; length and turns are counted.
    pub fn new(cells: Vec<Cell>, clearance: f64) -> Self {
        let [straight, diagonal, turns] = counts(&cells);
        Self { cells, length: f64::from(straight) + f64::from(diagonal) * SQRT_2, turns, clearance }
    }

    /// Energy: one unit per cell and half a unit per turn. Never better where both are worse, so it decides nothing about dominance.
    pub fn energy(&self) -> f64 {
        Aim::LeastEnergy.score(self.length, self.turns).cost
    }

    /// Is it at least as good in every respect?
    pub fn covers(&self, other: &Self) -> bool {
        self.length <= other.length && self.turns <= other.turns && self.clearance >= other.clearance
    }
}

/// An archive that keeps what nothing else covers, in the order of length, then turns, then clearance. Of equals the first offered stays.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Front {
    kept: Vec<Alternative>,
}

impl Front {
    /// Keeps the alternative unless one that is kept covers it, and lets go of those that it covers. Was it kept?
    pub fn offer(&mut self, offered: Alternative) -> bool {
        if self.kept.iter().any(|kept| kept.covers(&offered)) {
            return false;
        }
        self.kept.retain(|kept| !offered.covers(kept));
        let key = |a: &Alternative| (a.length, a.turns, -a.clearance);
        let place = self.kept.partition_point(|kept| key(kept) < key(&offered));
        self.kept.insert(place, offered);
        true
    }

    /// The alternatives, shortest first.
    pub fn alternatives(&self) -> &[Alternative] {
        &self.kept
    }
    /// Is nothing kept?
    pub fn is_empty(&self) -> bool {
        self.kept.is_empty()
    }
    /// Number of alternatives.
    pub fn len(&self) -> usize {
        self.kept.len()
    }

    /// Volume of what is covered: lengths up to `worst.length` cells, turns up to `worst.turns`, clearances from `worst.clearance` m. The measure of a
    /// front's quality (\[zitzler1999\]); exact, infinite where an alternative has no obstacle near.
    pub fn hypervolume(&self, worst: Worst) -> f64 {
        let mut inside: Vec<_> =
            self.kept.iter().filter(|a| a.length < worst.length && f64::from(a.turns) < worst.turns && a.clearance > worst.clearance).collect();
        inside.sort_by(|a, b| b.clearance.total_cmp(&a.clearance));
        let floors = inside.iter().skip(1).map(|a| a.clearance).chain([worst.clearance]);
        let slabs = inside.iter().zip(floors).enumerate().filter(|(_, (top, floor))| top.clearance > *floor);
        slabs.map(|(k, (top, floor))| (top.clearance - floor) * area(&inside[..=k], worst)).sum()
    }
}

/// Corner of the space that a hypervolume is measured from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Worst {
    /// Cells.
    pub length: f64,
    /// Changes of heading.
    pub turns: f64,
    /// m.
    pub clearance: f64,
}

/// Area covered in the plane of length and turns.
fn area(all: &[&Alternative], worst: Worst) -> f64 {
    let mut corners: Vec<_> = all.iter().map(|a| (a.length, f64::from(a.turns))).collect();
    corners.sort_by(|a, b| a.partial_cmp(b).unwrap_or(std::cmp::Ordering::Equal));
    let (mut sum, mut least) = (0.0, worst.turns);
    for (length, turns) in corners {
        if turns < least {
            sum += (worst.length - length) * (least - turns);
            least = turns;
        }
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    fn made(length: f64, turns: u32, clearance: f64) -> Alternative {
        Alternative { cells: Vec::new(), length, turns, clearance }
    }

    #[test]
    fn only_what_nothing_covers_is_kept_in_order() {
        let mut front = Front::default();
        assert!(front.offer(made(5.0, 2, 1.0)) && front.offer(made(4.0, 3, 1.0)) && front.offer(made(6.0, 2, 2.0)));
        assert!(!front.offer(made(5.0, 2, 1.0)) && !front.offer(made(5.0, 3, 0.5)));
        assert_eq!(front.alternatives().iter().map(|a| a.length).collect::<Vec<_>>(), [4.0, 5.0, 6.0]);
        assert!(front.offer(made(4.0, 2, 2.0)));
        assert_eq!(front.alternatives(), [made(4.0, 2, 2.0)]);
    }

    #[test]
    fn volumes_by_hand_and_against_counting_of_boxes() {
        let worst = Worst { length: 10.0, turns: 10.0, clearance: 0.0 };
        let mut front = Front::default();
        assert_eq!((front.hypervolume(worst), front.is_empty()), (0.0, true));
        for (length, turns, clearance) in [(4.0, 6, 1.0), (6.0, 3, 1.0), (7.0, 5, 4.0), (9.0, 1, 2.0), (5.0, 5, 2.0), (11.0, 0, 9.0)] {
            front.offer(made(length, turns, clearance));
        }
        let covered =
            |l: u32, t: u32, c: u32| front.alternatives().iter().any(|a| a.length <= f64::from(l) && a.turns <= t && a.clearance >= f64::from(c + 1));
        let boxes = (0..10).flat_map(|l| (0..10).flat_map(move |t| (0..10).map(move |c| (l, t, c)))).filter(|&(l, t, c)| covered(l, t, c)).count();
        assert_eq!(front.hypervolume(worst), boxes as f64);
        assert!(front.offer(made(9.5, 0, f64::INFINITY)) && front.hypervolume(worst).is_infinite());
    }
}
