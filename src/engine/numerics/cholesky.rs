//! Sparse Cholesky factorisation with a kept symbolic part.

use std::sync::Arc;

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::sparse::linalg::SupernodalThreshold;
use faer::sparse::linalg::cholesky::{
    CholeskySymbolicParams, LltRef, SymbolicCholesky, SymbolicCholeskyRaw, SymmetricOrdering,
    factorize_symbolic_cholesky,
};
use faer::{Conj, Par, Side};

use crate::engine::numerics::fronts::Fronts;
use crate::engine::numerics::hermitian::HermitianMatrix;
use crate::engine::numerics::multifrontal::{self, NotPositive};
use crate::engine::numerics::scalar::Scalar;

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
pub struct Cholesky<T: Scalar> {
    analysis: Arc<Analysis>,
    values: Vec<T>,
    n: usize,
}

/// What does not depend on the values of the matrix.
#[derive(Debug)]
struct Analysis {
    symbolic: SymbolicCholesky<u32>,
    /// `None` for diagonal matrices, which the library does not put into groups of columns.
    fronts: Option<Fronts>,
}

impl Analysis {
    /// The factor of a diagonal matrix.
    fn root_of_diagonal<T: Scalar>(&self, diagonal: &[T], values: &mut [T]) -> Result<(), NotPositive> {
        let order = self.symbolic.perm().map_or(&[][..], |p| p.arrays().0);
        for (value, &i) in values.iter_mut().zip(order) {
            let root = diagonal.get(i as usize).map_or(0.0, |d| d.real_part().sqrt());
            *value = if root > 0.0 { T::from_real(root) } else { return Err(NotPositive) };
        }
        Ok(())
    }
}

impl<T: Scalar> Cholesky<T> {
    /// Analyses and factors a positive definite matrix.
    ///
    /// # Errors
    /// [`SolveError`] if it is not positive definite or does not fit.
    pub fn new(matrix: &HermitianMatrix<T>) -> Result<Self, SolveError> {
        let n = matrix.n();
        // Columns are factored in groups whatever their number: the automatic choice is one by one for small matrices.
        let groups = CholeskySymbolicParams {
            supernodal_flop_ratio_threshold: SupernodalThreshold::FORCE_SUPERNODAL,
            ..CholeskySymbolicParams::default()
        };
        let lower = matrix.columns.as_ref().as_ref();
        let symbolic = factorize_symbolic_cholesky(lower, Side::Lower, SymmetricOrdering::Amd, groups)
            .map_err(|_| SolveError::TooLarge { n })?;
        let fronts = match (symbolic.raw(), symbolic.perm()) {
            (SymbolicCholeskyRaw::Supernodal(groups), Some(order)) => {
                Some(Fronts::new(groups, order.arrays().1, lower))
            }
            _ => None,
        };
        Self::with_analysis(Arc::new(Analysis { symbolic, fronts }), matrix)
    }

    /// Factors another matrix of the same pattern.
    ///
    /// # Errors
    /// As [`Cholesky::new`].
    pub fn refactor(&self, matrix: &HermitianMatrix<T>) -> Result<Self, SolveError> {
        Self::with_analysis(self.analysis.clone(), matrix)
    }

    fn with_analysis(analysis: Arc<Analysis>, matrix: &HermitianMatrix<T>) -> Result<Self, SolveError> {
        let n = matrix.n();
        let mut values = Vec::new();
        let len = analysis.symbolic.len_val();
        values.try_reserve_exact(len).map_err(|_| SolveError::TooLarge { n })?;
        values.resize(len, T::from_real(0.0));
        let done = match &analysis.fronts {
            Some(fronts) => multifrontal::factor(fronts, &matrix.values, &mut values),
            None => analysis.root_of_diagonal(&matrix.values, &mut values),
        };
        done.map_err(|_| SolveError::NotPositiveDefinite { n })?;
        Ok(Self { analysis, values, n })
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
        let mut memory = MemBuffer::new(self.analysis.symbolic.solve_in_place_scratch::<T>(n_columns, Par::Seq));
        LltRef::new(&self.analysis.symbolic, &self.values).solve_in_place_with_conj(
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
    use crate::engine::numerics::Random;
    use faer::c64;

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

    #[test]
    fn diagonal_and_empty_matrices_are_matrices_too() {
        let factor = Cholesky::new(&HermitianMatrix::from_lower(3, &[(0, 0, 4.0), (2, 2, 2.0), (1, 1, 8.0)])).unwrap();
        let mut x = [4.0, 4.0, 4.0];
        factor.solve(&mut x);
        assert!(x.iter().zip([1.0, 0.5, 2.0]).all(|(x, e)| (x - e).abs() < 1e-14), "{x:?}");
        let lacking = HermitianMatrix::from_lower(2, &[(0, 0, 4.0)]);
        assert!(Cholesky::new(&lacking).is_err());
        Cholesky::<f64>::new(&HermitianMatrix::from_lower(0, &[])).unwrap().solve(&mut []);
    }

    /// A lattice of `side`² unknowns with couplings of absolute value 1 to right and up, some far ones, and a full
    /// block: nodes of all sizes.
    fn lattice(side: u32) -> (usize, Vec<(u32, u32, c64)>) {
        let mut random = Random::new(7);
        let n = side * side;
        let mut entries = Vec::new();
        let mut couple = |a: u32, b: u32| {
            let angle = random.unit() * std::f64::consts::TAU;
            entries.push((a.max(b), a.min(b), c64::new(angle.cos(), angle.sin())));
            entries.extend([a, b].map(|v| (v, v, c64::new(1.01, 0.0))));
        };
        for v in 0..n {
            if v % side + 1 < side {
                couple(v, v + 1);
            }
            if v + side < n {
                couple(v, v + side);
            }
            if v % 97 == 1 {
                couple(v, (v * 31 + 5) % n);
            }
        }
        for a in 0..90 {
            (0..a).for_each(|b| couple(a * 3, b * 3));
        }
        (n as usize, entries)
    }

    #[test]
    fn the_residual_vanishes_and_threads_change_no_bit() {
        let (n, entries) = lattice(120);
        let matrix = HermitianMatrix::from_lower(n, &entries);
        let right: Vec<c64> = (0..n).map(|i| c64::new((i % 13) as f64, (i % 7) as f64 - 3.0)).collect();
        let solve = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let mut x = right.clone();
            pool.install(|| Cholesky::new(&matrix).unwrap()).solve(&mut x);
            x
        };
        let x = solve(1);
        assert!(solve(2) == x && solve(8) == x);
        let mut residual = right.clone();
        for &(r, c, v) in &entries {
            residual[r as usize] -= v * x[c as usize];
            if r != c {
                residual[c as usize] -= v.conj() * x[r as usize];
            }
        }
        let largest = residual.iter().map(|r| r.re.hypot(r.im)).fold(0.0, f64::max);
        assert!(largest < 1e-10, "{largest}");
    }
}
