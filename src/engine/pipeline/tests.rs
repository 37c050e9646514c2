//! Sizes that vary and lines to follow, from the soup to the certified quads.

use glam::DVec3;

use crate::engine::mesh::shapes::sample_surface;
use crate::engine::mesh::{TriMesh, TriangleSoup, next};
use crate::engine::methods::Level;
use crate::engine::parameterize::rotate;
use crate::engine::pipeline::{Boundary, Outcome, RemeshSpec, Target, WorkingMesh, remesh};
use crate::engine::quad::QuadMesh;
use crate::engine::run::{RunContext, WarningKind};

fn soup_of(name: &str, triangles: usize) -> TriangleSoup {
    let mesh = sample_surface(name, triangles).unwrap().mesh;
    TriangleSoup::from_triangles(mesh.positions().to_vec(), mesh.faces())
}

/// The certified quads, as many as asked for within 5 %.
fn certified(soup: &TriangleSoup, quads: u64, spec: RemeshSpec) -> Outcome {
    let spec = RemeshSpec { target: Target::Quads(quads), ..spec };
    let outcome = remesh(&RunContext::silent(), soup, &spec).unwrap();
    assert!(outcome.report.certified, "{:?}", outcome.report.warnings);
    let off = outcome.quads.quads.len() as f64 / quads as f64 - 1.0;
    assert!(off.abs() < 0.05, "{off}");
    outcome
}

fn corners(quads: &QuadMesh, quad: &[u32; 4]) -> [DVec3; 4] {
    quad.map(|v| quads.positions[v as usize])
}

fn centre(quads: &QuadMesh, quad: &[u32; 4]) -> DVec3 {
    corners(quads, quad).iter().sum::<DVec3>() / 4.0
}

/// Mean edge length and quads per area of the quads with such centres.
fn edge_and_density(quads: &QuadMesh, chosen: impl Fn(DVec3) -> bool) -> (f64, f64) {
    let (mut n, mut length, mut area) = (0.0, 0.0, 0.0);
    for quad in quads.quads.iter().filter(|quad| chosen(centre(quads, quad))) {
        let p = corners(quads, quad);
        n += 1.0;
        length += (0..4).map(|k| p[k].distance(p[(k + 1) % 4])).sum::<f64>() / 4.0;
        area += 0.5 * (p[2] - p[0]).cross(p[3] - p[1]).length();
    }
    assert!(n > 10.0, "no quads there");
    (length / n, n / area)
}

#[test]
fn quads_are_smaller_where_the_surface_curves_more() {
    let soup = soup_of("dumbbell", 6000);
    let ratio = |adaptive_size: f64| {
        let outcome = certified(&soup, 1500, RemeshSpec { adaptive_size, ..RemeshSpec::default() });
        let neck = edge_and_density(&outcome.quads, |p| p.x.abs() < 0.4).0;
        edge_and_density(&outcome.quads, |p| p.x.abs() > 1.2).0 / neck
    };
    let (none, half, full) = (ratio(0.0), ratio(50.0), ratio(100.0));
    assert!(none < 1.2 && half > 1.15 * none && full > 1.15 * half && full > 1.5, "{none} {half} {full}");
}

#[test]
fn vertex_colours_scale_the_density() {
    let mut soup = soup_of("sphere", 3000);
    let spec = || RemeshSpec { density_from_vertex_colour: true, ..RemeshSpec::default() };
    let plain = certified(&soup, 1000, spec());
    assert!(
        plain.report.warnings.iter().any(|w| w.kind == WarningKind::NoVertexColours {}),
        "{:?}",
        plain.report.warnings
    );
    // White at the top, black below.
    soup.colours = soup.positions.iter().map(|p| if p.z > 0.0 { [1.0; 4] } else { [0.0, 0.0, 0.0, 1.0] }).collect();
    let ratio = |outcome: &Outcome| {
        let top = edge_and_density(&outcome.quads, |p| p.z > 0.2).1;
        top / edge_and_density(&outcome.quads, |p| p.z < -0.5).1
    };
    let coloured = certified(&soup, 1000, spec());
    assert!((0.8..1.25).contains(&ratio(&plain)) && ratio(&coloured) > 8.0, "{} {}", ratio(&plain), ratio(&coloured));
}

/// A square plate of side 2 in the plane z = 0.
fn plate(n: u32) -> TriangleSoup {
    let at = |i: u32| DVec3::new(f64::from(i % (n + 1)), f64::from(i / (n + 1)), 0.0) * (2.0 / f64::from(n));
    let corner = |f: u32| f / n * (n + 1) + f % n;
    let split = |f: u32| {
        let [a, b, c, d] = [0, 1, n + 2, n + 1].map(|k| corner(f) + k);
        [[a, b, c], [a, c, d]]
    };
    let triangles: Vec<[u32; 3]> = (0..n * n).flat_map(split).collect();
    TriangleSoup::from_triangles((0..(n + 1) * (n + 1)).map(at).collect(), &triangles)
}

#[test]
fn quads_follow_a_stroke() {
    let soup = plate(30);
    let along = DVec3::new(22f64.to_radians().cos(), 22f64.to_radians().sin(), 0.0);
    let middle = DVec3::new(1.0, 1.0, 0.0);
    let stroke = vec![middle - 0.6 * along, middle, middle + 0.6 * along];
    // Mean angle between the edges and the stroke, modulo quarter turns, next to it and away from its ends.
    let off = |strokes: Vec<Vec<DVec3>>| {
        let quads = certified(&soup, 900, RemeshSpec { strokes, ..RemeshSpec::default() }).quads;
        let (mut n, mut sum) = (0.0, 0.0);
        for quad in &quads.quads {
            let p = corners(&quads, quad);
            let to = centre(&quads, quad) - middle;
            if to.dot(along).abs() < 0.4 && to.cross(along).length() < 0.05 {
                let side = p[1] - p[0] + p[2] - p[3];
                let angle = side.y.atan2(side.x).to_degrees() - 22.0;
                sum += (angle - 90.0 * (angle / 90.0).round()).abs();
                n += 1.0;
            }
        }
        assert!(n > 8.0);
        sum / n
    };
    let (without, with) = (off(Vec::new()), off(vec![stroke]));
    assert!(without > 20.0 && with < 6.0, "{without} {with}");
    let spec = RemeshSpec { strokes: vec![vec![DVec3::Z, 2.0 * DVec3::Z]], ..RemeshSpec::default() };
    let far = certified(&soup, 400, spec).report.warnings;
    assert!(far.iter().any(|w| w.kind == WarningKind::StrokeOffSurface { stroke: 0 }), "{far:?}");
}

/// The soup without the triangles with such centres.
fn without(soup: &TriangleSoup, gone: impl Fn(DVec3) -> bool) -> TriangleSoup {
    let centre = |t: &[u32; 3]| t.map(|v| soup.positions[v as usize]).iter().sum::<DVec3>() / 3.0;
    let triangles = soup.polygons().map(|p| [p[0], p[1], p[2]]);
    let triangles: Vec<[u32; 3]> = triangles.filter(|t| !gone(centre(t))).collect();
    TriangleSoup::from_triangles(soup.positions.clone(), &triangles)
}

/// Share of the edges within 10 degrees of a grid at this angle in the plane z = 0.
fn share_in_grid(quads: &QuadMesh, angle: f64) -> f64 {
    let sides = quads.quads.iter().flat_map(|quad| {
        let p = corners(quads, quad);
        (0..4).map(move |k| p[(k + 1) % 4] - p[k])
    });
    let off = |e: DVec3| {
        let turned = (e.y.atan2(e.x) - angle).rem_euclid(std::f64::consts::FRAC_PI_2);
        turned.min(std::f64::consts::FRAC_PI_2 - turned).to_degrees()
    };
    let off: Vec<f64> = sides.map(off).collect();
    off.iter().filter(|off| **off < 10.0).count() as f64 / off.len() as f64
}

#[test]
fn a_free_boundary_does_not_turn_the_grid() {
    // A plate with a hole, and a line across it that is parallel to no side.
    let soup = without(&plate(40), |p| (p - DVec3::new(1.3, 1.3, 0.0)).abs().max_element() < 0.3);
    let angle = 30f64.to_radians();
    let along = DVec3::new(angle.cos(), angle.sin(), 0.0);
    let stroke = (0..20).map(|k| DVec3::new(0.2, 0.2, 0.0) + along * (0.08 * f64::from(k))).collect();
    let spec = RemeshSpec { strokes: vec![stroke], ..RemeshSpec::default() };
    let aligned = certified(&soup, 900, spec.clone());
    let free = certified(&soup, 900, RemeshSpec { boundary: Boundary::Free, ..spec });
    assert_eq!((free.report.level, &free.report.warnings[..]), (Level::L0, &[][..]));
    let shares = [&aligned, &free].map(|outcome| share_in_grid(&outcome.quads, angle));
    assert!(shares[1] > 0.6 && shares[1] > shares[0] + 0.4, "{shares:?}");
}

#[test]
fn features_reach_a_free_boundary() {
    let cube = soup_of("cube", 3000);
    let highest = cube.positions.iter().map(|p| p.z).fold(f64::NEG_INFINITY, f64::max);
    let open = without(&cube, |p| p.z > highest - 1e-6);
    let outcome = certified(&open, 700, RemeshSpec { boundary: Boundary::Free, ..RemeshSpec::default() });
    assert_eq!((outcome.report.level, &outcome.report.warnings[..]), (Level::L0, &[][..]));
}

#[test]
fn a_surface_without_boundary_has_nothing_to_leave_free() {
    let soup = soup_of("torus", 2000);
    let [followed, free] = [Boundary::Align, Boundary::Free]
        .map(|boundary| certified(&soup, 400, RemeshSpec { boundary, ..RemeshSpec::default() }).quads);
    assert_eq!(followed, free);
}

/// A mesh as a soup with its vertices and triangles in another order, and triangles that begin elsewhere.
fn renumbered(mesh: &TriMesh) -> TriangleSoup {
    let n = mesh.n_vertices();
    let step = [7919, 7907, 7901].into_iter().find(|step| !n.is_multiple_of(*step)).unwrap();
    let name = |v: u32| (v as usize * step % n) as u32;
    let mut positions = mesh.positions().to_vec();
    (0..n as u32).for_each(|v| positions[name(v) as usize] = mesh.position(v));
    let mut faces: Vec<[u32; 3]> = mesh.faces().iter().rev().map(|t| t.map(name)).collect();
    faces.iter_mut().enumerate().for_each(|(f, face)| face.rotate_left(f % 3));
    TriangleSoup::from_triangles(positions, &faces)
}

#[test]
fn quads_do_not_depend_on_the_numbering_of_the_input() {
    for (name, triangles, quads) in [("noisy_blob", 2500, 600), ("gear", 5000, 1200)] {
        let other = renumbered(&sample_surface(name, triangles).unwrap().mesh);
        let [a, b] = [&soup_of(name, triangles), &other].map(|soup| certified(soup, quads, RemeshSpec::default()));
        let (a, b) = (a.report.quads, b.report.quads);
        assert_eq!((a.count, &a.valences), (b.count, &b.valences), "{name}");
        assert!((a.rsd_edge - b.rsd_edge).abs() < 1e-3, "{name}: {} {}", a.rsd_edge, b.rsd_edge);
    }
}

#[test]
fn maps_on_the_input_come_in_its_order() {
    let [a, b] = ["sphere", "torus"].map(|name| sample_surface(name, 3000).unwrap().mesh);
    let n = a.n_vertices() as u32;
    let positions = [a.positions().to_vec(), b.positions().iter().map(|&p| p + DVec3::X * 4.0).collect()].concat();
    // Triangles of the two in turn.
    let mut faces: Vec<[u32; 3]> = Vec::new();
    for f in 0..a.n_faces().max(b.n_faces()) {
        faces.extend(a.faces().get(f));
        faces.extend(b.faces().get(f).map(|t| t.map(|v| v + n)));
    }
    let soup = TriangleSoup::from_triangles(positions, &faces);
    let spec = RemeshSpec { working_mesh: WorkingMesh::Input, ..RemeshSpec::default() };
    let map = certified(&soup, 700, spec).map.unwrap();
    assert_eq!((&map.positions, &map.faces), (&soup.positions, &faces));
    let mesh = TriMesh::try_new(map.positions, map.faces).unwrap();
    for h in 0..mesh.n_halfedges() {
        let across = next(mesh.twin(h).unwrap());
        let seen = rotate(map.grid.uv[across], map.grid.rotation[h]) + map.grid.translation[h].as_dvec2();
        assert!(seen.distance(map.grid.uv[h]) < 1e-9, "halfedge {h}");
    }
    for s in &map.singularities {
        assert!(mesh.fan(s.vertex).any(|h| s.uv == map.grid.uv[h].to_array()), "vertex {}", s.vertex);
    }
    assert_eq!(map.singularities.iter().map(|s| s.index_quarters).sum::<i32>(), 8, "four times 2 + 0");
}
