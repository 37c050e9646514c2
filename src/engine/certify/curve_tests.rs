//! Corners, feature curves and boundaries that the quads have or miss.

use crate::engine::certify::Check;
use crate::engine::certify::tests::{certificate, join, rejects, split, surface};
use crate::engine::mesh::{Features, Surface, TriMesh};
use crate::engine::quad::QuadMesh;
use glam::{DMat3, DVec3, dvec3};

#[test]
fn closed_curves_are_judged_alike_in_every_numbering() {
    let sphere = surface("sphere", 700).mesh;
    let faces = (0..sphere.n_faces()).filter(|&f| sphere.triangle(f).iter().all(|p| p.z < 0.4));
    let faces: Vec<[u32; 3]> = faces.map(|f| sphere.face(f)).collect();
    let bowl = |turned: usize| {
        let mut faces = faces.clone();
        faces.rotate_left(turned);
        let mut number = std::collections::BTreeMap::new();
        let mut positions = Vec::new();
        let faces = faces.iter().map(|face| {
            face.map(|v| {
                *number.entry(v).or_insert_with(|| {
                    positions.push(sphere.position(v));
                    positions.len() as u32 - 1
                })
            })
        });
        let faces = faces.collect();
        Surface { mesh: TriMesh::try_new(positions, faces).unwrap(), features: Features::default() }
    };
    let mut quads = split(&bowl(0).mesh);
    quads.positions.iter_mut().for_each(|p| *p += 0.03 * dvec3(p.y, p.z, p.x));
    let error = |turned: usize| certificate(&bowl(turned), &quads).measures.feature_error_mean;
    assert!(error(0) > 1e-3);
    for turned in [1, 50, 333] {
        assert!((error(turned) - error(0)).abs() < 1e-12, "{turned}: {} and {}", error(turned), error(0));
    }
}

#[test]
fn lost_features_and_corners_are_rejected() {
    let plate = surface("plate_with_holes", 2500);
    let good = split(&plate.mesh);
    let corner = plate.features.corners[0];
    let moved = |v: u32, by: DVec3| {
        let mut quads = good.clone();
        quads.positions[v as usize] += by;
        quads
    };
    rejects(&plate, &moved(corner, DVec3::splat(1e-4)), &[Check::Corner]);
    let shifted = QuadMesh { positions: good.positions.iter().map(|p| *p + DVec3::Y * 0.01).collect(), ..good.clone() };
    rejects(&plate, &shifted, &[Check::Corner]);
    // A part of the boundary curve of a hole leaves it within the plane.
    let at_hole = plate
        .features
        .edges
        .iter()
        .flatten()
        .copied()
        .find(|&v| {
            let p = plate.mesh.position(v);
            (p.truncate() - glam::dvec2(0.0, 0.5)).length() < 0.29
        })
        .unwrap();
    let outwards = (plate.mesh.position(at_hole) - dvec3(0.0, 0.5, 0.12)) * dvec3(1.0, 1.0, 0.0);
    let length = plate
        .mesh
        .fan(at_hole)
        .map(|h| plate.mesh.position(plate.mesh.target(h)).distance(plate.mesh.position(at_hole)));
    let length = length.fold(f64::INFINITY, f64::min);
    let push = |p: &DVec3| {
        let near = p.distance(plate.mesh.position(at_hole)) < 3.0 * length;
        if near { *p + outwards.normalize() * (0.9 * length) } else { *p }
    };
    let pushed = QuadMesh { positions: good.positions.iter().map(push).collect(), ..good.clone() };
    rejects(&plate, &pushed, &[Check::FeatureCurve]);
    // The right body turned under its edges, and a round body over sharp edges.
    let cube = surface("cube", 1200);
    let straight = split(&cube.mesh);
    let turn = DMat3::from_rotation_z(0.3);
    let turned = QuadMesh { positions: straight.positions.iter().map(|p| turn * *p).collect(), ..straight.clone() };
    rejects(&cube, &turned, &[Check::Corner, Check::FeatureCurve]);
    let round = QuadMesh { positions: straight.positions.iter().map(|p| p.normalize() * 0.6).collect(), ..straight };
    rejects(&cube, &round, &[Check::Corner, Check::FeatureCurve]);
    // A feature across the grain: the diagonal of a side is no chain of edges of a grid along the sides.
    let grid = |n: u32| {
        let at = |i: u32, j: u32| j * (n + 1) + i;
        let positions = (0..(n + 1) * (n + 1))
            .map(|v| dvec3(f64::from(v % (n + 1)), f64::from(v / (n + 1)), 0.0) / f64::from(n))
            .collect();
        let cells = (0..n * n).map(|c| (c % n, c / n));
        let quads = cells.map(|(i, j)| [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]).collect();
        QuadMesh { positions, quads }
    };
    let p = vec![DVec3::ZERO, DVec3::X, dvec3(1.0, 1.0, 0.0), DVec3::Y];
    let mesh = TriMesh::try_new(p, vec![[0, 1, 2], [0, 2, 3]]).unwrap();
    let mut square = Surface { mesh, features: Features { edges: Vec::new(), corners: vec![0, 1, 2, 3] } };
    assert_eq!(certificate(&square, &grid(8)).violations, []);
    square.features.edges.push([0, 2]);
    rejects(&square, &grid(8), &[Check::FeatureCurve]);
    rejects(&square, &grid(9), &[Check::FeatureCurve]);
    assert!(certificate(&square, &split(&square.mesh)).certified);
}

#[test]
fn boundaries_out_of_place_are_rejected() {
    let pipe = surface("half_pipe", 800);
    let good = split(&pipe.mesh);
    let boundary = pipe.mesh.boundary_loops();
    let mut dented = good.clone();
    for &h in &boundary[0][20..26] {
        let p = &mut dented.positions[pipe.mesh.origin(h) as usize];
        *p = p.lerp(dvec3(0.0, 0.0, -1.0), 0.15);
    }
    rejects(&pipe, &dented, &[Check::BoundaryCurve]);
    let short = QuadMesh { positions: good.positions.iter().map(|p| *p * dvec3(1.0, 0.9, 1.0)).collect(), ..good };
    rejects(&pipe, &short, &[Check::BoundaryCurve, Check::BoundaryLoop, Check::Corner]);
    // Two pipes, one of which has both boundaries: numbers agree, places do not.
    let two = join(&pipe, &pipe, DVec3::X * 5.0);
    let stacked = join(&pipe, &pipe, DVec3::Z * 1e-3);
    rejects(&two, &split(&stacked.mesh), &[Check::ComponentMatch]);
}
