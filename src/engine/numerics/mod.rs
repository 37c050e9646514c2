//! Linear algebra, sets, shortest paths and random numbers, without geometry; the only door to the sparse solvers.

mod cholesky;
mod dense;
mod digits;
mod disjoint_sets;
mod path_search;
mod random;

pub use cholesky::{Cholesky, HermitianMatrix, SolveError, by_column};
pub use dense::{cholesky_lower, positive_definite_inverse};
pub use digits::rounded;
pub use disjoint_sets::DisjointSets;
pub use path_search::PathSearch;
pub use random::Random;
