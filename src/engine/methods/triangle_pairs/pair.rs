//! Triangles to quads: which pairs make good quads, and as many of them as possible.

use glam::DVec3;

use crate::engine::mesh::{NONE, Surface, next, prev};
use crate::engine::methods::subdivide::Polygon;
use crate::engine::methods::triangle_pairs::matching;
use crate::engine::run::{Cancelled, RunContext};

/// Sine of the flattest corner that a paired quad may have.
const MIN_SINE: f64 = 0.25;

/// Joins triangles over edges that are no features, the best pairs first and then as many as possible. Every interior
/// vertex keeps at least three edges.
pub(super) fn pair_triangles(ctx: &RunContext, surface: &Surface) -> Result<Vec<Polygon>, Cancelled> {
    let mesh = &surface.mesh;
    let mut candidates: Vec<(u64, usize)> = Vec::new();
    for h in (0..mesh.n_halfedges()).filter(|&h| mesh.is_edge_owner(h)) {
        let free = !surface.features.is_edge(mesh.origin(h), mesh.target(h));
        if let Some(quality) = mesh.twin(h).filter(|_| free).and_then(|t| pair_quality(surface, h, t)) {
            // Positive floats have the order of their bits; the best come first.
            candidates.push((u64::MAX - quality.to_bits(), h));
        }
    }
    candidates.sort_unstable();
    let n = mesh.n_faces();
    let mut mate = vec![NONE; n];
    let mut neighbours: Vec<Vec<u32>> = vec![Vec::new(); n];
    for &(_, h) in &candidates {
        let Some(t) = mesh.twin(h) else { continue };
        let (f, g) = (h / 3, t / 3);
        neighbours[f].push(g as u32);
        neighbours[g].push(f as u32);
        if mate[f] == NONE && mate[g] == NONE {
            (mate[f], mate[g]) = (g as u32, f as u32);
        }
    }
    matching::enlarge(ctx, &neighbours, &mut mate)?;
    part_at_poor_vertices(surface, &mut mate);
    Ok(polygons(surface, &mate))
}

/// The halfedge of `f` across which `g` lies.
fn shared_halfedge(surface: &Surface, f: usize, g: u32) -> Option<usize> {
    (3 * f..3 * f + 3).find(|&h| surface.mesh.twin(h).is_some_and(|t| t / 3 == g as usize))
}

/// A vertex with two edges would lie inside one side of a pair of quads that share both: its pairs part again.
fn part_at_poor_vertices(surface: &Surface, mate: &mut [u32]) {
    let mesh = &surface.mesh;
    let joined = |mate: &[u32], h: usize| mesh.twin(h).is_some_and(|t| mate[h / 3] == (t / 3) as u32);
    for v in (0..mesh.n_vertices() as u32).filter(|&v| !mesh.is_boundary_vertex(v)) {
        let degree = mesh.fan(v).count();
        let inner = mesh.fan(v).filter(|&h| joined(mate, h)).count();
        // Parting only ever adds edges, so vertices seen before stay rich.
        for h in mesh.fan(v).filter(|&h| joined(mate, h)).take((3 + inner).saturating_sub(degree)).collect::<Vec<_>>() {
            let g = mate[h / 3];
            (mate[h / 3], mate[g as usize]) = (NONE, NONE);
        }
    }
}

fn polygons(surface: &Surface, mate: &[u32]) -> Vec<Polygon> {
    let mesh = &surface.mesh;
    let polygon = |f: usize| {
        let [a, b, c] = mesh.face(f);
        if mate[f] == NONE {
            return Some([a, b, c, NONE]);
        }
        let h = shared_halfedge(surface, f, mate[f]).filter(|_| (f as u32) < mate[f])?;
        Some(around(surface, h, mesh.twin(h)?))
    };
    (0..mesh.n_faces()).filter_map(polygon).collect()
}

/// The four corners around the two faces at an edge.
fn around(surface: &Surface, h: usize, t: usize) -> Polygon {
    let mesh = &surface.mesh;
    [mesh.origin(h), mesh.target(next(t)), mesh.origin(t), mesh.origin(prev(h))]
}

/// Between 0 and 1, or `None` where the two faces must stay apart: how square the quad is, least at its corners.
fn pair_quality(surface: &Surface, h: usize, t: usize) -> Option<f64> {
    let mesh = &surface.mesh;
    let (n, m) = (mesh.normal(h / 3), mesh.normal(t / 3));
    let corners = around(surface, h, t);
    if n.dot(m) < 0.7 || corners[1] == corners[3] {
        return None;
    }
    let normal = (n + m).normalize_or_zero();
    let p = corners.map(|v| mesh.position(v));
    let centre = (p[0] + p[1] + p[2] + p[3]) / 4.0;
    let mut least = 1.0f64;
    for k in 0..4 {
        let (before, at, after) = (p[(k + 3) % 4], p[k], p[(k + 1) % 4]);
        least = least.min(sine(after - at, before - at, normal));
        // The quad that the subdivision will put into this corner must face outwards at each of its own corners.
        let part = [at, 0.5 * (at + after), centre, 0.5 * (at + before)];
        for i in 0..4 {
            if sine(part[(i + 1) % 4] - part[i], part[(i + 3) % 4] - part[i], normal) < 0.1 {
                return None;
            }
        }
    }
    (least > MIN_SINE).then_some(least * n.dot(m))
}

/// Sine of the angle from `a` to `b` seen along `normal`.
fn sine(a: DVec3, b: DVec3, normal: DVec3) -> f64 {
    let size = (a.length_squared() * b.length_squared()).sqrt();
    if size > 0.0 { a.cross(b).dot(normal) / size } else { 0.0 }
}
