//! Edges, their sides and the stiffness between them.

use faer::c64;

use crate::engine::field::frames::Frames;
use crate::engine::mesh::NONE;
use crate::engine::mesh::TriMesh;

/// The Crouzeix–Raviart elements of a surface.
#[derive(Clone, Debug)]
pub(super) struct Sides {
    /// Interior edge per halfedge, [`NONE`] at the boundary.
    pub(super) edge: Vec<u32>,
    /// The halfedge that owns each interior edge.
    pub(super) owner: Vec<usize>,
    /// `e_i · e_j / A` per face, for the pairs of sides of [`PAIRS`].
    pub(super) stiffness: Vec<[f64; 6]>,
}

/// The pairs of sides of a face in the order of their stiffness.
pub(super) const PAIRS: [(usize, usize); 6] = [(0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (2, 0)];

/// Slot of the stiffness of two sides of a face.
pub(super) fn slot(i: usize, j: usize) -> usize {
    const SLOTS: [[usize; 3]; 3] = [[0, 3, 5], [3, 1, 4], [5, 4, 2]];
    SLOTS[i][j]
}

impl Sides {
    /// Of all faces; those with hardly any area count as if they had `least`.
    pub(super) fn new(mesh: &TriMesh, frames: &Frames, least: f64) -> Self {
        let mut edge = vec![NONE; mesh.n_halfedges()];
        let mut owner = Vec::with_capacity(mesh.n_edges());
        for h in 0..mesh.n_halfedges() {
            if let Some(t) = mesh.twin(h).filter(|_| mesh.is_edge_owner(h)) {
                (edge[h], edge[t]) = (owner.len() as u32, owner.len() as u32);
                owner.push(h);
            }
        }
        let stiffness = (0..mesh.n_faces())
            .map(|f| {
                let area = frames.area(mesh, f).max(least);
                frames.side_products(mesh, f).map(|product| product / area)
            })
            .collect();
        Self { edge, owner, stiffness }
    }

    /// Factor of a value in the chart of the owner of an interior edge, as seen in the chart of halfedge `h`.
    pub(super) fn seen_from(&self, mesh: &TriMesh, turns: &[c64], h: usize) -> c64 {
        if mesh.is_edge_owner(h) { 1.0.into() } else { turns[self.edge[h] as usize].conj() }
    }
}
