//! What a straight leg costs: its length, weighed by the soft clearance where the query asks for one.

use crate::Point;
use crate::query::{Query, Soft};
use crate::world::shape::distance;
use crate::world::{ClearanceField, Lattice};
use std::sync::Arc;

/// Samples of a leg, per cell.
const SAMPLES: f64 = 2.0;

/// The cost of legs.
pub(super) struct Metric {
    soft: Option<(Soft, Arc<Lattice>, Arc<ClearanceField>)>,
}

impl Metric {
    pub fn of(query: &Query) -> Self {
        Self { soft: query.soft.map(|soft| (soft, query.world.lattice(query.radius()), query.world.clearance_field())) }
    }

    /// Cost of the leg from `a` to `b`, m of open ground: by the clearance of the cells that evenly spaced samples lie in.
    pub fn cost(&self, a: Point, b: Point) -> f64 {
        let length = distance(a, b);
        let Some((soft, lattice, field)) = &self.soft else { return length };
        let count = (length / lattice.resolution() * SAMPLES).ceil().max(1.0) as u32;
        let price = |k: u32| {
            let t = (f64::from(k) + 0.5) / f64::from(count);
            let cell = lattice.cell_at([a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])]);
            cell.map_or(1.0 + soft.weight, |c| soft.price(field.at(c) - lattice.radius()))
        };
        length * (0..count).map(price).sum::<f64>() / f64::from(count)
    }

    /// Cost from the first way point to each, m of open ground.
    pub fn along(&self, way: &[Point]) -> Vec<f64> {
        let mut costs = vec![0.0; way.len()];
        for i in 1..way.len() {
            costs[i] = costs[i - 1] + self.cost(way[i - 1], way[i]);
        }
        costs
    }
}
