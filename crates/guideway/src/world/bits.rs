//! A two-dimensional bit set, 64 cells a word, row by row.

/// Bits `(x, y)` with `0 <= x < width`, `0 <= y < height`; bits beyond the width are zero.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Bits {
    width: u32,
    height: u32,
    stride: usize,
    words: Vec<u64>,
}

impl Bits {
    /// All zero.
    pub fn new(width: u32, height: u32) -> Self {
        let stride = (width as usize).div_ceil(64);
        Self { width, height, stride, words: vec![0; stride * height as usize] }
    }

    /// Columns.
    pub fn width(&self) -> u32 {
        self.width
    }
    /// Rows.
    pub fn height(&self) -> u32 {
        self.height
    }
    /// Words of row `y`; bit `x % 64` of word `x / 64` is cell `x`.
    #[inline]
    pub fn row(&self, y: u32) -> &[u64] {
        &self.words[y as usize * self.stride..][..self.stride]
    }
    /// Writable words of row `y`. Bits beyond the width must stay zero.
    #[inline]
    pub fn row_mut(&mut self, y: u32) -> &mut [u64] {
        &mut self.words[y as usize * self.stride..][..self.stride]
    }
    /// The bit at `(x, y)`; must be inside.
    #[inline]
    pub fn at(&self, x: u32, y: u32) -> bool {
        self.words[y as usize * self.stride + (x >> 6) as usize] >> (x & 63) & 1 != 0
    }
    /// Sets the bit at `(x, y)`.
    #[inline]
    pub fn set(&mut self, x: u32, y: u32, on: bool) {
        let word = &mut self.words[y as usize * self.stride + (x >> 6) as usize];
        let bit = 1 << (x & 63);
        if on { *word |= bit } else { *word &= !bit }
    }
    /// Is any bit set in row `y` at `x0 <= x <= x1` (clipped to the row)?
    #[inline]
    pub fn any(&self, y: u32, x0: i64, x1: i64) -> bool {
        let (x0, x1) = (x0.max(0), x1.min(i64::from(self.width) - 1));
        if x0 > x1 {
            return false;
        }
        let row = self.row(y);
        let (w0, w1) = ((x0 >> 6) as usize, (x1 >> 6) as usize);
        let (first, last) = (!0u64 << (x0 & 63), !0u64 >> (63 - (x1 & 63)));
        if w0 == w1 {
            return row[w0] & first & last != 0;
        }
        row[w0] & first != 0 || row[w1] & last != 0 || row[w0 + 1..w1].iter().any(|&w| w != 0)
    }
    /// Number of set bits.
    pub fn count(&self) -> u64 {
        self.words.iter().map(|w| u64::from(w.count_ones())).sum()
    }
}
