//! Why there is no singularity graph or no map of it.

use crate::engine::field::FieldError;
use crate::engine::mesh::MeshError;
use crate::engine::numerics::SolveError;
use crate::engine::parameterize::MapError;
use crate::engine::run::Cancelled;

/// The method found no map.
#[derive(Clone, Debug, thiserror::Error)]
pub(super) enum HarmonicError {
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
    #[error("there is no field: {0}")]
    Field(FieldError),
    #[error("there is no integer-grid map to take a singularity graph from: {0}")]
    Map(MapError),
    #[error(transparent)]
    Solve(#[from] SolveError),
    #[error(transparent)]
    Mesh(#[from] MeshError),
    #[error("the singularity graph is cut into the triangles, so the map cannot live on those of the input")]
    OnInput,
    #[error("a separatrix is lost where the map of the field folds")]
    Fold,
    #[error("the separatrices do not end")]
    Endless,
    #[error("meta-face {face} of the singularity graph is not a disc")]
    NotDisc { face: u32 },
    #[error("meta-edge {edge} of the singularity graph follows no coordinate line")]
    NotStraight { edge: u32 },
    #[error("the tags around meta-face {face} turn by {quarters} quarter turns instead of 4")]
    Turning { face: u32, quarters: i32 },
    #[error("meta-face {face} is not closed: Σ D{coordinate} = {sum} instead of 0")]
    Open { face: u32, coordinate: char, sum: i64 },
    #[error(
        "meta-face {face} has no side tagged {missing} and cannot close with positive integers: ΣD{coordinate} = 0"
    )]
    OneSided { face: u32, coordinate: char, missing: &'static str },
    #[error("{cause}")]
    Given { cause: String },
    #[error("no positive integers close all meta-faces of the singularity graph")]
    NoIntegers,
}

impl From<FieldError> for HarmonicError {
    fn from(error: FieldError) -> Self {
        match error {
            FieldError::Cancelled(stop) => Self::Cancelled(stop),
            other => Self::Field(other),
        }
    }
}

impl From<MapError> for HarmonicError {
    fn from(error: MapError) -> Self {
        match error {
            MapError::Cancelled(stop) => Self::Cancelled(stop),
            other => Self::Map(other),
        }
    }
}
