//! Why there is no map.

use crate::engine::numerics::SolveError;
use crate::engine::run::Cancelled;

/// No map was found.
#[derive(Clone, Debug, thiserror::Error)]
pub enum MapError {
    /// The run was stopped.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
    /// A linear solve failed.
    #[error("the map could not be solved for: {0}")]
    Solve(#[from] SolveError),
    /// The integers have no unique real optimum.
    #[error("the {n} integers of the map have no unique real optimum")]
    Periods {
        /// Number of integers.
        n: usize,
    },
    /// The conditions on the integers contradict each other.
    #[error("{n} positions that must be integers are fractions of integers")]
    Fractions {
        /// Number of such positions.
        n: usize,
    },
    /// Neither the period matrix nor a flow gave integers.
    #[error("no flow was found for the {n} integers of the map")]
    NoFlow {
        /// Number of integers.
        n: usize,
    },
    /// More integers than the period matrix can be held for.
    #[error("the map has {n} integers, more than the limit of {limit}")]
    TooManyIntegers {
        /// Number of integers.
        n: usize,
        /// The limit.
        limit: usize,
    },
}
