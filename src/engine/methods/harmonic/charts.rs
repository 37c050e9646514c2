//! A map whose transitions are quarter turns and any translations: what a singularity graph is taken from.

use glam::DVec2;

use crate::engine::mesh::{TriMesh, next};
use crate::engine::parameterize::{GridMap, Iso, rotate};

/// A seamless map. As [`GridMap`], but translations are any numbers: `z_own = i^rotation z_twin + translation`.
#[derive(Clone, Debug, Default)]
pub(super) struct SeamlessMap {
    pub(super) uv: Vec<DVec2>,
    pub(super) rotation: Vec<u8>,
    pub(super) translation: Vec<DVec2>,
    pub(super) iso: Vec<Iso>,
}

impl SeamlessMap {
    /// The map with these corner values and the rotations and lines of another one; translations follow.
    pub(super) fn new(mesh: &TriMesh, uv: Vec<DVec2>, like: GridMap) -> Self {
        let across = |h: usize| {
            let Some(t) = mesh.twin(h) else { return DVec2::ZERO };
            let gap = |own: usize, other: usize| uv[own] - rotate(uv[other], like.rotation[h]);
            0.5 * (gap(h, next(t)) + gap(next(h), t))
        };
        let translation = (0..mesh.n_halfedges()).map(across).collect();
        Self { uv, rotation: like.rotation, translation, iso: like.iso }
    }

    /// The transition from the chart of the face of `h` to that of its twin, of a point.
    pub(super) fn to_twin(&self, h: usize, z: DVec2) -> DVec2 {
        rotate(z - self.translation[h], (4 - self.rotation[h]) & 3)
    }

    /// Puts both ends of every line exactly on it. Lines are straight up to rounding errors.
    pub(super) fn straighten(&mut self) {
        for h in 0..self.uv.len() {
            let n = next(h);
            match self.iso[h] {
                Iso::None => {}
                Iso::U => self.uv[n].x = self.uv[h].x,
                Iso::V => self.uv[n].y = self.uv[h].y,
            }
        }
    }
}
