//! Exact Euclidean distance transforms of bit sets, and the clearance field of a world.
//!
//! How they are computed: [`envelope`](super::envelope).

use super::bits::Bits;
use super::envelope::{self, Row, Rule, Sink};
use super::grid::{Cell, MAX_CELLS, MAX_SIDE};
use crate::Point;
use crate::error::PlanError;
use std::ops::Range;
use std::sync::Arc;

/// Nearest set cell of every cell, between centres.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct DistanceField {
    width: u32,
    height: u32,
    squared: Vec<u32>,
    nearest: Vec<u32>,
}

impl DistanceField {
    /// Columns.
    pub fn width(&self) -> u32 {
        self.width
    }
    /// Rows.
    pub fn height(&self) -> u32 {
        self.height
    }
    #[inline]
    fn index(&self, [x, y]: Cell) -> usize {
        y as usize * self.width as usize + x as usize
    }
    /// Squared distance between the centres of a cell and the nearest set cell, cells squared; `None` if nothing is set.
    #[inline]
    pub fn squared(&self, cell: Cell) -> Option<u32> {
        self.squared.get(self.index(cell)).copied()
    }
    /// Distance between the centres of a cell and the nearest set cell, cells; infinite if nothing is set.
    #[inline]
    pub fn distance(&self, cell: Cell) -> f64 {
        self.squared(cell).map_or(f64::INFINITY, |d| f64::from(d).sqrt())
    }
    /// The nearest set cell (one of them in a tie); `None` if nothing is set.
    #[inline]
    pub fn nearest(&self, cell: Cell) -> Option<Cell> {
        self.nearest.get(self.index(cell)).map(|i| [i % self.width, i / self.width])
    }
}

/// Exact squared distance and nearest set cell of every cell, in time proportional to the number of cells.
/// # Errors
/// [`PlanError::BadParameter`] for more than [`MAX_CELLS`] cells or sides longer than [`MAX_SIDE`].
pub fn distance_transform(set: &Bits) -> Result<DistanceField, PlanError> {
    check(set)?;
    let mut field = DistanceField { width: set.width(), height: set.height(), squared: Vec::new(), nearest: Vec::new() };
    if !set.is_empty() {
        let cells = set.width() as usize * set.height() as usize;
        field.squared = vec![0; cells];
        field.nearest = vec![0; cells];
        envelope::transform(set, &mut field);
    }
    Ok(field)
}

impl Sink for DistanceField {
    const RULE: Rule = Rule::Centers;
    fn near(&mut self, row: &Row, x0: usize, keys: &[i16]) {
        let w = self.width as usize;
        let start = row.y * w + x0;
        let (squared, nearest) = (&mut self.squared[start..][..keys.len()], &mut self.nearest[start..][..keys.len()]);
        for (i, ((&key, d), n)) in keys.iter().zip(squared).zip(nearest).enumerate() {
            let (square, k) = envelope::decode(key, x0 + i);
            *d = square;
            *n = (row.nearest(k) * w + k) as u32;
        }
    }
    fn far(&mut self, row: &Row, k: usize, x0: usize, x1: usize) {
        let w = self.width as usize;
        let height = row.height(k) as u32;
        for (x, d) in (x0 as i32..).zip(&mut self.squared[row.y * w..][x0..x1]) {
            *d = x.abs_diff(k as i32) * x.abs_diff(k as i32) + height;
        }
        self.nearest[row.y * w..][x0..x1].fill((row.nearest(k) * w + k) as u32);
    }
}

/// Exact distance between the centres of every cell and its nearest set cell, in cells, row after row; infinite if nothing is set.
/// The same numbers as [`distance_transform`] for less work.
/// # Errors
/// [`PlanError::BadParameter`] for more than [`MAX_CELLS`] cells or sides longer than [`MAX_SIDE`].
pub fn distances(set: &Bits) -> Result<Vec<f64>, PlanError> {
    check(set)?;
    let cells = set.width() as usize * set.height() as usize;
    if set.is_empty() {
        return Ok(vec![f64::INFINITY; cells]);
    }
    let roots = std::array::from_fn(|i| (i as f64).sqrt());
    let mut sink = Distances { width: set.width() as usize, out: vec![0.0; cells], roots };
    envelope::transform(set, &mut sink);
    Ok(sink.out)
}

struct Distances {
    width: usize,
    out: Vec<f64>,
    roots: [f64; 512],
}

impl Sink for Distances {
    const RULE: Rule = Rule::Centers;
    fn near(&mut self, row: &Row, x0: usize, keys: &[i16]) {
        for (&key, d) in keys.iter().zip(&mut self.out[row.y * self.width + x0..]) {
            *d = self.roots[(key as u16 >> 6) as usize & 511];
        }
    }
    fn far(&mut self, row: &Row, k: usize, x0: usize, x1: usize) {
        let height = row.height(k) as f64;
        for (x, d) in (x0 as i32..).zip(&mut self.out[row.y * self.width..][x0..x1]) {
            let dx = f64::from(x - k as i32);
            *d = (dx * dx + height).sqrt();
        }
    }
}

/// Squared distance from every cell centre to the nearest set *closed square*, in quarters of a squared cell, row after row: 0 in set cells, at least 1
/// elsewhere.
#[derive(Debug)]
pub(super) enum SquareField {
    /// Nothing is set.
    Empty,
    /// Most maps.
    Short(Vec<u32>),
    /// Maps so long that 32 bits do not do.
    Long(Vec<u64>),
}

/// Longest side for which [`SquareField::Short`] does, given [`MAX_CELLS`](super::grid::MAX_CELLS).
const SHORT_SIDE: u32 = 30_000;

impl SquareField {
    /// For sides up to [`MAX_SIDE`].
    pub fn new(set: &Bits) -> Self {
        if set.is_empty() {
            Self::Empty
        } else if set.width().max(set.height()) <= SHORT_SIDE {
            Self::Short(Squares::of(set, vec![0; cells_of(set)], std::iter::once(0..set.height())))
        } else {
            Self::Long(Squares::of(set, vec![0; cells_of(set)], std::iter::once(0..set.height())))
        }
    }
    /// The field of `set` where this is the one of `before`, which differs in the cells `changed`. Only rows that a changed cell can be nearest to are computed.
    pub fn updated(&self, before: &Bits, set: &Bits, changed: &[Cell]) -> Self {
        let rows = || rows_touched(before, set, changed);
        match self {
            _ if set.is_empty() => Self::Empty,
            Self::Empty => Self::new(set),
            Self::Short(all) => Self::Short(Squares::of(set, all.clone(), rows())),
            Self::Long(all) => Self::Long(Squares::of(set, all.clone(), rows())),
        }
    }
    /// Distance of the cell with that index, cells.
    #[inline]
    pub(super) fn at(&self, i: usize) -> Option<f64> {
        match self {
            Self::Empty => None,
            Self::Short(all) => Some(from_square(all[i])),
            Self::Long(all) => Some(0.5 * (all[i] as f64).sqrt()),
        }
    }
}

/// Cells.
#[inline]
fn from_square(quarters: u32) -> f64 {
    0.5 * f64::from(quarters).sqrt()
}

/// A square reaches half a cell beyond its centre: beside its column its distance is that of a parabola seen from the nearer border of the own
/// column, so the envelope at the two borders and the own column's height say all.
struct Squares<T> {
    width: usize,
    out: Vec<T>,
    /// Envelope at the left border of each column (and the right one of the last), quarters.
    borders: Vec<u64>,
}

impl<T: Copy + Default + From<u16> + TryFrom<u64>> Squares<T> {
    /// Fills these rows of `out`.
    fn of(set: &Bits, out: Vec<T>, rows: impl IntoIterator<Item = Range<u32>>) -> Vec<T> {
        let width = set.width() as usize;
        let mut sink = Self { width, out, borders: vec![0; width + 1] };
        for part in rows {
            envelope::transform_rows(set, part.start as usize..part.end as usize, &mut sink);
        }
        sink.out
    }
}

impl<T: Copy + Default + From<u16> + TryFrom<u64>> Sink for Squares<T> {
    const RULE: Rule = Rule::Squares;
    fn near(&mut self, row: &Row, x0: usize, keys: &[i16]) {
        for (&key, d) in keys.iter().zip(&mut self.out[row.y * self.width + x0..]) {
            *d = T::from(key as u16);
        }
    }
    fn far(&mut self, row: &Row, k: usize, x0: usize, x1: usize) {
        let height = row.height(k);
        for (x, d) in (x0 as i64..).zip(&mut self.borders[x0..x1]) {
            let gap = 2 * (x - k as i64) - 1;
            *d = (gap * gap + height) as u64;
        }
    }
    fn finish(&mut self, row: &Row, x0: usize, x1: usize) {
        for (x, d) in (x0..).zip(&mut self.out[row.y * self.width..][x0..x1]) {
            let least = self.borders[x].min(self.borders[x + 1]).min(row.height(x) as u64);
            *d = T::try_from(least).unwrap_or_default();
        }
    }
}

fn cells_of(set: &Bits) -> usize {
    set.width() as usize * set.height() as usize
}

/// Rows, apart from each other, in which a column's distance to its nearest set cell may differ: around each changed cell up to the next one that is set before and after.
fn rows_touched(before: &Bits, set: &Bits, changed: &[Cell]) -> Vec<Range<u32>> {
    let kept = |x: u32, y: &u32| before.at(x, *y) && set.at(x, *y);
    let around = |&[x, y]: &Cell| {
        let low = (0..y).rev().find(|y| kept(x, y)).map_or(0, |y| y + 1);
        let high = (y + 1..set.height()).find(|y| kept(x, y)).unwrap_or(set.height());
        low..high
    };
    let mut rows: Vec<Range<u32>> = changed.iter().map(around).collect();
    rows.sort_by_key(|r| r.start);
    let mut apart: Vec<Range<u32>> = Vec::new();
    for next in rows {
        match apart.last_mut() {
            Some(last) if next.start <= last.end => last.end = last.end.max(next.end),
            _ => apart.push(next),
        }
    }
    apart
}

fn check(set: &Bits) -> Result<(), PlanError> {
    let (w, h) = (set.width(), set.height());
    if w.max(h) > MAX_SIDE || u64::from(w) * u64::from(h) > MAX_CELLS {
        return Err(PlanError::bad("map size", format!("{w} x {h} cells"), format!("at most {MAX_CELLS} cells, sides up to {MAX_SIDE} cells")));
    }
    Ok(())
}

/// Distances whose squares (quarters) are below this are few: those up to 32 cells.
const FEW: u32 = 4096;

/// Clearance of the centre of every cell that a planner sees, m.
#[derive(Debug)]
pub struct ClearanceField {
    width: u32,
    height: u32,
    resolution: f64,
    squares: Arc<SquareField>,
    /// Distance to the nearest shape, m, or infinite where blocked cells are nearer; empty without shapes.
    shapes: Vec<f64>,
}

impl ClearanceField {
    pub(super) fn new(size: [u32; 2], resolution: f64, squares: Arc<SquareField>, shapes: Vec<f64>) -> Self {
        Self { width: size[0], height: size[1], resolution, squares, shapes }
    }
    /// Columns.
    pub fn width(&self) -> u32 {
        self.width
    }
    /// Rows.
    pub fn height(&self) -> u32 {
        self.height
    }
    #[inline]
    fn index(&self, [x, y]: Cell) -> usize {
        y as usize * self.width as usize + x as usize
    }
    /// Exact distance from the centre of a cell to the nearest obstacle, m; infinite if there is none. Negative inside: in a shape minus the
    /// distance to its border, in a blocked cell minus half its side (it may be deeper inside the union of the blocked cells).
    #[inline]
    pub fn at(&self, cell: Cell) -> f64 {
        let i = self.index(cell);
        let grid = self.squares.at(i).map_or(f64::INFINITY, |d| self.of_cells(d));
        self.shapes.get(i).map_or(grid, |s| s.min(grid))
    }
    /// m, of the distance to blocked squares in cells.
    #[inline]
    fn of_cells(&self, distance: f64) -> f64 {
        if distance == 0.0 { -0.5 * self.resolution } else { distance * self.resolution }
    }
    /// `f` of the clearance (m) of the cells, row after row from the bottom: `put(x, y, f)`. Most cells are one of few distances away from blocked ones, whose `f` is
    /// made once.
    pub(crate) fn map<T: Copy>(&self, f: impl Fn(f64) -> T, mut put: impl FnMut(u32, u32, T)) {
        let (mut few, squares) = (Vec::new(), if let SquareField::Short(all) = &*self.squares { all.as_slice() } else { &[] });
        if !squares.is_empty() {
            few.extend((0..FEW).map(|square| f(self.of_cells(from_square(square)))));
        }
        for (y, x) in (0..self.height).flat_map(|y| (0..self.width).map(move |x| (y, x))) {
            let i = self.index([x, y]);
            let known = squares.get(i).and_then(|square| few.get(*square as usize));
            let value = match known {
                Some(value) if self.shapes.get(i).is_none_or(|s| *s == f64::INFINITY) => *value,
                _ => f(self.at([x, y])),
            };
            put(x, y, value);
        }
    }
    /// All values, row after row from the bottom, m.
    pub fn values(&self) -> Vec<f64> {
        (0..self.height).flat_map(|y| (0..self.width).map(move |x| self.at([x, y]))).collect()
    }
    /// The cells whose centre has at least this clearance, m.
    pub fn at_least(&self, clearance: f64) -> Bits {
        let mut bits = Bits::new(self.width, self.height);
        if let (SquareField::Short(all), true) = (&*self.squares, clearance > 0.0) {
            let least = self.least_square(clearance);
            for (y, line) in (0..self.height).zip(all.chunks(self.width as usize)) {
                for (part, word) in line.chunks(64).zip(bits.row_mut(y)) {
                    *word = part.iter().enumerate().fold(0, |w, (i, &v)| w | u64::from(v >= least) << i);
                }
            }
            if !self.shapes.is_empty() {
                for (y, line) in (0..self.height).zip(self.shapes.chunks(self.width as usize)) {
                    for (part, word) in line.chunks(64).zip(bits.row_mut(y)) {
                        *word &= part.iter().enumerate().fold(0, |w, (i, &s)| w | u64::from(s >= clearance) << i);
                    }
                }
            }
            return bits;
        }
        for y in 0..self.height {
            for (i, word) in bits.row_mut(y).iter_mut().enumerate() {
                let x0 = 64 * i as u32;
                *word = (x0..self.width.min(x0 + 64)).fold(0, |w, x| w | u64::from(self.at([x, y]) >= clearance) << (x - x0));
            }
        }
        bits
    }
    /// The least entry of the square field that [`ClearanceField::at`] makes `clearance` > 0 (m) or more of.
    fn least_square(&self, clearance: f64) -> u32 {
        let about = (2.0 * clearance / self.resolution).powi(2) - 3.0;
        let mut least = about.max(1.0) as u32;
        while least < u32::MAX && 0.5 * f64::from(least).sqrt() * self.resolution < clearance {
            least += 1;
        }
        least
    }
    /// Centre of a cell (grid frame, cells) and its distance to the nearest blocked square, cells (0 in blocked ones), if any is blocked.
    #[inline]
    pub(super) fn near(&self, [x, y]: Cell) -> Option<(Point, f64)> {
        self.squares.at(self.index([x, y])).map(|d| ([f64::from(x) + 0.5, f64::from(y) + 0.5], d))
    }
}
