//! The limits of the jerk-limited problem and their barrier.
//!
//! At a place the squared speed `y` of the reference's time, half its slope `w` and the slope of that, `w'`, are sums of the unknowns of three neighbouring
//! cells. All limits of a place are read in these three, two at once in the vector units; only their sums are taken to the unknowns.

use super::barrier::Logs;

/// Rows are kept in groups of this many for the vector units.
const LANES: usize = 2;
/// Coefficients of a row.
const PARTS: usize = 7;

/// By how much a step that leads beyond a limit is shortened.
const SHORTER: f64 = 0.8;

/// Weights of three neighbouring cells from `at` on for `y`, `w` and `w'`.
#[derive(Debug, Clone, Copy)]
pub(super) struct Place {
    pub at: usize,
    pub basis: [[f64; 3]; 3],
}

/// A limit `|sqrt(y) (rooted . (y, w, w') + root) + plain . (y, w) + constant| <= 1`.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Row {
    pub rooted: [f64; 3],
    pub root: f64,
    pub plain: [f64; 2],
    pub constant: f64,
    /// Which limit it belongs to.
    pub owner: usize,
}

/// Limits at places.
#[derive(Debug, Default)]
pub(super) struct Lines {
    /// Places, and the end of their groups.
    places: Vec<(Place, usize)>,
    groups: Vec<[[f64; LANES]; PARTS]>,
    owners: Vec<[usize; LANES]>,
}

impl Row {
    /// Its size where a change of the unknowns by 1 takes it, and its value, both at y = 1 without slope.
    pub fn reach(&self, place: &Place) -> [f64; 2] {
        let cell = |p: usize| (0..3).map(|i| self.rooted[i] * place.basis[i][p]).sum::<f64>().abs();
        [(0..3).map(cell).sum(), (self.rooted[0] + self.root + self.plain[0] + self.constant).abs()]
    }
}

impl Lines {
    pub fn clear(&mut self) {
        self.places.clear();
        self.groups.clear();
        self.owners.clear();
    }

    /// Adds the limits of a place.
    pub fn add(&mut self, place: Place, rows: &[Row]) {
        for rows in rows.chunks(LANES) {
            // Where a group is not full, rows of zeros change nothing.
            let row = |i: usize| rows.get(i).copied().unwrap_or(Row { owner: usize::MAX, ..Row::default() });
            let part = |p: usize| {
                std::array::from_fn(|i| {
                    let Row { rooted: [a, b, c], root, plain: [d, e], constant, .. } = row(i);
                    [a, b, c, root, d, e, constant][p]
                })
            };
            self.groups.push(std::array::from_fn(part));
            self.owners.push(std::array::from_fn(|i| row(i).owner));
        }
        if !rows.is_empty() {
            self.places.push((place, self.groups.len()));
        }
    }

    /// Whether all limits are kept up to the share `most` with the same `y` everywhere; of what a limit asks at rest half the room is used.
    pub fn admits(&self, y: f64, most: f64) -> bool {
        let root = y.sqrt();
        self.groups.iter().all(|[a, _, _, k, d, _, m]| {
            (0..LANES).all(|i| (root * (a[i] * y + k[i]) + d[i] * y + m[i]).abs() < most.max(0.5 + 0.5 * m[i].abs()).min(1.0))
        })
    }

    /// Adds the barrier of all limits: minus the logarithms of `1 - value^2`, their gradient and their matrix (as far as it is positive); false beyond them.
    pub fn read(&self, y: &[f64], gradient: &mut [f64], matrix: &mut [[f64; 3]], logs: &mut Logs) -> bool {
        let mut from = 0;
        for (place, to) in &self.places {
            let Some(sums) = place.sums(y, &self.groups[from..*to], logs) else { return false };
            from = *to;
            place.spread(&sums, gradient, matrix);
        }
        true
    }

    /// How much of a step away from `y`, of `share` at most, leaves all limits kept: shortened at each place in turn.
    pub fn longest(&self, y: &[f64], step: &[f64], mut share: f64) -> f64 {
        let mut from = 0;
        for (place, to) in &self.places {
            let (here, change) = (place.values(y), place.values(step));
            while !inside([0, 1, 2].map(|i| here[i] - share * change[i]), &self.groups[from..*to]) && share > 1e-12 {
                share *= SHORTER;
            }
            from = *to;
        }
        share
    }

    /// Owner and share of every limit at `y`.
    pub fn shares(&self, y: &[f64], mut note: impl FnMut(usize, f64)) {
        let mut from = 0;
        for (place, to) in &self.places {
            let [level, slope, curve] = place.values(y);
            let root = level.sqrt();
            for (group, owners) in self.groups[from..*to].iter().zip(&self.owners[from..*to]) {
                let [a, b, c, k, d, e, m] = group;
                for i in (0..LANES).filter(|i| owners[*i] != usize::MAX) {
                    let share = root * (a[i] * level + b[i] * slope + c[i] * curve + k[i]) + d[i] * level + e[i] * slope + m[i];
                    note(owners[i], share);
                }
            }
            from = *to;
        }
    }
}

/// Whether limits are kept with the given `y`, `w`, `w'`.
fn inside([level, slope, curve]: [f64; 3], groups: &[[[f64; LANES]; PARTS]]) -> bool {
    let (root, mut kept) = (level.sqrt(), true);
    for [a, b, c, k, d, e, m] in groups {
        for i in 0..LANES {
            let value = root * (a[i] * level + b[i] * slope + c[i] * curve + k[i]) + d[i] * level + e[i] * slope + m[i];
            kept &= value.abs() < 1.0;
        }
    }
    kept
}

impl Place {
    /// `y`, `w` and `w'`.
    fn values(&self, y: &[f64]) -> [f64; 3] {
        let y = [y[self.at], y[self.at + 1], y[self.at + 2]];
        self.basis.map(|e| e[0] * y[0] + e[1] * y[1] + e[2] * y[2])
    }

    /// First and second derivatives of the barrier of the limits here, by `y`, `w`, `w'`; none if one is exceeded.
    fn sums(&self, y: &[f64], groups: &[[[f64; LANES]; PARTS]], logs: &mut Logs) -> Option<[f64; 9]> {
        let [level, slope, curve] = self.values(y);
        let root = level.sqrt();
        let half = 0.5 / root;
        let mut sums = [[0.0; LANES]; 9];
        let mut product = [1.0; LANES];
        for [a, b, c, k, d, e, m] in groups {
            for i in 0..LANES {
                let inner = a[i] * level + b[i] * slope + c[i] * curve + k[i];
                let value = root * inner + d[i] * level + e[i] * slope + m[i];
                let parts = [root * a[i] + half * inner + d[i], root * b[i] + e[i], root * c[i]];
                let (square, room) = (value * value, 1.0 - value * value);
                product[i] = if room > 0.0 { product[i] * room } else { f64::NAN };
                let inverse = 1.0 / room;
                let first = 2.0 * value * inverse;
                let second = 2.0 * (1.0 + square) * inverse * inverse;
                let scaled = parts.map(|part| second * part);
                sums[0][i] += first * parts[0];
                sums[1][i] += first * parts[1];
                sums[2][i] += first * parts[2];
                sums[3][i] += scaled[0] * parts[0];
                sums[4][i] += scaled[0] * parts[1];
                sums[5][i] += scaled[0] * parts[2];
                sums[6][i] += scaled[1] * parts[1];
                sums[7][i] += scaled[1] * parts[2];
                sums[8][i] += scaled[2] * parts[2];
            }
        }
        let product: f64 = product.iter().product();
        if product.is_nan() {
            return None;
        }
        logs.factor(product);
        Some(sums.map(|sum| sum.iter().sum()))
    }

    /// Adds derivatives by `y`, `w`, `w'` to those by the unknowns.
    fn spread(&self, [a, b, c, aa, ab, ac, bb, bc, cc]: &[f64; 9], gradient: &mut [f64], matrix: &mut [[f64; 3]]) {
        let [e, f, g] = self.basis;
        for i in 0..3 {
            gradient[self.at + i] += a * e[i] + b * f[i] + c * g[i];
            let row = [aa * e[i] + ab * f[i] + ac * g[i], ab * e[i] + bb * f[i] + bc * g[i], ac * e[i] + bc * f[i] + cc * g[i]];
            for j in i..3 {
                matrix[self.at + i][j - i] += row[0] * e[j] + row[1] * f[j] + row[2] * g[j];
            }
        }
    }
}
