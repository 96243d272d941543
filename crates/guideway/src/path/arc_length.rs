//! Arc length of a path and its inverse, by adaptive Gauss-Legendre quadrature over the Bezier pieces.

use super::bezier::derivatives;
use super::bspline::Path;
use std::sync::{Arc, OnceLock};

/// Nodes and weights of the 8-point Gauss-Legendre rule on [-1, 1], positive half.
const GAUSS: [(f64, f64); 4] = [
    (0.183_434_642_495_649_8, 0.362_683_783_378_362),
    (0.525_532_409_916_329, 0.313_706_645_877_887_3),
    (0.796_666_477_413_626_7, 0.222_381_034_453_374_48),
    (0.960_289_856_497_536_2, 0.101_228_536_290_376_26),
];
/// Two halves and the whole must agree to this share of the path's size.
const AGREEMENT: f64 = 1e-11;
const DEPTH: u32 = 24;
/// Newton's method ends when the length is met to this share of the path's.
const MET: f64 = 1e-14;

/// A stretch of one Bezier piece on which one Gauss rule is exact enough.
#[derive(Debug, Clone, Copy)]
pub(super) struct Leaf {
    pub piece: usize,
    pub t: [f64; 2],
    pub s: [f64; 2],
    /// Is the length in proportion to the parameter, as far as anybody can tell?
    pub even: bool,
}

/// Bezier pieces of positive length, and their arc length.
#[derive(Debug)]
pub(super) struct Table {
    /// (degree + 1) rows per piece.
    control: Vec<f64>,
    /// Parameters of the path at the ends of each piece.
    pub spans: Vec<[f64; 2]>,
    pub leaves: Vec<Leaf>,
    pub length: f64,
    dim: usize,
    stride: usize,
}

impl Table {
    pub fn build(path: &Path) -> Self {
        let (dim, stride) = (path.dimension(), (path.degree() + 1) * path.dimension());
        let mut table = Self { control: Vec::new(), spans: Vec::new(), leaves: Vec::new(), length: 0.0, dim, stride };
        let size = path.control().chunks_exact(dim).zip(path.control()[dim..].chunks_exact(dim)).map(|(a, b)| gap(a, b)).sum::<f64>();
        for span in path.degree()..path.count() {
            let u = [path.knots()[span], path.knots()[span + 1]];
            if u[0] == u[1] {
                continue;
            }
            let control = path.extract(span);
            if control.chunks_exact(dim).all(|row| row == &control[..dim]) {
                continue;
            }
            table.control.extend(control);
            table.spans.push(u);
            table.measure(path.degree() == 1, size);
        }
        table
    }

    /// Adds the leaves of the last piece.
    fn measure(&mut self, straight: bool, size: f64) {
        let piece = self.spans.len() - 1;
        if straight {
            let row = self.piece(piece);
            let length = gap(&row[..self.dim], &row[self.dim..]);
            return self.push((piece, true), [0.0, 1.0], length);
        }
        let even = self.even(piece, size);
        let mut stack = vec![(0.0, 1.0, self.integral(piece, 0.0, 1.0), 0)];
        while let Some((a, b, whole, depth)) = stack.pop() {
            let middle = f64::midpoint(a, b);
            let (left, right) = (self.integral(piece, a, middle), self.integral(piece, middle, b));
            if (left + right - whole).abs() <= AGREEMENT * size || depth >= DEPTH {
                self.push((piece, even), [a, middle], left);
                self.push((piece, even), [middle, b], right);
            } else {
                stack.push((middle, b, right, depth + 1));
                stack.push((a, middle, left, depth + 1));
            }
        }
    }

    /// Are the control points of a piece so evenly spaced on a straight line that Newton's method has nothing to do? The speed changes by no more than twice the
    /// degree times the distance of a control point from its place.
    fn even(&self, piece: usize, size: f64) -> bool {
        let (row, dim) = (self.piece(piece), self.dim);
        let degree = row.len() / dim - 1;
        let place = |i: usize, d: usize| row[d] + (row[degree * dim + d] - row[d]) * i as f64 / degree as f64;
        let off = (0..row.len()).map(|k| (row[k] - place(k / dim, k % dim)).abs()).fold(0.0, f64::max);
        2.0 * (degree * dim) as f64 * off <= 0.3 * MET * size
    }

    fn push(&mut self, (piece, even): (usize, bool), t: [f64; 2], length: f64) {
        let s = [self.length, self.length + length];
        self.length = s[1];
        self.leaves.push(Leaf { piece, t, s, even });
    }

    /// Control rows of a piece.
    pub fn piece(&self, i: usize) -> &[f64] {
        &self.control[i * self.stride..][..self.stride]
    }

    /// Length of the piece from `a` to `b`, m.
    fn integral(&self, piece: usize, a: f64, b: f64) -> f64 {
        let (half, middle) = ((b - a) / 2.0, f64::midpoint(a, b));
        half * GAUSS.iter().map(|(x, w)| w * (self.speed(piece, middle - half * x) + self.speed(piece, middle + half * x))).sum::<f64>()
    }

    fn speed(&self, piece: usize, t: f64) -> f64 {
        let control = self.piece(piece);
        if self.dim == 2 {
            let mut out = [0.0; 4];
            derivatives(control, 2, t, &mut out);
            return out[2].hypot(out[3]);
        }
        let mut out = vec![0.0; 2 * self.dim];
        derivatives(control, self.dim, t, &mut out);
        out[self.dim..].iter().map(|v| v * v).sum::<f64>().sqrt()
    }

    /// Index of the leaf that holds arc length `s`; at a joint the later one.
    pub fn leaf_at(&self, s: f64) -> usize {
        self.leaves.partition_point(|leaf| leaf.s[0] <= s).saturating_sub(1)
    }

    /// Piece and its parameter at arc length `s` (clamped to the path); `None` for a path of no length.
    pub fn locate(&self, s: f64) -> Option<(usize, f64)> {
        let leaf = *self.leaves.get(self.leaf_at(s))?;
        let ([a, b], [s0, s1]) = (leaf.t, leaf.s);
        let share = if s1 > s0 { ((s - s0) / (s1 - s0)).clamp(0.0, 1.0) } else { 0.0 };
        if share == 0.0 || share == 1.0 || leaf.even {
            return Some((leaf.piece, a + share * (b - a)));
        }
        Some((leaf.piece, self.invert(leaf, s, a + share * (b - a))))
    }

    /// Newton's method inside a bracket: the parameter where the leaf's length from its start is `s - leaf.s[0]`.
    fn invert(&self, leaf: Leaf, s: f64, guess: f64) -> f64 {
        let ([mut low, mut high], target) = (leaf.t, s - leaf.s[0]);
        let mut t = guess;
        for _ in 0..60 {
            let miss = self.integral(leaf.piece, leaf.t[0], t) - target;
            if miss.abs() <= MET * self.length {
                break;
            }
            if miss > 0.0 {
                high = t;
            } else {
                low = t;
            }
            let next = t - miss / self.speed(leaf.piece, t);
            let next = if next > low && next < high { next } else { f64::midpoint(low, high) };
            if next == t {
                break;
            }
            t = next;
        }
        t
    }

    /// Arc length at parameter `t` of a piece, m.
    pub fn length_at(&self, piece: usize, t: f64) -> f64 {
        let first = self.leaves.partition_point(|leaf| leaf.piece < piece);
        let count = self.leaves[first..].partition_point(|leaf| leaf.piece == piece && leaf.t[0] <= t).max(1);
        let Some(leaf) = self.leaves.get(first + count - 1) else { return self.length };
        if t >= leaf.t[1] {
            return leaf.s[1];
        }
        (leaf.s[0] + self.integral(piece, leaf.t[0], t)).min(leaf.s[1])
    }
}

fn gap(a: &[f64], b: &[f64]) -> f64 {
    if let ([ax, ay], [bx, by]) = (a, b) {
        return (bx - ax).hypot(by - ay);
    }
    a.iter().zip(b).map(|(x, y)| (y - x) * (y - x)).sum::<f64>().sqrt()
}

/// The table of a path, built once when first asked for. It is no part of the path's value.
#[derive(Debug, Default, Clone)]
pub(super) struct Lazy(OnceLock<Arc<Table>>);

impl Lazy {
    pub fn get(&self, path: &Path) -> &Table {
        self.0.get_or_init(|| Arc::new(Table::build(path)))
    }
}

impl PartialEq for Lazy {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}
