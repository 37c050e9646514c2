//! Linear algebra without geometry; the only door to the sparse solvers.

mod cholesky;
mod dense;

pub use cholesky::{Cholesky, HermitianMatrix, SolveError, by_column};
pub use dense::{cholesky_lower, positive_definite_inverse};
