//! Small surfaces with known topology and features, for the tests of this floor and of the fallback.

use std::f64::consts::TAU;

use glam::DVec3;

use crate::engine::mesh::{Features, Surface, TriMesh};

/// Marks edges with a dihedral angle above `degrees`, and as corners the vertices where not two of them (boundary
/// counted) meet or where they turn by 45 degrees or more.
pub(in crate::engine) fn with_features(mesh: TriMesh, degrees: f64) -> Surface {
    let mut edges = Vec::new();
    for h in (0..mesh.n_halfedges()).filter(|&h| mesh.is_edge_owner(h)) {
        if let Some(t) = mesh.twin(h)
            && mesh.normal(h / 3).dot(mesh.normal(t / 3)) < degrees.to_radians().cos()
        {
            let (a, b) = (mesh.origin(h), mesh.target(h));
            edges.push([a.min(b), a.max(b)]);
        }
    }
    edges.sort_unstable();
    let features = Features { edges, corners: Vec::new() };
    let flags = features.halfedge_flags(&mesh);
    let mut around = vec![Vec::new(); mesh.n_vertices()];
    for h in (0..mesh.n_halfedges()).filter(|&h| flags[h] && mesh.is_edge_owner(h)) {
        let (a, b) = (mesh.origin(h), mesh.target(h));
        around[a as usize].push((mesh.position(b) - mesh.position(a)).normalize());
        around[b as usize].push((mesh.position(a) - mesh.position(b)).normalize());
    }
    let is_corner = |d: &Vec<DVec3>| !(d.is_empty() || d.len() == 2 && d[0].dot(d[1]) < -(45f64.to_radians().cos()));
    let corners = (0..mesh.n_vertices() as u32).filter(|&v| is_corner(&around[v as usize])).collect();
    Surface { mesh, features: Features { corners, ..features } }
}

/// A box of 12 triangles.
pub(in crate::engine) fn cuboid(size: DVec3) -> Surface {
    let positions = (0..8).map(|i| size * DVec3::new((i & 1) as f64, (i >> 1 & 1) as f64, (i >> 2) as f64)).collect();
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let faces = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    with_features(TriMesh::try_new(positions, faces).unwrap(), 40.0)
}

/// A torus around the z axis with radii 1 and 0.4.
pub(in crate::engine) fn torus(n: usize, m: usize) -> Surface {
    let mut positions = Vec::new();
    for i in 0..n {
        for j in 0..m {
            let (u, v) = (TAU * i as f64 / n as f64, TAU * j as f64 / m as f64);
            positions.push(DVec3::new((1.0 + 0.4 * v.cos()) * u.cos(), (1.0 + 0.4 * v.cos()) * u.sin(), 0.4 * v.sin()));
        }
    }
    let at = |i: usize, j: usize| (i % n * m + j % m) as u32;
    let mut faces = Vec::new();
    for (i, j) in (0..n).flat_map(|i| (0..m).map(move |j| (i, j))) {
        faces.push([at(i, j), at(i + 1, j), at(i + 1, j + 1)]);
        faces.push([at(i, j), at(i + 1, j + 1), at(i, j + 1)]);
    }
    with_features(TriMesh::try_new(positions, faces).unwrap(), 180.0)
}

/// An octahedron subdivided `levels` times, pushed to `radius(direction)`.
pub(in crate::engine) fn ball(levels: usize, radius: impl Fn(DVec3) -> f64) -> Surface {
    let mut positions = vec![DVec3::X, -DVec3::X, DVec3::Y, -DVec3::Y, DVec3::Z, -DVec3::Z];
    let mut faces: Vec<[u32; 3]> =
        vec![[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]];
    for _ in 0..levels {
        let mut middles = std::collections::BTreeMap::new();
        let mut fine = Vec::new();
        for [a, b, c] in faces {
            let mut middle = |a: u32, b: u32| {
                *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
                    positions.push((positions[a as usize] + positions[b as usize]).normalize());
                    (positions.len() - 1) as u32
                })
            };
            let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
            fine.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]);
        }
        faces = fine;
    }
    let positions = positions.into_iter().map(|p| p * radius(p)).collect();
    with_features(TriMesh::try_new(positions, faces).unwrap(), 180.0)
}

/// A square of side 2 with a round hole of radius 0.5, coarse outside and fine inside.
pub(in crate::engine) fn plate_with_hole() -> Surface {
    let n = 40;
    let mut positions = Vec::new();
    for i in 0..n {
        let u = TAU * i as f64 / n as f64;
        let d = DVec3::new(u.cos(), u.sin(), 0.0);
        positions.push(0.5 * d);
        positions.push(d / d.x.abs().max(d.y.abs()));
    }
    let mut faces = Vec::new();
    for i in 0..n {
        let (a, b) = (2 * i as u32, 2 * ((i + 1) % n) as u32);
        faces.push([a, a + 1, b + 1]);
        faces.push([a, b + 1, b]);
    }
    with_features(TriMesh::try_new(positions, faces).unwrap(), 40.0)
}

/// A cylinder with lids: its feature curves are two loops without corners.
pub(in crate::engine) fn drum(n: u32) -> Surface {
    let mut positions = vec![DVec3::ZERO, DVec3::Z];
    for i in 0..n {
        let u = TAU * i as f64 / n as f64;
        positions.extend([DVec3::new(u.cos(), u.sin(), 0.0), DVec3::new(u.cos(), u.sin(), 1.0)]);
    }
    let mut faces = Vec::new();
    for i in 0..n {
        let (a, b) = (2 + 2 * i, 2 + 2 * ((i + 1) % n));
        faces.extend([[a, b, b + 1], [a, b + 1, a + 1], [0, b, a], [1, a + 1, b + 1]]);
    }
    with_features(TriMesh::try_new(positions, faces).unwrap(), 60.0)
}

/// All of them, with names.
pub(in crate::engine) fn all() -> Vec<(&'static str, Surface)> {
    let bumps = |p: DVec3| 1.0 + 0.15 * (5.0 * p.x).sin() * (4.0 * p.y + 1.0).cos() + 0.1 * (7.0 * p.z).sin();
    vec![
        ("cube", cuboid(DVec3::ONE)),
        ("long box", cuboid(DVec3::new(20.0, 1.0, 0.5))),
        ("torus", torus(24, 12)),
        ("ball", ball(3, |_| 1.0)),
        ("bumpy", ball(4, bumps)),
        ("plate with hole", plate_with_hole()),
        ("drum", drum(48)),
    ]
}

/// Lengths of all feature edges and of all boundary edges.
pub(in crate::engine) fn feature_length(surface: &Surface) -> (f64, f64) {
    let mesh = &surface.mesh;
    let length = |h: usize| mesh.position(mesh.origin(h)).distance(mesh.position(mesh.target(h)));
    let features = surface.features.edges.iter().map(|&[a, b]| mesh.position(a).distance(mesh.position(b))).sum();
    (features, (0..mesh.n_halfedges()).filter(|&h| mesh.is_boundary(h)).map(length).sum())
}

/// Per face, how many of its sides lie on feature curves or on the boundary.
pub(in crate::engine) fn flags_per_face(surface: &Surface) -> Vec<usize> {
    let flags = surface.features.halfedge_flags(&surface.mesh);
    flags.chunks(3).map(|sides| sides.iter().filter(|&&flag| flag).count()).collect()
}
