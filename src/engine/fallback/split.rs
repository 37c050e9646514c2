//! Every triangle split into three quads: needs nothing but a valid triangle mesh, and cannot fail.

use crate::engine::mesh::Surface;
use crate::engine::quad::Anchor;
use crate::engine::quad::QuadDraft;

/// Splits every triangle at its centroid and its edge midpoints into three quads, which lie in its plane. Feature and
/// boundary edges become two quad edges each; vertices come first, then midpoints, then centroids.
pub fn split_draft(surface: &Surface) -> QuadDraft {
    let mesh = &surface.mesh;
    let flags = surface.features.halfedge_flags(mesh);
    let mut draft = QuadDraft::default();
    draft.mesh.positions.extend_from_slice(mesh.positions());
    draft.anchors = vec![Anchor::Surface; mesh.n_vertices()];
    for h in (0..mesh.n_halfedges()).filter(|&h| flags[h]) {
        draft.anchors[mesh.origin(h) as usize] = Anchor::Curve;
        draft.anchors[mesh.target(h) as usize] = Anchor::Curve;
    }
    for &v in &surface.features.corners {
        draft.anchors[v as usize] = Anchor::Corner(v);
    }
    let mut middle = vec![0u32; mesh.n_halfedges()];
    for h in (0..mesh.n_halfedges()).filter(|&h| mesh.is_edge_owner(h)) {
        let m = draft.mesh.positions.len() as u32;
        let (a, b) = (mesh.origin(h), mesh.target(h));
        draft.mesh.positions.push(0.5 * (mesh.position(a) + mesh.position(b)));
        draft.anchors.push(if flags[h] { Anchor::Curve } else { Anchor::Surface });
        middle[h] = m;
        if let Some(t) = mesh.twin(h) {
            middle[t] = m;
            if flags[h] {
                draft.feature_edges.extend([[a.min(m), a.max(m)], [b.min(m), b.max(m)]]);
            }
        }
    }
    for f in 0..mesh.n_faces() {
        let centre = draft.mesh.positions.len() as u32;
        let [a, b, c] = mesh.triangle(f);
        draft.mesh.positions.push((a + b + c) / 3.0);
        draft.anchors.push(Anchor::Surface);
        for h in 3 * f..3 * f + 3 {
            let before = middle[crate::engine::mesh::prev(h)];
            draft.mesh.quads.push([mesh.origin(h), middle[h], centre, before]);
        }
    }
    draft.feature_edges.sort_unstable();
    draft
}
