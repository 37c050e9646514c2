//! The size that a field of sizes gives for a point.

use glam::DVec3;

use crate::engine::mesh::{SurfaceIndex, TriMesh};

/// The size (logarithm, per vertex) that a surface's sizes give for a point near it; 0 if they are empty.
pub fn size_at(mesh: &TriMesh, index: &SurfaceIndex, log_size: &[f64], p: DVec3) -> f64 {
    if log_size.is_empty() {
        return 0.0;
    }
    let at = index.closest(p);
    let face = mesh.face(at.face as usize);
    (0..3).map(|k| at.barycentric[k] * log_size[face[k] as usize]).sum()
}
