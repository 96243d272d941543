//! Maximal free runs in the rows of a bit map, found by scanning 64 cells at a time.

use crate::world::Bits;

/// A maximal free run: cells `a..b` of a row, so the rectangle `[a, b] x [row, row + 1]` is free.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::plan) struct Run {
    /// Left end, cells.
    pub a: i32,
    /// Right end, cells.
    pub b: i32,
}

/// Is cell `(x, y)` inside and free?
#[inline]
pub(in crate::plan) fn is_free(free: &Bits, x: i32, y: i32) -> bool {
    x >= 0 && y >= 0 && (x as u32) < free.width() && (y as u32) < free.height() && free.at(x as u32, y as u32)
}

/// First free cell at or right of `x` (the width if there is none).
fn next_free(free: &Bits, y: i32, x: i32) -> i32 {
    let row = free.row(y as u32);
    let mut word = (x >> 6) as usize;
    if word >= row.len() {
        return free.width() as i32;
    }
    let mut bits = row[word] & (!0 << (x & 63));
    while bits == 0 {
        word += 1;
        if word == row.len() {
            return free.width() as i32;
        }
        bits = row[word];
    }
    (word as i32) * 64 + bits.trailing_zeros() as i32
}

/// First blocked cell at or right of `x` (the width if there is none).
fn next_blocked(free: &Bits, y: i32, x: i32) -> i32 {
    let row = free.row(y as u32);
    let mut word = (x >> 6) as usize;
    let width = free.width() as i32;
    if word >= row.len() {
        return width;
    }
    let mut bits = !row[word] & (!0 << (x & 63));
    while bits == 0 {
        word += 1;
        if word == row.len() {
            return width;
        }
        bits = !row[word];
    }
    ((word as i32) * 64 + bits.trailing_zeros() as i32).min(width)
}

/// Left end of the run that holds the free cell `x`.
fn left_end(free: &Bits, y: i32, x: i32) -> i32 {
    let row = free.row(y as u32);
    let mut word = (x >> 6) as usize;
    let mut bits = !row[word] & (!0 >> (63 - (x & 63)));
    while bits == 0 {
        if word == 0 {
            return 0;
        }
        word -= 1;
        bits = !row[word];
    }
    (word as i32) * 64 + 64 - bits.leading_zeros() as i32
}

/// The run that holds the free cell `(x, y)`.
pub(in crate::plan) fn run_at(free: &Bits, x: i32, y: i32) -> Run {
    Run { a: left_end(free, y, x), b: next_blocked(free, y, x) }
}

/// The runs of row `y` that share more than a point with `[lo, hi]`, left to right; none outside the map.
pub(in crate::plan) fn runs_over(free: &Bits, y: i32, lo: f64, hi: f64) -> impl Iterator<Item = Run> + '_ {
    let inside = y >= 0 && (y as u32) < free.height() && lo < hi;
    let mut x = if inside { lo.max(0.0).floor() as i32 } else { i32::MAX };
    let mut first = true;
    std::iter::from_fn(move || {
        if x == i32::MAX || f64::from(x) >= hi {
            return None;
        }
        let start = next_free(free, y, x);
        if start >= free.width() as i32 || f64::from(start) >= hi {
            x = i32::MAX;
            return None;
        }
        let a = if first && start == x { left_end(free, y, start) } else { start };
        first = false;
        let b = next_blocked(free, y, start);
        x = b;
        Some(Run { a, b })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_match_a_plain_scan() {
        let mut state = 1u64;
        for width in [1u32, 5, 63, 64, 65, 130, 200] {
            for _ in 0..40 {
                let mut bits = Bits::new(width, 1);
                for x in 0..width {
                    state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                    bits.set(x, 0, !(state >> 33).is_multiple_of(5));
                }
                let mut plain = Vec::new();
                let mut x = 0;
                while x < width {
                    if !bits.at(x, 0) {
                        x += 1;
                        continue;
                    }
                    let a = x;
                    while x < width && bits.at(x, 0) {
                        x += 1;
                    }
                    plain.push(Run { a: a as i32, b: x as i32 });
                }
                let all: Vec<_> = runs_over(&bits, 0, 0.0, f64::from(width)).collect();
                assert_eq!(all, plain);
                let (lo, hi) = (f64::from(width) * 0.3, f64::from(width) * 0.7);
                let part: Vec<_> = runs_over(&bits, 0, lo, hi).collect();
                let expected: Vec<_> = plain.iter().copied().filter(|r| f64::from(r.a) < hi && f64::from(r.b) > lo).collect();
                assert_eq!(part, expected);
                for run in plain {
                    assert_eq!(run_at(&bits, i32::midpoint(run.a, run.b), 0), run);
                }
            }
        }
        assert_eq!(runs_over(&Bits::new(3, 3), -1, 0.0, 3.0).count(), 0);
    }
}
