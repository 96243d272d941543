//! The continuous planners by name: an optimizer, its settings over splines, and those of the source.

use super::planner::Spline;
use super::settings::Settings;
use crate::optimize;
use crate::plan::Preset;

/// Differential evolution over splines.
pub type De = Spline<optimize::De>;
/// Improved differential evolution over splines.
pub type ImprovedDe = Spline<optimize::ImprovedDe>;
/// Fireflies over splines.
pub type Firefly = Spline<optimize::Firefly>;
/// Success-history adaptive differential evolution over splines.
pub type LShade = Spline<optimize::LShade>;
/// Covariance matrix adaptation over splines.
pub type CmaEs = Spline<optimize::CmaEs>;

/// Generations of our settings where the budget names none, and those without improvement after which they stop.
const GENERATIONS: (u64, u64) = (200, 50);

impl<O> Spline<O> {
    fn ours(optimizer: O) -> Self {
        Self { preset: Preset::Default, settings: Settings::default(), optimizer }
    }

    fn source(optimizer: O) -> Self {
        Self { preset: Preset::Paper, settings: Settings::paper(), optimizer }
    }
}

macro_rules! method {
    ($name:ident, $ours:expr) => {
        impl Default for $name {
            fn default() -> Self {
                Self::ours($ours)
            }
        }

        impl $name {
            /// Settings of \[zhang2025\], or of the optimizer's own source, without hints.
            pub fn paper() -> Self {
                Self::source(optimize::$name::default())
            }
        }
    };
}

method!(De, optimize::De { iterations: GENERATIONS.0, patience: GENERATIONS.1, ..optimize::De::default() });
method!(ImprovedDe, optimize::ImprovedDe { iterations: GENERATIONS.0, patience: GENERATIONS.1, ..optimize::ImprovedDe::default() });
method!(Firefly, optimize::Firefly { iterations: GENERATIONS.0, patience: GENERATIONS.1, ..optimize::Firefly::default() });
method!(LShade, optimize::LShade { population: 60, iterations: GENERATIONS.0, patience: GENERATIONS.1, ..optimize::LShade::default() });
method!(CmaEs, optimize::CmaEs { iterations: 4 * GENERATIONS.0, patience: 2 * GENERATIONS.1, ..optimize::CmaEs::default() });
