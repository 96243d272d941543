//! What a path is worth: length, turns, turning, clearance, curvature, smoothness, energy.

use super::arc_length::Table;
use super::bspline::Path;
use super::eval::regular;
use crate::world::World;
use crate::world::shape::wrap;
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// Curvature above which a smooth path is turning, 1/m.
pub const TURNING: f64 = 0.05;
/// Dimensionless energy of a cell of travel and of a turn.
pub const ENERGY: [f64; 2] = [1.0, 0.5];
/// Samples per polynomial piece.
const SAMPLES: usize = 24;

/// Measures of a planar path. A cell is the world's resolution.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Metrics {
    /// m.
    pub length: f64,
    /// Corners, plus stretches with curvature above [`TURNING`] that more than a cell of straight travel separates.
    pub turns: usize,
    /// Integral of the absolute curvature, corners included, rad.
    pub total_turning: f64,
    /// Smallest distance of the robot's disc from an obstacle, m; negative in collision, `None` without obstacles.
    pub min_clearance: Option<f64>,
    /// Largest absolute curvature, 1/m; `None` (infinite) where the path has a corner.
    pub max_curvature: Option<f64>,
    /// 1 - mean heading change over windows of one cell / pi: 1 is straight, 0 reverses in every window.
    pub smoothness: f64,
    /// Cells of travel + 0.5 per turn, dimensionless.
    pub energy: f64,
}

/// Measures `path` in `world` for a robot that covers a disc of `radius` (m) around its reference point.
pub fn measure(path: &Path, world: &World, radius: f64) -> Metrics {
    let (cell, corners) = (world.resolution(), path.corners());
    let length = path.length();
    let turns = if path.degree() == 1 { corners.len() } else { turns(path, cell) };
    let clearance = min_clearance(path, world);
    Metrics {
        length,
        turns,
        total_turning: corners.iter().map(|c| c.turn().abs()).sum::<f64>() + bending(path),
        min_clearance: clearance.is_finite().then_some(clearance - radius),
        max_curvature: corners.is_empty().then(|| max_curvature(path)),
        smoothness: smoothness(path, cell),
        energy: ENERGY[0] * length / cell + ENERGY[1] * turns as f64,
    }
}

/// First and second derivatives of the piece at `t`, where it moves.
fn tangent(path: &Path, table: &Table, piece: usize, t: f64) -> [f64; 4] {
    let dim = path.dimension();
    let mut r = vec![0.0; 4 * dim];
    regular(table.piece(piece), dim, t, &mut r);
    [r[dim], r[dim + 1], r[2 * dim], r[2 * dim + 1]]
}

fn curvature(path: &Path, table: &Table, piece: usize, t: f64) -> f64 {
    let [x, y, xx, yy] = tangent(path, table, piece, t);
    let v = x.hypot(y);
    if v > 0.0 { (x * yy - y * xx).abs() / (v * v * v) } else { 0.0 }
}

/// Total turning inside the pieces, rad.
fn bending(path: &Path) -> f64 {
    if path.degree() == 1 {
        return 0.0;
    }
    let table = path.table();
    let heading = |piece: usize, i: usize| {
        let [x, y, ..] = tangent(path, table, piece, i as f64 / SAMPLES as f64);
        y.atan2(x)
    };
    let turned = |piece: usize| (0..SAMPLES).map(move |i| wrap(heading(piece, i + 1) - heading(piece, i)).abs()).sum::<f64>();
    (0..table.spans.len()).map(turned).sum()
}

/// Largest curvature, 1/m: sampled, then every sample that may hide the maximum is refined by golden sections.
fn max_curvature(path: &Path) -> f64 {
    let table = path.table();
    let mut best = 0.0f64;
    if path.degree() == 1 {
        return best;
    }
    for piece in 0..table.spans.len() {
        let at = |t: f64| curvature(path, table, piece, t);
        let samples: Vec<f64> = (0..=SAMPLES).map(|i| at(i as f64 / SAMPLES as f64)).collect();
        for i in 0..=SAMPLES {
            let (before, after) = (samples[i.saturating_sub(1)], samples[(i + 1).min(SAMPLES)]);
            if samples[i] >= before && samples[i] >= after && samples[i] > 0.5 * best {
                let step = 1.0 / SAMPLES as f64;
                let t = i as f64 * step;
                best = best.max(samples[i]).max(-least(|t| -at(t), (t - step).max(0.0), (t + step).min(1.0)));
            }
        }
    }
    best
}

/// Turns of a curve: corners and stretches above [`TURNING`], merged where no more than a cell of straight travel lies between.
fn turns(path: &Path, cell: f64) -> usize {
    let table = path.table();
    let mut bent: Vec<[f64; 2]> = path.corners().iter().map(|c| [c.s, c.s]).collect();
    for piece in 0..table.spans.len() {
        let at: Vec<(f64, bool)> = (0..=SAMPLES)
            .map(|i| i as f64 / SAMPLES as f64)
            .map(|t| (table.length_at(piece, t), curvature(path, table, piece, t) > TURNING))
            .collect();
        bent.extend(at.iter().filter(|(_, turning)| *turning).map(|(s, _)| [*s, *s]));
        bent.extend(at.windows(2).filter(|w| w[0].1 && w[1].1).map(|w| [w[0].0, w[1].0]));
    }
    bent.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let (mut count, mut end) = (0, f64::NEG_INFINITY);
    for [from, to] in bent {
        if from - end > cell {
            count += 1;
        }
        end = end.max(to);
    }
    count
}

/// Smallest distance of the path's points from an obstacle, m: sampled every tenth of a cell, refined around the smallest samples.
fn min_clearance(path: &Path, world: &World) -> f64 {
    let at = |s: f64| world.clearance(path.planar(s).point);
    let step = world.resolution() / 10.0;
    let mut best = at(0.0);
    for w in path.joints().windows(2) {
        let n = ((w[1] - w[0]) / step).ceil().clamp(1.0, 1e6);
        let s = |i: usize| w[0] + (w[1] - w[0]) * (i as f64 / n);
        let samples: Vec<f64> = (0..=n as usize).map(|i| at(s(i))).collect();
        for i in 0..samples.len() {
            let (a, b) = (i.saturating_sub(1), (i + 1).min(samples.len() - 1));
            best = best.min(samples[i]);
            // The distance changes by no more than the way travelled.
            if samples[i] <= samples[a] && samples[i] <= samples[b] && samples[i] - step <= best {
                best = best.min(least(at, s(a), s(b)));
            }
        }
    }
    best
}

/// Least value of `f` in a bracket around one minimum, by golden sections.
fn least(f: impl Fn(f64) -> f64, mut a: f64, mut b: f64) -> f64 {
    let g = (5f64.sqrt() - 1.0) / 2.0;
    let (mut x, mut y) = (b - g * (b - a), a + g * (b - a));
    let (mut fx, mut fy) = (f(x), f(y));
    let mut best = fx.min(fy);
    for _ in 0..40 {
        if fx < fy {
            (b, y, fy) = (y, x, fx);
            x = b - g * (b - a);
            fx = f(x);
        } else {
            (a, x, fx) = (x, y, fy);
            y = a + g * (b - a);
            fy = f(y);
        }
        best = best.min(fx).min(fy);
    }
    best
}

/// 1 - mean absolute heading change between places one cell apart / pi.
fn smoothness(path: &Path, cell: f64) -> f64 {
    let windows = (path.length() / cell * (1.0 + 1e-12)).floor() as usize;
    if windows == 0 {
        return 1.0;
    }
    let headings: Vec<f64> = (0..=windows).map(|k| path.planar(k as f64 * cell).heading).collect();
    1.0 - headings.windows(2).map(|w| wrap(w[1] - w[0]).abs()).sum::<f64>() / (PI * windows as f64)
}
