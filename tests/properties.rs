//! What must hold of any input: no panic, and certified quads of the same topology wherever there are quads.
//!
//! The cases are the same in every run; another `QUADRILLE_SEED` draws others. Whether results are right is judged here
//! by counting vertices, edges and faces, not by the engine's own certificate alone.

use std::collections::BTreeMap;

use glam::DVec3;
use proptest::collection::vec;
use proptest::prelude::*;
use proptest::test_runner::{RngSeed, TestCaseResult};
use quadrille::engine::mesh::shapes::sample;
use quadrille::engine::mesh::{TriMesh, TriangleSoup, next};
use quadrille::engine::pipeline::{
    FeatureSpec, NonOrientable, Optimise, Outcome, RemeshSpec, Target, WorkingMesh, remesh,
};
use quadrille::engine::run::{Blame, Fault, RunContext, WarningKind};

const SOUPS: u32 = 10_000;
const SURFACES: u32 = 1_000;

fn config(cases: u32) -> ProptestConfig {
    let seed = std::env::var("QUADRILLE_SEED").ok().and_then(|seed| seed.parse().ok()).unwrap_or(1);
    ProptestConfig {
        cases,
        rng_seed: RngSeed::Fixed(seed),
        failure_persistence: None,
        max_shrink_iters: 300,
        ..ProptestConfig::default()
    }
}

/// Euler characteristic and number of loops of the boundary; an error where an edge has more than two faces, two faces
/// run along an edge in the same direction, or a vertex has two fans.
fn topology<const N: usize>(faces: &[[u32; N]]) -> Result<(i64, usize), String> {
    let mut side = BTreeMap::new();
    let mut corners: BTreeMap<u32, Vec<(usize, usize)>> = BTreeMap::new();
    for (f, face) in faces.iter().enumerate() {
        for k in 0..N {
            if side.insert((face[k], face[(k + 1) % N]), (f, k)).is_some() {
                return Err(format!("two faces run from {} to {}", face[k], face[(k + 1) % N]));
            }
            corners.entry(face[k]).or_default().push((f, k));
        }
    }
    let edges = side.keys().filter(|&&(a, b)| a < b || !side.contains_key(&(b, a))).count();
    let mut after = BTreeMap::new();
    for &(a, b) in side.keys().filter(|&&(a, b)| !side.contains_key(&(b, a))) {
        if after.insert(a, b).is_some() {
            return Err(format!("the boundary meets itself at {a}"));
        }
    }
    for (&v, around) in &corners {
        // From the boundary if there is one, across edges, all corners are met.
        let is_first = |&&(f, k): &&(usize, usize)| !side.contains_key(&(faces[f][(k + 1) % N], v));
        let first = around.iter().find(is_first).copied().unwrap_or(around[0]);
        let across = |(f, k): (usize, usize)| side.get(&(v, faces[f][(k + N - 1) % N])).copied();
        let fan = std::iter::successors(Some(first), |&c| across(c).filter(|&c| c != first));
        let met = fan.take(around.len() + 1).count();
        if met != around.len() {
            return Err(format!("vertex {v} has {} corners, {met} in one fan", around.len()));
        }
    }
    let mut loops = 0;
    while let Some((start, mut at)) = after.pop_first() {
        loops += 1;
        while at != start {
            at = after.remove(&at).ok_or("the boundary ends")?;
        }
    }
    Ok((corners.len() as i64 - edges as i64 + faces.len() as i64, loops))
}

/// Certified quads, as manifold as the surface that they were made for and of its topology, and nothing went wrong
/// on the way.
fn check(outcome: &Outcome) -> TestCaseResult {
    let (quads, report) = (&outcome.quads, &outcome.report);
    prop_assert!(report.certified, "not certified: {:?}", report.warnings);
    prop_assert!(quads.positions.iter().all(|p| p.is_finite()));
    let contained = report.warnings.iter().find(|w| matches!(w.kind, WarningKind::InternalError { .. }));
    prop_assert!(contained.is_none(), "{:?}", report.warnings);
    let made = topology(&quads.quads).map_err(TestCaseError::fail)?;
    let given = topology(outcome.surface.mesh.faces()).map_err(TestCaseError::fail)?;
    prop_assert_eq!(made, given);
    Ok(())
}

/// Coordinates of all sizes: a power of ten, and how far from the origin in extents.
fn placement() -> impl Strategy<Value = (i32, f64)> {
    (-9..10i32, prop_oneof![3 => Just(0.0), 1 => -100.0..100.0f64])
}

fn place(soup: &mut TriangleSoup, (exponent, offset): (i32, f64)) {
    let scale = 10f64.powi(exponent);
    soup.positions.iter_mut().for_each(|p| *p = (*p + DVec3::new(offset, -offset, 0.5 * offset)) * scale);
}

/// Polygons over few places, which mostly are on a coarse grid: every kind of degeneracy at once.
fn heap() -> impl Strategy<Value = TriangleSoup> {
    let grid = (0..4i32, 0..4i32, 0..3i32).prop_map(|(x, y, z)| DVec3::new(x.into(), y.into(), z.into()));
    let anywhere = (-1.0..4.0f64, -1.0..4.0f64, -1.0..3.0f64).prop_map(|(x, y, z)| DVec3::new(x, y, z));
    let close = (0..4i32, 0..4i32, -1e-7..1e-7f64).prop_map(|(x, y, z)| DVec3::new(x.into(), y.into(), z));
    let position = prop_oneof![4 => grid, 2 => anywhere, 1 => close];
    let polygon = prop_oneof![4 => vec(0..1000u32, 3), 1 => vec(0..1000u32, 1..7)];
    (vec(position, 3..10), vec(polygon, 1..14), placement()).prop_map(|(positions, polygons, placement)| {
        let n = positions.len() as u32;
        let mut soup = TriangleSoup { positions, ..TriangleSoup::default() };
        for polygon in polygons {
            soup.push_polygon(&polygon.iter().map(|i| i % n).collect::<Vec<u32>>());
        }
        place(&mut soup, placement);
        soup
    })
}

/// A small surface with triangles missing, turned over and doubled, vertices joined and vertices torn away.
fn wreck() -> impl Strategy<Value = TriangleSoup> {
    let base = prop_oneof![16 => Just(("cube", 12)), 4 => Just(("cube", 48)), 1 => Just(("half_pipe", 200))];
    let damage = vec((0..6u8, any::<u32>(), any::<u32>()), 0..10);
    (base, damage, placement()).prop_map(|((name, triangles), damage, placement)| {
        let mut soup = sample(name, triangles, 0.0, 0).unwrap_or_default();
        let mut faces: Vec<Vec<u32>> = soup.polygons().map(<[u32]>::to_vec).collect();
        for (kind, i, j) in damage {
            let (n, m) = (soup.positions.len() as u32, faces.len());
            let face = i as usize % m;
            match kind {
                0 if m > 1 => drop(faces.swap_remove(face)),
                1 => faces[face].reverse(),
                2 => faces.push(faces[face].clone()),
                3 => faces.iter_mut().flatten().filter(|v| **v == i % n).for_each(|v| *v = j % n),
                4 => soup.positions[(i % n) as usize] = soup.positions[(j % n) as usize] * 1.5,
                _ => faces.push(vec![i % n, j % n, (i ^ j) % n]),
            }
        }
        let mut wreck = TriangleSoup { positions: soup.positions, ..TriangleSoup::default() };
        faces.iter().for_each(|face| wreck.push_polygon(face));
        place(&mut wreck, placement);
        wreck
    })
}

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
fn surface() -> impl Strategy<Value = TriangleSoup> {
    let base = prop_oneof![
        6 => Just(("cube", 12)),
        6 => Just(("cube", 100)),
        3 => Just(("cube", 300)),
        3 => Just(("sphere", 200)),
        3 => Just(("torus", 200)),
        2 => Just(("rounded_box", 250)),
        3 => Just(("half_pipe", 200)),
        2 => Just(("noisy_blob", 200)),
        1 => Just(("dumbbell", 300)),
        1 => Just(("genus2", 350)),
        1 => Just(("plate_with_holes", 250)),
        1 => Just(("trefoil", 250)),
    ];
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
fn spec() -> impl Strategy<Value = RemeshSpec> {
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

/// Quads of a soup, or the refusal of it.
fn check_soup(soup: &TriangleSoup, spec: &RemeshSpec) -> TestCaseResult {
    match remesh(&RunContext::silent(), soup, spec) {
        Ok(outcome) => check(&outcome),
        Err(error) => {
            prop_assert!(error.fault() == Fault::Input, "{}", error);
            Ok(())
        }
    }
}

proptest! {
    #![proptest_config(config(SOUPS / 2))]

    #[test]
    fn any_heap_of_polygons_becomes_certified_quads_or_is_refused(soup in heap(), spec in spec()) {
        check_soup(&soup, &spec)?;
    }

    #[test]
    fn any_wreck_of_a_surface_becomes_certified_quads_or_is_refused(soup in wreck(), spec in spec()) {
        check_soup(&soup, &spec)?;
    }
}

proptest! {
    #![proptest_config(config(SURFACES))]

    #[test]
    fn any_surface_becomes_certified_quads(soup in surface(), spec in spec()) {
        let outcome = remesh(&RunContext::silent(), &soup, &spec).map_err(|e| TestCaseError::fail(e.to_string()))?;
        check(&outcome)?;
        let faces: Vec<[u32; 3]> = soup.polygons().filter_map(|p| p.try_into().ok()).collect();
        prop_assert_eq!(topology(&outcome.quads.quads), topology(&faces));
    }
}
