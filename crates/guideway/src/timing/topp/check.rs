//! The dense check of a motion of legs of constant jerk, and what binds where.

use super::course::{ASIDE, Course, Shape, Span, Way};
use super::grid::Grid;
use super::limits::Bounds;
use super::motion::Leg;
use super::problem::{Demands, checked_ceiling, scale};
use crate::error::PlanError;

/// What is nearest to its bound on an interval.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Binding {
    Speed(usize),
    Acceleration(usize),
    Row(usize),
    Ceiling,
}

/// Use of the limits on one interval: 1 is the bound.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Use {
    /// Largest of all rows: demand over bound.
    pub rows: f64,
    /// Largest of all bounds of x: x over bound.
    pub speed: f64,
    pub binding: Binding,
    /// The use of what binds.
    pub most: f64,
}

impl Default for Use {
    fn default() -> Self {
        Self { rows: 0.0, speed: 0.0, binding: Binding::Ceiling, most: 0.0 }
    }
}

impl Use {
    /// What the use may rise to between three places: as a parabola through them does.
    fn between(&mut self, [before, here, after]: [[f64; 2]; 3]) {
        let peak = |i: usize| {
            let bulge = (2.0 * here[i] - before[i] - after[i]).max(0.0) / 8.0;
            before[i].max(here[i]).max(after[i]) + bulge
        };
        self.rows = self.rows.max(peak(0));
        self.speed = self.speed.max(peak(1));
    }

    /// Of the motion with its squared speeds divided by a factor.
    pub fn slowed(self, factor: f64) -> Self {
        Self { rows: self.rows / factor, speed: self.speed / factor, most: self.most / factor, ..self }
    }

    /// Notes what binds where the use is largest.
    fn name(&mut self, [speeds, rows]: [&[f64]; 2]) {
        for (i, (speed, row)) in speeds.iter().zip(rows).enumerate() {
            self.note(*speed, Binding::Speed(i));
            self.note(*row, Binding::Acceleration(i));
        }
    }

    fn note(&mut self, share: f64, binding: Binding) {
        if share > self.most {
            (self.most, self.binding) = (share, binding);
        }
        match binding {
            Binding::Speed(_) | Binding::Ceiling => self.speed = self.speed.max(share),
            Binding::Acceleration(_) | Binding::Row(_) => self.rows = self.rows.max(share),
        }
    }
}

/// Use of the limits of every joint at one place.
struct Gauge {
    /// One over the squared speed, the acceleration, the deceleration of each joint.
    inverse: [Vec<f64>; 3],
    symmetric: bool,
    /// Of speed (squared) and acceleration, joint by joint.
    speeds: Vec<f64>,
    rows: Vec<f64>,
}

impl Gauge {
    fn new(bounds: &Bounds) -> Self {
        let inverse = |v: &[f64]| v.iter().map(|v| 1.0 / v).collect::<Vec<f64>>();
        let [v, a, d] = [&bounds.speed, &bounds.acceleration, &bounds.deceleration].map(|v| inverse(v));
        let zeros = vec![0.0; v.len()];
        let inverse = [v.iter().map(|v| v * v).collect(), a, d];
        Self { inverse, symmetric: bounds.acceleration == bounds.deceleration, speeds: zeros.clone(), rows: zeros }
    }

    /// Largest use of rows and of speeds where joints move by `first * alpha + second * beta` with the squared speeds `first^2 * beta`.
    fn read(&mut self, shape: &Shape, alpha: f64, beta: f64) -> [f64; 2] {
        let (mut most, mut top) = (0.0f64, 0.0f64);
        let [v, a, d] = &self.inverse;
        for i in 0..v.len() {
            let (first, value) = (shape.first[i], shape.first[i] * alpha + shape.second[i] * beta);
            let inverse = if self.symmetric || value * first >= 0.0 { a[i] } else { d[i] };
            self.rows[i] = value.abs() * inverse;
            self.speeds[i] = first * first * beta * v[i];
            most = if self.rows[i] > most { self.rows[i] } else { most };
            top = if self.speeds[i] > top { self.speeds[i] } else { top };
        }
        [most, top]
    }
}

/// The check of some of the intervals at `count + 1` places.
pub(super) fn joints(course: &Course, grid: &Grid, bounds: &Bounds, (legs, which): (&[Leg], &[usize]), count: usize, used: &mut [Use]) {
    let mut shape = Shape::new(course.dimension);
    let mut gauge = Gauge::new(bounds);
    let mut check = |span: &Span, leg: &Leg| {
        let mut used = Use::default();
        let rates = [0.0, 1.0].map(|tau| {
            course.shape_in(span, tau, &mut shape);
            shape.rate
        });
        let way = Way::new(span, rates);
        let width = span.t[1] - span.t[0];
        let still = ASIDE * span.length() / width;
        let (mut past, step) = ([[0.0; 2]; 2], 1.0 / count as f64);
        let clock = leg.clock(span.length());
        for j in 0..=count {
            let tau = j as f64 * step;
            let [x, u] = clock.at(way.at(tau).max(0.0));
            let [square, product] = course.moving(span.piece, span.t[0] + width * tau, &mut shape);
            let now = if square > still * still {
                let inverse = 1.0 / square;
                let beta = x * inverse;
                gauge.read(&shape, u * inverse * square.sqrt() - beta * product * inverse, beta)
            } else {
                course.shape_in(span, tau, &mut shape);
                gauge.read(&shape, u, x)
            };
            if now[0].max(now[1]) > used.most {
                used.name([&gauge.speeds, &gauge.rows]);
            }
            (used.rows, used.speed) = (used.rows.max(now[0]), used.speed.max(now[1]));
            if j >= 2 {
                used.between([past[0], past[1], now]);
            }
            past = [past[1], now];
        }
        used
    };
    for k in which {
        used[*k] = check(&grid.spans[*k], &legs[*k]);
    }
}

/// How far inside an interval its ends are checked, as a share: rows may jump at nodes.
const INSIDE: f64 = 1e-7;

/// The check of what is called for, at `count + 1` places of some of the intervals, added to `used`.
pub(super) fn demands(demands: &mut Demands, s: &[f64], (legs, which): (&[Leg], &[usize]), count: usize, used: &mut [Use]) -> Result<(), PlanError> {
    if demands.rows.is_none() && demands.ceiling.is_none() {
        return Ok(());
    }
    let share = |j: usize| (j as f64 / count as f64).clamp(INSIDE, 1.0 - INSIDE);
    let places: Vec<f64> = which.iter().flat_map(|k| (0..=count).map(move |j| s[*k] + (s[k + 1] - s[*k]) * share(j))).collect();
    let at = |k: usize, j: usize| legs[k].at((s[k + 1] - s[k]) * share(j));
    if let Some(rows) = &mut demands.rows {
        let rows = rows(&places)?.checked(places.len())?;
        for (n, k) in which.iter().enumerate() {
            let used = &mut used[*k];
            let mut past = [[0.0; 2]; 2];
            for j in 0..=count {
                let [x, u] = at(*k, j);
                let mut most = 0.0f64;
                for r in 0..rows.count {
                    let i = (n * (count + 1) + j) * rows.count + r;
                    let value = rows.a[i] * u + rows.b[i] * x + rows.c[i] + rows.d.get(i).map_or(0.0, |d| d * x.sqrt());
                    let excess = (value - rows.high[i]).max(rows.low[i] - value);
                    let share = 1.0 + excess / scale([rows.low[i], rows.high[i]]);
                    used.note(share, Binding::Row(r));
                    most = most.max(share);
                }
                if j >= 2 {
                    used.between([past[0], past[1], [most, 0.0]]);
                }
                past = [past[1], [most, 0.0]];
            }
        }
    }
    if let Some(ceiling) = &mut demands.ceiling {
        let ceiling = checked_ceiling(ceiling(&places)?, places.len())?;
        for (n, k) in which.iter().enumerate() {
            for j in 0..=count {
                let (x, bound) = (at(*k, j)[0], ceiling[n * (count + 1) + j]);
                used[*k].note(if x > 0.0 { x / bound } else { 0.0 }, Binding::Ceiling);
            }
        }
    }
    Ok(())
}
