use super::*;
use crate::engine::mesh::shapes::{SHAPES, sample_surface};
use crate::engine::mesh::{Features, Surface, SurfaceIndex, TriMesh};
use crate::engine::quad::QuadMesh;
use crate::engine::run::{RunContext, StopReason};
use glam::{DMat3, DVec3, dvec3};

/// Every triangle as three quads around its centroid: lies exactly on the surface.
pub(super) fn split(mesh: &TriMesh) -> QuadMesh {
    let mut positions = mesh.positions().to_vec();
    let mut middle = vec![0u32; mesh.n_halfedges()];
    for h in (0..mesh.n_halfedges()).filter(|&h| mesh.is_edge_owner(h)) {
        middle[h] = positions.len() as u32;
        if let Some(t) = mesh.twin(h) {
            middle[t] = middle[h];
        }
        positions.push(0.5 * (mesh.position(mesh.origin(h)) + mesh.position(mesh.target(h))));
    }
    let mut quads = Vec::new();
    for f in 0..mesh.n_faces() {
        let centre = positions.len() as u32;
        positions.push(mesh.triangle(f).iter().sum::<DVec3>() / 3.0);
        for k in 0..3 {
            quads.push([mesh.face(f)[k], middle[3 * f + k], centre, middle[3 * f + (k + 2) % 3]]);
        }
    }
    QuadMesh { positions, quads }
}

pub(super) fn certificate(surface: &Surface, quads: &QuadMesh) -> Certificate {
    certify(&RunContext::silent(), surface, &SurfaceIndex::new(&surface.mesh), quads, 0.0).unwrap()
}

pub(super) fn surface(name: &str, triangles: usize) -> Surface {
    sample_surface(name, triangles).unwrap()
}

/// Two surfaces as one, the second moved.
pub(super) fn join(a: &Surface, b: &Surface, by: DVec3) -> Surface {
    let n = a.mesh.n_vertices() as u32;
    let positions = a.mesh.positions().iter().copied().chain(b.mesh.positions().iter().map(|&p| p + by)).collect();
    let faces = a.mesh.faces().iter().copied().chain(b.mesh.faces().iter().map(|f| f.map(|v| v + n))).collect();
    let edges = a.features.edges.iter().copied().chain(b.features.edges.iter().map(|e| e.map(|v| v + n))).collect();
    let corners = a.features.corners.iter().copied().chain(b.features.corners.iter().map(|v| v + n)).collect();
    Surface { mesh: TriMesh::try_new(positions, faces).unwrap(), features: Features { edges, corners } }
}

#[track_caller]
fn rejects(surface: &Surface, quads: &QuadMesh, checks: &[Check]) {
    let result = certificate(surface, quads);
    assert!(!result.certified);
    for check in checks {
        let said = result.violations.iter().find(|v| v.check == *check);
        let said = said.unwrap_or_else(|| panic!("{check:?} is missing in {:?}", result.violations));
        assert!(said.count >= said.witnesses.len() && said.witnesses.len() <= 200);
        assert!(said.to_string().starts_with(&said.count.to_string()));
    }
}

#[test]
fn an_exact_split_of_every_sample_is_certified() {
    for info in SHAPES {
        let surface = surface(info.name, 2500);
        let result = certificate(&surface, &split(&surface.mesh));
        assert_eq!(result.violations, [], "{}", info.name);
        let m = &result.measures;
        assert_eq!((m.components, m.genus, m.boundaries), (1, info.genus, info.boundaries), "{}", info.name);
        assert_eq!((m.count, m.flipped), (3 * surface.mesh.n_faces(), 0));
        assert!(m.hausdorff_max < 1e-9 && m.feature_error_max < 1e-9, "{} {m:?}", info.name);
        let inside: usize = m.valences.iter().map(|v| v.1).sum();
        let irregular: usize = m.valences.iter().filter(|v| v.0 != 4).map(|v| v.1).sum();
        assert_eq!((irregular, inside <= m.vertices), (m.irregular_interior, true));
        assert!(0.0 < m.scaled_jacobian_min && m.scaled_jacobian_min <= m.scaled_jacobian_mean);
    }
}

#[test]
fn corners_far_from_the_origin_are_found_in_single_precision() {
    let cube = surface("cube", 300);
    let by = cube.mesh.diagonal() * dvec3(11.3, -57.1, 23.7);
    let far = cube.mesh.positions().iter().map(|&p| p + by).collect();
    let far = Surface { mesh: TriMesh::try_new(far, cube.mesh.faces().to_vec()).unwrap(), ..cube };
    let mut quads = split(&far.mesh);
    quads.positions.iter_mut().for_each(|p| *p = p.as_vec3().as_dvec3());
    assert_eq!(certificate(&far, &quads).violations, []);
    // A thousandth of the diagonal is another place.
    let corner = far.features.corners[0] as usize;
    quads.positions[corner] += dvec3(1e-3, 0.0, 0.0) * far.mesh.diagonal();
    rejects(&far, &quads, &[Check::Corner]);
}

#[test]
fn measures_of_a_cube_of_unit_squares() {
    // The split of the 12 triangles is a cube; its exact squares are known.
    let cube = surface("cube", 12);
    let mut quads = QuadMesh { positions: cube.mesh.positions().to_vec(), quads: Vec::new() };
    for axis in 0..3 {
        for side in [-0.5, 0.5] {
            let mut ring: Vec<u32> = (0..8u32).filter(|&v| quads.positions[v as usize][axis] == side).collect();
            let (u, w) = ((axis + 1) % 3, (axis + 2) % 3);
            let turn = |v: &u32| {
                let p = quads.positions[*v as usize];
                side * p[w].atan2(p[u])
            };
            ring.sort_by(|a, b| turn(a).total_cmp(&turn(b)));
            quads.quads.push([ring[0], ring[1], ring[2], ring[3]]);
        }
    }
    let result = certificate(&cube, &quads);
    assert_eq!(result.violations, []);
    let m = result.measures;
    assert_eq!((m.valences, m.irregular_interior), (vec![(3, 8)], 8));
    assert!(m.rsd_edge < 1e-12 && m.rsd_angle < 1e-12 && m.hausdorff_max < 1e-12);
    assert!((m.scaled_jacobian_min - 1.0).abs() < 1e-12);
}

#[test]
fn distances_are_relative_and_two_sided() {
    let sphere = surface("sphere", 2000);
    let mut quads = split(&sphere.mesh);
    for p in &mut quads.positions {
        *p *= 1.05;
    }
    let m = certificate(&sphere, &quads).measures;
    let expected = 0.05 / sphere.mesh.diagonal();
    assert!((m.hausdorff_max / expected - 1.0).abs() < 0.05, "{m:?}");
    assert!((m.hausdorff_mean / expected - 1.0).abs() < 0.05, "{m:?}");
    // A spike of the surface that the quads do not follow counts too.
    let mut positions = sphere.mesh.positions().to_vec();
    positions[17] *= 1.5;
    let spiky = Surface { mesh: TriMesh::try_new(positions, sphere.mesh.faces().to_vec()).unwrap(), ..sphere.clone() };
    let m = certificate(&spiky, &split(&sphere.mesh)).measures;
    assert!((m.hausdorff_max * spiky.mesh.diagonal() - 0.5).abs() < 0.02, "{m:?}");
}

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
fn flipped_and_flat_quads_are_rejected() {
    let sphere = surface("sphere", 1200);
    let good = split(&sphere.mesh);
    let mut inside_out = good.clone();
    inside_out.quads.iter_mut().for_each(|q| q.reverse());
    rejects(&sphere, &inside_out, &[Check::Flipped]);
    let mut mirrored = good.clone();
    mirrored.positions.iter_mut().for_each(|p| p.x = -p.x);
    rejects(&sphere, &mirrored, &[Check::Flipped]);
    let mut fold = good.clone();
    let [a, b, c, _] = fold.quads[30];
    let over = 2.5 * fold.positions[c as usize] - 1.5 * fold.positions[a as usize];
    fold.positions[a as usize] = over + (fold.positions[b as usize] - over) * 0.1;
    rejects(&sphere, &fold, &[Check::Flipped]);
    let mut flat = good.clone();
    let [a, b, c, d] = flat.quads[30];
    flat.positions[d as usize] = flat.positions[b as usize];
    flat.positions[c as usize] = flat.positions[a as usize];
    rejects(&sphere, &flat, &[Check::ZeroArea]);
    // A closed leaf without thickness has both normals everywhere: no fault.
    let p = vec![DVec3::ZERO, DVec3::X, dvec3(1.0, 1.0, 0.0), DVec3::Y, dvec3(0.5, 0.4, 0.0), dvec3(0.5, 0.4, 0.0)];
    let up = [[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]];
    let faces = up.into_iter().chain(up.map(|[a, b, _]| [b, a, 5])).collect();
    let leaf = Surface { mesh: TriMesh::try_new(p, faces).unwrap(), features: Features::default() };
    assert_eq!(certificate(&leaf, &split(&leaf.mesh)).violations, []);
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
    // A part of a hole's rim leaves it within the plane.
    let rim = plate
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
    let outwards = (plate.mesh.position(rim) - dvec3(0.0, 0.5, 0.12)) * dvec3(1.0, 1.0, 0.0);
    let length =
        plate.mesh.fan(rim).map(|h| plate.mesh.position(plate.mesh.target(h)).distance(plate.mesh.position(rim)));
    let length = length.fold(f64::INFINITY, f64::min);
    let push = |p: &DVec3| {
        let near = p.distance(plate.mesh.position(rim)) < 3.0 * length;
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
    let mut pulled = good.clone();
    for &h in &boundary[0][20..26] {
        let p = &mut pulled.positions[pipe.mesh.origin(h) as usize];
        *p = p.lerp(dvec3(0.0, 0.0, -1.0), 0.15);
    }
    rejects(&pipe, &pulled, &[Check::BoundaryCurve]);
    let short = QuadMesh { positions: good.positions.iter().map(|p| *p * dvec3(1.0, 0.9, 1.0)).collect(), ..good };
    rejects(&pipe, &short, &[Check::BoundaryCurve, Check::BoundaryLoop, Check::Corner]);
    // Two pipes, one of which has both boundaries: numbers agree, places do not.
    let two = join(&pipe, &pipe, DVec3::X * 5.0);
    let stacked = join(&pipe, &pipe, DVec3::Z * 1e-3);
    rejects(&two, &split(&stacked.mesh), &[Check::ComponentMatch]);
}

#[test]
fn a_stopped_run_is_not_judged() {
    let ctx = RunContext::silent();
    ctx.stop(StopReason::Client);
    let sphere = surface("sphere", 500);
    assert!(certify(&ctx, &sphere, &SurfaceIndex::new(&sphere.mesh), &split(&sphere.mesh), 0.0).is_err());
}
