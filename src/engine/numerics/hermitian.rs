//! Sparse Hermitian matrices, assembled by entries or by values in the order of a fixed list of places.

use std::sync::Arc;

use faer::sparse::SymbolicSparseColMat;

use crate::engine::numerics::scalar::Scalar;

/// Where the entries of the lower triangle of an `n` × `n` matrix stand.
///
/// ```
/// use quadrille::engine::numerics::{Cholesky, Pattern};
///
/// let pattern = Pattern::new(2, [(0, 0), (1, 0), (1, 1), (1, 1)].into_iter());
/// let mut x = [8.0, 12.0];
/// Cholesky::new(&pattern.matrix([4.0, 2.0, 2.0, 3.0].into_iter()))?.solve(&mut x);
/// assert!((x[0] - 1.0_f64).abs() < 1e-12 && (x[1] - 2.0).abs() < 1e-12);
/// # Ok::<(), quadrille::engine::numerics::SolveError>(())
/// ```
#[derive(Clone, Debug)]
pub struct Pattern {
    columns: Arc<SymbolicSparseColMat<u32>>,
    /// Per place in the order given, the stored entry that it adds to.
    slot: Vec<u32>,
}

/// A Hermitian (for real `T`: symmetric) sparse matrix of which the lower triangle is stored.
#[derive(Clone, Debug)]
pub struct HermitianMatrix<T> {
    pub(super) columns: Arc<SymbolicSparseColMat<u32>>,
    pub(super) values: Vec<T>,
}

impl Pattern {
    /// The pattern of these (row, column) places, row ≥ column; places that occur again are summed. Places of the upper
    /// triangle are a bug of the caller. O(nnz log d) with d places in a column.
    pub fn new(n: usize, places: impl ExactSizeIterator<Item = (u32, u32)> + Clone) -> Self {
        debug_assert!(places.clone().all(|(r, c)| r >= c && (r as usize) < n));
        let numbered: Vec<(u32, u32, u32)> = places.zip(0..).map(|((r, c), i)| (r, c, i)).collect();
        let sorted = by_column(n, &numbered);
        let mut slot = vec![0; sorted.len()];
        let mut starts = Vec::with_capacity(n + 1);
        let mut rows: Vec<u32> = Vec::with_capacity(sorted.len());
        let mut at = 0;
        starts.push(0u32);
        for column in 0..n as u32 {
            let first = rows.len();
            while let Some(&(r, _, place)) = sorted.get(at).filter(|e| e.1 == column) {
                if rows.len() == first || rows.last() != Some(&r) {
                    rows.push(r);
                }
                slot[place as usize] = rows.len() as u32 - 1;
                at += 1;
            }
            starts.push(rows.len() as u32);
        }
        Self { columns: Arc::new(SymbolicSparseColMat::new_checked(n, n, starts, None, rows)), slot }
    }

    /// The matrix with these values at the places, in their order; values at one place are summed in the order given.
    pub fn matrix<T: Scalar>(&self, values: impl Iterator<Item = T>) -> HermitianMatrix<T> {
        let mut sums = vec![T::from_real(0.0); self.columns.row_idx().len()];
        for (&slot, value) in self.slot.iter().zip(values) {
            sums[slot as usize] += value;
        }
        HermitianMatrix { columns: self.columns.clone(), values: sums }
    }
}

impl<T: Scalar> HermitianMatrix<T> {
    /// Sums (row, column, value) entries of the lower triangle of an `n` × `n` matrix, as [`Pattern`] does.
    pub fn from_lower(n: usize, entries: &[(u32, u32, T)]) -> Self {
        Pattern::new(n, entries.iter().map(|e| (e.0, e.1))).matrix(entries.iter().map(|e| e.2))
    }

    /// Number of rows.
    pub fn n(&self) -> usize {
        self.columns.ncols()
    }
}

/// The entries sorted by column, then row; entries at one place keep their order. A counting sort by column, then short
/// sorts: assembly would otherwise cost more than the factorisation.
pub fn by_column<T: Copy>(n: usize, entries: &[(u32, u32, T)]) -> Vec<(u32, u32, T)> {
    let mut start = vec![0usize; n + 1];
    for &(_, c, _) in entries {
        start[c as usize + 1] += 1;
    }
    for c in 0..n {
        start[c + 1] += start[c];
    }
    let mut next = start.clone();
    let mut sorted = entries.to_vec();
    for &entry in entries {
        let at = &mut next[entry.1 as usize];
        sorted[*at] = entry;
        *at += 1;
    }
    for c in 0..n {
        sorted[start[c]..start[c + 1]].sort_by_key(|e| e.0);
    }
    sorted
}
