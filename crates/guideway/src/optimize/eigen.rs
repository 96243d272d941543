//! Eigenvalues and eigenvectors of a symmetric matrix by Jacobi's rotations, warm-started.
//!
//! Source: \[golub2013\], section 8.5. A covariance changes little between decompositions, so in the old eigenvectors it is nearly diagonal and few sweeps do.

/// Sweeps over all pairs, at most; convergence is quadratic, so more are never of use.
const SWEEPS: usize = 30;
/// Off-diagonal numbers below that share of the geometric mean of their diagonal ones are zero.
const NEGLIGIBLE: f64 = 1e-12;

/// Replaces the rows of `basis` (orthonormal, `n` by `n`) by eigenvectors of the symmetric `matrix`; gives back the eigenvalues in the order of the rows.
pub(super) fn eigen(matrix: &[f64], basis: &mut [f64], n: usize) -> Vec<f64> {
    let mut a = congruent(matrix, basis, n);
    for _ in 0..SWEEPS {
        let mut rotated = false;
        for p in 0..n {
            for q in p + 1..n {
                if a[p * n + q].abs() > NEGLIGIBLE * (a[p * n + p] * a[q * n + q]).abs().sqrt() {
                    rotate(&mut a, basis, n, (p, q));
                    rotated = true;
                }
            }
        }
        if !rotated {
            break;
        }
    }
    (0..n).map(|k| a[k * n + k]).collect()
}

/// The matrix seen in the basis.
fn congruent(matrix: &[f64], basis: &[f64], n: usize) -> Vec<f64> {
    let half: Vec<f64> = basis.chunks(n).flat_map(|row| matrix.chunks(n).map(|m| dot(row, m))).collect();
    half.chunks(n).flat_map(|row| basis.chunks(n).map(|b| dot(row, b))).collect()
}

/// Makes the numbers at `(p, q)` and `(q, p)` zero.
fn rotate(a: &mut [f64], basis: &mut [f64], n: usize, (p, q): (usize, usize)) {
    let ratio = (a[q * n + q] - a[p * n + p]) / (2.0 * a[p * n + q]);
    let t = 1.0f64.copysign(ratio) / (ratio.abs() + ratio.hypot(1.0));
    let c = 1.0 / t.hypot(1.0);
    let s = t * c;
    let (low, high) = (a[p * n + p] - t * a[p * n + q], a[q * n + q] + t * a[p * n + q]);
    turn(a, n, (p, q), (c, s));
    for k in 0..n {
        (a[k * n + p], a[k * n + q]) = (a[p * n + k], a[q * n + k]);
    }
    // The block of the pair was turned from one side only; what it becomes is known.
    (a[p * n + p], a[q * n + q]) = (low, high);
    (a[p * n + q], a[q * n + p]) = (0.0, 0.0);
    turn(basis, n, (p, q), (c, s));
}

/// Turns two rows into each other.
fn turn(rows: &mut [f64], n: usize, (p, q): (usize, usize), (c, s): (f64, f64)) {
    let (head, tail) = rows.split_at_mut(q * n);
    for (x, y) in head[p * n..][..n].iter_mut().zip(&mut tail[..n]) {
        (*x, *y) = (c * *x - s * *y, s * *x + c * *y);
    }
}

/// Scalar product.
pub(super) fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}
