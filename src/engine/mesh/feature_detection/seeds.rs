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

/// Normals that differ by more than this angle (one degree) are split; edges with a smaller one are flat.
const SPLIT_COSINE: f64 = 0.999_848;
/// Edges with a smaller dihedral angle than this (20 degrees) are smooth in most models.
const SMOOTH_COSINE: f64 = 0.939_693;
/// Corners of polygons in which a vertex is looked for.
const MOST_CORNERS: usize = 1000;

/// Marks the interior edges whose two sides have different normals at one end or both. Where most edges that are hardly
/// bent have, the model is shaded facet by facet, and nothing is marked.
pub(super) fn mark_split_normals(conditioned: &Conditioned, soup: &TriangleSoup, network: &mut Network) {
    let mesh = &conditioned.mesh;
    if soup.normals.len() != soup.indices.len() {
        return;
    }
    let normal = |face: usize, v: u32| {
        let place = mesh.position(v);
        let mut corners = soup.corners_of(conditioned.polygon[face] as usize).take(MOST_CORNERS);
        let corner = corners.find(|&c| soup.positions[soup.indices[c] as usize] == place)?;
        DVec3::from(soup.normals[corner].map(f64::from)).try_normalize()
    };
    let is_split = |h: usize, t: usize| {
        let differ =
            |v: u32| matches!((normal(h / 3, v), normal(t / 3, v)), (Some(n), Some(m)) if n.dot(m) < SPLIT_COSINE);
        differ(mesh.origin(h)) || differ(mesh.target(h))
    };
    let (mut split, mut smooth, mut faceted) = (Vec::new(), 0, 0);
    for h in 0..mesh.n_halfedges() {
        let Some(t) = mesh.twin(h).filter(|&t| h < t) else { continue };
        let is_split = is_split(h, t);
        let bend = mesh.normal(h / 3).dot(mesh.normal(t / 3));
        if (SMOOTH_COSINE..SPLIT_COSINE).contains(&bend) {
            smooth += 1;
            faceted += usize::from(is_split);
        }
        if is_split {
            split.push(h);
        }
    }
    if 2 * faceted <= smooth {
        split.into_iter().for_each(|h| network.mark_kept(h));
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
