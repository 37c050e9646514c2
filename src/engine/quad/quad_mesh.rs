//! A pure quad mesh, and the draft of one that still knows where it lies on the surface.

use glam::DVec3;

/// Quads over positions, counter-clockwise seen from outside. Nothing is proved: the certificate does that.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct QuadMesh {
    /// Vertex positions in model units.
    pub positions: Vec<DVec3>,
    /// Corners of the quads.
    pub quads: Vec<[u32; 4]>,
}

/// What a quad vertex must stay on while the quads are optimised.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Anchor {
    /// This vertex of the surface mesh: a corner of the feature network; the position is exact.
    Corner(u32),
    /// A feature curve or the boundary.
    Curve,
    /// The surface.
    Surface,
}

/// Quads before optimisation: every method ends here.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct QuadDraft {
    /// The quads; positions on the surface up to interpolation error.
    pub mesh: QuadMesh,
    /// Per quad vertex, what it must stay on.
    pub anchors: Vec<Anchor>,
    /// Quad edges that lie on feature curves, as (lower, higher) vertex index, sorted. Boundary edges of the quad mesh
    /// lie on the surface's boundary and are not listed.
    pub feature_edges: Vec<[u32; 2]>,
}

impl QuadDraft {
    /// Appends another draft, renumbering its vertices (not the surface vertices of its corners).
    pub fn append(&mut self, other: QuadDraft) {
        let shift = self.mesh.positions.len() as u32;
        self.mesh.positions.extend(other.mesh.positions);
        self.mesh.quads.extend(other.mesh.quads.into_iter().map(|q| q.map(|v| v + shift)));
        self.anchors.extend(other.anchors);
        self.feature_edges.extend(other.feature_edges.into_iter().map(|e| e.map(|v| v + shift)));
    }
}
