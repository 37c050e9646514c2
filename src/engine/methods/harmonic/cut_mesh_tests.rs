//! Cutting keeps the surface, its topology and the transitions of its charts.

use glam::DVec2;

use crate::engine::mesh::shapes::sample_surface;
use crate::engine::mesh::{NONE, next};
use crate::engine::methods::harmonic::charts::SeamlessMap;
use crate::engine::methods::harmonic::cut_mesh::CutMesh;
use crate::engine::methods::harmonic::regions::Regions;
use crate::engine::numerics::Random;
use crate::engine::parameterize::{Iso, rotate};

#[test]
fn any_splits_leave_the_same_surface_and_the_same_transitions() {
    let surface = sample_surface("genus2", 1500).unwrap();
    let mesh = &surface.mesh;
    let n = mesh.n_halfedges();
    let mut random = Random::new(11);
    // A chart of its own for every face: values of the plane in which a projection of it lies, turned and moved.
    let turns: Vec<(u8, DVec2)> =
        (0..mesh.n_faces()).map(|_| (random.below(4) as u8, 9.0 * DVec2::new(random.unit(), random.unit()))).collect();
    let seen = |h: usize| {
        let (quarters, by) = turns[h / 3];
        rotate(mesh.position(mesh.origin(h)).truncate(), quarters) + by
    };
    let uv: Vec<DVec2> = (0..n).map(seen).collect();
    let mut map = SeamlessMap { uv, rotation: vec![0; n], translation: vec![DVec2::ZERO; n], iso: vec![Iso::None; n] };
    for h in 0..n {
        let Some(t) = mesh.twin(h) else { continue };
        map.rotation[h] = (turns[h / 3].0 + 4 - turns[t / 3].0) & 3;
        map.translation[h] = map.uv[h] - rotate(map.uv[next(t)], map.rotation[h]);
    }
    let mut cut = CutMesh::new(&surface, Some(map));
    for _ in 0..3000 {
        match random.below(3) {
            0 => {
                let f = random.below(cut.n_faces());
                let z = (0..3).map(|k| cut.map.uv[3 * f + k]).sum::<DVec2>() / 3.0;
                cut.split_face(f, [1.0 / 3.0; 3], z);
            }
            1 => {
                let h = random.below(3 * cut.n_faces());
                let z = cut.map.uv[h].lerp(cut.map.uv[next(h)], 0.4);
                cut.split_edge(h, 0.4, z);
            }
            _ => cut.turn_chart(random.below(cut.n_faces()), random.below(4) as u8, DVec2::new(random.unit(), 2.0)),
        }
    }
    for h in 0..3 * cut.n_faces() {
        let t = cut.twin(h).unwrap();
        assert_eq!((cut.twin(t), cut.origin(h)), (Some(h), cut.origin(next(t))));
        assert!((cut.map.to_twin(h, cut.map.uv[h]) - cut.map.uv[next(t)]).length() < 1e-9);
        assert!((cut.map.to_twin(h, cut.map.uv[next(h)]) - cut.map.uv[t]).length() < 1e-9);
    }
    for v in 0..cut.n_vertices() as u32 {
        assert!(cut.fan(v).into_iter().all(|h| cut.origin(h) == v));
    }
    let regions = Regions::new(&cut);
    assert_eq!((regions.n(), regions.first_open()), (1, Some(0)), "without curves all is one part, and no disc");
    let (fine, ..) = cut.finish().unwrap();
    assert_eq!(fine.mesh.topology(), mesh.topology());
    assert!((fine.mesh.total_area() / mesh.total_area() - 1.0).abs() < 1e-9);
}

#[test]
fn a_closed_curve_cuts_a_sphere_into_two_discs_and_a_point_into_none() {
    let surface = sample_surface("sphere", 800).unwrap();
    let mut cut = CutMesh::new(&surface, None);
    assert_eq!(cut.line.iter().filter(|&&line| line != NONE).count(), 0);
    // Around a vertex.
    let ring: Vec<usize> = cut.fan(0).into_iter().map(next).collect();
    ring.into_iter().for_each(|h| cut.mark(h, 0));
    let regions = Regions::new(&cut);
    assert_eq!((regions.n(), regions.first_open()), (2, None));
    // One edge more to the middle is a slit, and leaves a disc; one edge less opens the ring.
    let spoke = cut.fan(0)[0];
    cut.mark(spoke, 1);
    assert_eq!(Regions::new(&cut).first_open(), None);
    let side = next(spoke);
    cut.mark(side, NONE);
    assert_eq!((Regions::new(&cut).n(), Regions::new(&cut).first_open()), (1, None));
}
