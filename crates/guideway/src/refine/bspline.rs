//! A cubic B-spline whose control points are the cells of a path.
//!
//! Source: \[han2024\], smoothing for heavy loads; the spline is that of \[deboor1978\], chapter IX: clamped, uniform knots, cubic. A B-spline is never longer than
//! its control polygon (variation diminishing), and each piece lies in the convex hull of four control points in a row.
//! Departures: the source does not say what happens where the spline meets an obstacle. Here each piece is proved free by its hull, subdivided where that does not
//! decide; where it fails the control point that pulls the curve away from the path is repeated, which draws the curve nearer (twice) or
//! through it (three times: the robot turns in place there). Via points are passed exactly.

use super::cells::stations;
use super::chords::prove;
use super::{Refined, Refiner};
use crate::Point;
use crate::context::Context;
use crate::error::PlanError;
use crate::path::Path;
use crate::query::Query;
use crate::world::shape::{cross, distance, dot, sub};
use serde::{Deserialize, Serialize};

/// Largest number of times that a control point counts: then the curve passes through it.
const MOST: u8 = 3;
/// Most control points; longer paths get them farther apart.
const POINTS: f64 = 20_000.0;

/// The clamped uniform cubic B-spline over all cells of a lattice path, or of other paths over their way points and points a cell apart between them. Proved
/// free, never longer than the path.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct BSpline {
    /// Distance of control points, cells; above 1 they lie evenly along the path instead, and the spline is gentler and keeps less to the path.
    pub spacing: f64,
}

impl Default for BSpline {
    fn default() -> Self {
        Self { spacing: 1.0 }
    }
}

impl Refiner for BSpline {
    fn refine(&self, path: &Path, query: &Query, ctx: &mut Context) -> Result<Refined, PlanError> {
        if !(self.spacing.is_finite() && (1e-3..=1e6).contains(&self.spacing)) {
            return Err(PlanError::bad("spacing", self.spacing, "0.001 to 1e6 cells"));
        }
        if path.degree() != 1 || path.length() <= 0.0 {
            return Ok(Refined { path: path.clone(), unmet: Vec::new() });
        }
        let mut control = self.control(path, query);
        let radius = query.radius();
        loop {
            let (curve, middles) = spline(&control)?;
            let failed: Vec<f64> = curve.beziers().iter().filter_map(|piece| prove(piece, &query.world, radius).err()).collect();
            let mut blamed: Vec<usize> = failed.iter().filter_map(|u| blame(&control, &middles, *u)).collect();
            blamed.dedup();
            if blamed.is_empty() || ctx.poll().is_some() {
                let unmet = unmet(&curve, failed.len());
                return Ok(Refined { path: if failed.is_empty() { curve } else { path.clone() }, unmet });
            }
            for i in blamed {
                control[i].times += 1;
            }
        }
    }
}

/// A control point and how often it counts.
#[derive(Debug, Clone, Copy)]
struct Control {
    at: Point,
    times: u8,
    /// The path turns here.
    bent: bool,
}

impl BSpline {
    fn control(self, path: &Path, query: &Query) -> Vec<Control> {
        let lattice = query.world.lattice(query.radius());
        let spacing = (self.spacing * query.world.resolution()).max(path.length() / POINTS);
        let points = match stations(path, query, &lattice) {
            _ if self.spacing > 1.0 => even(path, query, spacing),
            Some(stations) => stations.into_iter().map(|s| s.point).collect(),
            None => spaced(&path.points(), spacing),
        };
        let mut points: Vec<Point> = points;
        points.dedup();
        let points = at_least_four(points);
        let last = points.len() - 1;
        let bent = |i: usize| i > 0 && i < last && turns(points[i - 1], points[i], points[i + 1]);
        let mut control: Vec<Control> = (0..=last).map(|i| Control { at: points[i], times: 1, bent: bent(i) }).collect();
        for i in 1..last {
            let on_a_leg = (i.saturating_sub(1)..=(i + 1).min(last)).all(|k| !control[k].bent);
            if !on_a_leg && query.via.iter().any(|via| distance(*via, points[i]) < 1e-9) {
                control[i].times = MOST;
            }
        }
        control
    }
}

fn turns(a: Point, b: Point, c: Point) -> bool {
    let (u, v) = (sub(b, a), sub(c, b));
    dot(u, v) <= 0.0 || cross(u, v).abs() > 1e-9 * dot(u, v)
}

/// The way points with others between them, evenly on every leg.
fn spaced(points: &[Point], spacing: f64) -> Vec<Point> {
    let mut out = vec![points[0]];
    for w in points.windows(2) {
        let n = (distance(w[0], w[1]) / spacing).round().max(1.0) as u32;
        out.extend((1..=n).map(|k| f64::from(k) / f64::from(n)).map(|t| [0, 1].map(|d| w[0][d] + t * (w[1][d] - w[0][d]))));
    }
    out
}

/// Points evenly along the path, via points among them.
fn even(path: &Path, query: &Query, spacing: f64) -> Vec<Point> {
    let mut stops = vec![0.0];
    for via in &query.via {
        let from = stops[stops.len() - 1];
        stops.push(path.project(*via, from, path.length() - from).0);
    }
    stops.push(path.length());
    let mut out = vec![path.point(0)];
    for w in stops.windows(2) {
        let n = ((w[1] - w[0]) / spacing).round().max(1.0) as u32;
        out.extend((1..=n).map(|k| path.planar(w[0] + (w[1] - w[0]) * f64::from(k) / f64::from(n)).point));
    }
    let last = out.len() - 1;
    out[last] = path.point(path.count() - 1);
    out
}

/// Middles of the longest legs are added until there are enough points for a cubic.
fn at_least_four(mut points: Vec<Point>) -> Vec<Point> {
    while points.len() < 4 {
        let longest = (1..points.len()).max_by(|a, b| distance(points[a - 1], points[*a]).total_cmp(&distance(points[b - 1], points[*b])));
        let Some(i) = longest else { break };
        points.insert(i, [0, 1].map(|d| f64::midpoint(points[i - 1][d], points[i][d])));
    }
    points
}

/// The spline, and the knot parameter at which each control point pulls most. A point that counts three times ends one clamped spline and begins the next:
/// together they are one with a triple knot there, which evaluates better than a point that is repeated. Other knots are 0, 1, 2 ...
fn spline(control: &[Control]) -> Result<(Path, Vec<f64>), PlanError> {
    let last = control.len() - 1;
    let ends: Vec<usize> = (0..=last).filter(|&i| i == 0 || i == last || control[i].times == MOST).collect();
    let (mut points, mut knots, mut middles, mut offset) = (vec![control[0].at], vec![0.0; 4], vec![0.0], 0.0);
    for w in ends.windows(2) {
        let mut section = vec![control[w[0]].at];
        for (i, c) in control.iter().enumerate().take(w[1] + 1).skip(w[0] + 1) {
            let times = if i == w[1] { 1 } else { c.times };
            middles.push(offset + section.len() as f64 - 1.0 + f64::from(times - 1) / 2.0);
            section.extend(std::iter::repeat_n(c.at, usize::from(times)));
        }
        let section = at_least_four(section);
        let spans = section.len() - 3;
        points.extend_from_slice(&section[1..]);
        knots.extend((1..spans).map(|k| offset + k as f64));
        offset += spans as f64;
        knots.extend([offset; 3]);
    }
    knots.push(offset);
    Ok((Path::new(3, 2, knots, points.concat())?, middles))
}

/// The control point to blame for a curve that is not free at knot parameter `u`: the nearest at which the path turns, if it pulls there, else the nearest
/// of all. `None` if every one counts three times.
fn blame(control: &[Control], middles: &[f64], u: f64) -> Option<usize> {
    let off = |i: usize| (middles[i] - u).abs();
    let may = (1..control.len().saturating_sub(1)).filter(|&i| control[i].times < MOST);
    may.min_by(|&a, &b| {
        let rank = |i: usize| !(control[i].bent && off(i) < 2.0 + f64::from(control[i].times));
        rank(a).cmp(&rank(b)).then(off(a).total_cmp(&off(b)))
    })
}

fn unmet(curve: &Path, failed: usize) -> Vec<String> {
    if failed > 0 {
        return vec!["no spline over these cells is proved free; the path is as planned".into()];
    }
    let corner = |c: crate::path::Corner| {
        let [x, y] = curve.planar(c.s).point;
        format!("no room for a bend at ({x:.3}, {y:.3}): turn in place by {:.1} degrees", c.turn().to_degrees())
    };
    curve.corners().into_iter().map(corner).collect()
}

#[cfg(test)]
mod tests;
