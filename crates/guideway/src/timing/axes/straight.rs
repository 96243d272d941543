//! Phase synchronisation: all axes on one straight line, as one axis under the tightest of all limits.

use super::{Axis, AxisGoal, AxisLimits, AxisState};

/// Relative mismatch up to which vectors count as parallel.
const PARALLEL: f64 = 1e-12;

/// The motion along the line, in units of the axis that moves most, and the share of each axis in it.
pub(super) struct Straight {
    pub(super) axis: Axis,
    pub(super) shares: Vec<f64>,
}

impl Straight {
    /// `None` if states and goals do not lie on one line, or some goals have positions and others do not.
    pub(super) fn new(axes: &[&Axis]) -> Option<Self> {
        let placed = axes.first()?.goal.position.is_some();
        if axes.iter().any(|a| a.goal.position.is_some() != placed) {
            return None;
        }
        let way = |a: &Axis| a.goal.position.map_or(0.0, |p| p - a.start.position);
        let vectors: [Vec<f64>; 5] = [
            axes.iter().map(|a| way(a)).collect(),
            axes.iter().map(|a| a.start.velocity).collect(),
            axes.iter().map(|a| a.goal.velocity).collect(),
            axes.iter().map(|a| a.start.acceleration).collect(),
            axes.iter().map(|a| a.goal.acceleration).collect(),
        ];
        let along = vectors.iter().find(|v| v.iter().any(|x| *x != 0.0))?;
        let lead = (0..axes.len()).max_by(|i, k| along[*i].abs().total_cmp(&along[*k].abs()))?;
        let shares: Vec<f64> = along.iter().map(|x| x / along[lead]).collect();
        let parallel = |v: &Vec<f64>| {
            let size = v.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
            v.iter().zip(&shares).all(|(x, share)| (x - v[lead] * share).abs() <= PARALLEL * size)
        };
        if !vectors.iter().all(parallel) {
            return None;
        }
        let goal = AxisGoal {
            position: placed.then_some(axes[lead].start.position + vectors[0][lead]),
            velocity: vectors[2][lead],
            acceleration: vectors[4][lead],
        };
        let start = AxisState { position: axes[lead].start.position, velocity: vectors[1][lead], acceleration: vectors[3][lead] };
        Some(Self { axis: Axis { start, goal, limits: tightest(axes, &shares), enabled: true }, shares })
    }
}

/// The limits of all axes as limits of the motion along the line.
fn tightest(axes: &[&Axis], shares: &[f64]) -> AxisLimits {
    let mut all = AxisLimits { velocity: (f64::NEG_INFINITY, f64::INFINITY), acceleration: (f64::NEG_INFINITY, f64::INFINITY), jerk: f64::INFINITY };
    let cut = |range: (f64, f64), by: (f64, f64), share: f64| {
        let (x, y) = (by.0 / share, by.1 / share);
        (range.0.max(x.min(y)), range.1.min(x.max(y)))
    };
    for (axis, &share) in axes.iter().zip(shares).filter(|(_, share)| **share != 0.0) {
        all.velocity = cut(all.velocity, axis.limits.velocity, share);
        all.acceleration = cut(all.acceleration, axis.limits.acceleration, share);
        all.jerk = all.jerk.min(axis.limits.jerk / share.abs());
    }
    all
}
