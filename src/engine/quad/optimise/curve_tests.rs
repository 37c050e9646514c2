//! Vertices on feature curves and boundaries.

use glam::DVec3;

use crate::engine::mesh::shapes::sample_surface;
use crate::engine::mesh::{Features, Surface, SurfaceIndex, TriMesh};
use crate::engine::quad::optimise::incidence::counted_edges;
use crate::engine::quad::optimise::shape::quality;
use crate::engine::quad::optimise::tests::{
    anchored, corners_of, cube_grid, grid, noise, off_segment, run, square, worst_of,
};
use crate::engine::quad::{Anchor, OptimiseOptions, QuadDraft, optimise};
use crate::engine::run::RunContext;

#[test]
fn curve_vertices_stay_on_their_edge_of_a_cube_in_order_and_corners_do_not_move() {
    let surface = sample_surface("cube", 2000).unwrap();
    let size = surface.mesh.diagonal() / 12f64.sqrt();
    let centre = surface.mesh.positions().iter().sum::<DVec3>() / surface.mesh.n_vertices() as f64;
    let m = 6;
    let draft = anchored(&surface, cube_grid(m, |p| centre + size * p));
    let count = |a: Anchor| draft.anchors.iter().filter(|&&b| b == a).count();
    assert_eq!((count(Anchor::Curve), draft.feature_edges.len()), (12 * (m - 1), 12 * m));
    let mut shaken = draft.clone();
    for (p, shift) in shaken.mesh.positions.iter_mut().zip(noise(1000)) {
        *p += 0.9 * size / m as f64 * shift;
    }
    let result = run(&surface, shaken, 2.0 * size / m as f64);
    for (v, anchor) in result.anchors.iter().enumerate() {
        let p = result.mesh.positions[v];
        match *anchor {
            Anchor::Corner(c) => assert_eq!(p, surface.mesh.position(c)),
            Anchor::Curve => {
                let edges = surface.features.edges.iter();
                assert!(edges.map(|&e| off_segment(&surface, e, p)).fold(f64::INFINITY, f64::min) < 1e-12);
            }
            Anchor::Surface => assert!(((p - centre) / size).abs().max_element() - 1.0 < 1e-12),
        }
    }
    // In order: every feature edge runs as it ran.
    for &[a, b] in &draft.feature_edges {
        let along = |d: &QuadDraft| d.mesh.positions[b as usize] - d.mesh.positions[a as usize];
        assert!(along(&draft).dot(along(&result)) > 0.0);
    }
    for q in 0..draft.mesh.quads.len() {
        let before = corners_of(&draft, q);
        let up = (before[1] - before[0]).cross(before[2] - before[0]).normalize();
        assert!(quality(&corners_of(&result, q), up) > 0.9);
    }
}

#[test]
fn a_closed_boundary_without_corners_slides_round_in_order() {
    // A disk as rings around a centre, and a quad grid over it whose four corners are no corners of the disk.
    let (rings, sectors) = (20, 80);
    let round = |r: usize, s: usize| {
        let (sin, cos) = (std::f64::consts::TAU * s as f64 / sectors as f64).sin_cos();
        DVec3::new(cos, sin, 0.0) * r as f64 / rings as f64
    };
    let at = |r: usize, s: usize| if r == 0 { 0 } else { (1 + (r - 1) * sectors + s % sectors) as u32 };
    let mut positions = vec![DVec3::ZERO];
    positions.extend((0..rings * sectors).map(|k| round(k / sectors + 1, k % sectors)));
    let mut faces = Vec::new();
    for (r, s) in (0..rings * sectors).map(|k| (k / sectors, k % sectors)) {
        faces.push([at(r, s), at(r + 1, s), at(r + 1, s + 1)]);
        if r > 0 {
            faces.push([at(r, s), at(r + 1, s + 1), at(r, s + 1)]);
        }
    }
    let surface = Surface { mesh: TriMesh::try_new(positions, faces).unwrap(), features: Features::default() };
    let mut draft = grid(&surface, 8);
    for p in &mut draft.mesh.positions {
        let q = 2.0 * *p - DVec3::new(1.0, 1.0, 0.0);
        let square = q.abs().max_element();
        *p = if square > 0.0 { q * square / q.length() } else { q };
    }
    let result = run(&surface, draft, 0.22);
    assert!(worst_of(&result, |_| DVec3::Z) > 0.2);
    for (p, anchor) in result.mesh.positions.iter().zip(&result.anchors) {
        let distances = (0..sectors)
            .map(|s| crate::engine::mesh::closest_on_segment(*p, round(rings, s), round(rings, s + 1)).1.distance(*p));
        assert!(*anchor != Anchor::Curve || distances.fold(f64::INFINITY, f64::min) < 1e-12);
    }
}

/// A bend of a boundary in the middle of a side gets a vertex.
#[test]
fn vertices_on_curves_go_where_the_curves_bend() {
    let flat = square(40);
    // One side has a roof over it whose ridge lies between two vertices of the even grid.
    let roof = |x: f64| (0.36 * (0.25 - (x - 0.55).abs())).max(0.0);
    let raised = flat.mesh.positions().iter().map(|p| DVec3::new(p.x, p.y + p.y * roof(p.x), 0.0)).collect();
    let surface = Surface {
        mesh: TriMesh::try_new(raised, flat.mesh.faces().to_vec()).unwrap(),
        features: flat.features.clone(),
    };
    let options = |iterations| OptimiseOptions {
        iterations,
        edge_length: 0.1,
        log_size: Vec::new(),
        strokes: Vec::new(),
        held: Vec::new(),
    };
    let index = SurfaceIndex::new(&surface.mesh);
    let missed = |iterations: usize| {
        let draft = grid(&surface, 10);
        let done = optimise(&RunContext::silent(), &surface, &index, draft, &options(iterations)).unwrap().mesh;
        let sides = counted_edges(&done.quads).into_iter().filter(|e| e.1 == 1).map(|e| e.0);
        let sides: Vec<_> = sides.map(|e| e.map(|v| done.positions[v as usize])).collect();
        let ridge = DVec3::new(0.55, 1.0 + roof(0.55), 0.0);
        let off = |&[a, b]: &[DVec3; 2]| crate::engine::mesh::closest_on_segment(ridge, a, b).1.distance(ridge);
        assert!(done.quads.iter().all(|q| quality(&q.map(|v| done.positions[v as usize]), DVec3::Z) > 0.5));
        sides.iter().map(off).fold(f64::INFINITY, f64::min)
    };
    let (even, fitted) = (missed(0), missed(20));
    assert!(even > 0.015 && fitted < 0.3 * even, "{even} {fitted}");
}
