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

/// The inverse of an `n` × `n` matrix given row after row, by elimination with pivots of the largest size in their column; `None` if
/// a pivot is below 1e-12 of the largest entry. For small matrices: O(n³) without blocking.
pub fn inverse(n: usize, rows: &[f64]) -> Option<Vec<f64>> {
    let width = 2 * n;
    let mut m = vec![0.0; n * width];
    for i in 0..n {
        m[i * width..i * width + n].copy_from_slice(&rows[i * n..i * n + n]);
        m[i * width + n + i] = 1.0;
    }
    let least = 1e-12 * rows.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
    for k in 0..n {
        let pivot = (k..n).max_by(|&a, &b| m[a * width + k].abs().total_cmp(&m[b * width + k].abs()))?;
        if m[pivot * width + k].abs() <= least {
            return None;
        }
        (0..width).for_each(|j| m.swap(k * width + j, pivot * width + j));
        let scale = m[k * width + k];
        (0..width).for_each(|j| m[k * width + j] /= scale);
        for i in (0..n).filter(|&i| i != k) {
            let factor = m[i * width + k];
            (0..width).for_each(|j| m[i * width + j] -= factor * m[k * width + j]);
        }
    }
    Some((0..n * n).map(|k| m[(k / n) * width + n + k % n]).collect())
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
