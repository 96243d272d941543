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
    /// Is any column set in both rows `y` and `y + 1` at `x0 <= x <= x1` (clipped to the set)?
    #[inline]
    pub fn any_pair(&self, y: i64, x0: i64, x1: i64) -> bool {
        let (x0, x1) = (x0.max(0), x1.min(i64::from(self.width) - 1));
        if x0 > x1 || y < 0 || y + 1 >= i64::from(self.height) {
            return false;
        }
        let (low, high) = (self.row(y as u32), self.row(y as u32 + 1));
        let (w0, w1) = ((x0 >> 6) as usize, (x1 >> 6) as usize);
        (w0..=w1).any(|i| {
            let mut both = low[i] & high[i];
            if i == w0 {
                both &= !0u64 << (x0 & 63);
            }
            if i == w1 {
                both &= !0u64 >> (63 - (x1 & 63));
            }
            both != 0
        })
    }
    /// The bit at `(x, y)`; zero outside.
    #[inline]
    pub fn at_or_zero(&self, x: i64, y: i64) -> bool {
        x >= 0 && y >= 0 && x < i64::from(self.width) && y < i64::from(self.height) && self.at(x as u32, y as u32)
    }
    /// The first column `x0 <= x <= x1` of row `y` whose bit is `on`; the columns must lie inside.
    #[inline]
    pub fn first(&self, y: u32, x0: u32, x1: u32, on: bool) -> Option<u32> {
        let (row, flip) = (self.row(y), if on { 0 } else { !0 });
        let mut i = (x0 >> 6) as usize;
        let mut word = (row[i] ^ flip) & (!0 << (x0 & 63));
        while word == 0 {
            i += 1;
            if i > (x1 >> 6) as usize {
                return None;
            }
            word = row[i] ^ flip;
        }
        let x = (i << 6) as u32 + word.trailing_zeros();
        (x <= x1).then_some(x)
    }
    /// The last column `x0 <= x <= x1` of row `y` whose bit is `on`; the columns must lie inside.
    #[inline]
    pub fn last(&self, y: u32, x0: u32, x1: u32, on: bool) -> Option<u32> {
        let (row, flip) = (self.row(y), if on { 0 } else { !0 });
        let mut i = (x1 >> 6) as usize;
        let mut word = (row[i] ^ flip) & (!0 >> (63 - (x1 & 63)));
        while word == 0 {
            if i <= (x0 >> 6) as usize {
                return None;
            }
            i -= 1;
            word = row[i] ^ flip;
        }
        let x = (i << 6) as u32 + 63 - word.leading_zeros();
        (x >= x0).then_some(x)
    }
    /// Is no bit set?
    pub fn is_empty(&self) -> bool {
        self.words.iter().all(|&w| w == 0)
    }
    /// From one flag per cell, row after row (`width * height` of them; missing ones are zero).
    pub fn from_flags(width: u32, height: u32, flags: &[bool]) -> Self {
        let mut bits = Self::new(width, height);
        if width == 0 {
            return bits;
        }
        for (line, row) in flags.chunks(width as usize).zip(bits.words.chunks_mut(bits.stride)) {
            for (part, word) in line.chunks(64).zip(row) {
                *word = pack(part);
            }
        }
        bits
    }
    /// Number of set bits.
    pub fn count(&self) -> u64 {
        self.words.iter().map(|w| u64::from(w.count_ones())).sum()
    }
}

/// Up to 64 flags as bits, the first one lowest.
#[inline]
fn pack(flags: &[bool]) -> u64 {
    let eights = flags.chunks_exact(8);
    let rest = eights.remainder();
    let mut word = 0;
    for (i, eight) in eights.enumerate() {
        let bytes = eight.iter().enumerate().fold(0u64, |sum, (k, &on)| sum | u64::from(on) << (8 * k));
        // Gathers the lowest bit of each byte in the top byte.
        word |= (bytes.wrapping_mul(0x0102_0408_1020_4080) >> 56) << (8 * i);
    }
    let done = flags.len() - rest.len();
    rest.iter().enumerate().fold(word, |word, (k, &on)| word | u64::from(on) << (done + k))
}
