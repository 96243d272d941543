//! Swarms on the lattice: encodings that turn any optimizer into a planner, and a genetic algorithm on paths.

mod aide;
mod decoding;
mod ga;
mod guided_walk;
mod prune;
mod run;
mod spline;
mod way_points;

pub use aide::{Aide, Engine, PARAMETERS as AIDE_PARAMETERS};
pub use decoding::{Decoding, Encoding};
pub use ga::Ga;
pub(super) use run::{Found, search};
pub use spline::{CmaEs, Curves, De, Firefly, Form, ImprovedDe, Judged, LShade, Settings, Spline};

use super::score::Aim;
use super::{Planner, Preset, Solution};
use crate::context::Context;
use crate::error::PlanError;
use crate::optimize::{self, Optimizer};
use crate::query::Query;
use serde::{Deserialize, Serialize};

/// A planner that minimises over lattice paths with an optimizer; with [`Encoding::Spline`], over splines as [`Spline`] does.
///
/// `trace.legs` has for each leg `convergence`, pairs of iteration and best cost (cells), and `paths`, turning points (m) of the best distinct paths of
/// the last population.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Swarm<O> {
    /// Settings: ours or those of the source.
    #[serde(default)]
    pub preset: Preset,
    /// From a candidate to a path.
    #[serde(flatten)]
    pub decoding: Decoding,
    /// The optimizer and its parameters.
    #[serde(flatten)]
    pub optimizer: O,
}

/// Particle swarm on the lattice.
pub type Pso = Swarm<optimize::Pso>;
/// Grouped particle swarm on the lattice.
pub type GroupedPso = Swarm<optimize::GroupedPso>;
/// Sparrow search on the lattice.
pub type Sparrow = Swarm<optimize::Sparrow>;

/// Iterations without improvement after which our settings stop.
const PATIENCE: u64 = 20;

impl<O> Swarm<O> {
    /// Our settings around an optimizer.
    fn ours(optimizer: O) -> Self {
        Self { preset: Preset::Default, decoding: Decoding::default(), optimizer }
    }
}

impl Default for Pso {
    fn default() -> Self {
        Self::ours(optimize::Pso { patience: PATIENCE, ..optimize::Pso::default() })
    }
}

impl Default for GroupedPso {
    fn default() -> Self {
        Self::ours(optimize::GroupedPso::default())
    }
}

impl Default for Sparrow {
    fn default() -> Self {
        Self::ours(optimize::Sparrow { patience: PATIENCE, ..optimize::Sparrow::default() })
    }
}

impl Pso {
    /// Settings of the comparison in \[han2024\].
    pub fn paper() -> Self {
        Self { preset: Preset::Paper, decoding: Decoding::paper(), optimizer: optimize::Pso::default() }
    }
}

impl GroupedPso {
    /// Settings of \[han2024\].
    pub fn paper() -> Self {
        Self { preset: Preset::Paper, decoding: Decoding::paper(), optimizer: optimize::GroupedPso::default() }
    }
}

impl Sparrow {
    /// Settings of the comparison in \[han2024\], whose lengths show any-angle paths.
    pub fn paper() -> Self {
        let decoding = Decoding { prune: true, ..Decoding::paper() };
        Self { preset: Preset::Paper, decoding, optimizer: optimize::Sparrow::default() }
    }
}

impl Preset {
    /// What a swarm minimises: the length, or what the material asks for.
    pub(super) fn aim(self, query: &Query) -> Aim {
        match self {
            Self::Paper => Aim::Shortest,
            Self::Default | Self::Recommended => Aim::of(query.material),
        }
    }
}

impl<O: Optimizer> Planner for Swarm<O> {
    fn plan(&self, query: &Query, ctx: &mut Context) -> Result<Solution, PlanError> {
        if self.decoding.encoding == Encoding::Spline {
            let settings = if self.preset == Preset::Paper { Settings::paper() } else { Settings::default() };
            return spline::plan(query, &settings, &self.optimizer, ctx);
        }
        run::plan(query, ctx, |leg, ctx| search(leg, &self.optimizer, &self.decoding, self.preset.aim(query), ctx))
    }
}
