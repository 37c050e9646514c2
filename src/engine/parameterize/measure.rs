//! Measures of a map: what a user needs in order to trust it.

use glam::DVec2;

use crate::engine::field::Frames;
use crate::engine::mesh::TriMesh;
use crate::engine::mesh::next;
use crate::engine::parameterize::grid_map::{GridMap, rotate};
use crate::engine::parameterize::poisson::hat_gradients;

/// Measures of a map on its working mesh.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MapMeasures {
    /// Triangles with negative or no area in the map; after untangling also those around vertices wound around twice.
    pub flipped: usize,
    /// Largest deviation of a transition from its quarter turn and integer translation, in grid units.
    pub seam_residual: f64,
    /// Area in the map: the number of quads if nothing is flipped.
    pub grid_area: f64,
    /// Area-weighted mean of `(σ1 − 1)² + (σ2 − 1)²`, singular values relative to the scale.
    pub arap_mean: f64,
    /// Area-weighted mean of `σ1/σ2 + σ2/σ1` over triangles that are not flipped; 2 is conformal.
    pub conformal_mean: f64,
}

/// Gradients of u and v on face `f` in its frame.
pub fn gradients(mesh: &TriMesh, frames: &Frames, uv: &[DVec2], f: usize) -> (DVec2, DVec2) {
    let (hat, _) = hat_gradients(mesh, frames, f);
    let mut du = DVec2::ZERO;
    let mut dv = DVec2::ZERO;
    for k in 0..3 {
        du += hat[k] * uv[3 * f + k].x;
        dv += hat[k] * uv[3 * f + k].y;
    }
    (du, dv)
}

/// Signed singular values of the map on face `f`: larger first, the second negative if the face is flipped.
fn singular_values(mesh: &TriMesh, frames: &Frames, uv: &[DVec2], f: usize) -> (f64, f64) {
    let (du, dv) = gradients(mesh, frames, uv, f);
    // Conformal and anti-conformal part of the 2 × 2 gradient.
    let plus = DVec2::new(du.x + dv.y, dv.x - du.y).length() * 0.5;
    let minus = DVec2::new(du.x - dv.y, dv.x + du.y).length() * 0.5;
    (plus + minus, plus - minus)
}

/// Measures a map whose grid lines are `1 / scale` model units apart.
pub fn measure_map(mesh: &TriMesh, frames: &Frames, map: &GridMap, scale: f64) -> MapMeasures {
    let mut m = MapMeasures::default();
    let (mut total, mut upright) = (0.0, 0.0);
    for f in 0..mesh.n_faces() {
        let (s1, s2) = singular_values(mesh, frames, &map.uv, f);
        let area = frames.area(mesh, f);
        total += area;
        m.grid_area += s1 * s2 * area;
        m.arap_mean += area * ((s1 / scale - 1.0).powi(2) + (s2 / scale - 1.0).powi(2));
        if s2 > 1e-12 * s1 {
            upright += area;
            m.conformal_mean += area * (s1 / s2 + s2 / s1).min(1e6);
        } else {
            m.flipped += 1;
        }
    }
    m.arap_mean /= total.max(1e-300);
    m.conformal_mean /= upright.max(1e-300);
    m.seam_residual = seam_residual(mesh, map);
    m
}

/// Largest deviation of a transition from its quarter turn and integer translation.
pub fn seam_residual(mesh: &TriMesh, map: &GridMap) -> f64 {
    let mut worst: f64 = 0.0;
    for h in 0..mesh.n_halfedges() {
        let Some(t) = mesh.twin(h) else { continue };
        for (mine, theirs) in [(h, next(t)), (next(h), t)] {
            let expected = rotate(map.uv[theirs], map.rotation[h]) + map.translation[h].as_dvec2();
            worst = worst.max((map.uv[mine] - expected).abs().max_element());
        }
    }
    worst
}
