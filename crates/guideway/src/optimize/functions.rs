//! Functions to test optimizers with, also shifted: an optimizer with a liking for 0 or for the middle of the box is found out by them.
//!
//! Source: \[suganthan2005\] for the shifted ones; all have minimum 0.

use super::{Cost, Objective};
use crate::error::PlanError;
use std::f64::consts::{E, TAU};

/// A function of any number of variables whose minimum is 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Function {
    /// Sum of squares; minimum at 0, box 100 to each side.
    Sphere,
    /// A narrow bent valley; minimum at (1, ..., 1), box 30 to each side.
    Rosenbrock,
    /// Many local minima one apart; minimum at 0, box 5.12 to each side.
    Rastrigin,
    /// Nearly flat outside, a funnel full of local minima; minimum at 0, box 32 to each side.
    Ackley,
    /// A bowl full of shallow local minima that hide it; minimum at 0, box 600 to each side.
    Griewank,
}

impl Function {
    /// All of them.
    pub const ALL: [Self; 5] = [Self::Sphere, Self::Rosenbrock, Self::Rastrigin, Self::Ackley, Self::Griewank];

    /// The function of that name, in small letters.
    /// # Errors
    /// [`PlanError::BadParameter`] for an unknown one, naming those there are.
    pub fn named(name: &str) -> Result<Self, PlanError> {
        let names = Self::ALL.map(|f| format!("{f:?}").to_lowercase());
        let found = names.iter().position(|n| n == name).map(|k| Self::ALL[k]);
        found.ok_or_else(|| PlanError::bad("f", name, format!("a function, or one of {}", names.join(", "))))
    }

    /// Its value.
    pub fn value(self, x: &[f64]) -> f64 {
        let n = x.len().max(1) as f64;
        match self {
            Self::Sphere => x.iter().map(|v| v * v).sum(),
            Self::Rosenbrock => x.windows(2).map(|w| 100.0 * (w[1] - w[0] * w[0]).powi(2) + (1.0 - w[0]).powi(2)).sum(),
            Self::Rastrigin => x.iter().map(|v| v * v - 10.0 * (TAU * v).cos() + 10.0).sum(),
            Self::Ackley => {
                let (squares, waves) = (x.iter().map(|v| v * v).sum::<f64>() / n, x.iter().map(|v| (TAU * v).cos()).sum::<f64>() / n);
                (20.0 - 20.0 * (-0.2 * squares.sqrt()).exp() + E - waves.exp()).max(0.0)
            }
            Self::Griewank => {
                let bowl = x.iter().map(|v| v * v).sum::<f64>() / 4000.0;
                let waves: f64 = x.iter().enumerate().map(|(k, v)| (v / (k as f64 + 1.0).sqrt()).cos()).product();
                (bowl - waves + 1.0).max(0.0)
            }
        }
    }

    /// Half the side of its box.
    fn reach(self) -> f64 {
        match self {
            Self::Sphere => 100.0,
            Self::Rosenbrock => 30.0,
            Self::Rastrigin => 5.12,
            Self::Ackley => 32.0,
            Self::Griewank => 600.0,
        }
    }
}

/// A function in its box, its minimum moved by a shift.
#[derive(Debug, Clone, PartialEq)]
pub struct Shifted {
    function: Function,
    /// Empty: not moved.
    shift: Vec<f64>,
    bounds: Vec<(f64, f64)>,
    hints: Vec<Vec<f64>>,
}

impl Shifted {
    /// The function of that many variables as it is.
    pub fn plain(function: Function, dimension: usize) -> Self {
        let reach = function.reach();
        Self::inside(function, vec![(-reach, reach); dimension])
    }

    /// The function as it is in another box.
    pub fn inside(function: Function, bounds: Vec<(f64, f64)>) -> Self {
        Self { function, shift: Vec::new(), bounds, hints: Vec::new() }
    }

    /// The function with its minimum moved by `shift` in the same box.
    pub fn by(function: Function, shift: Vec<f64>) -> Self {
        let plain = Self::plain(function, shift.len());
        Self { shift, ..plain }
    }

    /// The function moved by `share` of half its box, to one side in even variables and to the other in odd ones.
    pub fn aside(function: Function, dimension: usize, share: f64) -> Self {
        let side = |k: usize| if k.is_multiple_of(2) { share } else { -share };
        Self::by(function, (0..dimension).map(|k| side(k) * function.reach()).collect())
    }

    /// With candidates that are known to be good.
    #[must_use]
    pub fn with_hints(self, hints: Vec<Vec<f64>>) -> Self {
        Self { hints, ..self }
    }
}

impl Objective for Shifted {
    fn bounds(&self) -> &[(f64, f64)] {
        &self.bounds
    }

    fn costs(&self, xs: &[Vec<f64>]) -> Result<Vec<Cost>, PlanError> {
        if self.shift.is_empty() {
            return Ok(xs.iter().map(|x| Cost::of(self.function.value(x))).collect());
        }
        let mut moved = vec![0.0; self.shift.len()];
        let value = |x: &Vec<f64>| {
            moved.iter_mut().zip(x).zip(&self.shift).for_each(|((m, v), s)| *m = v - s);
            Cost::of(self.function.value(&moved))
        };
        Ok(xs.iter().map(value).collect())
    }

    fn hints(&self) -> &[Vec<f64>] {
        &self.hints
    }

    /// They take a tenth of a microsecond or so.
    fn effort(&self) -> f64 {
        0.01 * self.bounds.len() as f64
    }
}
