//! Signs across edges: the monodromy of a twofold covering.

use crate::engine::mesh::{TriMesh, prev};

/// Whether the two sheets of a covering are exchanged across each halfedge, the same for twins. Around a branch point they
/// are exchanged an odd number of times.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Signs {
    is_exchanged: Vec<bool>,
}

impl Signs {
    /// No exchange anywhere: the covering is two copies of the surface.
    pub fn trivial(mesh: &TriMesh) -> Self {
        Self { is_exchanged: vec![false; mesh.n_halfedges()] }
    }

    /// The sign across halfedge `h`, 1 or −1.
    pub fn across(&self, h: usize) -> f64 {
        if self.is_exchanged[h] { -1.0 } else { 1.0 }
    }

    /// Whether the sheets are exchanged across halfedge `h`.
    pub fn is_exchanged(&self, h: usize) -> bool {
        self.is_exchanged[h]
    }

    /// Changes the sign of an interior edge; the boundary has none.
    pub fn turn(&mut self, mesh: &TriMesh, h: usize) {
        if let Some(t) = mesh.twin(h) {
            self.is_exchanged[h] = !self.is_exchanged[h];
            self.is_exchanged[t] = self.is_exchanged[h];
        }
    }

    /// Exchanges the sheets over face `f`: the same covering, written differently.
    pub fn exchange(&mut self, mesh: &TriMesh, f: usize) {
        (3 * f..3 * f + 3).for_each(|h| self.turn(mesh, h));
    }

    /// Whether the covering branches at vertex `v`. Boundary vertices never do.
    pub fn is_branch(&self, mesh: &TriMesh, v: u32) -> bool {
        !mesh.is_boundary_vertex(v) && mesh.fan(v).filter(|&h| self.is_exchanged[prev(h)]).count() % 2 == 1
    }

    /// The vertices at which the covering branches, in order. O(F).
    pub fn branch_points(&self, mesh: &TriMesh) -> Vec<u32> {
        (0..mesh.n_vertices() as u32).filter(|&v| self.is_branch(mesh, v)).collect()
    }

    /// Per corner (at the origin of its halfedge) the sign of its sheet against that of the first corner of its fan. At
    /// branch points that depends on where the fan begins; functions vanish there. O(F).
    pub fn corners(&self, mesh: &TriMesh) -> Vec<f64> {
        let mut corner = vec![1.0; mesh.n_halfedges()];
        for v in 0..mesh.n_vertices() as u32 {
            let mut sign = 1.0;
            for h in mesh.fan(v) {
                corner[h] = sign;
                sign *= self.across(prev(h));
            }
        }
        corner
    }

    /// Per face of a connected surface, whether its sheets are to be exchanged so that no edge has a sign any more; `None` if
    /// there is no such choice, that is, if the covering is connected. O(F).
    pub fn trivialisation(&self, mesh: &TriMesh) -> Option<Vec<bool>> {
        let mut side: Vec<Option<bool>> = vec![None; mesh.n_faces()];
        for seed in 0..mesh.n_faces() {
            if side[seed].is_some() {
                continue;
            }
            side[seed] = Some(false);
            let mut stack = vec![(seed, false)];
            while let Some((f, own)) = stack.pop() {
                for h in 3 * f..3 * f + 3 {
                    let Some(t) = mesh.twin(h) else { continue };
                    let wanted = own != self.is_exchanged[h];
                    match side[t / 3] {
                        None => {
                            side[t / 3] = Some(wanted);
                            stack.push((t / 3, wanted));
                        }
                        Some(known) if known != wanted => return None,
                        Some(_) => {}
                    }
                }
            }
        }
        Some(side.into_iter().map(|side| side == Some(true)).collect())
    }
}
