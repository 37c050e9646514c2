//! From the part to the whole.

use std::collections::BTreeMap;
use std::f64::consts::FRAC_PI_2;

use glam::{DVec2, DVec3, I64Vec2};

use crate::engine::mesh::{Features, Surface, TriMesh};
use crate::engine::parameterize::{GridMap, Iso};
use crate::engine::pipeline::outcome::MapOutcome;
use crate::engine::pipeline::report::Singularity;
use crate::engine::pipeline::symmetry::mirror::{Mirror, doubled};
use crate::engine::quad::QuadMesh;

/// Vertices of the boundary this near to the plane, in diagonals, are on it.
const NEAR: f64 = 1e-6;

/// One step from a half to its whole.
#[derive(Clone, Debug)]
pub(in crate::engine::pipeline) struct Unfolding {
    /// The plane.
    pub(super) mirror: Mirror,
    /// Feature edges of the whole that lie on the plane, by vertices of the part.
    pub(super) on_plane: Vec<[u32; 2]>,
}

/// The surface of which `part` is a part; `None` if it is no manifold. Faces of the part come first. Its corners on the
/// planes stay corners.
pub(in crate::engine::pipeline) fn unfold_surface(part: &Surface, unfoldings: &[Unfolding]) -> Option<Surface> {
    let mut surface = part.clone();
    let mut on_planes: Vec<Vec<[u32; 2]>> = unfoldings.iter().map(|u| u.on_plane.clone()).collect();
    for (step, Unfolding { mirror, .. }) in unfoldings.iter().enumerate() {
        let mesh = &surface.mesh;
        let is_on_plane: Vec<bool> = (0..mesh.n_vertices() as u32)
            .map(|v| mirror.side(mesh.position(v)) == 0.0 && mesh.is_boundary_vertex(v))
            .collect();
        let (positions, image) = doubled(*mirror, mesh.positions(), &is_on_plane);
        let name = |v: u32| image[v as usize];
        let with_images = |edges: &[[u32; 2]]| {
            let images = edges.iter().map(|e| e.map(name)).map(|[a, b]| [a.min(b), a.max(b)]);
            edges.iter().copied().chain(images).collect::<Vec<_>>()
        };
        let mut faces = mesh.faces().to_vec();
        faces.extend(mesh.faces().iter().map(|&[a, b, c]| [name(a), name(c), name(b)]));
        let mut edges = with_images(&surface.features.edges);
        edges.extend(&on_planes[step]);
        edges.sort_unstable();
        edges.dedup();
        for later in &mut on_planes[step + 1..] {
            *later = with_images(later);
        }
        let mut corners: Vec<u32> = surface.features.corners.iter().flat_map(|&v| [v, name(v)]).collect();
        corners.sort_unstable();
        corners.dedup();
        surface = Surface { mesh: TriMesh::try_new(positions, faces).ok()?, features: Features { edges, corners } };
    }
    Some(surface)
}

/// The quads of the whole and their feature edges; those of the part come first. Coordinates across the planes are rounded
/// such that images are exact. Where the whole has features on a plane, all edges there are taken for some.
pub(in crate::engine::pipeline) fn unfold_quads(
    mut quads: QuadMesh,
    mut features: Vec<[u32; 2]>,
    unfoldings: &[Unfolding],
) -> (QuadMesh, Vec<[u32; 2]>) {
    for Unfolding { mirror, .. } in unfoldings {
        quads.positions.iter_mut().for_each(|p| *p = mirror.exact(*p));
    }
    for Unfolding { mirror, on_plane: features_on_plane } in unfoldings {
        let is_on_plane = on_plane(*mirror, &quads.positions, &quads.quads);
        for (p, _) in quads.positions.iter_mut().zip(&is_on_plane).filter(|(_, on_plane)| **on_plane) {
            *p = mirror.foot(*p);
        }
        let (positions, image) = doubled(*mirror, &quads.positions, &is_on_plane);
        let mut both: Vec<[u32; 2]> = features.iter().flat_map(|e| [*e, e.map(|v| image[v as usize])]).collect();
        if !features_on_plane.is_empty() {
            let sides = boundary_sides(&quads.quads).into_iter();
            let sides = sides.map(|(q, k)| [quads.quads[q][k], quads.quads[q][(k + 1) % 4]]);
            both.extend(sides.filter(|e| e.iter().all(|&v| is_on_plane[v as usize])));
        }
        features = both.into_iter().map(|[a, b]| [a.min(b), a.max(b)]).collect();
        let images = quads.quads.iter().map(|&[a, b, c, d]| [a, d, c, b].map(|v| image[v as usize]));
        quads.quads = quads.quads.iter().copied().chain(images).collect();
        quads.positions = positions;
    }
    features.sort_unstable();
    features.dedup();
    (quads, features)
}

/// The map of the whole: images have (−u, v) in place of (u, v), in charts of their own. On the plane u or v is an
/// integer, so that the new transitions are integral too.
pub(in crate::engine::pipeline) fn unfold_map(mut map: MapOutcome, unfoldings: &[Unfolding]) -> MapOutcome {
    for Unfolding { mirror, .. } in unfoldings {
        let is_on_plane = on_plane(*mirror, &map.positions, &map.faces);
        let n = map.faces.len();
        let (positions, image) = doubled(*mirror, &map.positions, &is_on_plane);
        let name = |v: u32| image[v as usize];
        let grid = &mut map.grid;
        for f in 0..n {
            // Corners 0, 1, 2 of an image are those of corners 0, 2, 1; its sides are those of sides 2, 1, 0.
            for corner in [0, 2, 1] {
                grid.uv.push(grid.uv[3 * f + corner] * DVec2::new(-1.0, 1.0));
            }
            for side in [2, 1, 0] {
                let h = 3 * f + side;
                grid.rotation.push((4 - grid.rotation[h]) % 4);
                grid.translation.push(grid.translation[h] * I64Vec2::new(-1, 1));
                grid.iso.push(grid.iso[h]);
            }
        }
        let quarters = quarters_on_plane(&map, &is_on_plane);
        glue(&mut map.grid, &map.faces, &is_on_plane);
        let mirrored =
            map.singularities.iter().map(|s| Singularity { vertex: name(s.vertex), uv: [-s.uv[0], s.uv[1]], ..*s });
        let mut singularities: Vec<Singularity> = map.singularities.iter().copied().chain(mirrored).collect();
        singularities.extend(quarters);
        singularities.sort_by_key(|s| s.vertex);
        map.faces.extend(map.faces.clone().iter().map(|&[a, b, c]| [name(a), name(c), name(b)]));
        map.positions = positions;
        map.report.singularities.clone_from(&singularities);
        map.singularities = singularities;
        map.report.triangles *= 2;
        map.report.flipped *= 2;
    }
    map
}

/// Transitions between faces at the plane and their images.
fn glue(grid: &mut GridMap, faces: &[[u32; 3]], is_on_plane: &[bool]) {
    for (f, k) in boundary_sides(faces) {
        if ![k, (k + 1) % 3].iter().all(|&k| is_on_plane[faces[f][k] as usize]) {
            continue;
        }
        let (h, image) = (3 * f + k, 3 * (faces.len() + f) + 2 - k);
        let z = grid.uv[h];
        // z = i^rotation · image(z) + translation, on the line of constant u or of constant v; of opposite rotation the
        // other way round.
        let (rotation, translation) = match grid.iso[h] {
            Iso::V => (2, I64Vec2::new(0, 2 * z.y.round() as i64)),
            _ => (0, I64Vec2::new(2 * z.x.round() as i64, 0)),
        };
        for (h, sign) in [(h, 1), (image, if rotation == 2 { 1 } else { -1 })] {
            grid.rotation[h] = rotation;
            grid.translation[h] = translation * sign;
        }
    }
}

/// Vertices on the plane at which the whole has not four quarters. They are counted in the map, or, where that is folded,
/// on the surface.
fn quarters_on_plane(map: &MapOutcome, is_on_plane: &[bool]) -> Vec<Singularity> {
    let mut is_rim = vec![false; map.positions.len()];
    for (f, k) in boundary_sides(&map.faces) {
        let ends = [map.faces[f][k], map.faces[f][(k + 1) % 3]];
        if !ends.iter().all(|&v| is_on_plane[v as usize]) {
            // What stays boundary has no index.
            ends.iter().for_each(|&v| is_rim[v as usize] = true);
        }
    }
    let mut sectors: BTreeMap<u32, Sector> = BTreeMap::new();
    for (f, face) in map.faces.iter().enumerate() {
        for k in (0..3).filter(|&k| is_on_plane[face[k] as usize] && !is_rim[face[k] as usize]) {
            let [z, y, x] = [0, 1, 2].map(|i| map.grid.uv[3 * f + (k + i) % 3]);
            let [p, q, r] = [0, 1, 2].map(|i| map.positions[face[(k + i) % 3] as usize]);
            let sector =
                sectors.entry(face[k]).or_insert(Sector { in_map: 0.0, on_surface: 0.0, is_folded: false, uv: z });
            sector.in_map += (y - z).angle_to(x - z);
            sector.on_surface += (q - p).angle_between(r - p);
            sector.is_folded |= (y - z).perp_dot(x - z) <= 0.0;
        }
    }
    let index = |(&vertex, sector): (&u32, &Sector)| {
        let angle = if sector.is_folded { sector.on_surface } else { sector.in_map };
        let index_quarters = 4 - 2 * (angle / FRAC_PI_2).round() as i32;
        (index_quarters != 0).then_some(Singularity { vertex, index_quarters, uv: sector.uv.to_array() })
    };
    sectors.iter().filter_map(index).collect()
}

/// What a half has around a vertex on the plane: angles in radians, and the vertex's place in the map.
struct Sector {
    in_map: f64,
    on_surface: f64,
    is_folded: bool,
    uv: DVec2,
}

/// Per vertex whether it is on the boundary and on the plane.
fn on_plane<const N: usize>(mirror: Mirror, positions: &[DVec3], faces: &[[u32; N]]) -> Vec<bool> {
    let lo = positions.iter().copied().reduce(DVec3::min).unwrap_or_default();
    let hi = positions.iter().copied().reduce(DVec3::max).unwrap_or_default();
    let near = NEAR * (hi - lo).length();
    let mut on_plane = vec![false; positions.len()];
    for (f, k) in boundary_sides(faces) {
        for v in [faces[f][k], faces[f][(k + 1) % N]] {
            on_plane[v as usize] = mirror.side(positions[v as usize]).abs() <= near;
        }
    }
    on_plane
}

/// Sides (face, corner from which it starts) that no other face has.
fn boundary_sides<const N: usize>(faces: &[[u32; N]]) -> Vec<(usize, usize)> {
    let mut sides: Vec<([u32; 2], (usize, usize))> = Vec::with_capacity(N * faces.len());
    for (f, face) in faces.iter().enumerate() {
        sides.extend((0..N).map(|k| {
            let (a, b) = (face[k], face[(k + 1) % N]);
            ([a.min(b), a.max(b)], (f, k))
        }));
    }
    sides.sort_unstable();
    sides.chunk_by(|a, b| a.0 == b.0).filter(|same| same.len() == 1).map(|same| same[0].1).collect()
}
