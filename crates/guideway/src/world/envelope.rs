//! The engine of the distance transforms: one dimension after the other, in integers.
//!
//! Source: \[felzenszwalb2012\], section 2: the column's distance to its nearest set cell gives a parabola per column, and a row of the result is the
//! lower envelope of them. Where obstacles are near, most of a row, comparing the columns of a small window side by side (sixteen bits each) is
//! quicker than any envelope; the envelope is built only for the stretches that this leaves open, by cross-multiplied comparisons, and only
//! its survivors cost a division.

use super::bits::Bits;
use std::ops::Range;

/// Widest offset that the window looks at, columns.
const REACH: usize = 21;
/// Columns handled at once.
const BLOCK: usize = 64;
/// No set cell in the column.
const NONE: u16 = u16::MAX;
/// A key that stands for "not near".
const FAR: i16 = i16::MAX;

/// Which distance is asked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Rule {
    /// Between cell centres, cells squared. Keys hold 64 squares plus 32 plus the offset of the nearest column.
    Centers,
    /// From centres to closed squares, quarters of a squared cell. Keys are these.
    Squares,
}

/// Takes the result, row by row from the last, stretch by stretch.
pub(super) trait Sink {
    const RULE: Rule;
    /// The columns from `x0` on have these keys.
    fn near(&mut self, row: &Row, x0: usize, keys: &[i16]);
    /// The places `x0..x1` are ruled by column `k`. Places are cell centres, or left borders of cells for [`Rule::Squares`].
    fn far(&mut self, row: &Row, k: usize, x0: usize, x1: usize);
    /// All places of the stretch of columns `x0..x1` have been told to `far`.
    fn finish(&mut self, _row: &Row, _x0: usize, _x1: usize) {}
}

/// What is known about one row.
pub(super) struct Row {
    /// Row number.
    pub y: usize,
    rule: Rule,
    /// Distance to the nearest set cell above or at, and below or at, this row, for each column.
    up: Vec<u16>,
    down: Vec<u16>,
    gap: Vec<u16>,
}

impl Row {
    /// The nearest set row of column `k`, which must have one.
    #[inline]
    pub fn nearest(&self, k: usize) -> usize {
        if self.up[k] <= self.down[k] { self.y - usize::from(self.up[k]) } else { self.y + usize::from(self.down[k]) }
    }
    /// Height of the parabola of column `k`; huge without a set cell.
    #[inline]
    pub fn height(&self, k: usize) -> i64 {
        let gap = i64::from(self.gap[k]);
        match self.rule {
            _ if self.gap[k] == NONE => i64::MAX,
            Rule::Centers => gap * gap,
            Rule::Squares => (2 * gap - 1).max(0) * (2 * gap - 1),
        }
    }
}

/// Squared distance and nearest column of the key at column `x` ([`Rule::Centers`]).
#[inline]
pub(super) fn decode(key: i16, x: usize) -> (u32, usize) {
    (key as u32 >> 6, x + (key & 63) as usize - 32)
}

/// Runs the transform of `set`, which must not be empty.
pub(super) fn transform<S: Sink>(set: &Bits, sink: &mut S) {
    transform_rows(set, 0..set.height() as usize, sink);
}

/// The rows `rows` of the transform of `set`, which must not be empty.
pub(super) fn transform_rows<S: Sink>(set: &Bits, rows: Range<usize>, sink: &mut S) {
    let (w, h) = (set.width() as usize, set.height() as usize);
    if rows.is_empty() {
        return;
    }
    let mut ups = vec![NONE; w * rows.len()];
    ups[..w].copy_from_slice(&farther(set, (0..=rows.start).rev()));
    for (k, y) in rows.clone().enumerate().skip(1) {
        let (before, line) = ups.split_at_mut(k * w);
        one_more(&before[(k - 1) * w..], &mut line[..w]);
        clear(set, y, &mut line[..w]);
    }
    let mut row = Row { y: 0, rule: S::RULE, up: Vec::new(), down: farther(set, rows.end..h), gap: vec![0; w] };
    let mut window = Window::new(S::RULE, w);
    let mut stack = Vec::new();
    for (y, up) in rows.rev().zip(ups.chunks(w).rev()) {
        row.y = y;
        row.up.clear();
        row.up.extend_from_slice(up);
        for d in &mut row.down {
            *d = d.saturating_add(1);
        }
        clear(set, y, &mut row.down);
        for ((gap, &up), &down) in row.gap.iter_mut().zip(&row.up).zip(&row.down) {
            *gap = up.min(down);
        }
        window.load(&row.gap);
        let mut open = None;
        for x0 in (0..w).step_by(BLOCK) {
            let n = BLOCK.min(w - x0);
            if let Some(keys) = window.nearest(x0, n) {
                if let Some(start) = open.take() {
                    stretch(&row, &mut stack, [start, x0], sink);
                }
                sink.near(&row, x0, &keys[..n]);
            } else if open.is_none() {
                open = Some(x0);
            }
        }
        if let Some(start) = open {
            stretch(&row, &mut stack, [start, w], sink);
        }
    }
}

/// In how many rows from the first of `rows` on each column is set for the first time.
fn farther(set: &Bits, rows: impl Iterator<Item = usize>) -> Vec<u16> {
    let mut line = vec![NONE; set.width() as usize];
    let mut open: Vec<u64> = vec![!0; set.width().div_ceil(64) as usize];
    for (steps, y) in (0..NONE).zip(rows) {
        let mut rest = 0;
        for ((open, &word), part) in open.iter_mut().zip(set.row(y as u32)).zip(line.chunks_mut(64)) {
            let mut new = word & *open;
            while new != 0 {
                part[new.trailing_zeros() as usize] = steps;
                new &= new - 1;
            }
            *open &= !word;
            rest |= *open;
        }
        if rest == 0 {
            break;
        }
    }
    line
}

/// `to = from + 1`, at most [`NONE`].
fn one_more(from: &[u16], to: &mut [u16]) {
    for (t, f) in to.iter_mut().zip(from) {
        *t = f.saturating_add(1);
    }
}

/// Zero wherever row `y` is set.
fn clear(set: &Bits, y: usize, line: &mut [u16]) {
    for (word, part) in set.row(y as u32).iter().zip(line.chunks_mut(64)) {
        let mut word = *word;
        while word != 0 {
            part[word.trailing_zeros() as usize] = 0;
            word &= word - 1;
        }
    }
}

/// Compares the columns of a window around every cell.
struct Window {
    rule: Rule,
    /// Keys of the columns for offset 0 without their code, with room on both sides.
    heights: Vec<i16>,
    /// What offsets to the right and to the left add.
    costs: [(i16, i16); REACH + 1],
    /// Keys below this cannot be improved by offsets from here on.
    limits: [i16; REACH + 2],
}

impl Window {
    fn new(rule: Rule, w: usize) -> Self {
        let cost = |r: usize| -> i16 {
            let r = r as i16;
            match rule {
                Rule::Centers => (r * r) << 6,
                Rule::Squares => (2 * r - 1).max(0) * (2 * r - 1),
            }
        };
        let costs = std::array::from_fn(|r| match rule {
            Rule::Centers => (cost(r) + 32 + r as i16, cost(r) + 32 - r as i16),
            Rule::Squares => (cost(r), cost(r)),
        });
        Self { rule, heights: vec![FAR; w + 2 * REACH + BLOCK], costs, limits: std::array::from_fn(cost) }
    }

    fn load(&mut self, gaps: &[u16]) {
        // Gaps beyond the reach cannot be nearest within it.
        let near = REACH as u16 + 1;
        let heights = &mut self.heights[REACH..];
        let squares = self.rule == Rule::Squares;
        for (height, &gap) in heights.iter_mut().zip(gaps) {
            let (g, far) = (gap.min(near), gap > near);
            let side = if squares { (2 * g).saturating_sub(1) } else { 8 * g };
            *height = if far { FAR } else { (side * side) as i16 };
        }
    }

    /// Keys of the `n` columns from `x0` on, or `None` if the nearest set cell of one of them may be out of reach.
    #[inline]
    fn nearest(&self, x0: usize, n: usize) -> Option<[i16; BLOCK]> {
        let around = &self.heights[x0..x0 + 2 * REACH + BLOCK];
        if around.iter().fold(FAR, |low, &v| low.min(v)) == FAR {
            return None;
        }
        let mut best: [i16; BLOCK] = std::array::from_fn(|i| around[REACH + i].saturating_add(self.costs[0].0));
        for r in 1..=REACH {
            let (right, left) = (&around[REACH + r..][..BLOCK], &around[REACH - r..][..BLOCK]);
            let (to_right, to_left) = self.costs[r];
            for i in 0..BLOCK {
                best[i] = best[i].min(right[i].saturating_add(to_right)).min(left[i].saturating_add(to_left));
            }
            if best[..n].iter().fold(0, |high, &v| high.max(v)) < self.limits[r + 1] {
                return Some(best);
            }
        }
        None
    }
}

/// The columns `x0..x1` by the lower envelope.
fn stretch<S: Sink>(row: &Row, stack: &mut Vec<(i64, i64)>, [x0, x1]: [usize; 2], sink: &mut S) {
    // The own column bounds how far the nearest one can be.
    let w = row.gap.len();
    let reach = usize::from(row.gap[x0..x1].iter().fold(0, |high, &g| high.max(g)));
    merge(row, stack, [x0.saturating_sub(reach + 1), w.min(x1 + reach + 1)]);
    let mut start = x0;
    let last = if S::RULE == Rule::Squares { x1 + 1 } else { x1 };
    for (i, &(k, _)) in stack.iter().enumerate() {
        let end = stack.get(i + 1).map_or(last, |&next| takeover(row.rule, stack[i], next).clamp(0, last as i64) as usize);
        if end > start {
            sink.far(row, k as usize, start, end);
            start = end;
        }
    }
    sink.finish(row, x0, x1);
}

/// Lower envelope of the parabolas of the columns `k0..k1`: members and their values at place 0.
fn merge(row: &Row, stack: &mut Vec<(i64, i64)>, [k0, k1]: [usize; 2]) {
    stack.clear();
    let scale = if row.rule == Rule::Squares { 4 } else { 1 };
    for k in k0..k1 {
        if row.gap[k] == NONE {
            continue;
        }
        let f = row.height(k) + scale * (k * k) as i64;
        let k = k as i64;
        while let [.., (i, fi), (j, fj)] = stack[..] {
            // The last one is nowhere lowest if the new one takes over from it before it takes over from the one before.
            if (f - fj) * (j - i) > (fj - fi) * (k - j) {
                break;
            }
            stack.pop();
        }
        stack.push((k, f));
    }
}

/// First place at which the second member is not above the first.
#[inline]
fn takeover(rule: Rule, (j, fj): (i64, i64), (k, fk): (i64, i64)) -> i64 {
    // Integers below 2^53: the quotient in f64 never crosses an integer by rounding.
    let (num, den) = match rule {
        Rule::Centers => (fk - fj, 2 * (k - j)),
        Rule::Squares => (fk - fj + 4 * (k - j), 8 * (k - j)),
    };
    (num as f64 / den as f64).ceil() as i64
}
