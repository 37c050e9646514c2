//! The sides of triangles, grouped by edge.

use rayon::slice::ParallelSliceMut;

/// A side of a triangle: its edge as `lower << 32 | higher`, and its halfedge `3 f + k`.
pub(super) type Side = (u64, u32);

/// The edge of two vertices, whatever their order.
pub(super) fn edge_key(a: u32, b: u32) -> u64 {
    (u64::from(a.min(b)) << 32) | u64::from(a.max(b))
}

/// Origin of halfedge `h`.
pub(super) fn origin(corners: &[[u32; 3]], h: u32) -> u32 {
    corners[h as usize / 3][h as usize % 3]
}

/// Target of halfedge `h`.
pub(super) fn target(corners: &[[u32; 3]], h: u32) -> u32 {
    corners[h as usize / 3][(h as usize % 3 + 1) % 3]
}

/// Corner of the face of `h` that is not on `h`.
pub(super) fn apex(corners: &[[u32; 3]], h: u32) -> u32 {
    corners[h as usize / 3][(h as usize % 3 + 2) % 3]
}

/// All sides, sorted by edge and then by halfedge.
pub(super) fn sorted_sides(corners: &[[u32; 3]]) -> Vec<Side> {
    let n = 3 * corners.len() as u32;
    let mut sides: Vec<Side> = (0..n).map(|h| (edge_key(origin(corners, h), target(corners, h)), h)).collect();
    sides.par_sort_unstable();
    sides
}

/// The sides edge by edge.
pub(super) fn runs(sides: &[Side]) -> impl Iterator<Item = &[Side]> {
    sides.chunk_by(|a, b| a.0 == b.0)
}
