//! Rotations by quarter turns across edges, and the singularities that they imply.

use crate::engine::mesh::TriMesh;

/// A vertex around which a cross field turns.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Singularity {
    /// The vertex.
    pub vertex: u32,
    /// Index in quarters: +1 is valence 3, −1 valence 5.
    pub quarters: i32,
}

/// A rotation by quarter turns per halfedge: crossing halfedge h from face s to face t, charts obey
/// `z_s = i^m z_t + τ`. The twin carries the inverse; boundary halfedges carry 0.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Matching {
    quarters: Vec<u8>,
}

impl Matching {
    /// From a function of the owner halfedge of each interior edge; twins get the inverse.
    pub fn from_owners(mesh: &TriMesh, quarters_of: impl Fn(usize) -> i32) -> Self {
        let mut quarters = vec![0u8; mesh.n_halfedges()];
        for h in 0..mesh.n_halfedges() {
            if let Some(t) = mesh.twin(h).filter(|_| mesh.is_edge_owner(h)) {
                let m = quarters_of(h).rem_euclid(4) as u8;
                quarters[h] = m;
                quarters[t] = (4 - m) & 3;
            }
        }
        Self { quarters }
    }

    /// Quarter turns, 0 to 3, across halfedge `h`.
    #[inline]
    pub fn across(&self, h: usize) -> u8 {
        self.quarters[h]
    }

    /// Adds `k` quarter turns across `h`, and takes them away across its twin.
    pub fn turn(&mut self, mesh: &TriMesh, h: usize, k: u8) {
        if let Some(t) = mesh.twin(h) {
            self.quarters[h] = (self.quarters[h] + k) & 3;
            self.quarters[t] = (4 - self.quarters[h]) & 3;
        }
    }

    /// Turns the chart of face `f` by `k` quarter turns: `z_f := i^k z_f`, and adapts the rotations of its edges.
    pub(super) fn turn_chart(&mut self, mesh: &TriMesh, f: usize, k: u8) {
        for h in 3 * f..3 * f + 3 {
            if let Some(t) = mesh.twin(h) {
                self.quarters[h] = (self.quarters[h] + k) & 3;
                self.quarters[t] = (4 - self.quarters[h]) & 3;
            }
        }
    }

    /// Sum of the rotations met when crossing the fan of an interior vertex once, counter-clockwise, modulo 4.
    pub fn holonomy(&self, mesh: &TriMesh, v: u32) -> u8 {
        mesh.fan(v).map(|h| self.quarters[crate::engine::mesh::prev(h)]).fold(0, |sum, m| (sum + m) & 3)
    }
}
