//! Maps with triangles flipped: still a pure quad manifold of the same topology.

use glam::DVec2;

use crate::engine::mesh::prev;
use crate::engine::numerics::Random;
use crate::engine::parameterize::Iso;
use crate::engine::parameterize::rotate;
use crate::engine::quad::Anchor;
use crate::engine::quad::extract::Extraction;
use crate::engine::quad::extract::tests::clean::POLYCUBES;
use crate::engine::quad::extract::tests::clean::extract;
use crate::engine::quad::extract::tests::maps::Model;
use crate::engine::quad::extract::tests::maps::Sheet;
use crate::engine::quad::extract::tests::maps::polycube;
use crate::engine::quad::fill::manifold::quad_numbers;

/// Extracts and checks everything that must hold whatever the map does.
fn sound(model: &Model) -> Extraction {
    let done = extract(model);
    let numbers = quad_numbers(&done.draft);
    let topology = model.mesh.topology();
    assert_eq!((numbers.euler, numbers.boundaries, numbers.components), (topology.euler, topology.boundaries, 1));
    let mut corners = model.features.corners.clone();
    corners.retain(|&v| !done.draft.anchors.contains(&Anchor::Corner(v)));
    assert_eq!(corners, [0u32; 0], "corners are lost");
    done
}

/// Moves the values of `share` of the free vertices by up to `by` grid units.
fn fold(model: &mut Model, share: f64, by: f64, seed: u64) {
    let mut dice = Random::new(seed);
    for v in 0..model.mesh.n_vertices() as u32 {
        let (hit, shift) = (dice.signed().abs() < share, DVec2::new(dice.signed(), dice.signed()) * by);
        if hit && model.is_free(v) {
            model.shift(v, shift);
        }
    }
}

/// Moves the values of vertices of curves along their curve.
fn fold_curves(model: &mut Model, share: f64, by: f64, seed: u64) {
    let mut dice = Random::new(seed);
    for v in 0..model.mesh.n_vertices() as u32 {
        let (hit, shift) = (dice.signed().abs() < share, dice.signed() * by);
        if !hit || model.singular(v) || model.features.is_corner(v) {
            continue;
        }
        let h = model.mesh.outgoing(v);
        let iso = [model.map.iso[h], model.map.iso[prev(h)]].into_iter().find(|&i| i != Iso::None);
        if let (true, Some(iso)) = (model.mesh.is_boundary_vertex(v), iso) {
            model.shift(v, if iso == Iso::U { DVec2::Y } else { DVec2::X } * shift);
        }
    }
}

/// A smooth bump that pushes the values of all free vertices near vertex `v`, so that a long thin fold arises.
fn push(model: &mut Model, v: u32, radius: f64, by: DVec2) {
    let centre = model.mesh.position(v);
    for w in 0..model.mesh.n_vertices() as u32 {
        let far = (model.mesh.position(w) - centre).length() / radius;
        if far < 1.0 && model.is_free(w) {
            model.shift(w, by * (1.0 - far * far));
        }
    }
}

#[test]
fn small_folds_leave_no_trace() {
    // Moves below half a grid unit fold many triangles of a fine mesh, but no quad is lost.
    let mut flipped = 0;
    for seed in 1..20 {
        let mut model = Sheet { size: [6, 5], cells: [24, 20], ..Sheet::plane(1, 1) }.build();
        fold(&mut model, 0.1, 0.3, seed);
        let done = sound(&model);
        assert!(done.report.fill.is_clean(), "{:?}", done.report);
        assert_eq!(done.draft.mesh.quads.len(), 30);
        flipped += done.report.flipped_triangles;
    }
    assert!(flipped > 200);
}

#[test]
fn folds_over_several_quads_are_undone() {
    for seed in 1..20u32 {
        let mut model = Sheet { size: [12, 10], cells: [24, 20], seed: u64::from(seed), ..Sheet::plane(1, 1) }.build();
        let v = 10 * 25 + 6 + seed % 12;
        push(&mut model, v, 3.0, rotate(DVec2::new(4.0, 1.5), (seed % 4) as u8));
        let done = sound(&model);
        assert!(done.report.flipped_triangles > 0 && done.report.fill.joined_points > 0);
        assert_eq!(done.draft.mesh.quads.len(), 120, "{:?}", done.report);
    }
}

#[test]
fn wild_folds_are_undone_too() {
    // Moves of up to four grid units, three of a hundred triangles flipped: nearly always no trace is left.
    let (mut runs, mut clean, mut flipped) = (0, 0, 0);
    for seed in 1..12 {
        for (cubes, squares, _) in POLYCUBES {
            let mut model = polycube(cubes, 3, 6, false, seed);
            fold(&mut model, 0.02, 4.0, seed);
            let done = sound(&model);
            runs += 1;
            if done.report.fill.is_clean() {
                assert_eq!(done.draft.mesh.quads.len(), 9 * squares);
                clean += 1;
            }
            flipped += done.report.flipped_triangles;
        }
    }
    assert!(clean * 10 >= runs * 9 && flipped > 1000, "{clean} of {runs}");
}

#[test]
fn random_folds_on_all_surfaces() {
    for (share, by) in [(0.05, 1.0), (0.3, 0.7), (0.1, 4.0), (1.0, 0.5)] {
        for seed in 1..12 {
            for (cubes, ..) in POLYCUBES {
                for sharp in [false, true] {
                    let mut model = polycube(cubes, 3, 6, sharp, seed);
                    fold(&mut model, share, by, seed);
                    sound(&model);
                }
            }
            for closed in [[false, false], [true, false], [true, true]] {
                let cells = [30, 20];
                let mut model = Sheet { closed, size: [9, 7], cells, seed, ..Sheet::plane(1, 1) }.build();
                fold(&mut model, share, by, seed);
                fold_curves(&mut model, share, by, seed);
                sound(&model);
            }
        }
    }
}
