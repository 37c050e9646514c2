//! Why there is no form.

use crate::engine::numerics::SolveError;
use crate::engine::run::Cancelled;

/// A form was not found.
#[derive(Clone, Debug, thiserror::Error)]
pub enum CalculusError {
    /// The run was stopped.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
    /// A linear solve failed.
    #[error("the harmonic form could not be solved for: {0}")]
    Solve(#[from] SolveError),
}
