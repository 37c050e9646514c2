//! Sparse Cholesky factorisation with a kept symbolic part.
//!
//! Everything here is sequential on purpose: the factorisation is the same to the last bit whatever the number of
//! threads, and the cores are used for independent components instead.

use std::ops::AddAssign;
use std::sync::Arc;

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::sparse::linalg::SupernodalThreshold;
use faer::sparse::linalg::cholesky::{
    CholeskySymbolicParams, LltRef, SymbolicCholesky, SymmetricOrdering, factorize_symbolic_cholesky,
};
use faer::sparse::{SparseColMat, SymbolicSparseColMat};
use faer::traits::ComplexField;
use faer::{Conj, Par, Side};

/// A linear solve failed.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum SolveError {
    /// The matrix is not positive definite to working precision.
    #[error("the matrix of {n} unknowns is not positive definite")]
    NotPositiveDefinite {
        /// Number of unknowns.
        n: usize,
    },
    /// The factorisation does not fit.
    #[error("the factorisation of {n} unknowns does not fit into memory")]
    TooLarge {
        /// Number of unknowns.
        n: usize,
    },
}

/// A Hermitian (for real `T`: symmetric) sparse matrix of which the lower triangle is stored.
#[derive(Clone, Debug)]
pub struct HermitianMatrix<T> {
    lower: SparseColMat<u32, T>,
}

impl<T: ComplexField + Copy + AddAssign> HermitianMatrix<T> {
    /// Sums (row, column, value) entries of the lower triangle of an `n` × `n` matrix, row ≥ column. Entries of the
    /// upper triangle are a bug of the caller: they would be ignored by the factorisation. Entries at one place are
    /// summed in the order given. O(nnz log d) with d entries in a column.
    pub fn from_lower(n: usize, entries: &[(u32, u32, T)]) -> Self {
        debug_assert!(entries.iter().all(|&(r, c, _)| r >= c && (r as usize) < n));
        let columns = by_column(n, entries);
        let mut starts = Vec::with_capacity(n + 1);
        let mut rows: Vec<u32> = Vec::with_capacity(columns.len());
        let mut values: Vec<T> = Vec::with_capacity(columns.len());
        starts.push(0u32);
        let mut i = 0;
        for column in 0..n as u32 {
            let first = rows.len();
            while let Some(&(r, _, v)) = columns.get(i).filter(|e| e.1 == column) {
                match rows.last() {
                    Some(&last) if rows.len() > first && last == r => {
                        let sum = values.len() - 1;
                        values[sum] += v;
                    }
                    _ => {
                        rows.push(r);
                        values.push(v);
                    }
                }
                i += 1;
            }
            starts.push(rows.len() as u32);
        }
        let symbolic = SymbolicSparseColMat::new_checked(n, n, starts, None, rows);
        Self { lower: SparseColMat::new(symbolic, values) }
    }

    /// Number of rows.
    pub fn n(&self) -> usize {
        self.lower.ncols()
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

/// A factorisation A = L Lᴴ.
///
/// ```
/// use quadrille::engine::numerics::{Cholesky, HermitianMatrix};
///
/// let matrix = HermitianMatrix::from_lower(2, &[(0, 0, 4.0), (1, 0, 2.0), (1, 1, 5.0)]);
/// let mut x = [8.0, 12.0];
/// Cholesky::new(&matrix)?.solve(&mut x);
/// assert!((x[0] - 1.0_f64).abs() < 1e-12 && (x[1] - 2.0).abs() < 1e-12);
/// # Ok::<(), quadrille::engine::numerics::SolveError>(())
/// ```
#[derive(Clone, Debug)]
pub struct Cholesky<T: ComplexField> {
    symbolic: Arc<SymbolicCholesky<u32>>,
    values: Vec<T>,
    n: usize,
}

impl<T: ComplexField + Copy + AddAssign> Cholesky<T> {
    /// Analyses and factors a positive definite matrix.
    ///
    /// # Errors
    /// [`SolveError`] if it is not positive definite or does not fit.
    pub fn new(matrix: &HermitianMatrix<T>) -> Result<Self, SolveError> {
        // Columns are factored in groups whatever their number: the field of fandisk at 5,000 quads took 4.9 s so, and 5.7 s
        // with the choice that is made automatically, which is one by one for small matrices.
        let groups = CholeskySymbolicParams {
            supernodal_flop_ratio_threshold: SupernodalThreshold::FORCE_SUPERNODAL,
            ..CholeskySymbolicParams::default()
        };
        let symbolic =
            factorize_symbolic_cholesky(matrix.lower.symbolic(), Side::Lower, SymmetricOrdering::Amd, groups)
                .map_err(|_| SolveError::TooLarge { n: matrix.n() })?;
        Self::with_symbolic(Arc::new(symbolic), matrix)
    }

    /// Factors another matrix of the same pattern.
    ///
    /// # Errors
    /// As [`Cholesky::new`].
    pub fn refactor(&self, matrix: &HermitianMatrix<T>) -> Result<Self, SolveError> {
        Self::with_symbolic(self.symbolic.clone(), matrix)
    }

    fn with_symbolic(symbolic: Arc<SymbolicCholesky<u32>>, matrix: &HermitianMatrix<T>) -> Result<Self, SolveError> {
        let n = matrix.n();
        let mut values = vec![T::zero_impl(); symbolic.len_val()];
        if n > 0 {
            let scratch = symbolic.factorize_numeric_llt_scratch::<T>(Par::Seq, Default::default());
            let mut memory = MemBuffer::try_new(scratch).map_err(|_| SolveError::TooLarge { n })?;
            symbolic
                .factorize_numeric_llt(
                    &mut values,
                    matrix.lower.as_ref(),
                    Side::Lower,
                    Default::default(),
                    Par::Seq,
                    MemStack::new(&mut memory),
                    Default::default(),
                )
                .map_err(|_| SolveError::NotPositiveDefinite { n })?;
        }
        Ok(Self { symbolic, values, n })
    }

    /// Number of unknowns.
    pub fn n(&self) -> usize {
        self.n
    }

    /// Solves A x = b for each column of `columns` (column after column, each of length n), in place.
    pub fn solve(&self, columns: &mut [T]) {
        if self.n == 0 {
            return;
        }
        let n_columns = columns.len() / self.n;
        let b = faer::MatMut::from_column_major_slice_mut(columns, self.n, n_columns);
        let mut memory = MemBuffer::new(self.symbolic.solve_in_place_scratch::<T>(n_columns, Par::Seq));
        LltRef::new(&self.symbolic, &self.values).solve_in_place_with_conj(
            Conj::No,
            b,
            Par::Seq,
            MemStack::new(&mut memory),
        );
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn solves_a_small_system_and_refuses_an_indefinite_one() {
        let a = HermitianMatrix::from_lower(2, &[(0, 0, 4.0), (1, 0, 1.0), (1, 1, 3.0)]);
        let factor = Cholesky::new(&a).unwrap();
        let mut b = [1.0, 2.0, 5.0, 4.0];
        factor.solve(&mut b);
        for (x, expected) in b.iter().zip([1.0_f64 / 11.0, 7.0 / 11.0, 1.0, 1.0]) {
            assert!((x - expected).abs() < 1e-14);
        }
        let indefinite = HermitianMatrix::from_lower(2, &[(0, 0, 1.0), (1, 0, 2.0), (1, 1, 1.0)]);
        assert_eq!(factor.refactor(&indefinite).unwrap_err(), SolveError::NotPositiveDefinite { n: 2 });
    }
}
