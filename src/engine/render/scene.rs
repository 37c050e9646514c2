//! What is drawn: the quads that can be, their normals, their edges.

use crate::engine::quad::QuadMesh;
use glam::DVec3;
use rayon::prelude::*;

/// Edges sharper than this many degrees are drawn as creases and shaded as such.
const CREASE: f64 = 35.0;

pub(super) struct Scene {
    pub(super) positions: Vec<DVec3>,
    pub(super) quads: Vec<[u32; 4]>,
    /// Two per quad, along the shorter diagonal; triangle `t` belongs to quad `t / 2`.
    pub(super) triangles: Vec<[u32; 3]>,
    /// Per quad and corner, the unit normal that light falls on.
    pub(super) normals: Vec<[DVec3; 4]>,
    /// Per quad and side, whether the edge is a crease or the boundary.
    pub(super) is_strong: Vec<[bool; 4]>,
    /// Per vertex, its normal over all its quads.
    pub(super) vertex_normals: Vec<DVec3>,
    /// Interior irregular vertices and their valences.
    pub(super) irregular: Vec<(u32, usize)>,
    pub(super) centre: DVec3,
    pub(super) radius: f64,
    pub(super) mean_edge: f64,
}

impl Scene {
    pub(super) fn new(mesh: &QuadMesh) -> Self {
        let positions = mesh.positions.clone();
        let can_be_drawn = |q: &&[u32; 4]| q.iter().all(|&v| positions.get(v as usize).is_some_and(|p| p.is_finite()));
        let quads: Vec<[u32; 4]> = mesh.quads.iter().filter(can_be_drawn).copied().collect();
        let at = |v: u32| positions[v as usize];
        let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for &v in quads.iter().flatten() {
            low = low.min(at(v));
            high = high.max(at(v));
        }
        let (centre, radius) =
            if quads.is_empty() { (DVec3::ZERO, 1.0) } else { (0.5 * (low + high), 0.5 * low.distance(high)) };
        let triangles = quads
            .iter()
            .flat_map(|&[a, b, c, d]| {
                if at(a).distance_squared(at(c)) <= at(b).distance_squared(at(d)) {
                    [[a, b, c], [a, c, d]]
                } else {
                    [[a, b, d], [b, c, d]]
                }
            })
            .collect();
        let areas: Vec<DVec3> = quads.iter().map(|&[a, b, c, d]| (at(c) - at(a)).cross(at(d) - at(b))).collect();
        let (normals, vertex_normals) = shading_normals(&quads, &areas, positions.len());
        let (is_strong, irregular, mean_edge) = edges(&quads, &areas, &positions);
        let radius = radius.max(1e-300);
        Self { positions, quads, triangles, normals, is_strong, vertex_normals, irregular, centre, radius, mean_edge }
    }
}

/// Per corner the mean normal of the quads around its vertex that do not turn away from the corner's quad by more than
/// a crease; per vertex the mean of all.
fn shading_normals(quads: &[[u32; 4]], areas: &[DVec3], n: usize) -> (Vec<[DVec3; 4]>, Vec<DVec3>) {
    let mut around: Vec<(u32, u32)> = (0u32..).zip(quads).flat_map(|(q, quad)| quad.map(|v| (v, q))).collect();
    around.sort_unstable();
    let mut start = vec![0usize; n + 1];
    for &(v, _) in &around {
        start[v as usize + 1] += 1;
    }
    for v in 0..n {
        start[v + 1] += start[v];
    }
    let of = |v: u32| &around[start[v as usize]..start[v as usize + 1]];
    let limit = CREASE.to_radians().cos();
    let corners = quads
        .par_iter()
        .zip(areas)
        .map(|(quad, &own)| {
            let own_normal = own.normalize_or_zero();
            quad.map(|v| {
                let alike = of(v).iter().map(|&(_, q)| areas[q as usize]);
                let sum: DVec3 = alike.filter(|a| a.normalize_or_zero().dot(own_normal) >= limit).sum();
                sum.try_normalize().unwrap_or(own_normal)
            })
        })
        .collect();
    let all = (0..n as u32).map(|v| of(v).iter().map(|&(_, q)| areas[q as usize]).sum::<DVec3>().normalize_or_zero());
    (corners, all.collect())
}

fn edges(quads: &[[u32; 4]], areas: &[DVec3], positions: &[DVec3]) -> (Vec<[bool; 4]>, Vec<(u32, usize)>, f64) {
    let mut sides: Vec<(u32, u32, u32)> = Vec::with_capacity(4 * quads.len());
    for (q, quad) in (0u32..).zip(quads) {
        for k in 0..4 {
            let (a, b) = (quad[k], quad[(k + 1) % 4]);
            sides.push((a.min(b), a.max(b), 4 * q + k as u32));
        }
    }
    sides.sort_unstable();
    let limit = CREASE.to_radians().cos();
    let mut is_strong = vec![[false; 4]; quads.len()];
    let mut valence = vec![0usize; positions.len()];
    let mut on_boundary = vec![false; positions.len()];
    let (mut length, mut count) = (0.0, 0usize);
    for edge in sides.chunk_by(|x, y| (x.0, x.1) == (y.0, y.1)) {
        let (a, b, first) = edge[0];
        let normal = |h: u32| areas[h as usize / 4].normalize_or_zero();
        let strong = edge.len() != 2 || normal(first).dot(normal(edge[1].2)) < limit;
        for &(_, _, h) in edge {
            is_strong[h as usize / 4][h as usize % 4] = strong;
        }
        for v in [a, b] {
            valence[v as usize] += 1;
            on_boundary[v as usize] |= edge.len() != 2;
        }
        length += positions[a as usize].distance(positions[b as usize]);
        count += 1;
    }
    let irregular = (0..positions.len())
        .filter(|&v| valence[v] > 0 && valence[v] != 4 && !on_boundary[v])
        .map(|v| (v as u32, valence[v]))
        .collect();
    (is_strong, irregular, length / count.max(1) as f64)
}
