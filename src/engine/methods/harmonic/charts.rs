//! A map whose transitions are quarter turns and any translations: what a singularity graph is taken from.

use std::f64::consts::FRAC_PI_2;

use glam::{DVec2, I64Vec2};

use crate::engine::field::Frames;
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
    pub(super) fn new(mesh: &TriMesh, like: GridMap) -> Self {
        let GridMap { uv, rotation, iso, .. } = like;
        let across = |h: usize| {
            let Some(t) = mesh.twin(h) else { return DVec2::ZERO };
            let gap = |own: usize, other: usize| uv[own] - rotate(uv[other], rotation[h]);
            0.5 * (gap(h, next(t)) + gap(next(h), t))
        };
        let translation = (0..mesh.n_halfedges()).map(across).collect();
        Self { uv, rotation, translation, iso }
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

/// A seamless map in the form of one with integers, to be untangled: corner values, rotations and lines; no translations.
/// `direction` is the angle of ∇u per face, `is_followed` per halfedge whether it is to lie on a line.
pub(super) fn seamless_grid(
    mesh: &TriMesh,
    frames: &Frames,
    direction: &[f64],
    is_followed: &[bool],
    uv: Vec<DVec2>,
) -> GridMap {
    let mut rotation = vec![0u8; mesh.n_halfedges()];
    for h in 0..mesh.n_halfedges() {
        let Some(t) = mesh.twin(h).filter(|_| mesh.is_edge_owner(h)) else { continue };
        // The edge is the same vector in both charts but for the rotation.
        let (own, other) = (uv[next(h)] - uv[h], uv[t] - uv[next(t)]);
        let fits = |m: u8| own.dot(rotate(other, m));
        let m = (0..4).max_by(|&a, &b| fits(a).total_cmp(&fits(b)).then(b.cmp(&a))).unwrap_or(0);
        (rotation[h], rotation[t]) = (m, (4 - m) & 3);
    }
    let iso = |h: usize| {
        let quarter = ((frames.angle[h] - direction[h / 3]) / FRAC_PI_2).round() as i64;
        match (is_followed[h], quarter % 2) {
            (false, _) => Iso::None,
            (true, 0) => Iso::V,
            _ => Iso::U,
        }
    };
    let iso = (0..mesh.n_halfedges()).map(iso).collect();
    GridMap { uv, rotation, translation: vec![I64Vec2::ZERO; mesh.n_halfedges()], iso }
}
