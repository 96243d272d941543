//! The guide of a smooth path: a belt of tangents and arcs around pulleys, one pulley at each corner of the raw path.
//!
//! A taut path bends exactly at obstacle corners. An arc that is tangent to its legs would cut through them, so the pulley is moved out: its circle
//! goes around the corner on the free side, and the legs become the tangents of neighbouring circles.

use crate::Point;
use crate::world::shape::{cross, distance, dot, norm, sub, wrap};
use std::f64::consts::{PI, TAU};

/// Way by which an arc passes outside its corner, as a share of its height over its chord: room for the chords of the exported polyline.
const MARGIN: f64 = 0.01;
/// Largest turn of one knot span on an arc, rad.
const SPAN: f64 = PI / 10.0;
/// Fewest knot spans on an arc.
const SPANS: f64 = 4.0;
/// Sharper turns than this stay corners, rad.
pub(super) const SHARPEST: f64 = 0.95 * PI;
/// Largest sweep of an arc through a via point, rad: there the robot may turn round in a loop.
const LOOP: f64 = 1.6 * PI;

/// Knot spans for an arc of `sweep` rad, `fine` times as many as usual.
pub(super) fn spans(sweep: f64, fine: f64) -> f64 {
    fine * (sweep / SPAN).ceil().max(SPANS)
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
    /// The belt must not pass over it.
    pub held: bool,
    /// Factor on its number of knot spans: with short ones the bend begins and ends near its arc.
    pub fine: f64,
    /// It turns the other way round, by more than half a turn.
    pub round: bool,
    /// Unit vector from the centre of the turn to its apex.
    outward: Point,
}

impl Pulley {
    /// A point that the path starts from, ends at or goes through.
    pub fn point(at: Point, mode: Mode) -> Self {
        Self { contacts: vec![at], mode, radius: 0.0, cap: 0.0, turn: 0.0, held: false, fine: 1.0, round: false, outward: [0.0, 0.0] }
    }

    /// Mean of its way points, m.
    pub fn at(&self) -> Point {
        let n = self.contacts.len() as f64;
        [0, 1].map(|d| self.contacts.iter().map(|p| p[d]).sum::<f64>() / n)
    }

    /// Sets the turn from the headings (rad) of the legs before and after.
    pub fn face(&mut self, heading_in: f64, heading_out: f64) {
        self.turn = wrap(heading_out - heading_in);
        if self.round {
            self.turn -= TAU.copysign(self.turn);
        }
        let middle = heading_in + self.turn / 2.0;
        self.outward = [self.sign() * middle.sin(), -self.sign() * middle.cos()];
    }

    /// May the belt pass over it, as number `k` of `n` on the belt?
    fn may_slip(&self, k: usize, n: usize) -> bool {
        k > 0 && k + 1 < n && self.mode != Mode::Through && !self.held
    }

    /// 1 for a left turn, -1 for a right turn.
    pub fn sign(&self) -> f64 {
        if self.turn < 0.0 { -1.0 } else { 1.0 }
    }

    /// The circle of a turn by `sweep` rad; `None` if it is too small to go around all its way points.
    pub fn wheel(&self, sweep: f64) -> Option<Wheel> {
        let (at, r, n) = (self.at(), self.radius, self.outward);
        let depth = match self.mode {
            _ if r == 0.0 => 0.0,
            Mode::Through => r,
            Mode::Inside => r / (self.turn / 2.0).cos(),
            Mode::Outside => {
                // The spline runs inside its guide by (span length)^2 / (6 r), and the chords inside the spline.
                let span = sweep / spans(sweep, self.fine);
                let inner = r * (1.0 - 1e-7 - MARGIN * (1.0 - (sweep / 2.0).cos()) - span * span / 6.0);
                let mut depth = f64::INFINITY;
                for p in &self.contacts {
                    let v = sub(*p, at);
                    let square = inner * inner - cross(n, v) * cross(n, v);
                    if square < 0.0 {
                        return None;
                    }
                    depth = depth.min(square.sqrt() - dot(n, v));
                }
                depth
            }
        };
        depth.is_finite().then(|| Wheel { center: [at[0] - depth * n[0], at[1] - depth * n[1]], radius: self.sign() * r })
    }
}

/// A circle with a sense of turning.
#[derive(Debug, Clone, Copy)]
pub(super) struct Wheel {
    center: Point,
    /// Signed, positive to the left, m.
    radius: f64,
}

/// A straight stretch between two pulleys.
#[derive(Debug, Clone, Copy)]
pub(super) struct Leg {
    pub from: Point,
    pub to: Point,
    pub heading: f64,
}

/// The tangent that leaves `a` and arrives at `b` in their senses of turning.
pub(super) fn tangent(a: Wheel, b: Wheel) -> Option<Leg> {
    let (d, k) = (sub(b.center, a.center), b.radius - a.radius);
    let square = dot(d, d);
    if square <= k * k * (1.0 + 1e-12) || square == 0.0 {
        return None;
    }
    let l = (square - k * k).sqrt();
    let u = [(l * d[0] + k * d[1]) / square, (l * d[1] - k * d[0]) / square];
    let touch = |c: Point, k: f64| [c[0] + k * u[1], c[1] - k * u[0]];
    Some(Leg { from: touch(a.center, a.radius), to: touch(b.center, b.radius), heading: u[1].atan2(u[0]) })
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
    /// Pulleys that the line is between; the pulley of the arc, twice.
    pub pulleys: [usize; 2],
    /// Factor on the number of knot spans.
    pub fine: f64,
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
    fn push(&mut self, form: Form, length: f64, pulleys: [usize; 2], fine: f64) {
        if length > 0.0 {
            self.parts.push(Part { form, start: self.length, length, pulleys, fine });
            self.length += length;
        }
    }

    /// The belt around `chain`. `open` tells for either end that the chain goes on there: the guide then starts or ends in the middle of the leg.
    /// On failure the index of a pulley that must shrink together with its neighbours.
    pub fn around(chain: &[Pulley], open: [bool; 2]) -> Result<Self, usize> {
        let Wound { active, wheels, mut legs } = wind(chain)?;
        let Some(last) = legs.len().checked_sub(1) else { return Err(0) };
        let middle = |leg: &Leg| [f64::midpoint(leg.from[0], leg.to[0]), f64::midpoint(leg.from[1], leg.to[1])];
        if open[0] {
            legs[0].from = middle(&legs[0]);
        }
        if open[1] {
            legs[last].to = middle(&legs[last]);
        }
        let mut guide = Self { ends: [legs[0].from, legs[last].to], ..Self::default() };
        for (k, leg) in legs.iter().enumerate() {
            let (s, c) = leg.heading.sin_cos();
            let (i, next) = (active[k], active[k + 1]);
            guide.push(Form::Line { from: leg.from, along: [c, s] }, distance(leg.from, leg.to), [i, next], 1.0);
            if k < last {
                guide.join(&chain[next], next, wheels[k + 1].center, [leg.heading, legs[k + 1].heading])?;
            }
        }
        Ok(guide)
    }

    /// Adds the arc or the corner between two legs.
    fn join(&mut self, pulley: &Pulley, index: usize, center: Point, [heading_in, heading_out]: [f64; 2]) -> Result<(), usize> {
        let turn = wrap(heading_out - heading_in);
        if pulley.radius == 0.0 {
            if turn.abs() > 1e-9 {
                self.corners.push((self.length, pulley.at()));
            }
            return Ok(());
        }
        let through = pulley.mode == Mode::Through;
        let near = pulley.sign() * turn;
        // A bend through a via point may turn right round: near half a turn the angle alone does not tell which way.
        let sweep = if through && near < 0.0 && pulley.turn.abs() > PI / 2.0 { near + TAU } else { near };
        if !(-1e-9..=if through { LOOP } else { SHARPEST }).contains(&sweep) {
            return Err(index); // the belt runs past the pulley, or nearly back on itself
        }
        if through {
            let (sign, n) = (pulley.sign(), pulley.outward);
            let apex = sign * wrap((sign * n[0]).atan2(-sign * n[1]) - heading_in);
            if !(apex > 0.0 && apex < sweep) {
                return Err(index);
            }
            self.through.push((self.length + apex * pulley.radius, pulley.at()));
        }
        let form = Form::Arc { center, radius: pulley.sign() * pulley.radius, heading: heading_in };
        self.push(form, sweep.max(0.0) * pulley.radius, [index, index], pulley.fine);
        Ok(())
    }

    /// Point at arc length `s`, m.
    pub fn at(&self, s: f64) -> Point {
        let i = self.parts.partition_point(|part| part.start <= s).max(1) - 1;
        self.parts.get(i).map_or(self.ends[0], |part| part.at((s - part.start).clamp(0.0, part.length)))
    }
}

/// A belt as it lies: the pulleys that it touches, their wheels, and the legs between them.
struct Wound {
    active: Vec<usize>,
    wheels: Vec<Wheel>,
    legs: Vec<Leg>,
}

/// Lays the belt. A pulley that its neighbours push off the belt is passed over. How far a wheel stands out depends on the sweep of its arc and that
/// on the wheels: two rounds settle it. On failure the index of a pulley that is in the way.
fn wind(chain: &[Pulley]) -> Result<Wound, usize> {
    let mut active: Vec<usize> = (0..chain.len()).collect();
    let mut sweeps: Vec<f64> = chain.iter().map(|p| p.turn.abs()).collect();
    let mut round = 0;
    loop {
        let wheels = active.iter().map(|&i| chain[i].wheel(sweeps[i]).ok_or(i)).collect::<Result<Vec<_>, _>>()?;
        let mut legs = Vec::with_capacity(wheels.len());
        let mut slack = None;
        for (k, w) in wheels.windows(2).enumerate() {
            if let Some(leg) = tangent(w[0], w[1]) {
                legs.push(leg);
                continue;
            }
            // One wheel inside the other.
            let inner = if w[0].radius.abs() < w[1].radius.abs() { k } else { k + 1 };
            if w[0].radius * w[1].radius < 0.0 || !chain[active[inner]].may_slip(inner, wheels.len()) {
                return Err(active[k]);
            }
            slack = Some(inner);
            break;
        }
        if slack.is_none() {
            let mut worst = -1e-9;
            for (k, w) in legs.windows(2).enumerate() {
                let pulley = &chain[active[k + 1]];
                let sweep = pulley.sign() * wrap(w[1].heading - w[0].heading);
                sweeps[active[k + 1]] = sweep.clamp(0.0, PI);
                if sweep < worst && pulley.may_slip(k + 1, wheels.len()) {
                    (worst, slack) = (sweep, Some(k + 1));
                }
            }
        }
        match slack {
            Some(k) => drop(active.remove(k)),
            None if round == 2 => return Ok(Wound { active, wheels, legs }),
            None => round += 1,
        }
    }
}

/// Heading from `a` to `b`, rad.
pub(super) fn heading(a: Point, b: Point) -> f64 {
    let v = sub(b, a);
    if norm(v) > 0.0 { v[1].atan2(v[0]) } else { 0.0 }
}
