//! Manifold surfaces, and what is asked for them.

use glam::DVec3;
use proptest::collection::vec;
use proptest::prelude::*;
use proptest::strategy::Union;
use quadrille::engine::mesh::shapes::sample;
use quadrille::engine::mesh::{TriMesh, TriangleSoup, next};
use quadrille::engine::pipeline::{FeatureSpec, NonOrientable, Optimise, RemeshSpec, Target, WorkingMesh};

use crate::cases::number_of_cases;
use crate::soups::{place, placement};
use crate::topology::topology;

/// Samples with their triangles and how often they are drawn, where time is short and where it is not.
const BASES: [(&str, usize, u32, u32); 12] = [
    ("cube", 12, 8, 6),
    ("cube", 100, 8, 6),
    ("cube", 300, 3, 3),
    ("sphere", 200, 5, 3),
    ("torus", 200, 5, 3),
    ("rounded_box", 250, 2, 2),
    ("half_pipe", 200, 5, 3),
    ("noisy_blob", 200, 1, 2),
    ("dumbbell", 300, 1, 1),
    ("genus2", 350, 1, 1),
    ("plate_with_holes", 250, 1, 1),
    ("trefoil", 250, 1, 1),
];

/// Turns an edge that two triangles share, where that leaves a manifold.
fn turn_edge(faces: &mut [[u32; 3]], positions: &[DVec3], choice: u32) {
    let Ok(mesh) = TriMesh::try_new(positions.to_vec(), faces.to_vec()) else { return };
    let h = choice as usize % mesh.n_halfedges();
    let Some(twin) = mesh.twin(h) else { return };
    let (a, b) = (mesh.origin(h), mesh.target(h));
    let (c, d) = (mesh.target(next(h)), mesh.target(next(twin)));
    let is_joined = faces.iter().any(|face| face.contains(&c) && face.contains(&d));
    if !is_joined && c != d {
        faces[h / 3] = [a, d, c];
        faces[twin / 3] = [d, b, c];
    }
}

/// A manifold surface: a sample, bent and stretched, with noise, edges turned at random and triangles cut out.
pub(crate) fn surface() -> impl Strategy<Value = TriangleSoup> {
    let drawn = |&(name, triangles, gate, soak)| (number_of_cases(gate, soak), Just((name, triangles)));
    let base = Union::new_weighted(BASES.iter().map(drawn).collect());
    let shape = (-0.3..0.3f64, 0.1..1.0f64, 0.1..1.0f64, -2.0..2.0f64);
    let edits = (vec(any::<u32>(), 0..12), vec(any::<u32>(), 0..8));
    (base, shape, edits, any::<u64>(), placement()).prop_map(|((name, triangles), shape, edits, seed, placement)| {
        let (noise, flat, thin, twist) = shape;
        let mut soup = sample(name, triangles, noise.max(0.0), seed).unwrap_or_default();
        for p in &mut soup.positions {
            let (sin, cos) = (twist * p.x).sin_cos();
            *p = DVec3::new(p.x, flat * (cos * p.y - sin * p.z), thin * (sin * p.y + cos * p.z));
        }
        let mut faces: Vec<[u32; 3]> = soup.polygons().filter_map(|p| p.try_into().ok()).collect();
        edits.0.iter().for_each(|&choice| turn_edge(&mut faces, &soup.positions, choice));
        for &choice in &edits.1 {
            let face = faces.swap_remove(choice as usize % faces.len());
            // Vertices that only that triangle had, or that now join two fans, would make another surface of it.
            if faces.is_empty() || topology(&faces).is_err() {
                faces.push(face);
            }
        }
        let mut soup = TriangleSoup::from_triangles(soup.positions, &faces);
        place(&mut soup, placement);
        soup
    })
}

/// What is asked for: mostly the plain things, which are the fastest.
pub(crate) fn spec() -> impl Strategy<Value = RemeshSpec> {
    let optimise = prop_oneof![8 => Just(Optimise::None), 1 => Just(Optimise::Relocate), 1 => Just(Optimise::Balance)];
    let angle = prop_oneof![3 => Just(40.0), 1 => Just(180.0), 1 => 20.0..90.0f64];
    let adaptive_size = prop_oneof![4 => Just(0.0), 1 => 0.0..100.0f64];
    let working_mesh = prop_oneof![4 => Just(WorkingMesh::Auto), 1 => Just(WorkingMesh::Input)];
    (6..40u64, optimise, angle, adaptive_size, working_mesh).prop_map(
        |(quads, optimise, angle_degrees, adaptive_size, working_mesh)| RemeshSpec {
            target: Target::Quads(quads),
            optimise,
            adaptive_size,
            working_mesh,
            features: FeatureSpec { angle_degrees, ..FeatureSpec::default() },
            non_orientable: NonOrientable::Cut,
            ..RemeshSpec::default()
        },
    )
}
