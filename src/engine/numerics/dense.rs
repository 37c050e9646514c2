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

/// The lower triangle L of `A = L Lᵀ` for a symmetric `n` × `n` matrix given row after row, zeros above; `None` if it is
/// not positive definite. For small matrices: O(n³) without blocking.
pub fn cholesky_lower(n: usize, rows: &[f64]) -> Option<Vec<f64>> {
    let mut l = vec![0.0; n * n];
    for i in 0..n {
        for j in 0..=i {
            let known: f64 = l[i * n..i * n + j].iter().zip(&l[j * n..j * n + j]).map(|(a, b)| a * b).sum();
            let rest = rows[i * n + j] - known;
            if i > j {
                l[i * n + j] = rest / l[j * n + j];
            } else if rest > 0.0 {
                l[i * n + i] = rest.sqrt();
            } else {
                return None;
            }
        }
    }
    Some(l)
}
