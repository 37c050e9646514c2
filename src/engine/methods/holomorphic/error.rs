//! Why there is no differential.

use crate::engine::calculus::CalculusError;
use crate::engine::parameterize::MapError;
use crate::engine::run::Cancelled;

/// The method found no map.
#[derive(Clone, Debug, thiserror::Error)]
pub(super) enum HolomorphicError {
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
    #[error(
        "a surface of genus 0 has no holomorphic quadratic differential but zero; take the method quadcover or cuboid"
    )]
    GenusZero,
    #[error("surfaces with a boundary are not taken in this version; take the method quadcover")]
    Boundary,
    #[error("{0} handles are more than the {1} that curves are searched for")]
    TooManyHandles(usize, usize),
    #[error("only {found} of {wanted} disjoint curves were found: handles are too thin for the triangles")]
    Curves { found: usize, wanted: usize },
    #[error("the harmonic foliation could not be solved for: {0}")]
    Solve(CalculusError),
    #[error("no scale gave a map")]
    NoScale,
    #[error(transparent)]
    Map(MapError),
}

impl From<CalculusError> for HolomorphicError {
    fn from(e: CalculusError) -> Self {
        if let CalculusError::Cancelled(c) = e { Self::Cancelled(c) } else { Self::Solve(e) }
    }
}

impl From<MapError> for HolomorphicError {
    fn from(e: MapError) -> Self {
        if let MapError::Cancelled(c) = e { Self::Cancelled(c) } else { Self::Map(e) }
    }
}
