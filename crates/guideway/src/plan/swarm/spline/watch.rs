//! What pictures show of a search: candidates of some generations.

use super::curves::Curves;
use crate::Point;
use crate::error::PlanError;
use crate::optimize::{Cost, Minimum, Objective};
use serde_json::{Value, json};
use std::sync::{Mutex, PoisonError};

/// Generations that are shown (and the last one), paths of each, and points of a path at most.
const SHOWN: [usize; 3] = [7, 40, 100];

/// The objective, keeping the candidates of generations 1, 2, 5, 10, 20, 50 and 100.
///
/// Optimizers ask for what is shown of the best cost once at the end of each iteration, in the thread that runs the loop: that is how generations are
/// told apart. The first one holds the first population as well.
pub(in crate::plan::swarm) struct Watch<'a> {
    curves: &'a Curves,
    seen: Mutex<Seen>,
}

#[derive(Default)]
struct Seen {
    generation: u64,
    batch: Vec<(Cost, Vec<f64>)>,
    kept: Vec<(u64, Vec<Vec<f64>>)>,
}

fn shown(generation: u64) -> bool {
    let mut leading = generation;
    while leading >= 10 && leading.is_multiple_of(10) {
        leading /= 10;
    }
    matches!(leading, 1 | 2 | 5)
}

impl<'a> Watch<'a> {
    pub fn new(curves: &'a Curves) -> Self {
        Self { curves, seen: Mutex::new(Seen { generation: 1, ..Seen::default() }) }
    }

    fn seen(&self) -> std::sync::MutexGuard<'_, Seen> {
        self.seen.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The population over generations, at the end that which the search was left with.
    pub fn picture(self, left: &Minimum) -> Value {
        let mut seen = self.seen.into_inner().unwrap_or_else(PoisonError::into_inner);
        let last = seen.generation - 1;
        if seen.kept.last().is_some_and(|(generation, _)| *generation < last) {
            let population = left.costs.iter().copied().zip(left.population.iter().cloned()).collect();
            seen.kept.push((last, best_first(population)));
        }
        let paths = |xs: Vec<Vec<f64>>| xs.iter().map(|x| points(self.curves, x)).collect::<Vec<_>>();
        seen.kept.into_iter().map(|(g, xs)| json!({ "generation": g, "paths": paths(xs) })).collect()
    }
}

/// The best candidates in order, no more than are shown. Ties are broken by the numbers: threads hand in their parts in any order.
fn best_first(mut batch: Vec<(Cost, Vec<f64>)>) -> Vec<Vec<f64>> {
    batch.sort_by(|a, b| a.0.order(b.0).then_with(|| a.1.partial_cmp(&b.1).unwrap_or(std::cmp::Ordering::Equal)));
    batch.truncate(SHOWN[1]);
    batch.into_iter().map(|b| b.1).collect()
}

/// Some points of a candidate's curve, m.
pub(in crate::plan::swarm) fn points(curves: &Curves, x: &[f64]) -> Vec<Point> {
    curves.chain(x, SHOWN[2])
}

impl Objective for Watch<'_> {
    fn bounds(&self) -> &[(f64, f64)] {
        self.curves.bounds()
    }

    fn costs(&self, xs: &[Vec<f64>]) -> Result<Vec<Cost>, PlanError> {
        let costs = self.curves.costs(xs)?;
        let mut seen = self.seen();
        if shown(seen.generation) && seen.kept.len() < SHOWN[0] {
            seen.batch.extend(costs.iter().copied().zip(xs.iter().cloned()));
        }
        Ok(costs)
    }

    fn hints(&self) -> &[Vec<f64>] {
        self.curves.hints()
    }

    fn effort(&self) -> f64 {
        self.curves.effort()
    }

    fn shown(&self, cost: Cost) -> f64 {
        let mut seen = self.seen();
        let generation = seen.generation;
        seen.generation += 1;
        let batch = std::mem::take(&mut seen.batch);
        if !batch.is_empty() {
            seen.kept.push((generation, best_first(batch)));
        }
        self.curves.shown(cost)
    }
}
