//! Why there is no map.

use crate::engine::field::FieldError;
use crate::engine::parameterize::MapError;
use crate::engine::run::Cancelled;

/// The method found no map.
#[derive(Clone, Debug, thiserror::Error)]
pub enum QuadCoverError {
    /// The run was stopped.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
    /// The field failed.
    #[error(transparent)]
    Field(FieldError),
    /// The map failed.
    #[error(transparent)]
    Map(MapError),
}

impl From<FieldError> for QuadCoverError {
    fn from(e: FieldError) -> Self {
        if let FieldError::Cancelled(c) = e { Self::Cancelled(c) } else { Self::Field(e) }
    }
}

impl From<MapError> for QuadCoverError {
    fn from(e: MapError) -> Self {
        if let MapError::Cancelled(c) = e { Self::Cancelled(c) } else { Self::Map(e) }
    }
}
