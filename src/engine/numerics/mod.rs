//! Linear algebra, sets, shortest paths and random numbers, without geometry; the only door to the sparse solvers.

mod cholesky;
mod dense;
mod digits;
mod disjoint_sets;
mod fronts;
mod hermitian;
mod multifrontal;
mod path_search;
mod random;
mod scalar;

pub use cholesky::{Cholesky, SolveError};
pub use dense::{cholesky_lower, inverse, positive_definite_inverse};
pub use digits::rounded;
pub use disjoint_sets::DisjointSets;
pub use hermitian::{HermitianMatrix, Pattern, by_column};
pub use path_search::PathSearch;
pub use random::Random;
pub use scalar::Scalar;
