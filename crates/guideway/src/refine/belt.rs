//! The guide of a smooth path: a belt of tangents and arcs around pulleys, one pulley at each corner of the raw path.
//!
//! A taut path bends exactly at obstacle corners. An arc that is tangent to its legs would cut through them, so the pulley is moved out: its circle
//! goes around the corner on the free side, and the legs become the tangents of neighbouring circles.

use crate::Point;
use crate::world::shape::{cross, distance, dot, norm, sub, wrap};
use std::f64::consts::PI;

/// Way by which an arc passes outside its corner, as a share of its radius: room for the chords of the exported polyline.
const MARGIN: f64 = 1e-3;
/// Largest turn of one knot span on an arc, rad.
const SPAN: f64 = PI / 10.0;
/// Fewest knot spans on an arc.
const SPANS: f64 = 4.0;
/// Sharper turns than this stay corners, rad.
pub(super) const SHARPEST: f64 = 0.95 * PI;

/// Knot spans for an arc of `sweep` rad.
pub(super) fn spans(sweep: f64) -> f64 {
    (sweep / SPAN).ceil().max(SPANS)
}

/// How a corner is rounded.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Mode {
    /// Around the outside of the way points.
    Outside,
    /// Cutting the corner, tangent to its legs.
    Inside,
    /// Exactly through the way point (start, via, goal).
    Through,
}

/// A corner of the raw path, or several that are rounded together.
#[derive(Debug, Clone)]
pub(super) struct Pulley {
    /// Way points of the raw path, m.
    pub contacts: Vec<Point>,
    pub mode: Mode,
    /// Radius of the turn, m; 0 keeps the corner.
    pub radius: f64,
    /// Largest sensible radius, m.
    pub cap: f64,
    /// Signed turn of the raw path, rad.
    pub turn: f64,
    /// Unit vector from the centre of the turn to its apex.
    outward: Point,
}

impl Pulley {
    /// A point that the path starts from, ends at or goes through.
    pub fn point(at: Point, mode: Mode) -> Self {
        Self { contacts: vec![at], mode, radius: 0.0, cap: 0.0, turn: 0.0, outward: [0.0, 0.0] }
    }

    /// Reference point, m.
    pub fn at(&self) -> Point {
        self.contacts[self.contacts.len() / 2]
    }

    /// Sets the turn from the headings (rad) of the legs before and after.
    pub fn face(&mut self, heading_in: f64, heading_out: f64) {
        self.turn = wrap(heading_out - heading_in);
        let middle = heading_in + self.turn / 2.0;
        self.outward = [self.sign() * middle.sin(), -self.sign() * middle.cos()];
    }

    /// 1 for a left turn, -1 for a right turn.
    pub fn sign(&self) -> f64 {
        if self.turn < 0.0 { -1.0 } else { 1.0 }
    }

    /// Centre of the turn, m; `None` if the circle is too small to go around all its way points.
    fn center(&self) -> Option<Point> {
        let (at, r, n) = (self.at(), self.radius, self.outward);
        if r == 0.0 {
            return Some(at);
        }
        let depth = match self.mode {
            Mode::Through => r,
            Mode::Inside => r / (self.turn / 2.0).cos(),
            Mode::Outside => {
                // The spline runs inside its guide by (span length)^2 / (6 r).
                let span = self.turn.abs() / spans(self.turn.abs());
                let inner = r * (1.0 - MARGIN - span * span / 6.0);
                let depths = self.contacts.iter().map(|p| {
                    let v = sub(*p, at);
                    (inner * inner - cross(n, v) * cross(n, v)).max(-1.0).sqrt() - dot(n, v)
                });
                depths.fold(f64::INFINITY, |a, b| if b.is_nan() { b } else { a.min(b) })
            }
        };
        depth.is_finite().then(|| [at[0] - depth * n[0], at[1] - depth * n[1]])
    }
}

/// A straight stretch between two pulleys.
#[derive(Debug, Clone, Copy)]
pub(super) struct Leg {
    pub from: Point,
    pub to: Point,
    pub heading: f64,
}

/// The tangent that leaves `a` and arrives at `b` in their senses of turning.
pub(super) fn tangent(a: &Pulley, b: &Pulley) -> Option<Leg> {
    let (ca, cb) = (a.center()?, b.center()?);
    let (ka, kb) = (a.sign() * a.radius, b.sign() * b.radius);
    let (d, k) = (sub(cb, ca), kb - ka);
    let square = dot(d, d);
    if square <= k * k * (1.0 + 1e-12) || square == 0.0 {
        return None;
    }
    let l = (square - k * k).sqrt();
    let u = [(l * d[0] + k * d[1]) / square, (l * d[1] - k * d[0]) / square];
    let touch = |c: Point, k: f64| [c[0] + k * u[1], c[1] - k * u[0]];
    Some(Leg { from: touch(ca, ka), to: touch(cb, kb), heading: u[1].atan2(u[0]) })
}

/// One stretch of the guide.
#[derive(Debug, Clone, Copy)]
pub(super) enum Form {
    /// From a point along a unit direction.
    Line { from: Point, along: Point },
    /// Around a centre; `radius` is signed, positive to the left.
    Arc { center: Point, radius: f64, heading: f64 },
}

/// A stretch with its arc length on the guide, m.
#[derive(Debug, Clone, Copy)]
pub(super) struct Part {
    pub form: Form,
    pub start: f64,
    pub length: f64,
    /// Pulley that the arc is around, or that the line leaves.
    pub pulley: usize,
}

impl Part {
    /// Point at distance `x` from its start, m.
    pub fn at(&self, x: f64) -> Point {
        match self.form {
            Form::Line { from, along } => [from[0] + x * along[0], from[1] + x * along[1]],
            Form::Arc { center, radius, heading } => {
                let (s, c) = (heading + x / radius).sin_cos();
                [center[0] + radius * s, center[1] - radius * c]
            }
        }
    }
}

/// Tangents and arcs, and the places that need care.
#[derive(Debug, Default)]
pub(super) struct Guide {
    pub parts: Vec<Part>,
    /// Corners that stay: arc length (m) and point (m).
    pub corners: Vec<(f64, Point)>,
    /// Points to go through: arc length (m) and point (m).
    pub through: Vec<(f64, Point)>,
    pub ends: [Point; 2],
    pub length: f64,
}

impl Guide {
    fn push(&mut self, form: Form, length: f64, pulley: usize) {
        if length > 0.0 {
            self.parts.push(Part { form, start: self.length, length, pulley });
            self.length += length;
        }
    }

    /// The belt around `chain`. `open` tells for either end that the chain goes on there: the guide then starts or ends in the middle of the leg.
    /// On failure the index of a pulley that must shrink together with its neighbours.
    pub fn around(chain: &[Pulley], open: [bool; 2]) -> Result<Self, usize> {
        let mut legs = Vec::with_capacity(chain.len());
        for (i, pair) in chain.windows(2).enumerate() {
            legs.push(tangent(&pair[0], &pair[1]).ok_or(i)?);
        }
        let Some(last) = legs.len().checked_sub(1) else { return Err(0) };
        let middle = |leg: &Leg| [f64::midpoint(leg.from[0], leg.to[0]), f64::midpoint(leg.from[1], leg.to[1])];
        if open[0] {
            legs[0].from = middle(&legs[0]);
        }
        if open[1] {
            legs[last].to = middle(&legs[last]);
        }
        let mut guide = Self { ends: [legs[0].from, legs[last].to], ..Self::default() };
        for (i, leg) in legs.iter().enumerate() {
            let (s, c) = leg.heading.sin_cos();
            guide.push(Form::Line { from: leg.from, along: [c, s] }, distance(leg.from, leg.to), i);
            if i < last {
                guide.join(&chain[i + 1], i + 1, leg.heading, legs[i + 1].heading)?;
            }
        }
        Ok(guide)
    }

    /// Adds the arc or the corner between two legs.
    fn join(&mut self, pulley: &Pulley, index: usize, heading_in: f64, heading_out: f64) -> Result<(), usize> {
        let turn = wrap(heading_out - heading_in);
        if pulley.radius == 0.0 {
            if turn.abs() > 1e-9 {
                self.corners.push((self.length, pulley.at()));
            }
            return Ok(());
        }
        let sweep = pulley.sign() * turn;
        if !(-1e-9..=SHARPEST).contains(&sweep) {
            return Err(index); // the belt runs past the pulley, or nearly back on itself
        }
        let Some(center) = pulley.center() else { return Err(index) };
        if pulley.mode == Mode::Through {
            let (sign, n) = (pulley.sign(), pulley.outward);
            let apex = sign * wrap((sign * n[0]).atan2(-sign * n[1]) - heading_in);
            if !(apex > 0.0 && apex < sweep) {
                return Err(index);
            }
            self.through.push((self.length + apex * pulley.radius, pulley.at()));
        }
        self.push(Form::Arc { center, radius: pulley.sign() * pulley.radius, heading: heading_in }, sweep.max(0.0) * pulley.radius, index);
        Ok(())
    }

    /// Point at arc length `s`, m.
    pub fn at(&self, s: f64) -> Point {
        let i = self.parts.partition_point(|part| part.start <= s).max(1) - 1;
        self.parts.get(i).map_or(self.ends[0], |part| part.at((s - part.start).clamp(0.0, part.length)))
    }
}

/// Heading from `a` to `b`, rad.
pub(super) fn heading(a: Point, b: Point) -> f64 {
    let v = sub(b, a);
    if norm(v) > 0.0 { v[1].atan2(v[0]) } else { 0.0 }
}
