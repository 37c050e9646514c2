//! One linear subdivision: a polygon with n corners becomes n quads around its centre. Whatever the polygons are, the
//! result has quads only, the same topology and the same curves.

use glam::DVec3;

use crate::engine::mesh::{NONE, Surface};
use crate::engine::quad::{Anchor, QuadDraft, QuadMesh};

/// A triangle (the last corner is `NONE`) or a quad, counter-clockwise.
pub(super) type Polygon = [u32; 4];

/// Sine of the flattest corner that a bent side may leave.
const MIN_SINE: f64 = 0.1;

/// Subdivides polygons that cover `surface`, each a face or two of it. `corner_names` are the names of the surface's
/// corners, in order. `curve_middles` are (for sorted edges on curves) places for their middles, which are taken where
/// no quad turns over; all other middles are straight.
pub(super) fn subdivide(
    surface: &Surface,
    polygons: &[Polygon],
    corner_names: &[u32],
    curve_middles: &[([u32; 2], DVec3)],
) -> QuadDraft {
    let mesh = &surface.mesh;
    let flags = surface.features.halfedge_flags(mesh);
    let mut anchors = vec![Anchor::Surface; mesh.n_vertices()];
    for h in (0..mesh.n_halfedges()).filter(|&h| flags[h]) {
        anchors[mesh.origin(h) as usize] = Anchor::Curve;
        anchors[mesh.target(h) as usize] = Anchor::Curve;
    }
    for (&v, &name) in surface.features.corners.iter().zip(corner_names) {
        anchors[v as usize] = Anchor::Corner(name);
    }
    let mut draft = QuadDraft {
        mesh: QuadMesh { positions: mesh.positions().to_vec(), quads: Vec::new() },
        anchors,
        feature_edges: Vec::new(),
    };
    let mut edges: Vec<[u32; 2]> = Vec::new();
    for polygon in polygons {
        let corners = corners_of(polygon);
        for (k, &a) in corners.iter().enumerate() {
            let b = corners[(k + 1) % corners.len()];
            edges.push([a.min(b), a.max(b)]);
        }
    }
    edges.sort_unstable();
    let mut boundary = vec![false; edges.len()];
    let mut unique: Vec<[u32; 2]> = Vec::with_capacity(edges.len() / 2 + 1);
    for pair in edges.chunk_by(|a, b| a == b) {
        boundary[unique.len()] = pair.len() == 1;
        unique.push(pair[0]);
    }
    for (&[a, b], is_boundary) in unique.iter().zip(boundary) {
        let is_feature = surface.features.is_edge(a, b);
        let middle = push(&mut draft, 0.5 * (mesh.position(a) + mesh.position(b)));
        if is_feature || is_boundary {
            draft.anchors[middle as usize] = Anchor::Curve;
        }
        if is_feature && !is_boundary {
            draft.feature_edges.extend([[a, middle], [b, middle]]);
        }
    }
    draft.feature_edges.sort_unstable();
    let middle = |a: u32, b: u32| {
        let at = unique.binary_search(&[a.min(b), a.max(b)]).expect("every side of a polygon was listed");
        (mesh.n_vertices() + at) as u32
    };
    for polygon in polygons {
        let corners = corners_of(polygon);
        let n = corners.len();
        let centre = push(&mut draft, corners.iter().map(|&v| mesh.position(v)).sum::<DVec3>() / n as f64);
        for (k, &v) in corners.iter().enumerate() {
            let (after, before) = (corners[(k + 1) % n], corners[(k + n - 1) % n]);
            draft.mesh.quads.push([v, middle(v, after), centre, middle(before, v)]);
        }
    }
    let bent: Vec<(u32, DVec3)> = curve_middles.iter().map(|&([a, b], p)| (middle(a, b), p)).collect();
    bend(&mut draft, &bent);
    draft
}

/// Moves vertices to their places, and those of quads that turn over back again.
fn bend(draft: &mut QuadDraft, places: &[(u32, DVec3)]) {
    let QuadMesh { positions, quads } = &mut draft.mesh;
    let straight = positions.clone();
    for &(v, p) in places {
        positions[v as usize] = p;
    }
    let sine = |positions: &[DVec3], q: &[u32; 4], k: usize, normal: DVec3| {
        let [before, at, after] = [k + 3, k, k + 1].map(|i| positions[q[i % 4] as usize]);
        let cross = (after - at).cross(before - at);
        cross.dot(normal) / ((after - at).length() * (before - at).length()).max(f64::MIN_POSITIVE)
    };
    // Every round returns a vertex to its straight place, or is the last.
    let mut again = !places.is_empty();
    while std::mem::take(&mut again) {
        for q in quads.iter() {
            let [a, b, c, d] = q.map(|v| straight[v as usize]);
            let normal = (c - a).cross(d - b).normalize_or_zero();
            if (0..4).any(|k| sine(positions, q, k, normal) < MIN_SINE) {
                for &v in q {
                    again |= positions[v as usize] != straight[v as usize];
                    positions[v as usize] = straight[v as usize];
                }
            }
        }
    }
}

fn corners_of(polygon: &Polygon) -> &[u32] {
    if polygon[3] == NONE { &polygon[..3] } else { polygon }
}

fn push(draft: &mut QuadDraft, p: DVec3) -> u32 {
    draft.mesh.positions.push(p);
    draft.anchors.push(Anchor::Surface);
    (draft.mesh.positions.len() - 1) as u32
}
