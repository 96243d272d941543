//! Which cells and corners a disc may use: exact for square cells, nearly so for shapes.
//!
//! *Square cells.* A centre is free if its distance to the nearest blocked square is at least the radius `r`. Let a step start at a centre; per blocked square,
//! the distances along x and along y are convex functions of the way gone, and both change their behaviour only where the step crosses a grid line.
//! - Straight step: one of them is constant, the other has its minimum over the step at an end (a square between the two centres would have to be one of
//!   their own). So free ends make a free step.
//! - Diagonal step, up to the right through the corner `K`, from cell `(i, j)`: for a square `(a, b)` with `a <= i, b <= j` both distances
//!   grow, with `a > i, b > j` both shrink: minimum at an end. Else let the square be up to the left, `p = i - a >= 0` columns and `q = b - j - 1 >= 0` rows away from `K`.
//!   At `s` beyond `K` the distances are `max(0, p + s)` and `max(0, q - s)`, `|s| <= 1/2`; the sum of their squares is smallest at `s = (q - p) / 2`, that is at
//!   `K` for `p = q` and at an end for all other integers. So only the squares on the two diagonals through `K` matter, at `K`, where their distance is
//!   `p sqrt 2`. One bit a corner says that none of them is nearer than `r`.
//! - If both cells beside a diagonal step are free (corner rule `clear`), the bit is implied: the centre of the cell beside is `(p - 1/2) sqrt 2` away from the same square,
//!   which is less than `p sqrt 2`.
//!
//! *Shapes.* A centre is free if the disc fits at it and on the straight ways from it to the middles of the four sides of its cell; a corner if it fits on
//! both diagonals through it, from centre to centre. A step consists of such halves, so it is safe. Some safe steps are lost where one half of the
//! cross fits and another does not. Here `clear` does not imply the corner bit.

use super::Lattice;
use crate::Point;
use crate::world::{Bits, TOUCH, World};

/// Free cells and corners for a disc of radius `radius` (m), and whether the corner rule `clear` implies the corner bits.
pub(super) fn bits(world: &World, radius: f64) -> (Bits, Option<Bits>, bool) {
    if let Some(grid) = world.grid()
        && world.shapes().is_empty()
        && radius <= TOUCH
    {
        return (complement(grid.blocked()), None, true);
    }
    let mut free = roomy(world, radius);
    let mut corners = Bits::new(free.width() + 1, free.height() + 1);
    for y in 0..=free.height() {
        corners.row_mut(y).fill(!0);
    }
    if let Some(grid) = world.grid() {
        close_diagonals(&mut corners, grid.blocked(), radius / grid.resolution());
    }
    if !world.shapes().is_empty() {
        keep_off_shapes(world, radius, &mut free, &mut corners);
    }
    trim(&mut corners);
    (free, Some(corners), world.shapes().is_empty())
}

/// Zeroes the bits beyond the width.
fn trim(bits: &mut Bits) {
    let tail = bits.width() % 64;
    for y in (0..bits.height()).filter(|_| tail != 0) {
        if let Some(last) = bits.row_mut(y).last_mut() {
            *last &= (1 << tail) - 1;
        }
    }
}

fn complement(bits: &Bits) -> Bits {
    let mut out = Bits::new(bits.width(), bits.height());
    for y in 0..bits.height() {
        out.row_mut(y).iter_mut().zip(bits.row(y)).for_each(|(to, from)| *to = !from);
    }
    trim(&mut out);
    out
}

/// Cells inside the world at whose centre the disc fits.
fn roomy(world: &World, radius: f64) -> Bits {
    let (field, [w, h]) = (world.clearance_field(), world.size());
    if world.grid().is_some() {
        return field.at_least(radius - TOUCH);
    }
    let mut free = Bits::new(w, h);
    for y in 0..h {
        let row = free.row_mut(y);
        for x in 0..w {
            let fits = field.at([x, y]) >= radius - TOUCH && world.contains(world.cell_center([x, y]));
            row[(x / 64) as usize] |= u64::from(fits) << (x % 64);
        }
    }
    free
}

/// Closes the corners with a blocked cell nearer than `radius` (cells) on a diagonal through them.
fn close_diagonals(corners: &mut Bits, blocked: &Bits, radius: f64) {
    let steps = ((radius - TOUCH) / std::f64::consts::SQRT_2).ceil().clamp(0.0, f64::from(blocked.width().max(blocked.height()))) as i64;
    for y in 0..corners.height() {
        for p in 0..steps {
            for row in [i64::from(y) - 1 - p, i64::from(y) + p] {
                let Ok(row) = u32::try_from(row) else { continue };
                if row < blocked.height() {
                    // Corner x has the cells x + p and x - 1 - p on its diagonals.
                    remove_shifted(corners.row_mut(y), blocked.row(row), p);
                    remove_shifted(corners.row_mut(y), blocked.row(row), -1 - p);
                }
            }
        }
    }
}

/// Clears every bit `x` of `to` for which bit `x + shift` of `from` is set.
fn remove_shifted(to: &mut [u64], from: &[u64], shift: i64) {
    let (words, bits) = (shift.div_euclid(64), shift.rem_euclid(64) as u32);
    let word = |k: i64| usize::try_from(k).ok().and_then(|k| from.get(k)).copied().unwrap_or(0);
    for (k, target) in to.iter_mut().enumerate() {
        let k = k as i64 + words;
        *target &= !(word(k) >> bits | if bits == 0 { 0 } else { word(k + 1) << (64 - bits) });
    }
}

/// Takes out cells and corners whose half steps come too near a shape.
fn keep_off_shapes(world: &World, radius: f64, free: &mut Bits, corners: &mut Bits) {
    let half = world.resolution() / 2.0;
    let at = |x: f64, y: f64| world.cell_to_map([x, y]);
    let fits = |a: Point, b: Point| world.shapes().iter().all(|s| s.segment_distance(a, b) >= radius - TOUCH);
    // Nothing within this distance of a centre or corner comes nearer than the radius on the halves around it.
    let far = radius + 2.0 * half;
    let near = |p: Point| world.shapes().iter().any(|s| s.distance(p) < far);
    for y in 0..corners.height() {
        for x in 0..corners.width() {
            let (u, v) = (f64::from(x), f64::from(y));
            let (mid_u, mid_v) = (u + 0.5, v + 0.5);
            let cell = x < free.width() && y < free.height() && free.at(x, y);
            if cell && near(at(mid_u, mid_v)) && !(fits(at(u, mid_v), at(u + 1.0, mid_v)) && fits(at(mid_u, v), at(mid_u, v + 1.0))) {
                free.set(x, y, false);
            }
            let cross = || fits(at(u - 0.5, v - 0.5), at(mid_u, mid_v)) && fits(at(mid_u, v - 0.5), at(u - 0.5, mid_v));
            if near(at(u, v)) && !cross() {
                corners.set(x, y, false);
            }
        }
    }
}

impl Lattice {
    /// The lattice of a world for a disc of radius `radius`, m.
    pub(in crate::world) fn build(world: &World, radius: f64) -> Self {
        let (free, corner_free, implied) = bits(world, radius);
        Self::new(world, radius, free, corner_free, implied)
    }
}
