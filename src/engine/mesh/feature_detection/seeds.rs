//! Feature edges that the input names itself.

use glam::DVec3;

use crate::engine::mesh::Conditioned;
use crate::engine::mesh::TriangleSoup;
use crate::engine::mesh::feature_detection::network::Network;

/// Distance, relative to the diagonal, within which a position of the soup is that of a vertex: what nearly coincident
/// boundaries are welded with.
const SAME_PLACE: f64 = 1.1e-7;

/// Marks the interior edges between faces of different materials.
pub(super) fn mark_material_borders(conditioned: &Conditioned, soup: &TriangleSoup, network: &mut Network) {
    let material = |h: usize| soup.materials.get(conditioned.polygon[h / 3] as usize);
    for h in 0..conditioned.mesh.n_halfedges() {
        if let Some(t) = conditioned.mesh.twin(h)
            && h < t
            && material(h) != material(t)
        {
            network.mark_kept(h);
        }
    }
}

/// Marks the interior edges between vertices at the places that `explicit` names; pairs that are no edge of the
/// surface (any more) are passed over.
pub(super) fn mark_explicit(
    conditioned: &Conditioned,
    soup: &TriangleSoup,
    explicit: &[[u32; 2]],
    network: &mut Network,
) {
    if explicit.is_empty() {
        return;
    }
    let mesh = &conditioned.mesh;
    let reach = SAME_PLACE * mesh.diagonal();
    let mut by_x: Vec<u32> = (0..mesh.n_vertices() as u32).collect();
    by_x.sort_by(|&a, &b| mesh.position(a).x.total_cmp(&mesh.position(b).x).then(a.cmp(&b)));
    let at = |p: DVec3| {
        let start = by_x.partition_point(|&v| mesh.position(v).x < p.x - reach);
        let near = by_x[start..].iter().take_while(move |&&v| mesh.position(v).x <= p.x + reach);
        near.copied().filter(move |&v| mesh.position(v).distance(p) <= reach).collect::<Vec<u32>>()
    };
    let place = |v: u32| soup.positions.get(v as usize).copied().filter(|p| p.is_finite());
    for &[a, b] in explicit {
        let (Some(a), Some(b)) = (place(a), place(b)) else {
            continue;
        };
        let ends = at(b);
        for h in at(a).into_iter().flat_map(|v| mesh.fan(v).flat_map(|h| [h, crate::engine::mesh::prev(h)])) {
            if !mesh.is_boundary(h) && (ends.contains(&mesh.target(h)) || ends.contains(&mesh.origin(h))) {
                network.mark_kept(h);
            }
        }
    }
}
