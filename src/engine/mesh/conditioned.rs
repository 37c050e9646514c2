//! The surface that the quads are made for and measured against.

use crate::engine::mesh::{Features, TriMesh};

/// A conditioned surface. "Same topology as the input" means: as this mesh.
#[derive(Clone, Debug)]
pub struct Conditioned {
    /// Oriented 2-manifold without degenerate triangles, in model units.
    pub mesh: TriMesh,
    /// Per face, the polygon of the soup that it comes from.
    pub polygon: Vec<u32>,
    /// Per vertex, the position of the soup that it comes from.
    pub origin: Vec<u32>,
    /// What was repaired: name (`snake_case`, stable) and how often; only what happened.
    pub repairs: Vec<(&'static str, usize)>,
    /// Soft troubles, for people.
    pub warnings: Vec<String>,
}

/// A conditioned surface together with its feature network.
#[derive(Clone, Debug)]
pub struct Surface {
    /// The surface.
    pub mesh: TriMesh,
    /// Its features.
    pub features: Features,
}
