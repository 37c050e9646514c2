//! What must come out as quad edges and quad vertices.

use crate::engine::mesh::TriMesh;

/// The feature network of a mesh: interior edges that must become chains of quad edges, and vertices that must become
/// quad vertices. Boundary edges are not listed: they are known from the mesh.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Features {
    /// Interior feature edges as (lower, higher) vertex index, sorted.
    pub edges: Vec<[u32; 2]>,
    /// Ends, junctions and sharp turns of feature curves and of the boundary, sorted vertex indices.
    pub corners: Vec<u32>,
}

impl Features {
    /// Whether the edge between `a` and `b` is an interior feature edge.
    pub fn is_edge(&self, a: u32, b: u32) -> bool {
        self.edges.binary_search(&[a.min(b), a.max(b)]).is_ok()
    }

    /// Whether vertex `v` is a corner.
    pub fn is_corner(&self, v: u32) -> bool {
        self.corners.binary_search(&v).is_ok()
    }

    /// Per halfedge of `mesh`: whether it lies on a feature curve or on the boundary.
    pub fn halfedge_flags(&self, mesh: &TriMesh) -> Vec<bool> {
        (0..mesh.n_halfedges()).map(|h| mesh.is_boundary(h) || self.is_edge(mesh.origin(h), mesh.target(h))).collect()
    }
}
