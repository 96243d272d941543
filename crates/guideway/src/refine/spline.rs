//! From the guide to one clamped cubic B-spline with continuous curvature.
//!
//! Control points are the guide at the Greville abscissae of the knots (Schoenberg's variation-diminishing approximation \[deboor1978\]): straight legs
//! stay exactly straight, the curve has no more wiggles than the guide, and the curvature of an arc rises and falls over about two knot spans.

use super::belt::{Form, Guide, Part, spans};
use crate::Point;
use crate::error::PlanError;
use crate::path::Path;

/// The spline along the guide; its parameter is the guide's arc length.
pub(super) fn spline(guide: &Guide) -> Result<Path, PlanError> {
    let knots = clamp(&breaks(guide), guide);
    let mut control: Vec<Point> = (0..knots.len() - 4).map(|i| abscissa(&knots, i)).map(|s| guide.at(s)).collect();
    let last = control.len() - 1;
    (control[0], control[last]) = (guide.ends[0], guide.ends[1]);
    for (s, point) in &guide.corners {
        let i = knots.partition_point(|k| k < s);
        control[i - 1] = *point;
    }
    for (s, point) in &guide.through {
        pin(&knots, &mut control, *s, *point);
    }
    Path::new(3, 2, knots, control.concat())
}

fn abscissa(knots: &[f64], i: usize) -> f64 {
    (knots[i + 1] + knots[i + 2] + knots[i + 3]) / 3.0
}

/// Legs shorter than this, as a share of the knot spans of the arcs beside them, have no knots of their own.
const SHORT: f64 = 0.25;

/// Places where polynomial pieces meet, increasing, both ends included.
fn breaks(guide: &Guide) -> Vec<f64> {
    let spacing = |part: Option<&Part>| part.and_then(|p| matches!(p.form, Form::Arc { .. }).then(|| spacing(p)));
    let mut breaks = vec![0.0];
    for (i, part) in guide.parts.iter().enumerate() {
        match part.form {
            Form::Arc { .. } => {
                let via = guide.through.iter().map(|(s, _)| s - part.start).find(|x| *x > 0.0 && *x < part.length);
                arc(part, via, &mut breaks);
            }
            Form::Line { .. } => {
                let (before, after) = (spacing(i.checked_sub(1).and_then(|j| guide.parts.get(j))), spacing(guide.parts.get(i + 1)));
                line(part, before, after, &mut breaks);
            }
        }
        breaks.push(part.start + part.length);
    }
    widen(&mut breaks, guide);
    let shortest = 1e-9 * guide.length;
    breaks.dedup_by(|b, a| {
        let same = *b - *a <= shortest;
        if same && *a > 0.0 && guide.corners.iter().any(|(s, _)| s == b) {
            *a = *b;
        }
        same
    });
    if let Some(end) = breaks.last_mut() {
        *end = guide.length;
    }
    breaks
}

/// Leaves out the knots around a leg that is far shorter than the spans of its arcs: beside long spans a short one makes the curvature shoot over. A leg
/// between two arcs keeps a knot in its middle.
fn widen(breaks: &mut Vec<f64>, guide: &Guide) {
    let arc = |i: Option<usize>| i.and_then(|i| guide.parts.get(i)).filter(|p| matches!(p.form, Form::Arc { .. })).map(spacing);
    for (i, part) in guide.parts.iter().enumerate() {
        let (before, after) = (arc(i.checked_sub(1)), arc(Some(i + 1)));
        let Some(span) = before.into_iter().chain(after).reduce(f64::min) else { continue };
        let (start, end) = (part.start, part.start + part.length);
        if arc(Some(i)).is_some() || part.length >= SHORT * span {
            continue;
        }
        // Where the leg goes to the end of the path, or to a corner, that end stays.
        let gone = |b: &f64| before.is_some() && (b - start).abs() < 1e-9 * span || after.is_some() && (b - end).abs() < 1e-9 * span;
        let at = breaks.partition_point(|b| *b < start - 1e-9 * span);
        breaks.retain(|b| !gone(b));
        if before.is_some() && after.is_some() {
            breaks.insert(at, f64::midpoint(start, end));
        }
    }
}

/// Length of the knot spans on an arc, m.
fn spacing(part: &Part) -> f64 {
    match part.form {
        Form::Arc { radius, .. } => part.length / spans(part.length / radius.abs(), part.fine),
        Form::Line { .. } => part.length,
    }
}

/// Knots inside an arc: even spans, on either side of the point it goes through.
fn arc(part: &Part, via: Option<f64>, breaks: &mut Vec<f64>) {
    let cuts: Vec<f64> = std::iter::once(0.0).chain(via).chain(std::iter::once(part.length)).collect();
    for w in cuts.windows(2) {
        let n = ((w[1] - w[0]) / spacing(part) - 1e-9).ceil().clamp(1.0, 128.0);
        breaks.extend((1..n as u32).map(|k| part.start + w[0] + (w[1] - w[0]) * f64::from(k) / n));
        if w[1] < part.length {
            breaks.push(part.start + w[1]);
        }
    }
}

/// Knots inside a leg: two spans like those of the arc at either end, so that the bend stays at the arc. Where there is no room for that, two at the finer arc
/// alone, if it is much finer, and even ones on the rest.
fn line(part: &Part, before: Option<f64>, after: Option<f64>, breaks: &mut Vec<f64>) {
    let (a, b, end) = (before.unwrap_or(0.0), after.unwrap_or(0.0), part.start + part.length);
    if 2.2 * (a + b) < part.length {
        breaks.extend(before.into_iter().flat_map(|h| [h, 2.0 * h]).map(|x| part.start + x));
        breaks.extend(after.into_iter().flat_map(|h| [2.0 * h, h]).map(|x| end - x));
        return;
    }
    let even = |from: f64, to: f64, n: f64| (1..n as u32).map(move |k| from + (to - from) * f64::from(k) / n);
    let (fine, coarse) = (a.min(b), a.max(b));
    if fine > 0.0 && 2.0 * fine < coarse && 4.4 * fine < part.length {
        let rest = part.length - 2.0 * fine;
        let n = (rest / coarse - 0.2).ceil().clamp(1.0, 4.0);
        if a < b {
            breaks.extend([part.start + fine, part.start + 2.0 * fine]);
            breaks.extend(even(end - rest, end, n));
        } else {
            breaks.extend(even(part.start, part.start + rest, n));
            breaks.extend([end - 2.0 * fine, end - fine]);
        }
        return;
    }
    let count = f64::from(u8::from(before.is_some()) + u8::from(after.is_some()));
    breaks.extend(even(part.start, end, (part.length * count / (a + b) - 0.2).ceil().clamp(1.0, 5.0)));
}

/// Clamped knots; a corner is a triple knot.
fn clamp(breaks: &[f64], guide: &Guide) -> Vec<f64> {
    let (first, last) = (breaks[0], breaks[breaks.len() - 1]);
    let mut knots = vec![first; 4];
    for b in &breaks[1..breaks.len() - 1] {
        let sharp = guide.corners.iter().any(|(s, _)| s == b);
        knots.extend(std::iter::repeat_n(*b, if sharp { 3 } else { 1 }));
    }
    knots.extend([last; 4]);
    knots
}

/// Moves one control point so that the curve at the simple knot `s` is exactly at `point`.
fn pin(knots: &[f64], control: &mut [Point], s: f64, point: Point) {
    let j = knots.partition_point(|k| *k < s - 1e-9 * knots[knots.len() - 1]);
    if j < 4 || j + 3 >= knots.len() || knots[j] == knots[j + 1] {
        return;
    }
    let (a, b) = (knots[j] - knots[j - 1], knots[j + 1] - knots[j]);
    let before = b * b / ((knots[j + 1] - knots[j - 1]) * (knots[j + 1] - knots[j - 2]));
    let after = a * a / ((knots[j + 1] - knots[j - 1]) * (knots[j + 2] - knots[j - 1]));
    let (p, q) = (control[j - 3], control[j - 1]);
    control[j - 2] = [0, 1].map(|d| (point[d] - before * p[d] - after * q[d]) / (1.0 - before - after));
}
