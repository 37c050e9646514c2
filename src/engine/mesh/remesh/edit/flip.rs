//! The other diagonal of two faces.

use crate::engine::mesh::remesh::edit::EditMesh;
use crate::engine::mesh::{NONE, next, prev};

impl EditMesh {
    /// Replaces the diagonal of the two faces at `h` by the other one. The edge must be neither on a curve nor on the
    /// boundary and the new one must not exist yet.
    pub(in crate::engine::mesh) fn flip(&mut self, h: usize) {
        let Some(t) = self.twin(h) else { return };
        let (a, b, c, d) = (self.origin(h), self.target(h), self.apex(h), self.apex(t));
        let outer = [next(t), prev(h), prev(t), next(h)].map(|x| (self.twin[x], self.segment[x]));
        let (f, g) = (h / 3, t / 3);
        self.faces[f] = [a, d, c];
        self.faces[g] = [d, b, c];
        for (slot, (twin, segment)) in [3 * f, 3 * f + 2, 3 * g, 3 * g + 1].into_iter().zip(outer) {
            self.link(slot, twin);
            self.segment[slot] = segment;
        }
        self.link(3 * f + 1, (3 * g + 2) as u32);
        (self.segment[3 * f + 1], self.segment[3 * g + 2]) = (NONE, NONE);
        for (v, x) in [(a, 3 * f), (d, 3 * f + 1), (c, 3 * f + 2), (b, 3 * g + 1)] {
            self.outgoing[v as usize] = x as u32;
        }
    }
}
