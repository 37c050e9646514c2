//! Faces that are too thin to have a normal worth speaking of.

use glam::DVec3;

use crate::engine::mesh::TriMesh;

/// Height of a face, relative to the diagonal, below which the rounding of coordinates turns its normal: files hold five
/// or six digits of them.
const LEAST_HEIGHT: f64 = 3e-5;
/// Such a face is thin only if its height is below this part of its longest side too: small faces of good shape were
/// made from more digits than that.
const THIN: f64 = 0.01;
/// Thin faces in a row that are looked across.
const MOST_ACROSS: usize = 16;

/// Per face, whether it is thin: a needle or a cap whose normal is mostly rounding. O(F).
pub(super) fn thin_faces(mesh: &TriMesh) -> Vec<bool> {
    let least = LEAST_HEIGHT * mesh.diagonal();
    let is_thin = |f: usize| {
        let [a, b, c] = mesh.triangle(f);
        let longest = a.distance(b).max(b.distance(c)).max(c.distance(a));
        let height = 2.0 * mesh.area_vector(f).length() / longest;
        height < least.min(THIN * longest)
    };
    (0..mesh.n_faces()).map(is_thin).collect()
}

/// Normal of the first face beyond the edge of `h`, on the side of `h`, that is not thin: each thin face is crossed by
/// its longest other side. The normal of the face of `h` itself where there is none.
pub(super) fn normal_beyond(mesh: &TriMesh, is_thin: &[bool], h: usize) -> DVec3 {
    let mut at = h;
    for _ in 0..MOST_ACROSS {
        if !is_thin[at / 3] {
            return mesh.normal(at / 3);
        }
        let length = |g: usize| mesh.position(mesh.origin(g)).distance_squared(mesh.position(mesh.target(g)));
        let (g, o) = (crate::engine::mesh::next(at), crate::engine::mesh::prev(at));
        let across = if length(g) >= length(o) { g } else { o };
        match mesh.twin(across) {
            Some(twin) => at = twin,
            None => break,
        }
    }
    mesh.normal(h / 3)
}
