//! Why a soup cannot be conditioned.

use crate::engine::mesh::MeshError;
use crate::engine::run::Blame;
use crate::engine::run::Cancelled;
use crate::engine::run::Fault;

/// A soup holds no surface that quads can be made for.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ConditionError {
    /// No polygons at all.
    #[error("the model has no faces; a surface with at least one triangle is needed")]
    Empty,
    /// Every polygon has a corner that is NaN or infinite.
    #[error("all {polygons} faces have corners that are not finite numbers")]
    AllNotFinite {
        /// Polygons of the soup.
        polygons: usize,
    },
    /// The bounding box is a point, too large or too small to compute with.
    #[error("the model's extent is {extent}; it must lie between 1e-50 and 1e50 units")]
    Extent {
        /// Largest side of the bounding box, as text.
        extent: String,
    },
    /// Every polygon is degenerate.
    #[error("none of the {polygons} faces has an area")]
    ZeroArea {
        /// Polygons of the soup.
        polygons: usize,
    },
    /// Nothing was left after the repairs.
    #[error("no surface was left of {polygons} faces after the repairs")]
    NothingLeft {
        /// Polygons of the soup.
        polygons: usize,
    },
    /// A component has only one side, like a Möbius strip.
    #[error(
        "component {component} is not orientable: it has only one side; cut it open, or allow the cut (non_orientable)"
    )]
    NonOrientable {
        /// The component, counted in order of first faces.
        component: usize,
        /// Polygons of the soup along an orientation-reversing cut, at most 20.
        elements: Vec<u64>,
    },
    /// The run was stopped.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
    /// The repairs failed to make a manifold: a bug.
    #[error("conditioning left something that is not a manifold: {0}")]
    Internal(#[from] MeshError),
}

impl Blame for ConditionError {
    fn fault(&self) -> Fault {
        match self {
            ConditionError::Cancelled(_) => Fault::Cancelled,
            ConditionError::Internal(_) => Fault::Internal,
            _ => Fault::Input,
        }
    }

    fn elements(&self) -> Vec<u64> {
        match self {
            ConditionError::NonOrientable { elements, .. } => elements.clone(),
            _ => Vec::new(),
        }
    }
}
