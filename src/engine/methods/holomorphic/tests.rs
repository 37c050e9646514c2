//! What the steps of the method must hold on sample surfaces.

use crate::engine::calculus::{OneForm, Signs, Stars};
use crate::engine::mesh::TriMesh;
use crate::engine::mesh::shapes::sample_surface;
use crate::engine::methods::holomorphic::curves::{CurveSystem, curve_system};
use crate::engine::methods::holomorphic::differential::{Indices, Solver, harmonic_differential, indices};
use crate::engine::methods::holomorphic::foliation::Foliation;
use crate::engine::methods::holomorphic::strip::Strip;
use crate::engine::methods::holomorphic::{DifferentialMap, Options, quadratic_differential_map};
use crate::engine::run::RunContext;

fn sample(name: &str, triangles: usize) -> TriMesh {
    sample_surface(name, triangles).unwrap().mesh
}

fn strips(mesh: &TriMesh, system: CurveSystem) -> Vec<Strip> {
    curve_system(&RunContext::silent(), mesh, system, 0).unwrap()
}

fn foliation(mesh: &TriMesh, system: CurveSystem) -> Foliation {
    let strips = strips(mesh, system);
    Foliation::new(mesh, &strips, &vec![1.0; strips.len()])
}

fn map(mesh: &TriMesh, system: CurveSystem, quads: f64) -> DifferentialMap {
    let edge_length = (mesh.total_area() / quads).sqrt();
    let options = Options { system, seed: 0, edge_length, quads };
    quadratic_differential_map(&RunContext::silent(), mesh, &options).unwrap()
}

fn largest_difference(a: &OneForm, b: &OneForm) -> f64 {
    a.along.iter().zip(&b.along).map(|(x, y)| (x - y).abs()).fold(0.0, f64::max)
}

/// Pieces of the surface without the faces of the strips.
fn pieces(mesh: &TriMesh, strips: &[Strip]) -> usize {
    let mut is_seen = vec![false; mesh.n_faces()];
    strips.iter().flat_map(Strip::faces).for_each(|f| is_seen[f] = true);
    let mut n = 0;
    for seed in 0..mesh.n_faces() {
        if std::mem::replace(&mut is_seen[seed], true) {
            continue;
        }
        n += 1;
        let mut stack = vec![seed];
        while let Some(f) = stack.pop() {
            for t in (3 * f..3 * f + 3).filter_map(|h| mesh.twin(h)) {
                if !std::mem::replace(&mut is_seen[t / 3], true) {
                    stack.push(t / 3);
                }
            }
        }
    }
    n
}

#[test]
fn curves_are_simple_disjoint_and_cut_the_surface_as_they_should() {
    for (name, genus) in [("torus", 1), ("genus2", 2), ("genus5", 5)] {
        // Fine enough that three strips do not pinch the piece between them.
        let mesh = sample(name, 12000);
        let most = if genus == 1 { 1 } else { 3 * genus - 3 };
        for (system, n, n_pieces) in [
            (CurveSystem::Single, 1, 1),
            (CurveSystem::Handles, genus, 1),
            (CurveSystem::Pants, most, if genus == 1 { 1 } else { 2 * genus - 2 }),
        ] {
            let strips = strips(&mesh, system);
            assert_eq!(strips.len(), n, "{name} {system:?}");
            let mut faces: Vec<usize> = strips.iter().flat_map(Strip::faces).collect();
            let all = faces.len();
            faces.sort_unstable();
            faces.dedup();
            assert_eq!(faces.len(), all, "a face belongs to one strip, once");
            for strip in &strips {
                let next = strip.crossed.iter().cycle().skip(1);
                assert!(strip.crossed.iter().zip(next).all(|(&h, n)| mesh.twin(h).unwrap() / 3 == n / 3));
            }
            assert_eq!(pieces(&mesh, &strips), n_pieces, "{name} {system:?}");
        }
    }
}

#[test]
fn foliations_are_closed_and_branch_where_the_index_theorem_says() {
    for (name, genus) in [("torus", 1), ("genus2", 2), ("genus5", 5)] {
        let mesh = sample(name, 4000);
        for system in [CurveSystem::Single, CurveSystem::Handles, CurveSystem::Pants] {
            let foliation = foliation(&mesh, system);
            assert_eq!(foliation.form.mismatch(&mesh, &foliation.signs), 0.0);
            assert!(foliation.form.curl().iter().all(|c| *c == 0.0));
            let branch = foliation.signs.branch_points(&mesh).len();
            assert_eq!(branch, 4 * genus - 4, "{name} {system:?}");
            let form = Solver::new(&mesh, &Stars::new(&mesh)).solve(&foliation).unwrap();
            let Indices { zeros, poles } = indices(&mesh, &foliation, &form);
            assert_eq!(zeros, poles + 4 * genus - 4, "{name} {system:?}");
        }
    }
}

#[test]
fn a_class_has_one_harmonic_form_and_dragging_leaves_the_class() {
    let mesh = sample("genus2", 3000);
    let stars = Stars::new(&mesh);
    let start = foliation(&mesh, CurveSystem::Handles);
    let mut solver = Solver::new(&mesh, &stars);
    let form = solver.solve(&start).unwrap();
    let branch = start.signs.branch_points(&mesh);
    // A branch point goes to a neighbour and comes back: leaves were dragged along, so nothing else has changed.
    let h = mesh.fan(branch[0]).find(|&h| !branch.contains(&mesh.target(h))).unwrap();
    let mut moved = start.clone();
    moved.drag(&mesh, h);
    assert_ne!(moved.signs.branch_points(&mesh), branch);
    let there = solver.solve(&moved).unwrap();
    assert!(largest_difference(&there, &form) > 1e-4, "the branch point is felt");
    moved.drag(&mesh, mesh.twin(h).unwrap());
    assert_eq!(moved.signs.branch_points(&mesh), branch);
    assert!(largest_difference(&solver.solve(&moved).unwrap(), &form) < 1e-9);
    // Isotopic curves: the form changed by the differential of any function that vanishes at branch points.
    let corner = start.signs.corners(&mesh);
    let function: Vec<f64> = (0..mesh.n_vertices() as u32)
        .map(|v| if branch.contains(&v) { 0.0 } else { f64::from(v % 17) - 8.0 })
        .collect();
    let mut other = start.clone();
    other.form.add(1.0, &OneForm::differential(&mesh, &corner, &function));
    assert_eq!(other.form.mismatch(&mesh, &other.signs), 0.0);
    assert!(largest_difference(&solver.solve(&other).unwrap(), &form) < 1e-6);
}

#[test]
fn every_branch_point_becomes_a_zero_and_there_is_no_pole() {
    for (name, genus) in [("genus2", 2), ("genus5", 5)] {
        let mesh = sample(name, 6000);
        let stars = Stars::new(&mesh);
        let start = foliation(&mesh, CurveSystem::Pants);
        let before = indices(&mesh, &start, &Solver::new(&mesh, &stars).solve(&start).unwrap());
        let found = harmonic_differential(&RunContext::silent(), &mesh, &stars, start).unwrap();
        let after = indices(&mesh, &found.foliation, &found.form);
        assert_eq!(after, Indices { zeros: 4 * genus - 4, poles: 0 }, "{name}, before: {before:?}");
        assert!(before.poles > 0, "{name}: the first guess is not the answer");
    }
}

#[test]
fn maps_are_seamless_upright_and_have_vertices_of_valence_six_only() {
    for (name, genus) in [("torus", 1), ("genus2", 2)] {
        let mesh = sample(name, 6000);
        let map = map(&mesh, CurveSystem::Pants, 2000.0);
        assert!(map.measures.seam_residual < 1e-9, "{name} {:?}", map.measures);
        assert_eq!(map.measures.flipped, 0, "{name}");
        assert!(map.grid.rotation.iter().all(|m| m % 2 == 0), "transitions are z to z or to -z");
        assert_eq!(map.singularities.len(), 4 * genus - 4, "{name}");
        assert!(map.singularities.iter().all(|s| s.quarters == -2), "{name}");
        assert!((map.measures.grid_area / 2000.0 - 1.0).abs() < 0.05, "{name} {}", map.measures.grid_area);
    }
}

#[test]
fn the_conformality_residual_falls_with_the_edges() {
    for (name, least) in [("torus", 1.8), ("genus2", 1.6)] {
        // The energy of the seamless map relative to that of its gradients is half the square of the residual.
        let residual = |triangles: usize| {
            let mesh = sample(name, triangles);
            let map = map(&mesh, CurveSystem::Pants, 1000.0);
            ((2.0 * map.curl_energy).sqrt(), mesh.n_faces() as f64)
        };
        let (coarse, fine) = (residual(3000), residual(12000));
        let halved = (coarse.0 / fine.0).powf(2.0 / (fine.1 / coarse.1).log2());
        assert!(halved > least, "{name} {coarse:?} {fine:?} {halved}");
    }
}

#[test]
fn no_signs_are_left_on_a_torus() {
    let mesh = sample("torus", 2000);
    let foliation = foliation(&mesh, CurveSystem::Single);
    assert_eq!(foliation.signs, Signs::trivial(&mesh));
}
