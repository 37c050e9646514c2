use std::collections::BTreeSet;

use glam::{DMat3, DQuat, DVec3};

use crate::engine::mesh::shapes::{sample, sample_surface};
use crate::engine::mesh::{Surface, TriMesh, TriangleSoup};
use crate::engine::parameterize::{rotate, rotate_integer};
use crate::engine::pipeline::symmetry::{FoundPlane, Planes, find_planes, fold, unfold_surface};
use crate::engine::pipeline::{
    MirrorPlane, Outcome, RemeshError, RemeshSpec, RunFindings, Symmetry, Target, check, remesh,
};
use crate::engine::run::{Blame, Fault, RunContext, WarningKind};

fn folded_and_unfolded(surface: &Surface, axes: &[usize]) -> (Surface, Surface) {
    let fold = fold(&RunContext::silent(), surface, &[], &Planes::across(axes), 0.0, &mut Vec::new()).unwrap();
    let whole = unfold_surface(&fold.surface, &fold.unfoldings).unwrap();
    (fold.surface, whole)
}

#[test]
fn a_part_and_its_images_are_the_surface_again() {
    for name in ["sphere", "cube", "torus", "ellipsoid", "genus5"] {
        let surface = sample_surface(name, 1500).unwrap();
        let area = surface.mesh.total_area();
        for axes in [&[0][..], &[1], &[2], &[0, 1], &[2, 0, 1]] {
            let (part, whole) = folded_and_unfolded(&surface, axes);
            assert_eq!(whole.mesh.topology(), surface.mesh.topology(), "{name} {axes:?}");
            let share = part.mesh.total_area() * f64::from(1 << axes.len()) / area;
            assert!((share - 1.0).abs() < 0.01, "{name} {axes:?}: {share}");
            assert!(
                (whole.mesh.total_area() / (part.mesh.total_area() * f64::from(1 << axes.len())) - 1.0).abs() < 1e-12
            );
            // Only the edges of the cube are features by design.
            let length = |s: &Surface| -> f64 {
                s.features.edges.iter().map(|e| s.mesh.position(e[0]).distance(s.mesh.position(e[1]))).sum()
            };
            let is_same = (length(&whole) - length(&surface)).abs() <= 0.01 * length(&surface);
            assert!(name != "cube" || is_same, "{axes:?}: {}", length(&whole));
        }
    }
}

/// Every quad's image is a quad, bit for bit.
fn is_symmetric(outcome: &Outcome, axis: usize, at: f64) -> bool {
    let bits = |p: DVec3| p.to_array().map(|x| (x + 0.0).to_bits());
    let image = |mut p: DVec3| {
        p[axis] = 2.0 * at - p[axis];
        p
    };
    let quad = |q: &[u32; 4], map: &dyn Fn(DVec3) -> DVec3| {
        let mut corners = q.map(|v| bits(map(outcome.quads.positions[v as usize])));
        corners.sort_unstable();
        corners
    };
    let own: BTreeSet<_> = outcome.quads.quads.iter().map(|q| quad(q, &|p| p)).collect();
    outcome.quads.quads.iter().all(|q| own.contains(&quad(q, &image)))
}

fn remeshed(soup: &TriangleSoup, quads: u64, symmetry: &[usize]) -> Result<Outcome, RemeshError> {
    let spec = RemeshSpec {
        target: Target::Quads(quads),
        symmetry: Symmetry::Across(symmetry.to_vec()),
        ..RemeshSpec::default()
    };
    remesh(&RunContext::silent(), soup, &spec)
}

#[test]
fn quads_are_their_own_mirror_image_bit_for_bit() {
    for (name, axes) in [("ellipsoid", &[0][..]), ("cube", &[1, 2]), ("genus5", &[0, 1, 2]), ("gear", &[2])] {
        let soup = sample(name, 4000, 0.0, 0).unwrap();
        let target = if name == "gear" { 3000 } else { 800 };
        let outcome = remeshed(&soup, target, axes).unwrap();
        assert!(outcome.report.certified, "{name}");
        let given_up = outcome.report.warnings.iter().find(|w| matches!(w.kind, WarningKind::SymmetryDropped { .. }));
        assert_eq!(given_up, None, "{name}");
        for &axis in axes {
            assert!(is_symmetric(&outcome, axis, 0.0), "{name} {axis}");
        }
        let off = (outcome.report.quads.count as f64 / target as f64 - 1.0).abs();
        assert!(off < 0.1, "{name}: {}", outcome.report.quads.count);
    }
}

/// Far from the origin the plane is in the middle of the model.
#[test]
fn the_plane_is_where_the_model_is() {
    let mut soup = sample("ellipsoid", 1500, 0.0, 0).unwrap();
    soup.positions.iter_mut().for_each(|p| p.x += 10.3);
    let outcome = remeshed(&soup, 400, &[0]).unwrap();
    let at = 0.5
        * (outcome.quads.positions.iter().map(|p| p.x).fold(f64::INFINITY, f64::min)
            + outcome.quads.positions.iter().map(|p| p.x).fold(f64::NEG_INFINITY, f64::max));
    assert!((at - 10.3).abs() < 1e-3 && is_symmetric(&outcome, 0, at), "{at}");
}

/// Transitions of the map of the whole are exact, also across the plane, and its indices are those of a closed surface.
#[test]
fn the_map_of_the_whole_is_an_integer_grid_map() {
    for (name, axes) in [("ellipsoid", &[0][..]), ("torus", &[0, 1]), ("cube", &[2, 1]), ("genus5", &[0, 1])] {
        let soup = sample(name, 2000, 0.0, 0).unwrap();
        let map = remeshed(&soup, 800, axes).unwrap().map.unwrap();
        let mesh = TriMesh::try_new(map.positions.clone(), map.faces.clone()).unwrap();
        let corner = |h: usize| map.grid.uv[h];
        let after = |h: usize| if h % 3 == 2 { h - 2 } else { h + 1 };
        for h in 0..mesh.n_halfedges() {
            let t = mesh.twin(h).expect("a closed surface");
            let (r, shift) = (map.grid.rotation[h], map.grid.translation[h]);
            for (own, other) in [(h, after(t)), (after(h), t)] {
                let z = rotate(corner(other), r) + shift.as_dvec2();
                assert!(corner(own).distance(z) < 1e-6, "{name}: {} {z}", corner(own));
            }
            assert_eq!((r + map.grid.rotation[t]) % 4, 0);
            assert_eq!(rotate_integer(map.grid.translation[t], r) + shift, glam::I64Vec2::ZERO);
        }
        let chi = mesh.n_vertices() as i64 - mesh.n_edges() as i64 + mesh.n_faces() as i64;
        let index: i64 = map.singularities.iter().map(|s| i64::from(s.index_quarters)).sum();
        // Where the map is folded, indices on the plane are only those of its neighbourhood.
        assert!(name == "genus5" || map.report.flipped == 0);
        assert!(index == 4 * chi || map.report.flipped > 0, "{name}: {index}");
    }
}

#[test]
fn a_model_without_symmetry_is_refused() {
    let mut soup = sample("ellipsoid", 1500, 0.0, 0).unwrap();
    soup.positions.iter_mut().for_each(|p| p.y += if p.x > 0.0 { 0.8 * p.x } else { 0.0 });
    let refused = remeshed(&soup, 400, &[0]).unwrap_err();
    assert_eq!(refused.fault(), Fault::Unsatisfiable);
    assert!(refused.to_string().contains("not symmetric in x"), "{refused}");
}

fn turned(soup: &mut TriangleSoup) -> DMat3 {
    let turn = DMat3::from_quat(DQuat::from_axis_angle(DVec3::new(1.0, -2.0, 0.5).normalize(), 0.8));
    soup.positions.iter_mut().for_each(|p| *p = turn * *p + DVec3::new(3.0, 0.5, -1.0));
    turn
}

/// The samples are symmetric to all coordinate planes; turned and moved they are to the turned ones.
#[test]
fn planes_are_found_in_any_direction() {
    for name in ["ellipsoid", "rounded_box", "gear", "genus5", "torus", "dumbbell"] {
        let mut soup = sample(name, 3000, 0.0, 0).unwrap();
        let plain = sample_surface(name, 3000).unwrap().mesh;
        let turn = turned(&mut soup);
        let mesh = TriMesh::try_new(soup.positions.clone(), plain.faces().to_vec()).unwrap();
        for (mesh, turn, centre) in [(&plain, DMat3::IDENTITY, DVec3::ZERO), (&mesh, turn, DVec3::new(3.0, 0.5, -1.0))]
        {
            let symmetric = |k: usize| {
                let plane = MirrorPlane { normal: plain_axis(k), offset: 0.0 };
                let index = crate::engine::mesh::SurfaceIndex::new(&plain);
                plain.positions().iter().map(|&p| index.closest(plane.image(p)).distance).fold(0.0, f64::max)
                    < 0.01 * plain.diagonal()
            };
            let found = find_planes(&RunContext::silent(), mesh, 0.01).unwrap();
            let wanted = (0..3).filter(|&k| symmetric(k)).count();
            assert!(wanted > 0 && found.len() >= wanted.min(1), "{name}: {found:?}");
            for FoundPlane { plane, away } in found {
                assert!(away <= 0.01 && (plane.normal.length() - 1.0).abs() < 1e-12, "{name}");
                assert!(
                    (plane.normal.dot(centre) - plane.offset).abs() < 0.005 * plain.diagonal(),
                    "{name}: {plane:?}"
                );
                // Bodies of revolution, and the frame of a cube, have planes in between.
                let cosine = (0..3).map(|k| (turn * plain_axis(k)).dot(plane.normal).abs()).fold(0.0, f64::max);
                assert!(
                    ["torus", "dumbbell", "gear", "genus5"].contains(&name) || cosine > 0.9999,
                    "{name}: {plane:?}"
                );
            }
        }
    }
}

fn plain_axis(k: usize) -> DVec3 {
    DVec3::AXES[k]
}

#[test]
fn a_model_without_a_plane_has_none() {
    let mesh = sample_surface("trefoil", 3000).unwrap().mesh;
    assert!(find_planes(&RunContext::silent(), &mesh, 0.01).unwrap().is_empty());
    let spec = RemeshSpec { target: Target::Quads(600), symmetry: Symmetry::Auto, ..RemeshSpec::default() };
    let soup = TriangleSoup::from_triangles(mesh.positions().to_vec(), mesh.faces());
    let outcome = remesh(&RunContext::silent(), &soup, &spec).unwrap();
    assert!(outcome.report.certified && outcome.report.symmetry.is_empty());
    assert!(outcome.report.warnings.iter().any(|w| matches!(w.kind, WarningKind::NoSymmetry { .. })));
}

/// A turned model, one of whose sides is a little off: its quads are their own image at the planes that are reported, and
/// the certificate can be made again from the report.
#[test]
fn symmetry_that_is_found_is_made_exact() {
    let mut soup = sample("ellipsoid", 3000, 0.0, 0).unwrap();
    soup.positions.iter_mut().for_each(|p| p.y += if p.x > 0.0 { 0.02 * p.x } else { 0.0 });
    turned(&mut soup);
    let spec = RemeshSpec { target: Target::Quads(600), symmetry: Symmetry::Auto, ..RemeshSpec::default() };
    let outcome = remesh(&RunContext::silent(), &soup, &spec).unwrap();
    let planes = outcome.report.symmetry.clone();
    assert!(outcome.report.certified && planes.len() == 3, "{planes:?} {:?}", outcome.report.warnings);
    let quads = &outcome.quads;
    let size = quads.positions.iter().fold(0f64, |most, p| most.max(p.abs().max_element()));
    let key = |p: DVec3| p.to_array().map(|x| (x / (1e-9 * size)).round() as i64);
    let near = |p: DVec3| {
        let [x, y, z] = key(p);
        (0..27).map(move |i| [x + i % 3 - 1, y + i / 3 % 3 - 1, z + i / 9 - 1])
    };
    let own: BTreeSet<[i64; 3]> = quads.positions.iter().map(|&p| key(p)).collect();
    for plane in &planes {
        for &p in &quads.positions {
            assert!(near(plane.image(p)).any(|key| own.contains(&key)), "{plane:?}: {p}");
        }
    }
    let findings = RunFindings { edge_length: outcome.report.edge_length, symmetry: planes, given_up: Vec::new() };
    let certificate = check(&RunContext::silent(), &soup, quads, &spec, Some(&findings)).unwrap();
    assert!(certificate.certified, "{:?}", certificate.violations);
}

/// Without symmetry asked for, that of the model is offered, and nothing else changes.
#[test]
fn symmetry_is_offered_where_there_is_one() {
    let offers = |soup: &TriangleSoup| {
        let outcome = remeshed(soup, 400, &[]).unwrap();
        assert!(outcome.report.symmetry.is_empty());
        let is_offer =
            |kind: &WarningKind| matches!(kind, WarningKind::SymmetryOffered { percent, .. } if *percent < 1.0);
        outcome.report.warnings.iter().filter(|w| is_offer(&w.kind)).count()
    };
    let mut soup = sample("ellipsoid", 1500, 0.0, 0).unwrap();
    assert_eq!(offers(&soup), 1);
    soup.positions.iter_mut().for_each(|p| p.y += 0.3 * p.x * p.x + if p.z > 0.0 { 0.5 * p.x * p.z } else { 0.0 });
    assert_eq!(offers(&soup), 0);
}
