use super::*;
use crate::engine::mesh::shapes::{SHAPES, sample_surface};
use crate::engine::mesh::{Features, Surface, SurfaceIndex, TriMesh};
use crate::engine::quad::QuadMesh;
use crate::engine::run::{RunContext, StopReason};
use glam::{DVec3, dvec3};

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
pub(super) fn rejects(surface: &Surface, quads: &QuadMesh, checks: &[Check]) {
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
fn a_stopped_run_is_not_judged() {
    let ctx = RunContext::silent();
    ctx.stop(StopReason::Client);
    let sphere = surface("sphere", 500);
    assert!(certify(&ctx, &sphere, &SurfaceIndex::new(&sphere.mesh), &split(&sphere.mesh), 0.0).is_err());
}
