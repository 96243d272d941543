//! Groups of neighbouring scan points, as discs.

use crate::Point;
use crate::world::shape::distance;

/// Points farther apart than this and the spacing of the rays are of different things, m.
const JUMP: f64 = 0.1;
/// Rays without a point that a group may bridge.
const BRIDGE: usize = 2;
/// Longer groups are cut, m.
const LONG: f64 = 1.3;
/// Largest radius that the width of a group may suggest, m.
const WIDEST: f64 = 0.8;

/// A point of a scan in the map frame.
#[derive(Debug, Clone, Copy)]
pub(super) struct Dot {
    /// Number of its ray.
    pub ray: usize,
    pub at: Point,
    /// m.
    pub range: f64,
}

/// A group as a disc: as wide as its rays, as near as its nearest point, and around all its points.
#[derive(Debug, Clone, Copy)]
pub(super) struct Blob {
    pub center: Point,
    pub radius: f64,
    /// First and one past the last of its dots.
    pub dots: [usize; 2],
    /// It may go on where nothing can be seen: beyond the last ray, or behind something nearer.
    pub cut: bool,
}

/// The groups among `dots` (in the order of their rays), seen from `origin` with `step` rad from ray to ray of these `ranges`; `closed`: the last ray is beside the first.
pub(super) fn blobs(dots: &[Dot], origin: Point, (step, ranges, closed): (f64, &[f64], bool), out: &mut Vec<Blob>) {
    out.clear();
    let mut from = 0;
    for i in 1..=dots.len() {
        let ends =
            i == dots.len() || apart(&dots[i - 1], &dots[i], dots[i].ray - dots[i - 1].ray, step) || distance(dots[from].at, dots[i].at) > LONG;
        if ends && from < i {
            let part = &dots[from..i];
            let cut = hidden(&part[0], -1, (ranges, closed)) || hidden(&part[part.len() - 1], 1, (ranges, closed));
            out.push(Blob { cut, ..blob(part, origin, (step, [from, i])) });
            from = i;
        }
    }
    // Over the seam of a full circle.
    if let (true, [first, .., last]) = (closed, &out[..]) {
        let (a, b) = (&dots[dots.len() - 1], &dots[0]);
        if !apart(a, b, b.ray + ranges.len() - a.ray, step) {
            let joined = join(first, last);
            let n = out.len();
            out[0] = joined;
            out.truncate(n - 1);
        }
    }
}

/// Is what lies beside a dot, on the side of the next (1) or the previous (-1) ray, hidden?
fn hidden(dot: &Dot, side: isize, (ranges, closed): (&[f64], bool)) -> bool {
    let n = ranges.len();
    let beside = match dot.ray.checked_add_signed(side).filter(|k| *k < n) {
        Some(k) => k,
        None if closed => (dot.ray + n).saturating_add_signed(side) % n,
        None => return true,
    };
    // A ray that measured nothing tells nothing.
    ranges[beside].is_nan() || ranges[beside] < dot.range - JUMP
}

fn apart(a: &Dot, b: &Dot, rays: usize, step: f64) -> bool {
    let spacing = 2.5 * step * rays as f64 * a.range.min(b.range);
    rays > BRIDGE + 1 || distance(a.at, b.at) > JUMP + spacing
}

fn blob(dots: &[Dot], origin: Point, (step, span): (f64, [usize; 2])) -> Blob {
    let (first, last) = (&dots[0], &dots[dots.len() - 1]);
    let near = dots.iter().map(|d| d.range).fold(f64::INFINITY, f64::min);
    // Half the angle that it covers: half a ray more on either side.
    let half = (0.5 * step * (last.ray - first.ray + 1) as f64).min(1.2);
    let s = half.sin();
    let wide = (near * s / (1.0 - s)).min(WIDEST).max(0.5 * distance(first.at, last.at).min(LONG));
    let u = middle(first, last, origin);
    let center = [origin[0] + (near + wide) * u[0], origin[1] + (near + wide) * u[1]];
    let around = dots.iter().map(|d| distance(d.at, center)).fold(0.0, f64::max);
    Blob { center, radius: wide.max(around), dots: span, cut: false }
}

/// Unit vector halfway between the rays of two dots.
fn middle(a: &Dot, b: &Dot, origin: Point) -> Point {
    let unit = |d: &Dot| [(d.at[0] - origin[0]) / d.range.max(1e-9), (d.at[1] - origin[1]) / d.range.max(1e-9)];
    let (p, q) = (unit(a), unit(b));
    let sum = [p[0] + q[0], p[1] + q[1]];
    let n = sum[0].hypot(sum[1]);
    if n > 1e-6 { [sum[0] / n, sum[1] / n] } else { p }
}

/// The disc around two discs.
fn join(a: &Blob, b: &Blob) -> Blob {
    let d = distance(a.center, b.center);
    let radius = (0.5 * (d + a.radius + b.radius)).max(a.radius).max(b.radius);
    let r = if d > 0.0 { ((radius - a.radius) / d).clamp(0.0, 1.0) } else { 0.0 };
    let center = [a.center[0] + r * (b.center[0] - a.center[0]), a.center[1] + r * (b.center[1] - a.center[1])];
    Blob { center, radius, dots: a.dots, cut: a.cut || b.cut }
}
