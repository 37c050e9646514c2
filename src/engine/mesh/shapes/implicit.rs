//! Sample surfaces given as the zero set of a function, polygonised by marching tetrahedra: always a closed manifold,
//! whatever the function. Triangles are then evened out on the surface.

use crate::engine::mesh::TriMesh;
use crate::engine::mesh::shapes::cad::cube_frame;
use glam::{DVec3, dvec3};
use rayon::prelude::*;

/// A closed surface { f = 0 } inside the box from `low` to `high`; f is negative inside and roughly a distance.
pub(super) struct Implicit {
    function: Box<dyn Fn(DVec3) -> f64 + Send + Sync>,
    low: DVec3,
    high: DVec3,
    genus: usize,
}

/// A minimum that rounds the joint over the width `k`.
fn smooth_min(a: f64, b: f64, k: f64) -> f64 {
    let h = (k - (a - b).abs()).max(0.0) / k;
    a.min(b) - h * h * k * 0.25
}

fn distance_to_segment(p: DVec3, a: DVec3, b: DVec3) -> f64 {
    let t = ((p - a).dot(b - a) / a.distance_squared(b)).clamp(0.0, 1.0);
    p.distance(a.lerp(b, t))
}

/// Two tori grown together.
pub(super) fn genus2() -> Implicit {
    let torus = |p: DVec3| ((p.x.hypot(p.y) - 1.0).powi(2) + p.z * p.z).sqrt() - 0.38;
    let function = move |p: DVec3| {
        let tilt = |q: DVec3, s: f64| dvec3(q.x, q.y * 0.98 + s * q.z * 0.2, q.z * 0.98 - s * q.y * 0.2);
        let left = torus(tilt(p + dvec3(1.12, 0.0, 0.0), 1.0));
        let right = torus(tilt((p - dvec3(1.12, 0.0, 0.0)) * 1.12, -1.0)) / 1.12;
        smooth_min(left, right, 0.35)
    };
    Implicit { function: Box::new(function), low: dvec3(-2.7, -1.6, -0.9), high: dvec3(2.6, 1.6, 0.9), genus: 2 }
}

/// The frame of a cube, grown together at its corners.
pub(super) fn genus5() -> Implicit {
    let edges = cube_frame();
    let function = move |p: DVec3| {
        edges.iter().fold(f64::INFINITY, |d, &(a, b)| {
            let bar = distance_to_segment(p, a, b) - 0.33;
            if d.is_finite() { smooth_min(d, bar, 0.4) } else { bar }
        })
    };
    Implicit { function: Box::new(function), low: DVec3::splat(-1.6), high: DVec3::splat(1.6), genus: 5 }
}

/// Two balls joined by a thin neck.
pub(super) fn dumbbell() -> Implicit {
    let function = |p: DVec3| {
        let c = dvec3(1.3, 0.0, 0.0);
        let balls = (p - c).length().min((p + c).length() / 0.85 - 0.1) - 0.7;
        smooth_min(balls, distance_to_segment(p, -c, c) - 0.2, 0.35)
    };
    Implicit { function: Box::new(function), low: dvec3(-2.3, -0.95, -0.95), high: dvec3(2.3, 0.95, 0.95), genus: 0 }
}

impl Implicit {
    /// Positions and triangles, about `triangles` of them, more where so few could not show the topology.
    pub(super) fn triangulate(&self, triangles: usize) -> (Vec<DVec3>, Vec<[u32; 3]>) {
        let mut cell = (self.high - self.low).max_element() / 24.0;
        for _ in 0..2 {
            cell *= (self.march(cell).1.len() as f64 / triangles.min(20_000) as f64).sqrt();
        }
        cell *= (triangles.min(20_000) as f64 / triangles as f64).sqrt();
        loop {
            let (mut positions, faces) = self.march(cell);
            if let Ok(mesh) = TriMesh::try_new(positions.clone(), faces.clone())
                && (mesh.topology().components, mesh.topology().genus) == (1, self.genus)
            {
                self.even_out(&mesh, &mut positions, cell);
                return (positions, faces);
            }
            cell *= 0.9;
        }
    }

    /// Marching tetrahedra on cubes of the given size, each cut into six tetrahedra along its diagonal.
    fn march(&self, cell: f64) -> (Vec<DVec3>, Vec<[u32; 3]>) {
        let n = ((self.high - self.low) / cell).ceil().as_u64vec3() + 2;
        let place = |i: u64, j: u64, k: u64| self.low + (dvec3(i as f64, j as f64, k as f64) - 0.5) * cell;
        let layer =
            |k: u64| -> Vec<f64> { (0..n.y * n.x).map(|at| (self.function)(place(at % n.x, at / n.x, k))).collect() };
        // The six tetrahedra 0, a, a+b, 7 with corners as bit sets xyz, positively oriented.
        const TETRAHEDRA: [[u64; 4]; 6] =
            [[0, 1, 3, 7], [0, 3, 2, 7], [0, 2, 6, 7], [0, 6, 4, 7], [0, 4, 5, 7], [0, 5, 1, 7]];
        let slabs: Vec<Vec<[u64; 3]>> = (0..n.z - 1)
            .into_par_iter()
            .map(|k| {
                let layers = [layer(k), layer(k + 1)];
                let mut out = Vec::new();
                for j in 0..n.y - 1 {
                    for i in 0..n.x - 1 {
                        let value: [f64; 8] = std::array::from_fn(|c| {
                            let c = c as u64;
                            layers[(c >> 2) as usize][((j + (c >> 1 & 1)) * n.x + i + (c & 1)) as usize]
                        });
                        let inside = value.map(|v| v < 0.0);
                        if inside.iter().all(|&s| s) || inside.iter().all(|&s| !s) {
                            continue;
                        }
                        // An edge of the grid: its lower corner and its direction, a bit set. Ends nest as bit sets.
                        let edge = |a: u64, b: u64| {
                            let low = a & b;
                            let at = ((k + (low >> 2)) * n.y + j + (low >> 1 & 1)) * n.x + i + (low & 1);
                            at * 8 + (a ^ b)
                        };
                        for tetrahedron in TETRAHEDRA {
                            cut(tetrahedron, &inside, edge, &mut out);
                        }
                    }
                }
                out
            })
            .collect();
        let mut keys: Vec<u64> = slabs.iter().flatten().flatten().copied().collect();
        keys.par_sort_unstable();
        keys.dedup();
        let positions = keys
            .par_iter()
            .map(|key| {
                let (at, way) = (key / 8, key % 8);
                let (i, j, k) = (at % n.x, at / n.x % n.y, at / n.x / n.y);
                let (a, b) = (place(i, j, k), place(i + (way & 1), j + (way >> 1 & 1), k + (way >> 2)));
                let (fa, fb) = ((self.function)(a), (self.function)(b));
                // Away from the ends: no two vertices of a face coincide.
                a.lerp(b, (fa / (fa - fb)).clamp(0.15, 0.85))
            })
            .collect();
        let index = |key: u64| keys.binary_search(&key).expect("every key was listed") as u32;
        let faces = slabs.par_iter().flatten().map(|t| t.map(index)).collect();
        (positions, faces)
    }

    /// Moves vertices towards the mean of their neighbours and back to the surface.
    fn even_out(&self, mesh: &TriMesh, positions: &mut Vec<DVec3>, cell: f64) {
        let f = &self.function;
        let step = 1e-3 * cell;
        for _ in 0..12 {
            let old = std::mem::take(positions);
            *positions = (0..mesh.n_vertices() as u32)
                .into_par_iter()
                .map(|v| {
                    let (mut sum, mut count) = (DVec3::ZERO, 0.0);
                    for h in mesh.fan(v) {
                        sum += old[mesh.target(h) as usize];
                        count += 1.0;
                    }
                    let p = old[v as usize].lerp(sum / count, 0.6);
                    let slope = dvec3(
                        f(p + DVec3::X * step) - f(p - DVec3::X * step),
                        f(p + DVec3::Y * step) - f(p - DVec3::Y * step),
                        f(p + DVec3::Z * step) - f(p - DVec3::Z * step),
                    ) / (2.0 * step);
                    let back = slope * (f(p) / slope.length_squared().max(0.1));
                    p - back.clamp_length_max(0.5 * cell)
                })
                .collect();
        }
    }
}

/// The triangles that separate the inside corners of a tetrahedron from the others, seen from outside.
fn cut(corners: [u64; 4], inside: &[bool; 8], edge: impl Fn(u64, u64) -> u64, out: &mut Vec<[u64; 3]>) {
    let is_in = corners.map(|c| inside[c as usize]);
    let count = is_in.iter().filter(|&&s| s).count();
    if count == 0 || count == 4 {
        return;
    }
    // Even permutations that bring any corner, or any two corners, to the front.
    const FIRST: [[usize; 4]; 4] = [[0, 1, 2, 3], [1, 0, 3, 2], [2, 3, 0, 1], [3, 2, 1, 0]];
    const PAIRS: [[usize; 4]; 6] = [[0, 1, 2, 3], [0, 2, 3, 1], [0, 3, 1, 2], [1, 2, 0, 3], [1, 3, 2, 0], [2, 3, 0, 1]];
    if count == 2 {
        for pair in PAIRS {
            if is_in[pair[0]] && is_in[pair[1]] {
                let [a, b, c, d] = pair.map(|k| corners[k]);
                let [p, q, r, s] = [edge(a, c), edge(a, d), edge(b, d), edge(b, c)];
                out.extend([[p, q, r], [p, r, s]]);
            }
        }
        return;
    }
    for first in FIRST {
        if is_in[first[0]] == (count == 1) {
            let [a, b, c, d] = first.map(|k| corners[k]);
            let (x, y, z) = (edge(a, b), edge(a, c), edge(a, d));
            out.push(if count == 1 { [x, y, z] } else { [x, z, y] });
        }
    }
}
