//! Smoothing with a proof: straight legs, generous bends, continuous curvature, no collision.
//!
//! The path is simplified, every corner becomes a pulley with the largest radius that fits, the belt around the pulleys becomes one cubic B-spline,
//! and each piece of it is proved free by the hull property.

use super::arcs::coarse;
use super::belt::{Mode, Pulley, heading, spans};
use super::fit::Fit;
use super::simplify::Simplify;
use super::{Refined, Refiner};
use crate::Point;
use crate::context::Context;
use crate::error::PlanError;
use crate::path::Path;
use crate::query::Query;
use crate::world::shape::{distance, wrap};
use serde::{Deserialize, Serialize};

/// Smooths a path into one clamped cubic B-spline with continuous curvature that is proved free of collision.
///
/// Source: arcs of the largest feasible radius, control points on legs and arcs, hull checks with subdivision, as usual for paths on grids; the spline
/// is the variation-diminishing one of \[deboor1978\], chapter XI.
/// Departures: the arcs go around the outside of corners that the path touches, so taut paths can be smoothed; near corners share one bend; knots are
/// not uniform, so that long legs stay straight. Where nothing fits a corner stays (a triple knot): the robot turns in place there, and `unmet` says so.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Smooth {
    /// Largest curvature, 1/m; met where there is room, else reported. `None`: as gentle as `stretch` and the room allow.
    pub max_curvature: Option<f64>,
    /// Length that a bend may add, as a share of its two legs; one around several corners or through a via point three times that. 0.01 lengthens a taut path by about
    /// half a per cent.
    pub stretch: f64,
    /// Bends with a smaller radius stay corners, cells. Turning in place is quicker than creeping around such a bend.
    pub smallest: f64,
}

/// Share of a leg that its bends may take where the limit on the curvature asks for it.
const WHOLE: f64 = 0.999;
/// Factor on the radius that the limit asks for.
const SPARE: f64 = 1.002;

/// Largest radius as a multiple of the legs: wider bends are straight for all purposes and reach too far.
const WIDEST: f64 = 2.0;
/// A bend around several corners, or through a via point, may add this much more than one around a single corner: the tight bends or the stop that it replaces
/// are worth it.
const GENEROUS: f64 = 3.0;

impl Default for Smooth {
    fn default() -> Self {
        Self { max_curvature: None, stretch: 0.01, smallest: 0.02 }
    }
}

impl Refiner for Smooth {
    fn refine(&self, path: &Path, query: &Query, ctx: &mut Context) -> Result<Refined, PlanError> {
        self.validate()?;
        let coarse = (path.degree() == 1).then(|| Path::polyline(&coarse(path.points(), query)));
        let points = distinct(Simplify::default().points(coarse.as_ref().unwrap_or(path), query));
        if points.len() < 2 {
            return Ok(Refined { path: path.clone(), unmet: Vec::new() });
        }
        let mut fit = Fit::new(*self, query, self.chain(&points, query));
        fit.settle()?;
        for pass in 0..2 {
            if ctx.poll().is_some() {
                break;
            }
            fit.grow();
            if pass == 0 {
                fit.merge();
            }
        }
        let (path, given) = fit.settle()?;
        let unmet = self.unmet(&path, &given, query);
        Ok(Refined { path, unmet })
    }
}

impl Smooth {
    fn validate(&self) -> Result<(), PlanError> {
        if let Some(k) = self.max_curvature
            && !(k.is_finite() && (1e-6..=1e6).contains(&k))
        {
            return Err(PlanError::bad("max_curvature", k, "1e-6 to 1e6 per m"));
        }
        if !(self.stretch.is_finite() && (0.0..=1.0).contains(&self.stretch)) {
            return Err(PlanError::bad("stretch", self.stretch, "0 to 1 (share of the leg's length)"));
        }
        if !(self.smallest.is_finite() && (1e-6..=1e3).contains(&self.smallest)) {
            return Err(PlanError::bad("smallest", self.smallest, "1e-6 to 1000 cells"));
        }
        Ok(())
    }

    /// Largest sensible radius, m, of a bend by `turn` rad (`single`: at one way point) between legs of which lengths `room` (m) are its own.
    pub(super) fn cap(&self, turn: f64, room: [f64; 2], single: bool) -> f64 {
        let turn = turn.abs().max(1e-9);
        let reach = if single { (turn / 2.0).tan() } else { 2.0 * (turn / 4.0).tan() };
        let fits = room[0].min(room[1]) / reach;
        let added = turn - 2.0 * (turn / 2.0).sin(); // length per radius that a bend around the outside adds
        let cheap = self.stretch * (room[0] + room[1]) / added.max(1e-300);
        let wanted = self.max_curvature.map_or(0.0, |k| 1.1 / k);
        cheap.max(wanted).min(fits).min(WIDEST * (room[0] + room[1]))
    }

    /// Radius (m) with which a bend by `turn` rad keeps the limit: an arc of few knot spans is a little tighter than its circle.
    pub(super) fn wanted(&self, turn: f64, fine: f64) -> Option<f64> {
        let span = turn.abs() / spans(turn.abs(), fine);
        self.max_curvature.map(|k| SPARE * 2.0 / (k * (1.0 + span.cos())))
    }

    /// Length (m) of the leg from way point `i` to its neighbour `j` that belongs to the bend at `i`. Half of it, unless the limit asks for more than that at one
    /// of its ends, and the leg is long enough for both.
    fn room(&self, points: &[(Point, bool)], [i, j]: [usize; 2]) -> f64 {
        let alone = j == 0 || j + 1 == points.len();
        let length = distance(points[i].0, points[j].0);
        let half = room(length, alone);
        let Some(limit) = self.max_curvature else { return half };
        let tangent = |k: usize| {
            let [a, b, c] = [points[k - 1].0, points[k].0, points[k + 1].0];
            (wrap(heading(b, c) - heading(a, b)).abs() / 2.0).tan() / limit
        };
        let (own, other) = (tangent(i), if alone { 0.0 } else { tangent(j) });
        let rest = WHOLE * length - own - other;
        match (own.max(other) > half, rest >= 0.0) {
            (true, true) if alone => WHOLE * length,
            (true, true) => own + rest / 2.0,
            _ => half,
        }
    }

    /// The same with room for bends that replace more than a corner.
    pub(super) fn generous(&self) -> Self {
        Self { stretch: GENEROUS * self.stretch, ..*self }
    }

    /// One pulley per way point.
    fn chain(&self, points: &[(Point, bool)], query: &Query) -> Vec<Pulley> {
        let last = points.len() - 1;
        let mut chain: Vec<Pulley> = points.iter().map(|(p, fixed)| Pulley::point(*p, if *fixed { Mode::Through } else { Mode::Outside })).collect();
        for i in 1..last {
            let [a, b, c] = [points[i - 1].0, points[i].0, points[i + 1].0];
            let (heading_in, heading_out) = (heading(a, b), heading(b, c));
            let pulley = &mut chain[i];
            pulley.face(heading_in, heading_out);
            if pulley.mode == Mode::Through {
                // A corner at first; it bends once its neighbours lie.
                continue;
            }
            pulley.cap = self.cap(pulley.turn, [self.room(points, [i, i - 1]), self.room(points, [i, i + 1])], true);
            pulley.radius = pulley.cap;
            // A corner that can be cut is not taut.
            let step = (0.4 * distance(a, b).min(distance(b, c))).min(0.5 * query.world.resolution().max(query.radius()));
            let near = |h: f64, d: f64| [b[0] + d * h.cos(), b[1] + d * h.sin()];
            if query.world.segment_free(near(heading_in, -step), near(heading_out, step), query.radius()) {
                pulley.mode = Mode::Inside;
            }
        }
        chain
    }

    /// What could not be met, in words: corners, curvature above the limit, raw legs that are no better than the planner gave them.
    fn unmet(&self, path: &Path, given: &[[Point; 2]], query: &Query) -> Vec<String> {
        let mut unmet: Vec<String> = given
            .iter()
            .map(|[a, b]| {
                format!("the leg from ({:.3}, {:.3}) to ({:.3}, {:.3}) is as planned: it is not free for a robot that slides", a[0], a[1], b[0], b[1])
            })
            .collect();
        for corner in path.corners() {
            let [x, y] = path.planar(corner.s).point;
            let what = if query.via.iter().any(|v| distance(*v, [x, y]) < 1e-6) { "via point " } else { "" };
            unmet.push(format!("no room for a bend at {what}({x:.3}, {y:.3}): turn in place by {:.1} degrees", corner.turn().to_degrees()));
        }
        if let Some(limit) = self.max_curvature {
            let peaks = peaks(path, limit).into_iter();
            unmet.extend(peaks.map(|([x, y], k)| format!("curvature {k:.3} 1/m at ({x:.3}, {y:.3}) is above {limit} 1/m: no room for a wider bend")));
        }
        unmet
    }
}

/// Share of a leg that belongs to the bend at one of its ends.
pub(super) fn room(length: f64, alone: bool) -> f64 {
    length * if alone { 0.95 } else { 0.48 }
}

/// Without repeated points and without way points on a straight line.
fn distinct(points: Vec<(Point, bool)>) -> Vec<(Point, bool)> {
    let span = points.iter().map(|p| distance(p.0, points[0].0)).fold(0.0, f64::max);
    let mut kept: Vec<(Point, bool)> = Vec::with_capacity(points.len());
    for p in points {
        match kept.last_mut() {
            Some(q) if distance(p.0, q.0) <= 1e-9 * span => *q = (if q.1 { q.0 } else { p.0 }, p.1 || q.1),
            _ => kept.push(p),
        }
    }
    let straight = |i: usize| {
        let [a, b, c] = [kept[i - 1].0, kept[i].0, kept[i + 1].0];
        wrap(heading(b, c) - heading(a, b)).abs() < 1e-9
    };
    let last = kept.len() - 1;
    (0..kept.len()).filter(|&i| i == 0 || i == last || kept[i].1 || !straight(i)).map(|i| kept[i]).collect()
}

/// Places (m) and values (1/m) of the curvature maxima above `limit`, one per stretch above it.
pub(super) fn peaks(path: &Path, limit: f64) -> Vec<(Point, f64)> {
    let mut peaks: Vec<(Point, f64)> = Vec::new();
    let mut above = false;
    for w in path.joints().windows(2) {
        for i in 0..24 {
            let place = path.planar(w[0] + (w[1] - w[0]) * f64::from(i) / 24.0);
            let k = place.curvature.abs();
            let over = k > limit * (1.0 + 1e-6);
            match peaks.last_mut() {
                Some(peak) if over && above && k > peak.1 => *peak = (place.point, k),
                _ if over && !above => peaks.push((place.point, k)),
                _ => {}
            }
            above = over;
        }
    }
    peaks
}
