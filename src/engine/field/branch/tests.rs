use crate::engine::field::branch::curl::Curl;
use crate::engine::field::branch::{BranchOptions, curl_energy};
use crate::engine::field::cross_field::{CrossField, residual};
use crate::engine::field::frames::Frames;
use crate::engine::field::turning::Turning;
use crate::engine::field::{FieldOptions, smooth_cross_field};
use crate::engine::mesh::shapes::sample_surface;
use crate::engine::mesh::{Surface, TriMesh};
use crate::engine::run::RunContext;

fn field_on(name: &str, triangles: usize) -> (Surface, Frames, CrossField, Vec<bool>, f64) {
    let surface = sample_surface(name, triangles).unwrap();
    let frames = Frames::new(&surface.mesh);
    let flags = surface.features.halfedge_flags(&surface.mesh);
    let edge_length = (surface.mesh.total_area() / (triangles as f64 / 10.0)).sqrt();
    let options = FieldOptions { edge_length, smoothing: 1.0, branch_points: None, strokes: None, start: None };
    let (field, _) = smooth_cross_field(&RunContext::silent(), &surface.mesh, &frames, &flags, None, &options).unwrap();
    (surface, frames, field, flags, edge_length)
}

fn free_turning(surface: &Surface) -> Turning {
    let n = surface.mesh.n_faces();
    Turning::new(&surface.mesh, &Frames::new(&surface.mesh), &vec![false; n], &vec![0.0; n]).unwrap()
}

#[test]
fn the_derivative_finds_the_better_turn() {
    // Matchings are whole quarters, so a difference quotient would need matchings that are none; what is asked of the
    // derivative is that it finds the better of the two turns where it is large.
    let (surface, frames, field, _, _) = field_on("ellipsoid", 600);
    let (mesh, curl, turning) = (&surface.mesh, Curl::new(&surface.mesh, &frames, &[]), free_turning(&surface));
    let at = |field: &CrossField| curl.energy(mesh, &frames, field, None).unwrap();
    let rest = field.angle.clone();
    let mut field = field;
    turning.relax(mesh, &frames, &mut field, &rest);
    let energy = at(&field);
    let derivative = curl.derivative(mesh, &energy, &turning);
    let mut order: Vec<usize> = (0..derivative.len()).collect();
    order.sort_by(|&a, &b| derivative[b].abs().total_cmp(&derivative[a].abs()));
    let mut right = 0;
    for &e in &order[..20] {
        let change = [1u8, 3].map(|k| {
            let mut turned = field.clone();
            turned.matching.turn(mesh, curl.sides.owner[e], k);
            turning.relax(mesh, &frames, &mut turned, &rest);
            at(&turned).value - energy.value
        });
        right += usize::from((change[0] < change[1]) == (derivative[e] < 0.0));
    }
    assert!(right >= 19, "{right} of 20");
}

/// With crosses at features held.
fn bound_turning(surface: &Surface, flags: &[bool]) -> Turning {
    let is_fixed: Vec<bool> = flags.chunks_exact(3).map(|sides| sides.contains(&true)).collect();
    let alignment = vec![0.0; surface.mesh.n_faces()];
    Turning::new(&surface.mesh, &Frames::new(&surface.mesh), &is_fixed, &alignment).unwrap()
}

#[test]
fn the_derivative_is_the_difference_quotient() {
    difference_quotient(usize::MAX);
    // Single bound edges: rings of them would leave constants without energy, and the energy a jump beside whole turns.
    difference_quotient(40);
}

/// On an ellipsoid of which every so many-th edge is bound.
fn difference_quotient(bound: usize) {
    let (surface, frames, mut field, mut flags, _) = field_on("ellipsoid", 600);
    for h in (0..flags.len()).step_by(bound).skip(1) {
        flags[h] = true;
        flags[surface.mesh.twin(h).unwrap()] = true;
    }
    let (mesh, curl) = (&surface.mesh, Curl::new(&surface.mesh, &frames, &flags));
    let turning = bound_turning(&surface, &flags);
    let rest = field.angle.clone();
    // Until no residual changes its branch: the crosses are a linear function of the matching only from there.
    for _ in 0..10 {
        turning.relax(mesh, &frames, &mut field, &rest);
    }
    let energy = curl.energy(mesh, &frames, &field, None).unwrap();
    let derivative = curl.derivative(mesh, &energy, &turning);
    let largest = derivative.iter().fold(0.0_f64, |a, d| a.max(d.abs()));
    let turns = curl.turns(&field);
    // Crosses depend linearly on a matching as long as no residual passes half a turn.
    let turns_little = |&e: &usize| {
        let h = curl.sides.owner[e];
        !flags[h] && residual(mesh, &frames, &field.angle, &field.matching, h).abs() < 1.5
    };
    for e in (0..derivative.len()).filter(turns_little).step_by(37) {
        // The crosses depend linearly on the matching: a part of a quarter turns them by a part of what a quarter does.
        let mut turned = field.clone();
        turned.matching.turn(mesh, curl.sides.owner[e], 1);
        turning.relax(mesh, &frames, &mut turned, &rest);
        let at = |quarters: f64| {
            let mut between = field.clone();
            let parts = between.angle.iter_mut().zip(&turned.angle);
            parts.for_each(|(angle, end)| *angle += quarters * (end - *angle));
            let mut turns = turns.clone();
            let turn = quarters * std::f64::consts::FRAC_PI_2;
            turns[e] *= faer::c64::new(turn.cos(), turn.sin());
            curl.energy_with(mesh, &frames, &between, &turns, None).unwrap().value
        };
        let quotient = (at(1e-4) - at(-1e-4)) / 2e-4;
        assert!((quotient - derivative[e]).abs() < 1e-5 * largest, "edge {e}, {bound}: {quotient} {}", derivative[e]);
    }
}

#[test]
fn real_unknowns_without_a_bound_edge_are_the_complex_ones() {
    let (surface, frames, field, _, _) = field_on("half_pipe", 800);
    let mesh = &surface.mesh;
    let free = curl_energy(mesh, &frames, &field, &[]).unwrap();
    // A flag on a face's side that is no edge's owner binds nothing.
    let mut flags = vec![false; mesh.n_halfedges()];
    let twin = (0..mesh.n_halfedges()).find(|&h| !mesh.is_edge_owner(h)).unwrap();
    flags[twin] = true;
    let real = curl_energy(mesh, &frames, &field, &flags).unwrap();
    assert!((real - free).abs() < 1e-9 * free.max(1e-6), "{real} {free}");
}

#[test]
fn binding_edges_takes_freedom_from_the_map() {
    let (surface, frames, field, flags, _) = field_on("gear", 2000);
    let [free, bound] = [&[][..], &flags].map(|flags| curl_energy(&surface.mesh, &frames, &field, flags).unwrap());
    assert!(bound > free && bound < 1.0, "{bound} {free}");
}

#[test]
fn the_curl_energy_does_not_change_with_charts() {
    let (surface, frames, field, _, _) = field_on("genus2", 1200);
    let mesh = &surface.mesh;
    // Matched by the nearest turn, as the other one below.
    let field = CrossField::from_angles(mesh, &frames, field.angle);
    let value = Curl::new(mesh, &frames, &[]).energy(mesh, &frames, &field, None).unwrap().value;
    assert!(value > 1e-4 && value < 0.2, "{value}");
    // Other representatives of the same crosses.
    let turned: Vec<f64> =
        field.angle.iter().enumerate().map(|(f, a)| a + (f % 4) as f64 * std::f64::consts::FRAC_PI_2).collect();
    let other = CrossField::from_angles(mesh, &frames, turned);
    assert_eq!(other.quarter_index, field.quarter_index);
    let again = Curl::new(mesh, &frames, &[]).energy(mesh, &frames, &other, None).unwrap().value;
    assert!((again - value).abs() < 1e-9 * value, "{again} {value}");
}

/// A scaled and rotated copy has the same energy.
#[test]
fn the_curl_energy_does_not_change_with_scale_or_rotation() {
    let (surface, frames, field, _, _) = field_on("genus2", 1200);
    let value = curl_energy(&surface.mesh, &frames, &field, &[]).unwrap();
    let turn = glam::DQuat::from_euler(glam::EulerRot::XYZ, 0.3, 1.1, -0.7);
    let positions = surface.mesh.positions().iter().map(|p| turn * (*p * 1e-3)).collect();
    let moved = TriMesh::try_new(positions, surface.mesh.faces().to_vec()).unwrap();
    let again = curl_energy(&moved, &Frames::new(&moved), &field, &[]).unwrap();
    assert!((again - value).abs() < 1e-7 * value, "{again} {value}");
}

/// So has one whose faces and vertices are numbered otherwise: crosses are carried over by their directions in space.
#[test]
fn the_curl_energy_does_not_change_with_numbering() {
    let (surface, frames, field, _, _) = field_on("genus2", 1200);
    let mesh = &surface.mesh;
    let field = CrossField::from_angles(mesh, &frames, field.angle);
    let value = curl_energy(mesh, &frames, &field, &[]).unwrap();
    let (n, m) = (mesh.n_faces(), mesh.n_vertices() as u32);
    let face = |f: usize| n - 1 - f;
    let faces = (0..n).map(|f| {
        let [a, b, c] = mesh.face(face(f)).map(|v| m - 1 - v);
        [b, c, a]
    });
    let positions = mesh.positions().iter().rev().copied().collect();
    let other = TriMesh::try_new(positions, faces.collect()).unwrap();
    let other_frames = Frames::new(&other);
    let angle = (0..n).map(|f| {
        let a = field.angle[face(f)];
        let direction = frames.x[face(f)] * a.cos() + frames.y[face(f)] * a.sin();
        direction.dot(other_frames.y[f]).atan2(direction.dot(other_frames.x[f]))
    });
    let carried = CrossField::from_angles(&other, &other_frames, angle.collect());
    let again = curl_energy(&other, &other_frames, &carried, &[]).unwrap();
    assert!((again - value).abs() < 1e-7 * value, "{again} {value}");
}

#[test]
fn every_search_lowers_its_cost_and_keeps_the_sum_of_indices() {
    for (name, create) in [("genus2", false), ("genus2", true), ("gear", false), ("noisy_blob", true)] {
        let (surface, frames, before, flags, edge_length) = field_on(name, 3000);
        let mesh = &surface.mesh;
        let branch_points = Some(BranchOptions { create, price: BranchOptions::PRICE });
        let options = FieldOptions { edge_length, smoothing: 1.0, branch_points, strokes: None, start: None };
        let (after, found) = smooth_cross_field(&RunContext::silent(), mesh, &frames, &flags, None, &options).unwrap();
        assert!(found.energy[1] <= found.energy[0] && found.accepted < found.evaluations, "{name}: {found:?}");
        assert!(create || found.points[1] <= found.points[0], "{name}: {found:?}");
        let sum = |field: &CrossField| field.quarter_index.iter().sum::<i32>();
        assert_eq!(sum(&after), sum(&before), "{name}");
        let value = curl_energy(mesh, &frames, &after, &flags).unwrap();
        assert!((value - found.energy[1]).abs() < 1e-9, "{name}: {value} {found:?}");
        if name == "genus2" {
            assert!(found.energy[1] < 0.9 * found.energy[0], "{found:?}");
        }
    }
}
