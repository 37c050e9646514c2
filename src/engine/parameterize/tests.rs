//! Maps of the sample surfaces.

use super::*;
use crate::engine::field::CrossField;
use crate::engine::field::FieldOptions;
use crate::engine::field::Frames;
use crate::engine::field::curl_energy;
use crate::engine::field::curvature_guidance;
use crate::engine::field::smooth_cross_field;
use crate::engine::mesh::Surface;
use crate::engine::mesh::refine;
use crate::engine::mesh::shapes::sample_surface;
use crate::engine::run::RunContext;

struct Case {
    surface: Surface,
    frames: Frames,
    flags: Vec<bool>,
    field: CrossField,
    scale: f64,
}

fn case(name: &str, quads: f64) -> Case {
    let ctx = RunContext::silent();
    let surface = sample_surface(name, 2000).expect("a sample");
    let h = (surface.mesh.total_area() / quads).sqrt();
    let surface = refine(&ctx, &surface, |_| 0.5 * h, 100_000).unwrap().surface;
    let frames = Frames::new(&surface.mesh);
    let flags = surface.features.halfedge_flags(&surface.mesh);
    let guidance = curvature_guidance(&surface.mesh, &frames, &flags, 0.7 * h);
    let options = FieldOptions { edge_length: h, smoothing: 0.5, branch_points: None, strokes: None, start: None };
    let (field, _) = smooth_cross_field(&ctx, &surface.mesh, &frames, &flags, Some(&guidance), &options).unwrap();
    Case { surface, frames, flags, field, scale: 1.0 / h }
}

fn map(case: &Case) -> (MapSystem, RoundedIntegers, GridMap) {
    let ctx = RunContext::silent();
    let mesh = &case.surface.mesh;
    let corners = &case.surface.features.corners;
    let system =
        MapSystem::new(&ctx, mesh, &case.frames, &case.field, &case.flags, corners, vec![1.0; mesh.n_faces()]).unwrap();
    let rounded = system.round(&ctx, mesh, case.scale).unwrap();
    let map = system.map(mesh, &rounded).unwrap();
    (system, rounded, map)
}

#[test]
fn simple_samples_have_the_fewest_singularities() {
    for (name, quarters) in [("sphere", 8), ("torus", 0), ("cube", 8), ("rounded_box", 8), ("ellipsoid", 8)] {
        let case = case(name, 300.0);
        let found = case.field.singularities();
        assert_eq!(found.len(), quarters, "{name}");
        assert!(found.iter().all(|s| s.quarters == 1), "{name}");
    }
}

#[test]
fn indices_sum_to_the_euler_characteristic() {
    for name in ["sphere", "genus2", "genus5", "trefoil", "noisy_blob", "gear"] {
        let case = case(name, 500.0);
        let sum: i32 = case.field.quarter_index.iter().sum();
        assert_eq!(i64::from(sum), 4 * case.surface.mesh.topology().euler, "{name}");
    }
}

#[test]
fn maps_of_samples_are_seamless_and_integral() {
    for name in ["sphere", "torus", "cube", "genus2", "gear", "half_pipe", "plate_with_holes"] {
        let case = case(name, 500.0);
        let mesh = &case.surface.mesh;
        let (_, rounded, map) = map(&case);
        assert!(seam_residual(mesh, &map) < 1e-9, "{name}");
        // The area of a map whose boundary lies on integer lines counts whole quads.
        let measures = measure_map(mesh, &case.frames, &map, case.scale);
        assert!((measures.grid_area - measures.grid_area.round()).abs() < 1e-6, "{name}: {measures:?}");
        assert!(rounded.rounding_energy >= -1e-12 && rounded.curl_energy >= 0.0, "{name}");
        for h in 0..mesh.n_halfedges() {
            let along = map.uv[crate::engine::mesh::next(h)] - map.uv[h];
            match map.iso[h] {
                Iso::None => {}
                Iso::U => assert!(along.x.abs() < 1e-9 && (map.uv[h].x - map.uv[h].x.round()).abs() < 1e-9, "{name}"),
                Iso::V => assert!(along.y.abs() < 1e-9 && (map.uv[h].y - map.uv[h].y.round()).abs() < 1e-9, "{name}"),
            }
        }
    }
}

#[test]
fn the_map_of_a_cube_is_an_isometry() {
    let case = case("cube", 600.0);
    let (_, _, map) = map(&case);
    let m = measure_map(&case.surface.mesh, &case.frames, &map, case.scale);
    assert_eq!(m.flipped, 0);
    assert!((m.grid_area - 600.0).abs() < 1e-6 && m.arap_mean < 1e-12, "{m:?}");
}

/// The rounding energy of the period matrix is the increase of the Poisson energy, computed from the maps themselves.
#[test]
fn the_period_matrix_predicts_the_energy_of_the_rounded_map() {
    let case = case("genus2", 500.0);
    let mesh = &case.surface.mesh;
    let (system, rounded, map) = map(&case);
    let energy = |uv: &[glam::DVec2], scale: f64| {
        let (mut sum, mut norm) = (0.0, 0.0);
        for f in 0..mesh.n_faces() {
            let (du, dv) = gradients(mesh, &case.frames, uv, f);
            let [x, y] = system.gradients()[f].map(|gradient| gradient * scale);
            sum += mesh.area(f) * ((du - x).length_squared() + (dv - y).length_squared());
            norm += 2.0 * mesh.area(f) * scale * scale;
        }
        sum / norm
    };
    let seamless = energy(system.seamless_corners(), 1.0);
    let integral = energy(&map.uv, case.scale);
    assert!((seamless - rounded.curl_energy).abs() < 1e-8, "{seamless} {}", rounded.curl_energy);
    assert!((integral - seamless - rounded.rounding_energy).abs() < 1e-8, "{integral} {seamless} {rounded:?}");
}
/// What the best seamless map leaves of the field is the curl of the field on the covering: the Hodge decomposition into
/// a conforming gradient and a nonconforming cogradient, from two different systems; also where the map is bound to
/// features and to the boundary.
#[test]
fn the_curl_of_the_field_is_what_the_seamless_map_leaves() {
    for name in ["sphere", "torus", "ellipsoid", "dumbbell", "cube", "gear", "half_pipe"] {
        let case = case(name, 500.0);
        let (_, rounded, _) = map(&case);
        let curl = curl_energy(&case.surface.mesh, &case.frames, &case.field, &case.flags).unwrap();
        let found = rounded.curl_energy;
        assert!((found - curl).abs() < 1e-6 * curl + 1e-9, "{name}: {found} {curl}");
    }
}

/// Regular vertices are thrown to the far side of the singular vertex beside them, where the map may fold, or wind around
/// them twice and around the singular vertex once less.
#[test]
fn untangling_leaves_every_vertex_wound_around_as_its_index_says() {
    use crate::engine::mesh::{next, prev};
    for name in ["dumbbell", "sphere", "cube", "ellipsoid"] {
        let case = case(name, 900.0);
        let mesh = &case.surface.mesh;
        let (_, _, mut map) = map(&case);
        let pinned: Vec<bool> = (0..mesh.n_vertices() as u32)
            .map(|v| case.field.quarter_index[v as usize] != 0 || case.surface.features.is_corner(v))
            .collect();
        let ctx = RunContext::silent();
        let winding = |map: &GridMap, v: u32| -> f64 {
            let at = |h: usize| (map.uv[next(h)] - map.uv[h]).angle_to(map.uv[prev(h)] - map.uv[h]);
            mesh.fan(v).map(at).sum::<f64>() / std::f64::consts::FRAC_PI_2
        };
        let is_right = |map: &GridMap| {
            let free = |v: &u32| !mesh.is_boundary_vertex(*v) && !case.surface.features.is_corner(*v);
            (0..mesh.n_vertices() as u32)
                .filter(free)
                .all(|v| (winding(map, v) - f64::from(4 - case.field.quarter_index[v as usize])).abs() < 1e-6)
        };
        assert_eq!(untangle(&ctx, mesh, &case.frames, &mut map, &pinned, case.scale).unwrap(), 0, "{name}");
        assert!(is_right(&map), "{name}");
        for s in case.field.singularities() {
            let h = mesh.fan(s.vertex).next().unwrap();
            let v = mesh.target(h);
            // Charts around v, until the one that has the singular vertex ahead.
            let (mut quarters, mut corners) = (0u8, Vec::new());
            for h in mesh.fan(v) {
                corners.push((h, quarters));
                quarters = (quarters + 4 - map.rotation[prev(h)]) & 3;
            }
            let &(ahead, turned) = corners.iter().find(|(h, _)| mesh.target(*h) == s.vertex).unwrap();
            let step = rotate(2.0 * (map.uv[next(ahead)] - map.uv[ahead]), (4 - turned) & 3);
            for (h, quarters) in corners {
                map.uv[h] += rotate(step, quarters);
            }
        }
        assert!(!is_right(&map), "{name}");
        let left = untangle(&ctx, mesh, &case.frames, &mut map, &pinned, case.scale).unwrap();
        assert_eq!((left, is_right(&map)), (0, true), "{name}");
        assert!(seam_residual(mesh, &map) < 1e-9, "{name}");
    }
}

/// The flow gives integers with which the map is one, and that let hardly any neighbours collapse.
#[test]
fn maps_by_flow_are_integral_and_keep_most_neighbours_apart() {
    for name in ["genus2", "torus", "gear", "plate_with_holes", "half_pipe", "sphere"] {
        let case = case(name, 500.0);
        let mesh = &case.surface.mesh;
        let (system, by_periods, _) = map(&case);
        let by_flow = system.round_by_flow(&RunContext::silent(), mesh, case.scale).unwrap().expect(name);
        // Pairs that the decimated triangles do not join may still collapse; they are few.
        let most = 1 + system.n_integers() / 50;
        assert!(by_flow.fallen_together <= most, "{name}: {} of {}", by_flow.fallen_together, system.n_integers());
        let grid = system.map(mesh, &by_flow).unwrap();
        assert!(seam_residual(mesh, &grid) < 1e-9, "{name}");
        let measures = measure_map(mesh, &case.frames, &grid, case.scale);
        assert!((measures.grid_area - measures.grid_area.round()).abs() < 1e-6, "{name}: {measures:?}");
        assert!((measures.grid_area / 500.0).ln().abs() < 0.4, "{name}: {}", measures.grid_area);
        // It knows nothing of the energy, but small deviations cost little.
        assert!(
            by_flow.rounding_energy < 3.0 * by_periods.rounding_energy + 0.05,
            "{name}: {by_flow:?} {by_periods:?}"
        );
    }
}

/// Without the period matrix the optimum and the energies come from the whole system, and are the same.
#[test]
fn energies_without_the_period_matrix_are_the_same() {
    let ctx = RunContext::silent();
    let case = case("genus2", 500.0);
    let mesh = &case.surface.mesh;
    let (system, ..) = map(&case);
    let expected = system.round_by_flow(&ctx, mesh, case.scale).unwrap().unwrap();
    let seamless = system.seamless_corners().to_vec();
    let system = system.without_periods();
    let away = seamless.iter().zip(system.seamless_corners()).map(|(a, b)| (*a - b).length()).fold(0.0, f64::max);
    assert!(away * case.scale < 1e-6, "{away}");
    let added = system.added_energy(&expected);
    assert!((added - expected.rounding_energy).abs() < 1e-8, "{added} {expected:?}");
    let found = system.round(&ctx, mesh, case.scale).unwrap();
    assert_eq!(found.fallen_together, 0);
    assert!((found.curl_energy - expected.curl_energy).abs() < 1e-8, "{found:?} {expected:?}");
    assert!(matches!(system.nearest(&ctx, &[]), Err(MapError::TooManyIntegers { .. })));
}
