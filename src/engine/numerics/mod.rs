//! Linear algebra without geometry; the only door to the sparse solvers.

mod cholesky;

pub use cholesky::{Cholesky, HermitianMatrix, SolveError};
