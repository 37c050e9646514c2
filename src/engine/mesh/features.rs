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

    /// The feature edges that `others` does not have.
    pub fn without<'a>(&'a self, others: &'a Features) -> impl Iterator<Item = [u32; 2]> + 'a {
        self.edges.iter().copied().filter(|e| others.edges.binary_search(e).is_err())
    }

    /// The network with some of its edges only, in their order. Corners stay where a feature or the boundary is left, and
    /// loose ends become corners.
    pub fn restricted(&self, mesh: &TriMesh, edges: Vec<[u32; 2]>) -> Features {
        let (before, now) = (Self::degrees(&self.edges, mesh), Self::degrees(&edges, mesh));
        let is_corner = |v: u32| {
            let (before, now) = (before[v as usize], now[v as usize]);
            let was = self.is_corner(v) && (now > 0 || mesh.is_boundary_vertex(v));
            was || now != before && now > 0
        };
        let corners = (0..mesh.n_vertices() as u32).filter(|&v| is_corner(v)).collect();
        Features { edges, corners }
    }

    /// Per vertex of `mesh`, how many of the edges end there.
    pub fn degrees(edges: &[[u32; 2]], mesh: &TriMesh) -> Vec<u32> {
        let mut degrees = vec![0; mesh.n_vertices()];
        for &v in edges.iter().flatten() {
            degrees[v as usize] += 1;
        }
        degrees
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
