//! Lists of quads that are no surface, or not the one that was given.

use crate::engine::certify::Check;
use crate::engine::certify::tests::{certificate, join, rejects, split, surface};
use crate::engine::mesh::{Features, Surface, TriMesh};
use crate::engine::quad::QuadMesh;
use glam::{DVec3, dvec3};

#[test]
fn broken_lists_of_quads_are_rejected() {
    let torus = surface("torus", 1500);
    let good = split(&torus.mesh);
    let change = |f: &dyn Fn(&mut QuadMesh)| {
        let mut quads = good.clone();
        f(&mut quads);
        quads
    };
    let n = good.positions.len() as u32;
    rejects(&torus, &change(&|q| q.quads[5][2] = n), &[Check::FourVertices]);
    rejects(&torus, &change(&|q| q.quads[5][2] = q.quads[5][0]), &[Check::FourVertices]);
    rejects(&torus, &change(&|q| q.quads.push(q.quads[9])), &[Check::DuplicateQuad]);
    rejects(
        &torus,
        &change(&|q| {
            let [a, b, c, d] = q.quads[9];
            q.quads.push([d, c, b, a]);
        }),
        &[Check::DuplicateQuad],
    );
    rejects(&torus, &change(&|q| q.positions.push(DVec3::ZERO)), &[Check::UnusedVertex]);
    rejects(&torus, &change(&|q| q.positions[3].y = f64::NAN), &[Check::Finite]);
    rejects(&torus, &change(&|q| q.positions[3].y = f64::INFINITY), &[Check::Finite]);
    rejects(&torus, &change(&|q| q.quads[7].reverse()), &[Check::EdgeOrientation]);
    rejects(
        &torus,
        &change(&|q| {
            let [a, b, ..] = q.quads[0];
            q.positions.extend([DVec3::X * 3.0, DVec3::Y * 3.0]);
            q.quads.push([a, b, n, n + 1]);
        }),
        &[Check::EdgeFaces],
    );
    // Two far vertices become one.
    rejects(
        &torus,
        &change(&|q| {
            let far = q.quads[q.quads.len() / 2][0];
            let last = n - 1;
            for v in q.quads.iter_mut().flatten() {
                if *v == far {
                    *v = 0;
                }
                if *v == last {
                    *v = far;
                }
            }
            q.positions.swap_remove(far as usize);
        }),
        &[Check::VertexFan],
    );
    rejects(&torus, &QuadMesh::default(), &[Check::Components, Check::Genus, Check::ComponentMatch]);
}

#[test]
fn the_wrong_topology_is_rejected() {
    let (torus, sphere) = (surface("torus", 1500), surface("sphere", 1200));
    let good = split(&torus.mesh);
    let mut hole = good.clone();
    hole.quads.swap_remove(11);
    rejects(&torus, &hole, &[Check::Boundaries, Check::BoundaryLoop, Check::ComponentMatch]);
    rejects(&torus, &split(&sphere.mesh), &[Check::Genus]);
    rejects(&sphere, &good, &[Check::Genus]);
    // A slit along one edge pair: one vertex doubled does not do it, two neighbouring edges do.
    let mut slit = split(&surface("half_pipe", 800).mesh);
    slit.quads.retain(|q| !q.contains(&400));
    let pipe = surface("half_pipe", 800);
    let used: Vec<u32> = {
        let mut map = vec![u32::MAX; slit.positions.len()];
        let mut next = 0;
        for v in slit.quads.iter().flatten() {
            if map[*v as usize] == u32::MAX {
                map[*v as usize] = next;
                next += 1;
            }
        }
        map
    };
    let mut positions = vec![DVec3::ZERO; used.iter().filter(|&&v| v != u32::MAX).count()];
    for (v, &to) in used.iter().enumerate().filter(|(_, to)| **to != u32::MAX) {
        positions[to as usize] = slit.positions[v];
    }
    let quads = slit.quads.iter().map(|q| q.map(|v| used[v as usize])).collect();
    rejects(&pipe, &QuadMesh { positions, quads }, &[Check::Boundaries]);
    // A handle between two removed quads.
    let mut handle = split(&sphere.mesh);
    let (far, near) = (handle.quads.swap_remove(handle.quads.len() / 2), handle.quads.swap_remove(0));
    for k in 0..4 {
        let (j, i) = ((4 - k) % 4, (3 - k) % 4);
        handle.quads.push([near[k], near[(k + 1) % 4], far[i], far[j]]);
    }
    rejects(&sphere, &handle, &[Check::Genus]);
}

#[test]
fn components_are_counted_and_found_again() {
    let (a, b) = (surface("sphere", 700), surface("torus", 900));
    let both = join(&a, &b, DVec3::X * 4.0);
    let good = split(&both.mesh);
    assert!(certificate(&both, &good).certified);
    rejects(&both, &split(&a.mesh), &[Check::Components, Check::Genus, Check::ComponentMatch]);
    rejects(&both, &split(&join(&both, &a, DVec3::Y * 4.0).mesh), &[Check::Components]);
    // Two spheres, but both in the place of one.
    let spheres = join(&a, &a, DVec3::X * 4.0);
    rejects(&spheres, &split(&join(&a, &a, DVec3::ZERO).mesh), &[Check::ComponentMatch]);
    // Totals agree, components do not: each handle is on the wrong body.
    let swapped = split(&join(&b, &a, DVec3::X * 4.0).mesh);
    rejects(&both, &swapped, &[Check::ComponentMatch]);
    // Two surfaces in the same place are not a fault of the quads.
    let twice = join(&a, &a, DVec3::ZERO);
    assert_eq!(certificate(&twice, &split(&twice.mesh)).violations, []);
}

#[test]
fn a_model_is_judged_as_its_parts_are() {
    let (a, b) = (surface("rounded_box", 900), surface("cube", 900));
    let inside_out = |s: &Surface| {
        let faces = s.mesh.faces().iter().map(|&[a, b, c]| [a, c, b]).collect();
        Surface { mesh: TriMesh::try_new(s.mesh.positions().to_vec(), faces).unwrap(), features: s.features.clone() }
    };
    // A shell: the same surface twice in the same place, once inside out; quads in either order.
    let shell = join(&a, &inside_out(&a), DVec3::ZERO);
    let swapped = join(&inside_out(&a), &a, DVec3::ZERO);
    assert_eq!(certificate(&shell, &split(&shell.mesh)).violations, []);
    assert_eq!(certificate(&shell, &split(&swapped.mesh)).violations, []);
    rejects(&shell, &split(&join(&a, &a, DVec3::ZERO).mesh), &[Check::Flipped]);
    // A small part far from the origin, its coordinates rounded as a file of single precision does.
    let tiny = Surface {
        mesh: TriMesh::try_new(b.mesh.positions().iter().map(|p| *p * 0.01).collect(), b.mesh.faces().to_vec())
            .unwrap(),
        features: b.features.clone(),
    };
    let far = join(&a, &tiny, DVec3::X * 20.0 + DVec3::Y * 7.7);
    let mut rounded = split(&far.mesh);
    rounded.positions.iter_mut().for_each(|p| *p = p.as_vec3().as_dvec3());
    assert_eq!(certificate(&far, &rounded).violations, []);
    // What is wrong with the second part is told in the numbers of the whole.
    let both = join(&a, &b, DVec3::X * 9.0);
    let mut quads = split(&both.mesh);
    let (n, wrong) = (3 * a.mesh.n_faces(), split(&b.mesh));
    assert!(certificate(&both, &quads).certified && wrong.quads.len() + n == quads.quads.len());
    let [p, q, ..] = quads.quads[n + 40];
    quads.positions[q as usize] = quads.positions[p as usize];
    let of_part = |quads: &QuadMesh, check: Check, surface: &Surface| {
        let violations = certificate(surface, quads).violations;
        violations.into_iter().find(|v| v.check == check).map(|v| v.witnesses).unwrap_or_default()
    };
    for check in [Check::Flipped, Check::ZeroArea] {
        let mut part = wrong.clone();
        let [p, q, ..] = part.quads[40];
        part.positions[q as usize] = part.positions[p as usize];
        let own: Vec<u32> = of_part(&part, check, &b).iter().map(|w| w + n as u32).collect();
        assert_eq!(of_part(&quads, check, &both), own, "{check:?}");
    }
}

#[test]
fn parts_in_the_same_place_are_told_by_their_vertices() {
    let plate = |size: f64| {
        let corners = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]].map(|[x, y]| size * dvec3(x, y, 0.0));
        let mesh = TriMesh::try_new(corners.to_vec(), vec![[0, 1, 2], [0, 2, 3]]).unwrap();
        Surface { mesh, features: Features { edges: Vec::new(), corners: vec![0, 1, 2, 3] } }
    };
    // A small plate on a large one; a file may hold the quads in any order.
    let both = join(&plate(1.0), &plate(0.25), dvec3(0.3, 0.3, 0.0));
    let mut quads = split(&both.mesh);
    assert_eq!(certificate(&both, &quads).violations, []);
    quads.quads.reverse();
    assert_eq!(certificate(&both, &quads).violations, []);
}
