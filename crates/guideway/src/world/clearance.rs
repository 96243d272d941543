//! Exact distances between points, segments and the blocked squares of a grid, read straight from the bit rows.
//!
//! Everything here is in the grid frame: cells, cell `(i, j)` is the closed square `[i, i+1] x [j, j+1]`, and everything outside the grid is free.

use super::bits::Bits;
use crate::Point;

/// A cell centre and its distance to the nearest set square (0 inside one).
pub(super) type Known = (Point, f64);

/// A window of this size is searched before anything else, cells: most queries end in it.
const SMALL: f64 = 8.0;

/// Signed distance from `q` to the union of the set squares, exact where it is below `reach`; `reach` or more elsewhere.
/// Negative inside: minus the distance to the nearest point that is not in the union, so also on an edge that two set squares share.
/// `q` must be finite. `known` may tell about a cell near `q`; it is asked only if nothing is near.
pub(super) fn signed(set: &Bits, q: Point, reach: f64, known: impl FnOnce() -> Option<Known>) -> f64 {
    let small = reach.min(SMALL);
    let found = window_scan(set, q, small);
    let outside = if found < small || small == reach {
        found
    } else if let Some((center, distance)) = known() {
        let away = (q[0] - center[0]).hypot(q[1] - center[1]) + 1e-9;
        if distance - away >= reach { reach } else { ring_scan(set, q, distance - away, (distance + away).min(reach)) }
    } else {
        nearest(set, q, reach)
    };
    if outside > 0.0 { outside } else { 0.0 - depth(set, q) }
}

/// Distance from `q` to the nearest set closed square if that is below `reach`, else `reach`.
fn nearest(set: &Bits, q: Point, reach: f64) -> f64 {
    let (w, h) = (f64::from(set.width()), f64::from(set.height()));
    let outside = (-q[0]).max(q[0] - w).max(0.0).hypot((-q[1]).max(q[1] - h).max(0.0));
    // Nothing is farther than the far corner; windows that grow keep the cost in proportion to the distance.
    let limit = reach.min(q[0].max(w - q[0]).hypot(q[1].max(h - q[1])) + 1.0);
    let mut window = (outside + 4.0 * SMALL).min(limit);
    loop {
        let found = window_scan(set, q, window);
        if found < window {
            return found;
        }
        if window >= limit {
            return reach;
        }
        window = (4.0 * window).min(limit);
    }
}

/// Distance from `q` to the nearest set square within `best`, row by row outwards; `best` if there is none.
fn window_scan(set: &Bits, q: Point, mut best: f64) -> f64 {
    let last = i64::from(set.height()) - 1;
    let middle = (q[1].floor() as i64).clamp(0, last);
    let mut squared = best * best;
    let mut visit = |j: i64, best: &mut f64| {
        let y = j as f64;
        let dy = (y - q[1]).max(q[1] - y - 1.0).max(0.0);
        if dy >= *best {
            return false;
        }
        if let Some(dx) = row_gap(set, j as u32, q[0], *best) {
            let d = dx * dx + dy * dy;
            if d < squared {
                squared = d;
                *best = d.sqrt();
            }
        }
        true
    };
    visit(middle, &mut best);
    let (mut up, mut down) = (middle + 1, middle - 1);
    let (mut go_up, mut go_down) = (true, true);
    while go_up || go_down {
        go_up = go_up && up <= last && visit(up, &mut best);
        go_down = go_down && down >= 0 && visit(down, &mut best);
        up += 1;
        down -= 1;
    }
    best
}

/// Distance from `q` to the nearest set square, which is known to be at least `low` away; `best` if it is not below.
fn ring_scan(set: &Bits, q: Point, low: f64, mut best: f64) -> f64 {
    let (w, h) = (i64::from(set.width()), i64::from(set.height()));
    let (x, middle) = (q[0], q[1].floor() as i64);
    let mut squared = best * best;
    let low2 = low.max(0.0) * low.max(0.0);
    for k in 0.. {
        let mut seen = false;
        for j in [middle - k, middle + k] {
            let dy = (j as f64 - q[1]).max(q[1] - j as f64 - 1.0).max(0.0);
            if dy >= best {
                continue;
            }
            seen = true;
            if j < 0 || j >= h || (k == 0 && j > middle) {
                continue;
            }
            // Squares nearer than this in this row would be nearer than `low`.
            let skip = (low2 - dy * dy).max(0.0).sqrt();
            let gap = if skip > 1.0 {
                let (r0, r1) = (((x + skip).ceil() as i64).max(0), ((x + best).floor() as i64).min(w - 1));
                let (l0, l1) = (((x - best).ceil() - 1.0).max(0.0) as i64, ((x - skip).floor() as i64 - 1).min(w - 1));
                let right = if r0 <= r1 { set.first(j as u32, r0 as u32, r1 as u32, true) } else { None };
                let left = if l0 <= l1 { set.last(j as u32, l0 as u32, l1 as u32, true) } else { None };
                let gaps = (right.map_or(f64::INFINITY, |i| f64::from(i) - x), left.map_or(f64::INFINITY, |i| x - f64::from(i) - 1.0));
                gaps.0.min(gaps.1)
            } else {
                row_gap(set, j as u32, x, best).unwrap_or(f64::INFINITY)
            };
            let d = gap * gap + dy * dy;
            if d < squared {
                squared = d;
                best = d.sqrt();
            }
        }
        if !seen {
            break;
        }
    }
    best
}

/// The largest integer that is not above `x`, without a call.
#[inline]
fn down(x: f64) -> i64 {
    let whole = x as i64;
    whole.saturating_sub(i64::from(whole as f64 > x))
}

/// The smallest integer that is not below `x`.
#[inline]
fn up(x: f64) -> i64 {
    let whole = x as i64;
    whole.saturating_add(i64::from((whole as f64) < x))
}

/// Smallest horizontal gap between `x` and a set square of row `j` that is at most `reach` away.
#[inline]
fn row_gap(set: &Bits, j: u32, x: f64, reach: f64) -> Option<f64> {
    let last = i64::from(set.width()) - 1;
    let (low, high) = ((up(x - reach).saturating_sub(1)).max(0), down(x + reach).min(last));
    // Most rows are empty.
    if low > high || !set.any(j, low, high) {
        return None;
    }
    let own = down(x).clamp(low, high) as u32;
    let right = set.first(j, own, high as u32, true).map(|k| (f64::from(k) - x).max(x - f64::from(k) - 1.0).max(0.0));
    let left = set.last(j, low as u32, own, true).map(|k| (x - f64::from(k) - 1.0).max(f64::from(k) - x).max(0.0));
    match (right, left) {
        (Some(a), Some(b)) => Some(a.min(b)),
        (a, b) => a.or(b),
    }
}

/// Distance from `q` to the nearest point outside the union of the set squares; zero outside and on its border.
fn depth(set: &Bits, q: Point) -> f64 {
    let (w, h) = (i64::from(set.width()), i64::from(set.height()));
    let mut best = q[0].min(w as f64 - q[0]).min(q[1]).min(h as f64 - q[1]).max(0.0);
    if best == 0.0 {
        return 0.0;
    }
    let (x, middle) = (q[0], q[1].floor() as i64);
    let mut k = 0;
    loop {
        let mut seen = false;
        for j in [middle - k, middle + k] {
            let dy = (j as f64 - q[1]).max(q[1] - j as f64 - 1.0).max(0.0);
            if j < 0 || j >= h || dy >= best {
                continue;
            }
            seen = true;
            let (low, high) = (((x - best).ceil() - 1.0).max(0.0) as i64 as u32, ((x + best).floor() as i64).min(w - 1) as u32);
            let own = (x.floor() as i64).clamp(i64::from(low), i64::from(high)) as u32;
            let gaps = [set.first(j as u32, own, high, false), set.last(j as u32, low, own, false)];
            for i in gaps.into_iter().flatten().map(f64::from) {
                best = best.min((i - x).max(x - i - 1.0).max(0.0).hypot(dy));
            }
        }
        if !seen {
            return best;
        }
        k += 1;
    }
}
