//! The optimizers that can drive the loop.

use crate::optimize::{CmaEs, De, Firefly, ImprovedDe, LShade, Optimizer};
use serde::{Deserialize, Serialize};

/// An optimizer by name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Engine {
    /// Improved differential evolution, as the source has it.
    ImprovedDe,
    /// Plain differential evolution.
    De,
    /// Success-history adaptive differential evolution.
    LShade,
    /// Covariance matrix adaptation.
    #[default]
    CmaEs,
    /// Fireflies.
    Firefly,
}

impl Engine {
    /// The optimizer with that population (0: its own).
    pub(super) fn build(self, population: usize) -> Box<dyn Optimizer> {
        let or = |own: usize| if population == 0 { own } else { population };
        match self {
            Self::ImprovedDe => Box::new(ImprovedDe { population: or(ImprovedDe::default().population), ..ImprovedDe::default() }),
            Self::De => Box::new(De { population: or(De::default().population), ..De::default() }),
            Self::LShade => Box::new(LShade { population: or(60), ..LShade::default() }),
            Self::CmaEs => Box::new(CmaEs { population, hint_step: 0.01, ..CmaEs::default() }),
            Self::Firefly => Box::new(Firefly { population: or(Firefly::default().population), ..Firefly::default() }),
        }
    }
}
