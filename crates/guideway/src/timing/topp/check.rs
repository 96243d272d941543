//! The dense check of a motion of legs of constant jerk, and what binds where.

use super::course::{Course, Shape, Span, Way};
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

    /// The joints at one place: use of rows and of bounds of x.
    fn place(&mut self, shape: &Shape, (x, u): (f64, f64), inverse: &[[f64; 3]]) -> [f64; 2] {
        let (mut rows, mut speed) = (0.0f64, 0.0f64);
        for ((q, qq), [v, a, d]) in shape.first.iter().zip(&shape.second).zip(inverse) {
            let value = q * u + qq * x;
            rows = rows.max(value.abs() * if value * q >= 0.0 { *a } else { *d });
            speed = speed.max(q * q * x * v * v);
        }
        (self.rows, self.speed) = (self.rows.max(rows), self.speed.max(speed));
        if speed.max(rows) <= self.most {
            return [rows, speed];
        }
        for (i, ((q, qq), [v, a, d])) in shape.first.iter().zip(&shape.second).zip(inverse).enumerate() {
            let value = q * u + qq * x;
            self.note(q * q * x * v * v, Binding::Speed(i));
            self.note(value.abs() * if value * q >= 0.0 { *a } else { *d }, Binding::Acceleration(i));
        }
        [rows, speed]
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

/// The check of every interval at `count + 1` places.
pub(super) fn joints(course: &Course, grid: &Grid, bounds: &Bounds, legs: &[Leg], count: usize) -> Vec<Use> {
    let mut shape = Shape::new(course.dimension);
    let mut end = Shape::new(course.dimension);
    let inverse: Vec<[f64; 3]> =
        (0..course.dimension).map(|i| [1.0 / bounds.speed[i], 1.0 / bounds.acceleration[i], 1.0 / bounds.deceleration[i]]).collect();
    let check = |(k, span): (usize, &Span)| {
        let mut used = Use::default();
        course.shape_in(span, 0.0, &mut shape);
        let start = shape.rate;
        course.shape_in(span, 1.0, &mut end);
        let way = Way::new(span, [start, end.rate]);
        let mut past = [[0.0; 2]; 2];
        for j in 0..=count {
            let tau = j as f64 / count as f64;
            course.shape_in(span, tau, &mut shape);
            let [here, u] = legs[k].at(way.at(tau).max(0.0));
            let now = used.place(&shape, (here, u), &inverse);
            if j >= 2 {
                used.between([past[0], past[1], now]);
            }
            past = [past[1], now];
        }
        used
    };
    grid.spans.iter().enumerate().map(check).collect()
}

/// The check of what is called for, at `count` places inside every interval, added to `used`.
pub(super) fn demands(demands: &mut Demands, s: &[f64], legs: &[Leg], count: usize, used: &mut [Use]) -> Result<(), PlanError> {
    if demands.rows.is_none() && demands.ceiling.is_none() {
        return Ok(());
    }
    let share = |j: usize| (j as f64 + 0.5) / count as f64;
    let places: Vec<f64> = s.windows(2).flat_map(|w| (0..count).map(move |j| w[0] + (w[1] - w[0]) * share(j))).collect();
    let at = |k: usize, j: usize| legs[k].at((s[k + 1] - s[k]) * share(j));
    if let Some(rows) = &mut demands.rows {
        let rows = rows(&places)?.checked(places.len())?;
        for (k, used) in used.iter_mut().enumerate() {
            for j in 0..count {
                let [x, u] = at(k, j);
                for r in 0..rows.count {
                    let i = (k * count + j) * rows.count + r;
                    let value = rows.a[i] * u + rows.b[i] * x + rows.c[i] + rows.d.get(i).map_or(0.0, |d| d * x.sqrt());
                    let excess = (value - rows.high[i]).max(rows.low[i] - value);
                    used.note(1.0 + excess / scale([rows.low[i], rows.high[i]]), Binding::Row(r));
                }
            }
        }
    }
    if let Some(ceiling) = &mut demands.ceiling {
        let ceiling = checked_ceiling(ceiling(&places)?, places.len())?;
        for (k, used) in used.iter_mut().enumerate() {
            for j in 0..count {
                let (x, bound) = (at(k, j)[0], ceiling[k * count + j]);
                used.note(if x > 0.0 { x / bound } else { 0.0 }, Binding::Ceiling);
            }
        }
    }
    Ok(())
}
