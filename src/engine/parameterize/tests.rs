//! Maps of the sample surfaces.

use super::*;
use crate::engine::field::FieldOptions;
use crate::engine::field::Frames;
use crate::engine::field::curvature_guidance;
use crate::engine::field::smooth_cross_field;
use crate::engine::mesh::refine;
use crate::engine::mesh::shapes::sample_surface;
use crate::engine::run::RunContext;

fn check(name: &str, quads: f64, expected: &[(i32, usize)]) {
    let ctx = RunContext::silent();
    let surface = sample_surface(name, 8000).expect("a sample");
    let h = (surface.mesh.total_area() / quads).sqrt();
    let refined = refine(&ctx, &surface, |_| 0.5 * h, 200_000).unwrap();
    let (mesh, features) = (&refined.surface.mesh, &refined.surface.features);
    let frames = Frames::new(mesh);
    let flags = features.halfedge_flags(mesh);
    let guidance = curvature_guidance(mesh, &frames, &flags, 0.7 * h);
    let options = FieldOptions { edge_length: h, smoothing: 0.5 };
    let field = smooth_cross_field(&ctx, mesh, &frames, &flags, Some(&guidance), &options).unwrap();
    let mut histogram = std::collections::BTreeMap::new();
    for s in field.singularities() {
        *histogram.entry(s.quarters).or_insert(0usize) += 1;
    }
    let system = MapSystem::new(&ctx, mesh, &frames, &field, &flags, &features.corners).unwrap();
    let rounded = system.round(&ctx, 1.0 / h).unwrap();
    let map = system.map(mesh, &rounded).unwrap();
    let m = measure_map(mesh, &frames, &map, 1.0 / h);
    println!(
        "{name}: faces {} integers {} singularities {histogram:?} {m:?} {:.4} {:.4}",
        mesh.n_faces(),
        system.n_integers(),
        rounded.curl_energy,
        rounded.rounding_energy
    );
    assert!(m.seam_residual < 1e-9);
    if !expected.is_empty() {
        assert_eq!(histogram.into_iter().collect::<Vec<_>>(), expected, "{name}");
    }
}

#[test]
fn maps_of_samples() {
    for (name, expected) in [
        ("sphere", &[(1, 8)][..]),
        ("torus", &[]),
        ("cube", &[(1, 8)]),
        ("rounded_box", &[(1, 8)]),
        ("ellipsoid", &[(1, 8)]),
        ("genus2", &[]),
        ("genus5", &[]),
        ("gear", &[]),
        ("half_pipe", &[]),
        ("plate_with_holes", &[]),
        ("dumbbell", &[]),
        ("trefoil", &[]),
        ("noisy_blob", &[]),
    ] {
        check(name, 2000.0, expected);
    }
}
