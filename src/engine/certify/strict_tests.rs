//! Folded corners, distance, and what is below the scale of the quads.

use crate::engine::certify::tests::{join, split, surface};
use crate::engine::certify::{Check, certify};
use crate::engine::mesh::shapes::{SHAPES, sample};
use crate::engine::mesh::{Features, Surface, SurfaceIndex, TriMesh};
use crate::engine::quad::QuadMesh;
use crate::engine::run::RunContext;
use glam::{DVec3, dvec3};

fn strict(surface: &Surface, quads: &QuadMesh) -> Vec<(Check, usize)> {
    let index = SurfaceIndex::new(&surface.mesh);
    let result = certify(&RunContext::silent(), surface, &index, quads, 0.0).unwrap();
    assert_eq!(result.certified, result.violations.is_empty());
    for v in result.violations.iter().filter(|v| matches!(v.check, Check::Folded | Check::Far | Check::Flipped)) {
        assert_eq!(v.witnesses.len(), v.places.len(), "every quad has its place");
    }
    result.violations.iter().map(|v| (v.check, v.count)).collect()
}

#[test]
fn an_exact_split_of_every_sample_passes() {
    for info in SHAPES {
        let surface = surface(info.name, 2500);
        assert_eq!(strict(&surface, &split(&surface.mesh)), [], "{}", info.name);
    }
}

#[test]
fn folded_corners_refuse() {
    let torus = surface("torus", 1500);
    let good = split(&torus.mesh);
    let mut folded = good.clone();
    let [a, _, c, _] = folded.quads[77];
    folded.positions[c as usize] = good.positions[a as usize].lerp(good.positions[c as usize], 0.65);
    assert_eq!(strict(&torus, &folded), [(Check::Folded, 1)]);
    // Of two components the second: the witness is a quad of the whole.
    let both = join(&torus, &torus, DVec3::X * 5.0);
    let mut quads = split(&both.mesh);
    let q = good.quads.len() + 77;
    let [a, _, c, _] = quads.quads[q];
    quads.positions[c as usize] = quads.positions[a as usize].lerp(quads.positions[c as usize], 0.65);
    let index = SurfaceIndex::new(&both.mesh);
    let found = certify(&RunContext::silent(), &both, &index, &quads, 0.0).unwrap().violations;
    assert_eq!((found.len(), found[0].witnesses.clone()), (1, vec![q as u32]));
    assert!(found[0].places[0].distance(quads.positions[c as usize]) < 0.2);
}

#[test]
fn what_lies_two_edges_apart_refuses() {
    // A spike of the surface that the quads do not follow; edges of the quads are about 0.14.
    let sphere = surface("sphere", 600);
    let quads = split(&sphere.mesh);
    let spiky = |height: f64| {
        let mut positions = sphere.mesh.positions().to_vec();
        positions[17] *= 1.0 + height;
        Surface { mesh: TriMesh::try_new(positions, sphere.mesh.faces().to_vec()).unwrap(), ..sphere.clone() }
    };
    assert_eq!(strict(&spiky(0.15), &quads), []);
    let index = SurfaceIndex::new(&spiky(0.5).mesh);
    let found = certify(&RunContext::silent(), &spiky(0.5), &index, &quads, 0.0).unwrap();
    assert_eq!(found.violations.iter().map(|v| v.check).collect::<Vec<_>>(), [Check::Far]);
    assert!(found.violations[0].places.iter().any(|p| p.length() > 1.2));
    // Where edges as long as the spike were asked for, it is within two of them.
    let asked = certify(&RunContext::silent(), &spiky(0.5), &index, &quads, 0.5).unwrap();
    assert_eq!(asked.violations, []);
    // The other way: quads that stand off the surface.
    let mut moved = quads.clone();
    moved.positions[17] *= 1.6;
    assert!(strict(&sphere, &moved).iter().any(|v| v.0 == Check::Far));
}

#[test]
fn wrinkles_below_the_quads_refuse_nothing() {
    // Every triangle is turned about by two of its edges, and quads are four of them wide.
    for (name, seed) in [("sphere", 1), ("torus", 2), ("rounded_box", 3)] {
        let smooth = surface(name, 700);
        let soup = sample(name, 20_000, 2.0, seed).unwrap();
        let mesh =
            TriMesh::try_new(soup.positions.clone(), soup.polygons().map(|p| [p[0], p[1], p[2]]).collect()).unwrap();
        let noisy = Surface { mesh, features: Features::default() };
        let index = SurfaceIndex::new(&noisy.mesh);
        let quads = split(&smooth.mesh);
        let leans = |q: &[u32; 4]| {
            let p = q.map(|v| quads.positions[v as usize]);
            let own = (p[2] - p[0]).cross(p[3] - p[1]).normalize_or_zero();
            index.normal(index.closest(p.iter().sum::<DVec3>() / 4.0).face).dot(own) < 0.6
        };
        let leaning = quads.quads.iter().filter(|q| leans(q)).count();
        assert!(10 * leaning > quads.quads.len(), "{name}: the triangles beneath the quads lean: {leaning}");
        assert_eq!(strict(&noisy, &quads), [], "{name}");
    }
}

#[test]
fn a_second_sheet_close_by_hides_no_flipped_quad() {
    let cube = surface("cube", 500);
    let flat = |p: &DVec3| *p * dvec3(1.0, 1.0, 0.004);
    let mesh = TriMesh::try_new(cube.mesh.positions().iter().map(flat).collect(), cube.mesh.faces().to_vec()).unwrap();
    let plate = Surface { mesh, features: cube.features };
    let good = split(&plate.mesh);
    assert_eq!(strict(&plate, &good), []);
    let middle = |q: &[u32; 4]| q.iter().map(|&v| good.positions[v as usize]).sum::<DVec3>() / 4.0;
    let inner = (0..good.quads.len()).filter(|&q| {
        let p = middle(&good.quads[q]);
        p.x.abs() < 0.3 && p.y.abs() < 0.3
    });
    let (mut tried, mut found) = (0, 0);
    for q in inner.step_by(23) {
        let mut fold = good.clone();
        let [a, _, c, _] = fold.quads[q];
        // The corner of a triangle goes beyond its centre: that quad is turned over.
        fold.positions[a as usize] = fold.positions[c as usize] * 2.0 - fold.positions[a as usize];
        tried += 1;
        found += usize::from(strict(&plate, &fold).iter().any(|v| v.0 == Check::Flipped));
    }
    assert!(tried > 5 && found == tried, "{found} of {tried}");
}

/// A flat square of `n` by `n` cells of this size, two triangles each, without the cells that `is_cut` names.
fn sheet(n: u32, cell: f64, is_cut: impl Fn(u32, u32) -> bool) -> Surface {
    let at = |i: u32, j: u32| j * (n + 1) + i;
    let mut faces = Vec::new();
    for (i, j) in (0..n).flat_map(|j| (0..n).map(move |i| (i, j))).filter(|&(i, j)| !is_cut(i, j)) {
        faces.push([at(i, j), at(i + 1, j), at(i + 1, j + 1)]);
        faces.push([at(i, j), at(i + 1, j + 1), at(i, j + 1)]);
    }
    let used: Vec<u32> = (0..(n + 1) * (n + 1)).filter(|v| faces.iter().flatten().any(|w| w == v)).collect();
    let number = |v: u32| used.binary_search(&v).unwrap() as u32;
    let position = |&v: &u32| dvec3(cell * f64::from(v % (n + 1)), cell * f64::from(v / (n + 1)), 0.0);
    let faces = faces.iter().map(|f| f.map(number)).collect();
    let mesh = TriMesh::try_new(used.iter().map(position).collect(), faces).unwrap();
    Surface { mesh, features: Features::default() }
}

#[test]
fn a_bay_below_the_quads_is_passed_over_and_a_slit_is_not() {
    let at = |i: u32, j: u32| 11 * j + i;
    let position = |v: u32| dvec3(f64::from(v % 11), f64::from(v / 11), 0.0);
    let cells = (0..10u32).flat_map(|j| (0..10u32).map(move |i| (i, j)));
    let quads = QuadMesh {
        positions: (0..121).map(position).collect(),
        quads: cells.map(|(i, j)| [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]).collect(),
    };
    let bay = |depth: u32| sheet(40, 0.25, |i, j| i == 21 && j < depth);
    assert_eq!(strict(&bay(0), &quads), []);
    // A quarter of an edge wide: one edge deep, and six.
    assert_eq!(strict(&bay(4), &quads), []);
    assert!(strict(&bay(24), &quads).iter().any(|v| v.0 == Check::BoundaryCurve));
    // Two edges wide it is a shore that the quads must follow.
    let wide = sheet(40, 0.25, |i, j| (16..24).contains(&i) && j < 8);
    assert!(strict(&wide, &quads).iter().any(|v| v.0 == Check::BoundaryCurve));
}

#[test]
fn a_quad_in_the_surface_is_not_flipped_whatever_lies_around() {
    // A step whose riser leans back over the tread below: it faces away from the mean of the two treads.
    let profile =
        [(0.0, 0.0), (0.5, 0.0), (1.0, 0.0), (1.5, 0.0), (2.0, 0.0), (1.965, 0.2), (2.5, 0.2), (3.0, 0.2), (4.0, 0.2)];
    let n = profile.len() as u32;
    let positions = (0..5 * n).map(|v| {
        let (x, z) = profile[(v % n) as usize];
        dvec3(x, 0.5 * f64::from(v / n), z)
    });
    let corners = (0..4).flat_map(|j| (0..n - 1).map(move |i| [i, i + 1].map(|i| [j * n + i, (j + 1) * n + i])));
    let faces = corners.flat_map(|[[a, d], [b, c]]| [[a, b, c], [a, c, d]]).collect();
    let mesh = TriMesh::try_new(positions.collect(), faces).unwrap();
    let step = Surface { mesh, features: Features::default() };
    let good = split(&step.mesh);
    assert_eq!(strict(&step, &good), []);
}

#[test]
fn at_a_kept_feature_quads_may_meet_at_any_angle() {
    // A roof of 90 degrees, and quads that meet at 24 degrees at its ridge, each within 35 degrees of its own side.
    let roof = |n: i32, cell: f64, features: bool| {
        let at = |i: i32, j: i32| (j * (2 * n + 1) + i + n) as u32;
        let cells: Vec<(i32, i32)> = (0..2 * n).flat_map(|j| (-n..n).map(move |i| (i, j))).collect();
        let position = |v: i32| {
            let x = cell * f64::from(v % (2 * n + 1) - n);
            dvec3(x, cell * f64::from(v / (2 * n + 1)), -x.abs())
        };
        let positions: Vec<DVec3> = (0..(2 * n + 1) * (2 * n + 1)).map(position).collect();
        let quads: Vec<[u32; 4]> =
            cells.iter().map(|&(i, j)| [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]).collect();
        let faces = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
        let edges = if features { (0..2 * n).map(|j| [at(0, j), at(0, j + 1)]).collect() } else { Vec::new() };
        let features = Features { edges, corners: Vec::new() };
        let mesh = TriMesh::try_new(positions.clone(), faces).unwrap();
        (Surface { mesh, features }, QuadMesh { positions, quads })
    };
    let (_, mut quads) = roof(3, 1.0, true);
    for p in quads.positions.iter_mut().filter(|p| p.x.abs() == 1.0 && p.y > 0.0 && p.y < 6.0) {
        *p = dvec3(0.25 * p.x, p.y, 1.2 * p.z);
    }
    assert_eq!(strict(&roof(6, 0.5, true).0, &quads), []);
    // Where the ridge is no feature they lie on each other.
    assert_eq!(strict(&roof(6, 0.5, false).0, &quads), [(Check::Flipped, 4)]);
}
