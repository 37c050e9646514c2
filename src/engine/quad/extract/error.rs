//! Why there are no quads.

use crate::engine::quad::fill::FillError;
use crate::engine::run::Blame;
use crate::engine::run::Cancelled;
use crate::engine::run::Fault;

/// Why there are no quads.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ExtractError {
    /// The run was stopped.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
    /// The lists of the map do not fit the mesh.
    #[error("the map does not have one entry per halfedge of the mesh; compute it for this mesh")]
    WrongLength,
    /// A coordinate is NaN or infinite.
    #[error("corner {corner} of the map is not finite; the solve that made the map failed")]
    NotFinite {
        /// Corner 3 f + k.
        corner: u32,
    },
    /// The coordinates leave no digits for exact arithmetic.
    #[error("the map extends to {extent} grid units, more than exact arithmetic allows; ask for fewer quads")]
    TooLarge {
        /// Largest coordinate.
        extent: f64,
    },
    /// The two sides of an edge do not fit together.
    #[error("the map gapes by {gap} grid units at the edge {a}-{b}; it is not seamless")]
    GapingSeam {
        /// One end.
        a: u32,
        /// The other end.
        b: u32,
        /// The gap in grid units.
        gap: f64,
    },
    /// The transitions around a regular vertex do not compose to the identity.
    #[error("the transitions of the map around vertex {vertex} do not close")]
    OpenVertex {
        /// The vertex.
        vertex: u32,
    },
    /// A singularity does not lie on a grid point.
    #[error("the transitions of the map put the singular vertex {vertex} off the grid; round the map first")]
    SingularityOffGrid {
        /// The vertex.
        vertex: u32,
    },
    /// A boundary edge does not lie on a grid line.
    #[error("the map does not put the boundary edge {a}-{b} on a grid line; align the map to the boundary")]
    BoundaryOffGrid {
        /// One end.
        a: u32,
        /// The other end.
        b: u32,
    },
    /// The grid lines do not cut the surface into disks of the right number, or what they cut could not be filled.
    #[error("the grid lines of the map do not describe the surface: {reason}; use a finer or less folded map")]
    Unrepairable {
        /// What did not fit.
        reason: String,
    },
}

impl Blame for ExtractError {
    fn fault(&self) -> Fault {
        if matches!(self, ExtractError::Cancelled(_)) { Fault::Cancelled } else { Fault::Internal }
    }
}

impl From<FillError> for ExtractError {
    fn from(error: FillError) -> Self {
        match error {
            FillError::Cancelled(stop) => Self::Cancelled(stop),
            FillError::Topology { .. } | FillError::Stuck { .. } => Self::Unrepairable { reason: error.to_string() },
        }
    }
}
