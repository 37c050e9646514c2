//! Reduced bases `[lenstra_1982]`. Positions of branch points against one origin are far from orthogonal in the energy:
//! whoever moves one alone pulls it away from all its neighbours. In a reduced basis close ones move together.

use crate::engine::parameterize::rounding::gram::{Basis, Gram};

/// Share of the length that a vector must keep when the one before it is projected out.
const DELTA: f64 = 0.99;
/// Swaps at most, per squared number of integers: bunnies take 0.3.
const MOST_SWAPS: usize = 8;
/// Entries are exact far beyond this; no map needs them so large.
const LARGEST_ENTRY: f64 = 1e6;

/// An LLL-reduced basis of the integer vectors for the norm `xᵀ G x`. `None` if the matrix is numerically indefinite
/// or too ill-conditioned. O(n³) where the basis given is good already.
pub(super) fn reduce(gram: &Gram) -> Option<Basis> {
    let n = gram.n;
    let mut l = gram.cholesky(&(0..n).collect::<Vec<_>>())?;
    let mut basis = Basis::unit(n);
    let mut swaps = 0;
    let mut k = 1;
    while k < n {
        shorten(&mut l, &mut basis, k, k - 1);
        let (across, own, before) = (l[k * n + k - 1], l[k * n + k], l[(k - 1) * n + k - 1]);
        if own * own + across * across >= DELTA * before * before {
            (0..k - 1).rev().for_each(|j| shorten(&mut l, &mut basis, k, j));
            k += 1;
            continue;
        }
        swap(&mut l, &mut basis, k);
        swaps += 1;
        if swaps > MOST_SWAPS * n * n {
            break;
        }
        k = (k - 1).max(1);
    }
    let largest = basis.vectors.iter().chain(&basis.dual).fold(0.0_f64, |a, b| a.max(b.abs()));
    (largest <= LARGEST_ENTRY).then_some(basis)
}

/// Subtracts the multiple of vector j from vector k that leaves the least of it.
fn shorten(l: &mut [f64], basis: &mut Basis, k: usize, j: usize) {
    let n = basis.n;
    let times = (l[k * n + j] / l[j * n + j]).round();
    if times == 0.0 {
        return;
    }
    let subtract = |rows: &mut [f64], from: usize, what: usize, times: f64, n_columns: usize| {
        for c in 0..n_columns {
            rows[from * n + c] -= times * rows[what * n + c];
        }
    };
    subtract(l, k, j, times, j + 1);
    subtract(&mut basis.vectors, k, j, times, n);
    subtract(&mut basis.dual, j, k, -times, n);
}

/// Exchanges vectors k − 1 and k and makes the factor triangular again by a rotation of its columns.
fn swap(l: &mut [f64], basis: &mut Basis, k: usize) {
    let n = basis.n;
    for rows in [&mut *l, &mut basis.vectors, &mut basis.dual] {
        (0..n).for_each(|c| rows.swap(k * n + c, (k - 1) * n + c));
    }
    let (a, b) = (l[(k - 1) * n + k - 1], l[(k - 1) * n + k]);
    let length = a.hypot(b);
    let (cos, sin) = (a / length, b / length);
    // The sign keeps the diagonal positive.
    let sign = if l[k * n + k] * cos - l[k * n + k - 1] * sin < 0.0 { -1.0 } else { 1.0 };
    for i in k - 1..n {
        let (x, y) = (l[i * n + k - 1], l[i * n + k]);
        l[i * n + k - 1] = cos * x + sin * y;
        l[i * n + k] = sign * (cos * y - sin * x);
    }
}
