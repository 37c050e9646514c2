//! Normals of quads: smooth, but split where kept features are sharp.

use glam::DVec3;
use rayon::prelude::*;

use crate::engine::quad::QuadMesh;
use crate::engine::run::{Cancelled, RunContext};

/// Quads between two looks at the context.
const STRIDE: usize = 1 << 14;
/// Cosine of the angle (15 degrees) below which quads are smooth across a kept feature, such as a border between two
/// materials on a sphere.
const SMOOTH_COSINE: f64 = 0.965_926;

/// The side of a quad: its vertices in order, its corner at the first and its corner at the second of them.
type Side = ([u32; 2], u32, u32);

/// A unit normal per corner of each quad. Around a vertex, quads between two sharp features have one normal: the mean of
/// theirs, weighted by their angles at the vertex. `features` are edges of the quads as (lower, higher) vertex, sorted.
/// O(Q log Q).
///
/// # Errors
/// If the run was stopped.
pub fn corner_normals(
    ctx: &RunContext,
    mesh: &QuadMesh,
    features: &[[u32; 2]],
) -> Result<Vec<[[f32; 3]; 4]>, Cancelled> {
    let normals: Vec<DVec3> = mesh.quads.par_iter().map(|quad| of_quad(mesh, quad)).collect();
    ctx.check()?;
    let mut groups = Groups { parent: (0..4 * mesh.quads.len() as u32).collect() };
    let mut sides: Vec<Side> = Vec::with_capacity(4 * mesh.quads.len());
    for (q, quad) in (0u32..).zip(&mesh.quads) {
        for k in 0..4 {
            let (a, b) = ((quad[k as usize], 4 * q + k), (quad[(k as usize + 1) % 4], 4 * q + (k + 1) % 4));
            let [a, b] = if a.0 < b.0 { [a, b] } else { [b, a] };
            sides.push(([a.0, b.0], a.1, b.1));
        }
    }
    ctx.check()?;
    sides.par_sort_unstable();
    for (i, pair) in sides.windows(2).enumerate() {
        check_now_and_then(ctx, i)?;
        let [(edge, a, b), (other, c, d)] = [pair[0], pair[1]];
        let is_smooth = || normals[a as usize / 4].dot(normals[c as usize / 4]) >= SMOOTH_COSINE;
        if edge == other && (features.binary_search(&edge).is_err() || is_smooth()) {
            groups.join(a, c);
            groups.join(b, d);
        }
    }
    let mut sums = vec![DVec3::ZERO; 4 * mesh.quads.len()];
    for (q, quad) in mesh.quads.iter().enumerate() {
        check_now_and_then(ctx, q)?;
        for k in 0..4 {
            let corner = (4 * q + k) as u32;
            sums[groups.of(corner) as usize] += angle(mesh, quad, k) * normals[q];
        }
    }
    let normal = |q: usize, group: u32| {
        let normal = sums[group as usize].normalize_or(normals[q]);
        // Quads without area around a vertex leave nothing to take the mean of; a normal has a length all the same.
        let normal = normal.normalize_or(DVec3::Z);
        normal.as_vec3().to_array()
    };
    let corner = |q: usize, k: usize, groups: &mut Groups| normal(q, groups.of((4 * q + k) as u32));
    let corners = |q: usize| {
        check_now_and_then(ctx, q)?;
        Ok::<_, Cancelled>([0, 1, 2, 3].map(|k| corner(q, k, &mut groups)))
    };
    (0..mesh.quads.len()).map(corners).collect()
}

fn check_now_and_then(ctx: &RunContext, i: usize) -> Result<(), Cancelled> {
    if i.is_multiple_of(STRIDE) { ctx.check() } else { Ok(()) }
}

/// The unit normal of a quad; zero without area.
fn of_quad(mesh: &QuadMesh, quad: &[u32; 4]) -> DVec3 {
    let [a, b, c, d] = quad.map(|v| mesh.positions[v as usize]);
    (c - a).cross(d - b).normalize_or_zero()
}

/// The angle of a quad at its corner k.
fn angle(mesh: &QuadMesh, quad: &[u32; 4], k: usize) -> f64 {
    let [before, at, after] = [3, 0, 1].map(|i| mesh.positions[quad[(k + i) % 4] as usize]);
    let (u, v) = (before - at, after - at);
    if u == DVec3::ZERO || v == DVec3::ZERO { 0.0 } else { u.angle_between(v) }
}

/// Which corners share a normal.
struct Groups {
    parent: Vec<u32>,
}

impl Groups {
    /// The first corner of a corner's group.
    fn of(&mut self, mut corner: u32) -> u32 {
        while self.parent[corner as usize] != corner {
            self.parent[corner as usize] = self.parent[self.parent[corner as usize] as usize];
            corner = self.parent[corner as usize];
        }
        corner
    }

    fn join(&mut self, a: u32, b: u32) {
        let (a, b) = (self.of(a), self.of(b));
        self.parent[a.max(b) as usize] = a.min(b);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn normals_of(mesh: &QuadMesh, features: &[[u32; 2]]) -> Vec<[[f32; 3]; 4]> {
        corner_normals(&RunContext::silent(), mesh, features).unwrap()
    }

    /// The surface of a cube from −1 to 1, n by n quads per side, with what `moved` makes of its vertices.
    fn cube(n: i32, moved: impl Fn(DVec3) -> DVec3) -> QuadMesh {
        let mut mesh = QuadMesh::default();
        let mut seen = std::collections::BTreeMap::new();
        for (axis, side) in [(0, 0), (0, n), (1, 0), (1, n), (2, 0), (2, n)] {
            for (i, j) in (0..n).flat_map(|i| (0..n).map(move |j| (i, j))) {
                let mut corners = [(0, 0), (1, 0), (1, 1), (0, 1)].map(|(di, dj)| {
                    let mut p = [0; 3];
                    p[axis] = side;
                    p[(axis + 1) % 3] = i + di;
                    p[(axis + 2) % 3] = j + dj;
                    p
                });
                if side == 0 {
                    corners.reverse();
                }
                mesh.quads.push(corners.map(|p| {
                    *seen.entry(p).or_insert_with(|| {
                        let p = DVec3::from_array(p.map(|x| 2.0 * f64::from(x) / f64::from(n) - 1.0));
                        mesh.positions.push(moved(p));
                        mesh.positions.len() as u32 - 1
                    })
                }));
            }
        }
        mesh
    }

    /// The edges of a mesh whose ends both lie where `is_feature` says.
    fn edges(mesh: &QuadMesh, is_feature: impl Fn(DVec3) -> bool) -> Vec<[u32; 2]> {
        let sides = mesh.quads.iter().flat_map(|q| (0..4).map(|k| [q[k], q[(k + 1) % 4]]));
        let mut edges: Vec<[u32; 2]> = sides.map(|[a, b]| [a.min(b), a.max(b)]).collect();
        edges.retain(|e| e.iter().all(|&v| is_feature(mesh.positions[v as usize])));
        edges.sort_unstable();
        edges.dedup();
        edges
    }

    fn bits(normal: [f32; 3]) -> [u32; 3] {
        normal.map(|x| (x + 0.0).to_bits())
    }

    fn is_on_two_sides(p: DVec3) -> bool {
        p.to_array().iter().filter(|x| x.abs() == 1.0).count() >= 2
    }

    #[test]
    fn a_cube_with_its_edges_has_six_normals_and_three_at_every_corner() {
        for n in [1, 4] {
            let mesh = cube(n, |p| p);
            let normals = normals_of(&mesh, &edges(&mesh, is_on_two_sides));
            for (quad, normals) in mesh.quads.iter().zip(&normals) {
                let flat = of_quad(&mesh, quad).as_vec3().to_array();
                assert!(normals.iter().all(|n| bits(*n) == bits(flat)), "{normals:?}");
            }
            let pairs = mesh.quads.iter().zip(&normals).flat_map(|(q, n)| (0..4).map(|k| (q[k], bits(n[k]))));
            let at_corners = pairs.filter(|(v, _)| mesh.positions[*v as usize].abs() == DVec3::ONE);
            assert_eq!(at_corners.collect::<std::collections::BTreeSet<_>>().len(), 24);
        }
    }

    #[test]
    fn without_features_and_on_smooth_ones_every_vertex_has_one_normal() {
        let sphere = cube(16, DVec3::normalize);
        let equator = edges(&sphere, |p| p.z.abs() < 1e-12);
        assert_eq!(equator.len(), 64);
        for features in [&[], equator.as_slice()] {
            let normals = normals_of(&sphere, features);
            let mut of_vertex = vec![None; sphere.positions.len()];
            for (quad, normals) in sphere.quads.iter().zip(&normals) {
                for (&v, &normal) in quad.iter().zip(normals) {
                    assert_eq!(bits(*of_vertex[v as usize].get_or_insert(normal)), bits(normal));
                    let normal = DVec3::from_array(normal.map(f64::from));
                    assert!((normal.length() - 1.0).abs() < 1e-6);
                    let degrees = normal.angle_between(sphere.positions[v as usize]).to_degrees();
                    assert!(degrees < 2.0, "{degrees}");
                }
            }
        }
    }

    #[test]
    fn a_feature_that_ends_splits_no_normal_at_its_end() {
        // One edge of a cube is sharp: it splits its inner vertices, and not the corners where it ends.
        let mesh = cube(4, |p| p);
        let sharp = edges(&mesh, |p| p.x == 1.0 && p.y == 1.0);
        let normals = normals_of(&mesh, &sharp);
        let mut of_vertex = vec![std::collections::BTreeSet::new(); mesh.positions.len()];
        for (quad, normals) in mesh.quads.iter().zip(&normals) {
            for (&v, &normal) in quad.iter().zip(normals) {
                of_vertex[v as usize].insert(bits(normal));
            }
        }
        for (p, normals) in mesh.positions.iter().zip(&of_vertex) {
            let is_inside = p.x == 1.0 && p.y == 1.0 && p.z.abs() < 1.0;
            assert_eq!(normals.len(), if is_inside { 2 } else { 1 }, "{p}");
        }
    }

    #[test]
    fn quads_without_area_have_normals_too() {
        let positions = vec![DVec3::ZERO, DVec3::X, DVec3::X, DVec3::ZERO];
        let mesh = QuadMesh { positions, quads: vec![[0, 1, 2, 3]] };
        assert_eq!(normals_of(&mesh, &[]), [[[0.0, 0.0, 1.0]; 4]]);
    }
}
