//! Blocked cells as bits with a blocked frame, laid out for scans that need no bounds.

use crate::world::Bits;

/// Bits of blocked frame left of cell 0 of every line; also the smallest frame right of the last cell.
const FRAME: usize = 64;

/// Lines of blocked bits (1 = blocked) inside a frame of blocked bits: one line below and above, a word left and right.
///
/// Bit `at(x, line)` is a cell; the next cell of the line is one bit, the next line `pitch()` bits away. A window is an unaligned
/// 64-bit load, so it shows 57 cells at least, whatever the position.
#[derive(Debug)]
pub struct Padded {
    bytes: Vec<u8>,
    pitch: usize,
}

impl Padded {
    /// The frame around the complement of `free`.
    pub(super) fn around(free: &Bits) -> Self {
        let width = free.width() as usize;
        let words = width.div_ceil(64) + 2;
        let lines = free.height() as usize + 2;
        let mut bytes = Vec::with_capacity((words * lines + 1) * 8);
        bytes.resize(words * 8, 0xff);
        for y in 0..free.height() {
            bytes.extend_from_slice(&[0xff; 8]);
            for word in free.row(y) {
                bytes.extend_from_slice(&(!word).to_le_bytes());
            }
            bytes.extend_from_slice(&[0xff; 8]);
        }
        bytes.resize((words * lines + 1) * 8, 0xff);
        Self { bytes, pitch: words * 64 }
    }

    /// Bits from one line to the next.
    #[inline]
    pub fn pitch(&self) -> usize {
        self.pitch
    }
    /// Number of bits, frame included.
    #[inline]
    pub fn len(&self) -> usize {
        self.bytes.len() * 8
    }
    /// Never: the frame alone has bits.
    pub fn is_empty(&self) -> bool {
        self.bytes.is_empty()
    }
    /// Bit of cell `x` of line `line`.
    #[inline]
    pub fn at(&self, x: u32, line: u32) -> usize {
        (line as usize + 1) * self.pitch + x as usize + FRAME
    }
    /// Is the bit blocked? The frame is.
    #[inline]
    pub fn blocked(&self, at: usize) -> bool {
        self.bytes[at >> 3] >> (at & 7) & 1 != 0
    }
    /// Bits from `at` on: bit 0 is `at`; the lowest `64 - at % 8` bits are valid, the rest zero.
    #[inline]
    pub fn ahead(&self, at: usize) -> u64 {
        self.load(at >> 3) >> (at & 7)
    }
    /// Bits up to `at`: bit 63 is `at`, bit 62 the one before; the highest `57 + at % 8` bits are valid, the rest zero.
    #[inline]
    pub fn behind(&self, at: usize) -> u64 {
        self.load((at >> 3) - 7) << (7 - (at & 7))
    }
    #[inline]
    fn load(&self, byte: usize) -> u64 {
        let mut word = [0; 8];
        word.copy_from_slice(&self.bytes[byte..byte + 8]);
        u64::from_le_bytes(word)
    }
}

/// Columns as rows: bit `(y, x)` of the result is bit `(x, y)` of `bits`. Blocks of 64 x 64 are turned by halving swaps.
pub(super) fn transposed(bits: &Bits) -> Bits {
    let mut out = Bits::new(bits.height(), bits.width());
    let mut block = [0u64; 64];
    for y0 in (0..bits.height()).step_by(64) {
        let rows = (bits.height() - y0).min(64);
        for x0 in (0..bits.width()).step_by(64) {
            let columns = (bits.width() - x0).min(64);
            for (k, word) in block.iter_mut().enumerate() {
                *word = if (k as u32) < rows { bits.row(y0 + k as u32)[(x0 / 64) as usize] } else { 0 };
            }
            turn(&mut block);
            for k in 0..columns {
                out.row_mut(x0 + k)[(y0 / 64) as usize] = block[k as usize];
            }
        }
    }
    out
}

/// Transposes a 64 x 64 bit matrix in place (row `i`, bit `j` to row `j`, bit `i`).
fn turn(block: &mut [u64; 64]) {
    let (mut half, mut mask) = (32, 0x0000_0000_ffff_ffffu64);
    while half != 0 {
        let mut k = 0;
        while k < 64 {
            let t = ((block[k] >> half) ^ block[k + half]) & mask;
            block[k] ^= t << half;
            block[k + half] ^= t;
            k = (k + half + 1) & !half;
        }
        half >>= 1;
        mask ^= mask << half;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    fn random(width: u32, height: u32, seed: u64) -> Bits {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut bits = Bits::new(width, height);
        for y in 0..height {
            for x in 0..width {
                bits.set(x, y, rng.random_bool(0.5));
            }
        }
        bits
    }

    #[test]
    fn columns_are_rows_turned() {
        for (k, (w, h)) in [(1, 1), (64, 64), (65, 63), (3, 200), (200, 3), (129, 130)].into_iter().enumerate() {
            let bits = random(w, h, k as u64);
            let turned = transposed(&bits);
            assert_eq!((turned.width(), turned.height()), (h, w));
            assert!((0..h).all(|y| (0..w).all(|x| bits.at(x, y) == turned.at(y, x))));
            assert_eq!(turned.count(), bits.count());
            assert_eq!(transposed(&turned), bits);
        }
    }

    #[test]
    fn windows_show_the_cells_ahead_and_behind() {
        let bits = random(150, 3, 9);
        let padded = Padded::around(&bits);
        let blocked = |x: i64, y: i64| !(0..150).contains(&x) || !(0..3).contains(&y) || !bits.at(x as u32, y as u32);
        for (y, x) in (0..3).flat_map(|y| (0..150).map(move |x| (y, x))) {
            let at = padded.at(x as u32, y as u32);
            let (ahead, behind) = (padded.ahead(at), padded.behind(at));
            for k in 0..57 {
                assert_eq!(ahead >> k & 1 != 0, blocked(x + k, y));
                assert_eq!(behind << k >> 63 != 0, blocked(x - k, y));
                assert_eq!(padded.blocked(at + k as usize), blocked(x + k, y));
            }
            for (line, dy) in [(at + padded.pitch(), 1), (at - padded.pitch(), -1)] {
                assert_eq!(padded.ahead(line) & 1 != 0, blocked(x, y + dy));
            }
        }
    }
}
