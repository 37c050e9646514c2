//! The part of a surface on one side of a plane.

use std::collections::BTreeMap;

use glam::DVec3;

use crate::engine::mesh::{NONE, Surface, TriMesh, features_of_edges};
use crate::engine::pipeline::symmetry::mirror::Mirror;

/// Vertices nearer to the plane than this part of their shortest edge are put on it, but moved by no more than that
/// part of the diagonal.
const NEAR: f64 = 0.1;
const LEAST: f64 = 1e-4;

/// One side of a surface, or at first all of it.
pub(super) struct Half {
    /// The surface; the cut is boundary, at the exact coordinate.
    pub(super) surface: Surface,
    /// Sizes per vertex, empty if they were.
    pub(super) log_size: Vec<f64>,
    /// Feature edges that lie on the planes so far, this one last; each as (lower, higher) vertex, sorted.
    pub(super) on_planes: Vec<Vec<[u32; 2]>>,
}

/// Cuts a surface and keeps the side of larger coordinates; `None` if that is no manifold or nothing. `on_planes` are
/// feature edges on the planes before, which are boundary by now; `min_length` is that of the feature detection.
/// O(n log n).
pub(super) fn halve(whole: &Half, mirror: Mirror, min_length: f64) -> Option<Half> {
    [true, false].into_iter().find_map(|with_snapping| cut(whole, mirror, min_length, with_snapping))
}

fn cut(whole: &Half, mirror: Mirror, min_length: f64, with_snapping: bool) -> Option<Half> {
    let Half { surface: whole, log_size, on_planes } = whole;
    let mesh = &whole.mesh;
    let sides = sides(mesh, mirror, with_snapping);
    let mut positions: Vec<DVec3> = mesh.positions().to_vec();
    let mut log_size = log_size.clone();
    for (p, _) in positions.iter_mut().zip(&sides).filter(|(_, side)| **side == 0.0) {
        *p = mirror.foot(*p);
    }
    let mut cuts: BTreeMap<[u32; 2], u32> = BTreeMap::new();
    let mut faces: Vec<[u32; 3]> = Vec::new();
    for face in mesh.faces() {
        if face.iter().all(|&v| sides[v as usize] == 0.0) {
            return None;
        }
        if face.iter().all(|&v| sides[v as usize] <= 0.0) {
            continue;
        }
        let mut polygon = Vec::with_capacity(4);
        for k in 0..3 {
            let (a, b) = (face[k], face[(k + 1) % 3]);
            let (s, t) = (sides[a as usize], sides[b as usize]);
            if s >= 0.0 {
                polygon.push(a);
            }
            if s * t < 0.0 {
                let [low, high] = [a.min(b), a.max(b)];
                polygon.push(*cuts.entry([low, high]).or_insert_with(|| {
                    let (s, t) = (sides[low as usize], sides[high as usize]);
                    let along = s / (s - t);
                    positions.push(mirror.foot(mesh.position(low).lerp(mesh.position(high), along)));
                    if !log_size.is_empty() {
                        log_size.push((1.0 - along) * log_size[low as usize] + along * log_size[high as usize]);
                    }
                    positions.len() as u32 - 1
                }));
            }
        }
        match polygon[..] {
            [a, b, c] => faces.push([a, b, c]),
            [a, b, c, d] => {
                let length = |v: u32, w: u32| positions[v as usize].distance_squared(positions[w as usize]);
                let halves = if length(a, c) <= length(b, d) { [[a, b, c], [a, c, d]] } else { [[a, b, d], [b, c, d]] };
                faces.extend(halves);
            }
            _ => return None,
        }
    }
    // Only the vertices that are left, in their order.
    let mut is_used = vec![false; positions.len()];
    faces.iter().flatten().for_each(|&v| is_used[v as usize] = true);
    let mut name = vec![NONE; positions.len()];
    let kept: Vec<usize> = (0..positions.len()).filter(|&v| is_used[v]).collect();
    (0u32..).zip(&kept).for_each(|(new, &old)| name[old] = new);
    let faces: Vec<[u32; 3]> = faces.into_iter().map(|f| f.map(|v| name[v as usize])).collect();
    let half = TriMesh::try_new(kept.iter().map(|&v| positions[v]).collect(), faces).ok()?;
    if half.n_faces() == 0 || (0..half.n_faces()).any(|f| half.area(f) <= 0.0) {
        return None;
    }
    let is_on_plane = |v: u32| sides[v as usize] == 0.0;
    let carried = |[a, b]: [u32; 2]| {
        let (s, t) = (sides[a as usize], sides[b as usize]);
        let kept = match (s > 0.0, t > 0.0) {
            (true, false) if t < 0.0 => [a, *cuts.get(&[a, b])?],
            (false, true) if s < 0.0 => [b, *cuts.get(&[a, b])?],
            (false, false) => return None,
            _ => [a, b],
        };
        Some(kept.map(|v| name[v as usize]))
    };
    let of_half = |edges: Vec<[u32; 2]>| {
        let mut edges: Vec<[u32; 2]> = edges.into_iter().map(|[a, b]| [a.min(b), a.max(b)]).collect();
        edges.retain(|e| e[1] != NONE);
        edges.sort_unstable();
        edges
    };
    let own = &whole.features.edges;
    let edges = of_half(own.iter().filter_map(|&e| carried(e)).collect());
    let along = |e: &&[u32; 2]| e.iter().all(|&v| is_on_plane(v));
    let on_plane = of_half(own.iter().filter(along).map(|e| e.map(|v| name[v as usize])).collect());
    let before = on_planes.iter().map(|edges| of_half(edges.iter().filter_map(|&e| carried(e)).collect()));
    let on_planes = before.chain([on_plane]).collect();
    let features = features_of_edges(&half, &edges, min_length);
    let log_size = if log_size.is_empty() { log_size } else { kept.iter().map(|&v| log_size[v]).collect() };
    Some(Half { surface: Surface { mesh: half, features }, log_size, on_planes })
}

/// Per vertex how far it is on the side that is kept; 0 for those that are put on the plane.
fn sides(mesh: &TriMesh, mirror: Mirror, with_snapping: bool) -> Vec<f64> {
    let most = if with_snapping { LEAST * mesh.diagonal() } else { 0.0 };
    let mut shortest = vec![f64::INFINITY; mesh.n_vertices()];
    for h in 0..mesh.n_halfedges() {
        let (a, b) = (mesh.origin(h), mesh.target(h));
        let length = mesh.position(a).distance(mesh.position(b));
        for v in [a, b] {
            shortest[v as usize] = length.min(shortest[v as usize]);
        }
    }
    let side = |(p, shortest): (&DVec3, f64)| {
        let side = mirror.side(*p);
        if side.abs() <= (NEAR * shortest).min(most) { 0.0 } else { side }
    };
    mesh.positions().iter().zip(shortest).map(side).collect()
}
