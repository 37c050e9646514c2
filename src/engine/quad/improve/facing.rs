//! Whether quads turn their face to the surface, as it looks from single points of it.

use glam::DVec3;

use crate::engine::mesh::SurfaceIndex;
use crate::engine::quad::optimise::area_vector;

/// Whether a quad has no area, or turns its back both to the normals beneath its corners and to the one beneath its
/// middle.
pub(super) fn is_turned_over(index: &SurfaceIndex, p: &[DVec3; 4]) -> bool {
    if is_flat(p) {
        return true;
    }
    let around: DVec3 = p.iter().map(|&c| index.smooth_normal(&index.closest(c))).sum();
    area_vector(p).dot(around) <= 0.0 && is_against(index, p)
}

/// Whether a quad turns its back to the normal beneath its middle.
fn is_against(index: &SurfaceIndex, p: &[DVec3; 4]) -> bool {
    area_vector(p).dot(index.normal(index.closest(p.iter().sum::<DVec3>() / 4.0).face)) <= 0.0
}

fn is_flat(p: &[DVec3; 4]) -> bool {
    area_vector(p).length() <= 1e-9 * p[0].distance_squared(p[2]).max(p[1].distance_squared(p[3]))
}
