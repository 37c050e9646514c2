//! Maps without folds: all numbers are known.

use glam::I64Vec2;

use crate::engine::quad::Anchor;
use crate::engine::quad::extract::Extraction;
use crate::engine::quad::extract::extract_quads;
use crate::engine::quad::extract::tests::maps::Model;
use crate::engine::quad::extract::tests::maps::Sheet;
use crate::engine::quad::extract::tests::maps::polycube;
use crate::engine::quad::fill::manifold::QuadNumbers;
use crate::engine::quad::fill::manifold::quad_numbers;
use crate::engine::run::RunContext;

pub(super) fn extract(model: &Model) -> Extraction {
    extract_quads(&RunContext::silent(), &model.mesh, &model.features, &model.map).unwrap()
}

fn clean(model: &Model) -> (QuadNumbers, Extraction) {
    let done = extract(model);
    assert!(done.report.fill.is_clean(), "{:?}", done.report);
    assert_eq!((done.report.flipped_triangles, done.report.fill.joined_points), (0, 0));
    (quad_numbers(&done.draft), done)
}

#[test]
fn a_rectangle_has_its_quads() {
    for (w, h) in [(1, 1), (3, 2), (7, 5), (20, 11)] {
        for seed in 1..4 {
            let model = Sheet { seed, ..Sheet::plane(w, h) }.build();
            let (numbers, done) = clean(&model);
            assert_eq!((numbers.quads as i64, numbers.boundary_edges as i64), (w * h, 2 * (w + h)));
            let corners = done.draft.anchors.iter().filter(|a| matches!(a, Anchor::Corner(_))).count();
            let curve = done.draft.anchors.iter().filter(|a| **a == Anchor::Curve).count();
            assert_eq!((corners, curve as i64), (4, 2 * (w + h) - 4));
            // Positions are the grid points themselves.
            for p in &done.draft.mesh.positions {
                assert!((*p - p.round()).length() < 1e-6);
            }
            for (a, p) in done.draft.anchors.iter().zip(&done.draft.mesh.positions) {
                if let Anchor::Corner(v) = *a {
                    assert_eq!(*p, model.mesh.position(v));
                }
            }
        }
    }
}

#[test]
fn grid_lines_through_vertices_and_along_edges() {
    // Without jitter and with commensurable cells, most mesh vertices and edges lie on grid lines.
    for (cells, size) in [([6, 4], [6, 4]), ([6, 4], [12, 8]), ([12, 8], [6, 4]), ([3, 3], [9, 6]), ([2, 1], [40, 30])]
    {
        let model = Sheet { cells, size, jitter: 0.0, ..Sheet::plane(1, 1) }.build();
        let (numbers, _) = clean(&model);
        assert_eq!((numbers.quads as i64, numbers.euler), (size[0] * size[1], 1));
    }
}

#[test]
fn far_from_the_origin() {
    for offset in [I64Vec2::new(1 << 20, -(1 << 20)), I64Vec2::new(-7, 1 << 15)] {
        let (numbers, _) = clean(&Sheet { offset, ..Sheet::plane(9, 4) }.build());
        assert_eq!(numbers.quads, 36);
        let exact = Sheet { offset, jitter: 0.0, cells: [9, 4], ..Sheet::plane(9, 4) };
        assert_eq!(clean(&exact.build()).0.quads, 36);
    }
}

#[test]
fn tubes_and_tori() {
    for jitter in [0.0, 0.3] {
        for cells in [[10, 6], [7, 5], [5, 9]] {
            let tube = Sheet { closed: [true, false], cells, jitter, size: [10, 6], ..Sheet::plane(1, 1) }.build();
            let (n, _) = clean(&tube);
            assert_eq!((n.quads, n.euler, n.boundaries, n.boundary_edges), (60, 0, 2, 20));
            let torus = Sheet { closed: [true, true], cells, jitter, size: [10, 6], ..Sheet::plane(1, 1) }.build();
            let (n, _) = clean(&torus);
            assert_eq!((n.quads, n.euler, n.boundaries), (60, 0, 0));
        }
    }
}

#[test]
fn a_feature_becomes_a_chain_of_edges() {
    let mut sheet = Sheet { size: [8, 5], cells: [8, 7], feature: Some(3), ..Sheet::plane(1, 1) };
    for closed in [[false, false], [true, false], [true, true]] {
        sheet.closed = closed;
        let (n, done) = clean(&sheet.build());
        assert_eq!((n.quads, done.draft.feature_edges.len(), done.report.features_off_grid), (40, 5, 0));
        for e in &done.draft.feature_edges {
            assert!(e.iter().all(|&v| done.draft.anchors[v as usize] != Anchor::Surface));
        }
    }
}

const CUBE: &[[i32; 3]] = &[[0, 0, 0]];
const ELL: &[[i32; 3]] = &[[0, 0, 0], [1, 0, 0], [0, 1, 0]];
const TRIPOD: &[[i32; 3]] = &[[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]];
const RING: &[[i32; 3]] = &[[0, 0, 0], [1, 0, 0], [2, 0, 0], [0, 1, 0], [2, 1, 0], [0, 2, 0], [1, 2, 0], [2, 2, 0]];

pub(super) const POLYCUBES: [(&[[i32; 3]], usize, i64); 4] =
    [(CUBE, 6, 2), (ELL, 14, 2), (TRIPOD, 18, 2), (RING, 32, 0)];

#[test]
fn polycubes_have_cones_of_all_kinds() {
    for (cubes, squares, euler) in POLYCUBES {
        for (n, m) in [(1, 4), (2, 3), (3, 3), (5, 4), (4, 8)] {
            for sharp in [false, true] {
                let model = polycube(cubes, n, m, sharp, 7);
                let (numbers, done) = clean(&model);
                assert_eq!(numbers.quads as i64, squares as i64 * n * n);
                assert_eq!((numbers.euler, numbers.components), (euler, 1));
                let mut corners: Vec<u32> = Vec::new();
                corners.extend(done.draft.anchors.iter().filter_map(|a| match a {
                    Anchor::Corner(v) => Some(*v),
                    _ => None,
                }));
                corners.sort_unstable();
                assert_eq!(corners, model.features.corners);
                if sharp {
                    assert_eq!(
                        done.draft.feature_edges.len() as i64,
                        model.features.edges.len() as i64 * n / i64::from(m)
                    );
                }
            }
        }
    }
}

#[test]
fn the_same_map_gives_the_same_bytes() {
    let model = polycube(RING, 3, 4, true, 3);
    assert_eq!(extract(&model).draft, extract(&model).draft);
}
