//! Maps of given frame fields: the Hodge projection, exactly.

use glam::DVec2;

use crate::engine::field::{
    CrossField, FieldOptions, FrameField, Frames, GivenBranchPoints, GivenField, GivenMatching, GivenVectors,
    smooth_cross_field,
};
use crate::engine::mesh::shapes::sample_surface;
use crate::engine::mesh::{Surface, TriMesh, TriangleSoup};
use crate::engine::parameterize::{MapAim, MapSystem, Precision, gradients, measure_map, untangle};
use crate::engine::run::RunContext;

fn smooth(surface: &Surface, frames: &Frames, edge_length: f64) -> CrossField {
    let flags = surface.features.halfedge_flags(&surface.mesh);
    let options = FieldOptions { edge_length, smoothing: 0.5, branch_points: None, strokes: None, start: None };
    smooth_cross_field(&RunContext::silent(), &surface.mesh, frames, &flags, None, &options).unwrap().0
}

fn put(mesh: &TriMesh, vectors: GivenVectors, matchings: Vec<GivenMatching>) -> FrameField {
    let soup = TriangleSoup::from_triangles(mesh.positions().to_vec(), mesh.faces());
    let polygon: Vec<u32> = (0..mesh.n_faces() as u32).collect();
    let given = GivenField { vectors, matchings, branch_points: GivenBranchPoints::Keep };
    FrameField::on_surface(&given, &soup, mesh, &polygon).unwrap()
}

/// The system of a given field, and its crosses.
fn system_of(surface: &Surface, frames: &Frames, given: &FrameField) -> (MapSystem, CrossField) {
    let mesh = &surface.mesh;
    let flags = surface.features.halfedge_flags(mesh);
    let crosses = given.crosses(mesh, frames, &flags);
    let gradients = given.gradients(mesh, frames);
    let aim = MapAim { weight: vec![1.0; mesh.n_faces()], gradients, precision: Precision::Refined };
    let corners = &surface.features.corners;
    (MapSystem::new(&RunContext::silent(), mesh, frames, &crosses, &flags, corners, aim).unwrap(), crosses)
}

/// ‖X‖², ‖dz‖² and ‖X − dz‖² of the seamless map of a system.
fn energies(mesh: &TriMesh, frames: &Frames, system: &MapSystem) -> [f64; 3] {
    let mut sums = [0.0; 3];
    for f in 0..mesh.n_faces() {
        let (du, dv) = gradients(mesh, frames, system.seamless_corners(), f);
        let [x, y] = system.gradients()[f];
        let parts = [[x, y], [du, dv], [x - du, y - dv]];
        for (sum, part) in sums.iter_mut().zip(parts) {
            *sum += mesh.area(f) * part.map(DVec2::length_squared).iter().sum::<f64>();
        }
    }
    sums
}

/// `‖X‖² = ‖dz‖² + ‖X − dz‖²`: the map is the orthogonal projection of the field, lengths and angles and all.
#[test]
fn the_map_of_a_given_field_is_its_projection() {
    for name in ["torus", "sphere", "genus2", "half_pipe", "cube"] {
        let surface = sample_surface(name, 1500).unwrap();
        let mesh = &surface.mesh;
        let frames = Frames::new(mesh);
        let field = smooth(&surface, &frames, (mesh.total_area() / 300.0).sqrt());
        let stretch = |f: usize| 1.5 + mesh.triangle(f)[0].x.sin();
        let pair = |f: usize| {
            let x = DVec2::from_angle(field.angle[f]);
            [frames.vector(f, stretch(f) * x), frames.vector(f, 0.3 * x + 0.8 * x.perp())]
        };
        for vectors in [
            GivenVectors::Crosses((0..mesh.n_faces()).map(|f| pair(f)[0]).collect()),
            GivenVectors::Frames((0..mesh.n_faces()).map(pair).collect()),
        ] {
            let (system, _) = system_of(&surface, &frames, &put(mesh, vectors, Vec::new()));
            let [whole, map, rest] = energies(mesh, &frames, &system);
            assert!((whole - map - rest).abs() < 1e-9 * whole, "{name}: {whole} {map} {rest}");
            let curl_energy = system.round(&RunContext::silent(), mesh, 3.0).unwrap().curl_energy;
            assert!((curl_energy - rest / whole).abs() < 1e-9, "{name}: {curl_energy} {}", rest / whole);
            assert!(map < whole * (1.0 + 1e-12), "{name}");
        }
    }
}

/// The gradients of a seamless map are a field without curl: with the matchings of the map, which directions are called
/// the first in which triangle being arbitrary, the map comes out again.
#[test]
fn a_field_of_gradients_gives_its_map_again() {
    for name in ["torus", "ellipsoid", "cube", "half_pipe"] {
        let surface = sample_surface(name, 3000).unwrap();
        let mesh = &surface.mesh;
        let frames = Frames::new(mesh);
        let edge_length = (mesh.total_area() / 300.0).sqrt();
        let field = smooth(&surface, &frames, edge_length);
        let flags = surface.features.halfedge_flags(mesh);
        let ctx = RunContext::silent();
        let weight = vec![1.0; mesh.n_faces()];
        let known = MapSystem::new(&ctx, mesh, &frames, &field, &flags, &surface.features.corners, weight).unwrap();
        let mut grid = known.map(mesh, &known.round(&ctx, mesh, 1.0 / edge_length).unwrap()).unwrap();
        let special = |v: usize| field.quarter_index[v] != 0 || surface.features.is_corner(v as u32);
        let pinned: Vec<bool> = (0..mesh.n_vertices()).map(special).collect();
        untangle(&ctx, mesh, &frames, &mut grid, &pinned, 1.0 / edge_length).unwrap();
        assert_eq!(measure_map(mesh, &frames, &grid, 1.0 / edge_length).flipped, 0, "{name}");
        let name_of = |f: usize| f * 5 % 4;
        let pair = |f: usize| {
            let (du, dv) = gradients(mesh, &frames, &grid.uv, f);
            let all = [du, dv, -du, -dv];
            [0, 1].map(|k| frames.vector(f, all[(name_of(f) + k) % 4]))
        };
        let matching = |h: usize| {
            let (f, g) = (h / 3, mesh.twin(h)? / 3);
            let quarters = (8 + name_of(f) - name_of(g) - usize::from(grid.rotation[h])) % 4;
            Some(GivenMatching { from: f as u32, to: g as u32, quarters: quarters as u8 })
        };
        let matchings = (0..mesh.n_halfedges()).filter_map(matching).collect();
        let vectors = GivenVectors::Frames((0..mesh.n_faces()).map(pair).collect());
        let (system, crosses) = system_of(&surface, &frames, &put(mesh, vectors, matchings));
        assert_eq!(crosses.quarter_index, field.quarter_index, "{name}");
        let mut away: f64 = 0.0;
        for f in 0..mesh.n_faces() {
            let (du, dv) = gradients(mesh, &frames, system.seamless_corners(), f);
            let [x, y] = system.gradients()[f];
            away = away.max((du - x).length() / x.length()).max((dv - y).length() / y.length());
        }

        assert!(away < 1e-9, "{name}: {away}");
    }
}
