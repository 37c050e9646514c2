//! Chains of edges.

use crate::engine::mesh::TriMesh;

/// One edge of a chain. The boundary has halfedges of one direction only.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Step {
    /// A halfedge of the edge.
    pub halfedge: usize,
    /// Whether the chain runs against it.
    pub is_reversed: bool,
}

impl Step {
    /// First vertex.
    pub fn from(&self, mesh: &TriMesh) -> u32 {
        if self.is_reversed { mesh.target(self.halfedge) } else { mesh.origin(self.halfedge) }
    }

    /// Second vertex.
    pub fn to(&self, mesh: &TriMesh) -> u32 {
        if self.is_reversed { mesh.origin(self.halfedge) } else { mesh.target(self.halfedge) }
    }
}
