//! The curves of a surface that its quads must follow.

use crate::engine::mesh::{Surface, TriMesh};
use glam::DVec3;

/// A maximal chain of feature edges, or of boundary edges, between corners and junctions, or closed.
pub(super) struct Curve {
    pub(super) vertices: Vec<u32>,
    pub(super) is_boundary: bool,
}

impl Curve {
    /// The places of its vertices.
    pub(super) fn points(&self, surface: &Surface) -> Vec<DVec3> {
        self.vertices.iter().map(|&v| surface.mesh.position(v)).collect()
    }
}

/// Cuts the network of feature and boundary edges at corners and junctions.
pub(super) fn trace(surface: &Surface) -> Vec<Curve> {
    let mesh = &surface.mesh;
    let n = mesh.n_vertices() as u32;
    // Half of each network edge per end: (from, to, on the boundary).
    let mut halves: Vec<(u32, u32, bool)> = Vec::new();
    let interior = surface.features.edges.iter().filter(|e| e.iter().all(|&v| v < n));
    halves.extend(interior.flat_map(|&[a, b]| [(a, b, false), (b, a, false)]));
    let boundary = (0..mesh.n_halfedges()).filter(|&h| mesh.is_boundary(h));
    let boundary = boundary.map(|h| (mesh.origin(h), mesh.target(h)));
    halves.extend(boundary.flat_map(|(a, b)| [(a, b, true), (b, a, true)]));
    halves.sort_unstable();
    let around = |v: u32| {
        let start = halves.partition_point(|h| h.0 < v);
        start..start + halves[start..].partition_point(|h| h.0 == v)
    };
    let is_stop = |v: u32| around(v).len() != 2 || surface.features.is_corner(v);
    let mut seen = vec![false; halves.len()];
    let mut curves = Vec::new();
    // First the chains that begin at a stop, then the closed ones.
    for from_stops in [true, false] {
        for first in 0..halves.len() {
            if seen[first] || (from_stops && !is_stop(halves[first].0)) {
                continue;
            }
            let mut vertices = vec![halves[first].0];
            let mut at = first;
            loop {
                let (from, to, _) = halves[at];
                seen[at] = true;
                let back = around(to).find(|&i| halves[i].1 == from && !seen[i]);
                if let Some(back) = back {
                    seen[back] = true;
                }
                vertices.push(to);
                if to == vertices[0] || is_stop(to) {
                    break;
                }
                let Some(onward) = around(to).find(|&i| !seen[i]) else { break };
                at = onward;
            }
            if vertices.len() > 2 && vertices[0] == vertices[vertices.len() - 1] && !is_stop(vertices[0]) {
                start_where_any_numbering_does(mesh, &mut vertices);
            }
            curves.push(Curve { vertices, is_boundary: halves[first].2 });
        }
    }
    curves
}

/// Turns a closed curve so that it starts at its least vertex by coordinates and goes on to the lesser neighbour: samples
/// are then in the same places whether a component is judged alone or in its model.
fn start_where_any_numbering_does(mesh: &TriMesh, vertices: &mut Vec<u32>) {
    let order = |a: u32, b: u32| {
        let (p, q) = (mesh.position(a).to_array(), mesh.position(b).to_array());
        p.iter().zip(&q).map(|(x, y)| x.total_cmp(y)).find(|o| o.is_ne()).unwrap_or(std::cmp::Ordering::Equal)
    };
    vertices.pop();
    let n = vertices.len();
    let least = (0..n).min_by(|&i, &j| order(vertices[i], vertices[j])).unwrap_or(0);
    vertices.rotate_left(least);
    if order(vertices[n - 1], vertices[1 % n]).is_lt() {
        vertices[1..].reverse();
    }
    vertices.push(vertices[0]);
}
