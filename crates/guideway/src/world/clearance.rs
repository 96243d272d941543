//! Exact distances between points, segments and the blocked squares of a grid, read straight from the bit rows.
//!
//! Everything here is in the grid frame: cells, cell `(i, j)` is the closed square `[i, i+1] x [j, j+1]`, and everything outside the grid is free.

use super::bits::Bits;
use crate::Point;

/// Signed distance from `q` to the union of the set squares, exact where it is below `reach`; `reach` or more elsewhere.
/// Negative inside: minus the distance to the nearest point that is not in the union, so also on an edge that two set squares share.
pub(super) fn signed(set: &Bits, q: Point, reach: f64) -> f64 {
    if !(q[0].is_finite() && q[1].is_finite()) {
        return f64::NAN;
    }
    let outside = nearest(set, q, reach);
    if outside > 0.0 { outside } else { 0.0 - depth(set, q) }
}

/// Distance from `q` to the nearest set closed square if that is below `reach`, else `reach`.
pub(super) fn nearest(set: &Bits, q: Point, reach: f64) -> f64 {
    let (w, h) = (f64::from(set.width()), f64::from(set.height()));
    let outside = (-q[0]).max(q[0] - w).max(0.0).hypot((-q[1]).max(q[1] - h).max(0.0));
    // Nothing is farther than the far corner; a small window first keeps the cost in proportion to the distance.
    let limit = reach.min(q[0].max(w - q[0]).hypot(q[1].max(h - q[1])) + 1.0);
    let mut window = (outside + 8.0).min(limit);
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

/// Smallest horizontal gap between `x` and a set square of row `j` that is at most `reach` away.
#[inline]
fn row_gap(set: &Bits, j: u32, x: f64, reach: f64) -> Option<f64> {
    let last = i64::from(set.width()) - 1;
    let (low, high) = (((x - reach).ceil() as i64 - 1).max(0), ((x + reach).floor() as i64).min(last));
    if low > high {
        return None;
    }
    let own = (x.floor() as i64).clamp(low, high) as u32;
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
            let (low, high) = (((x - best).ceil() as i64 - 1).max(0) as u32, ((x + best).floor() as i64).min(w - 1) as u32);
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
