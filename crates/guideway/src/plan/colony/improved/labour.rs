//! O3: soldiers look around, kings follow the best; soldiers become kings.

use super::super::rule::Rule;
use super::Conversion;
use rand::{Rng, RngExt};

/// Share of soldiers among the ants at first.
const SOLDIERS: f64 = 0.9;
/// Largest share of the soldiers that become kings in an iteration.
const RATE: f64 = 0.18;
/// Share of choices in which a soldier takes any exit.
const WANDER: f64 = 0.2;
/// Share of choices in which a king takes the best exit.
const GREEDY: f64 = 0.7;
/// Weight of a king's deposit.
const KING: f64 = 2.0;

/// What an ant does.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::plan::colony) enum Role {
    Soldier,
    King,
}

impl Role {
    /// The rule of a role from that of a plain ant.
    pub fn rule(self, plain: Rule) -> Rule {
        match self {
            Self::Soldier => Rule { alpha: plain.alpha / 2.0, uniform: WANDER, ..plain },
            Self::King => Rule { greedy: GREEDY, ..plain },
        }
    }

    /// Weight of its deposit.
    pub fn weight(self) -> f64 {
        if self == Self::King { KING } else { 1.0 }
    }
}

/// Roles of the first generation: soldiers first.
pub(in crate::plan::colony) fn roles(ants: usize) -> Vec<Role> {
    let soldiers = (SOLDIERS * ants as f64).round() as usize;
    (0..ants).map(|ant| if ant < soldiers { Role::Soldier } else { Role::King }).collect()
}

/// Probability that a soldier becomes a king: `S^2 / (S^2 + theta^2)` with `S = n/N` and `theta = clip(1 - sigma / mean, 0.1, 1)`. (3), (4)
pub(in crate::plan::colony) fn change(progress: f64, mean: f64, deviation: f64) -> f64 {
    let varied = if mean > 0.0 { deviation / mean } else { 0.0 };
    let (stimulus, threshold) = (progress, (1.0 - varied).clamp(0.1, 1.0));
    stimulus * stimulus / (stimulus * stimulus + threshold * threshold)
}

/// What the conversion of an iteration looks at.
pub(in crate::plan::colony) struct Signs {
    /// Share of the iterations that are over.
    pub progress: f64,
    /// Mean length of the ants, cells.
    pub mean: f64,
    /// Standard deviation of the lengths, cells.
    pub deviation: f64,
    /// Entropy of the choices along the best trail, 0 to 1.
    pub entropy: f64,
}

/// Changes roles at the end of an iteration.
pub(in crate::plan::colony) fn convert(roles: &mut [Role], conversion: Conversion, signs: &Signs, rng: &mut impl Rng) {
    let soldiers = roles.iter().filter(|r| **r == Role::Soldier).count();
    let most = (RATE * soldiers as f64).ceil() as usize;
    match conversion {
        Conversion::Entropy => {
            let soldiers = (roles.len() as f64 * SOLDIERS * (1.0 - signs.entropy)).round() as usize;
            for (ant, role) in roles.iter_mut().enumerate() {
                *role = if ant < soldiers { Role::Soldier } else { Role::King };
            }
        }
        Conversion::Rate => promote(roles, most, |_| true, rng),
        Conversion::Stimulus => {
            let probability = change(signs.progress, signs.mean, signs.deviation);
            promote(roles, most, |rng| rng.random_bool(probability), rng);
        }
    }
}

fn promote<R: Rng>(roles: &mut [Role], most: usize, mut chosen: impl FnMut(&mut R) -> bool, rng: &mut R) {
    let mut left = most;
    for role in roles.iter_mut().filter(|r| **r == Role::Soldier) {
        if left > 0 && chosen(rng) {
            (*role, left) = (Role::King, left - 1);
        }
    }
}

/// Mean and standard deviation of the lengths of a generation. Ants that were abandoned count with the mean.
pub(in crate::plan::colony) fn statistics(lengths: &[f64], ants: usize) -> [f64; 2] {
    if lengths.is_empty() {
        return [0.0; 2];
    }
    let mean = lengths.iter().sum::<f64>() / lengths.len() as f64;
    let squares: f64 = lengths.iter().map(|d| (d - mean) * (d - mean)).sum();
    [mean, (squares / ants.max(1) as f64).sqrt()]
}
