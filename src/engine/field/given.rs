//! A frame field as a user gives it: the input of QuadCover (`[kaelberer_2007]` section 3), in the place of the field that
//! follows curvature.

use glam::DVec3;

use crate::engine::run::{Blame, Fault};

/// One or two vectors per polygon of the input.
#[derive(Clone, Debug, PartialEq)]
pub enum GivenVectors {
    /// One direction of a cross, model coordinates, of any length; the others follow by quarter turns in the plane of the
    /// face.
    Crosses(Vec<DVec3>),
    /// The gradients of u and v up to one factor for the whole model, which the density sets: of any length and at any
    /// angle other than 0 and 180 degrees.
    Frames(Vec<[DVec3; 2]>),
}

impl GivenVectors {
    /// For how many polygons there are vectors.
    pub fn len(&self) -> usize {
        match self {
            Self::Crosses(vectors) => vectors.len(),
            Self::Frames(vectors) => vectors.len(),
        }
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// What becomes of the branch points of a given field.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum GivenBranchPoints {
    /// They stay where the field has them, and the map follows the field exactly.
    #[default]
    Keep,
    /// The field is where the search begins: crosses are smoothed below the size of the quads, near pairs of branch points
    /// are cancelled, and the others are moved as for a field of the engine's own.
    Optimise,
}

/// Which direction of one polygon goes on as which of another: direction d of polygon `from` as direction d + `quarters` of
/// polygon `to`. Directions are numbered 0 to 3: first, second, minus first, minus second; of a cross counter-clockwise,
/// seen from the side from which the corners of the polygon are in counter-clockwise order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct GivenMatching {
    /// A polygon of the input.
    pub from: u32,
    /// Another one, with which it has an edge in common.
    pub to: u32,
    /// 0 to 3.
    pub quarters: u8,
}

/// A field for all polygons of the input, in their order.
#[derive(Clone, Debug, PartialEq)]
pub struct GivenField {
    /// The vectors.
    pub vectors: GivenVectors,
    /// How directions go on from polygon to polygon; pairs that are not named are matched by the smallest turn.
    pub matchings: Vec<GivenMatching>,
    /// What becomes of its branch points.
    pub branch_points: GivenBranchPoints,
}

/// A field that does not fit the input.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum GivenFieldError {
    /// There are more vectors than polygons, or fewer.
    #[error("field has vectors for {given} polygons, and the input has {polygons}")]
    Count {
        /// Number of vectors, or of pairs.
        given: usize,
        /// Polygons of the input.
        polygons: usize,
    },
    /// It is not known which vectors belong to which polygons.
    #[error(
        "field cannot be used: {polygons} polygons of the input were left out because they name a vertex twice or the like"
    )]
    LeftOut {
        /// Polygons that the reader left out.
        polygons: usize,
    },
    /// Vectors that are zero, not finite or normal to their polygon, or pairs of parallel ones.
    #[error(
        "the vectors of {} polygons of field span no frame: zero, not finite, normal to the polygon, or parallel",
        polygons.len()
    )]
    Degenerate {
        /// Which polygons.
        polygons: Vec<u32>,
    },
    /// A matching between polygons that are no neighbours, or that turn around each other.
    #[error("{} matchings of field are between polygons that are no neighbours or not oriented alike", polygons.len())]
    Matching {
        /// The first polygons of the pairs.
        polygons: Vec<u32>,
    },
}

impl Blame for GivenFieldError {
    fn fault(&self) -> Fault {
        Fault::Request
    }

    fn spec_field(&self) -> &'static str {
        "field"
    }

    fn elements(&self) -> Vec<u64> {
        match self {
            Self::Count { .. } | Self::LeftOut { .. } => Vec::new(),
            Self::Degenerate { polygons } | Self::Matching { polygons } => {
                polygons.iter().map(|&polygon| u64::from(polygon)).collect()
            }
        }
    }
}
