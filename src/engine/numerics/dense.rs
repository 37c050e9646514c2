//! Small dense linear algebra.

use faer::Mat;
use faer::Side;
use faer::linalg::solvers::DenseSolveCore;

/// The inverse of a symmetric positive definite `n` × `n` matrix given row after row, or `None` if it is not positive
/// definite. O(n³).
pub fn positive_definite_inverse(n: usize, rows: &[f64]) -> Option<Vec<f64>> {
    let a = Mat::from_fn(n, n, |i, j| 0.5 * (rows[i * n + j] + rows[j * n + i]));
    let inverse = a.llt(Side::Lower).ok()?.inverse();
    Some((0..n * n).map(|k| inverse[(k / n, k % n)]).collect())
}
