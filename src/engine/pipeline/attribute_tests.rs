//! What the input carries besides its shape, from the soup to the certified quads.

use glam::DVec3;

use crate::engine::attributes::Preserve;
use crate::engine::mesh::shapes::sample;
use crate::engine::mesh::{Influences, NONE, SurfaceIndex, TriMesh, TriangleSoup};
use crate::engine::numerics::Random;
use crate::engine::pipeline::{Outcome, RemeshSpec, Target, remesh};
use crate::engine::quad::QuadMesh;
use crate::engine::run::RunContext;

fn run(soup: &TriangleSoup, quads: u64, preserve: Preserve) -> Outcome {
    let spec = RemeshSpec { target: Target::Quads(quads), preserve, ..RemeshSpec::default() };
    let outcome = remesh(&RunContext::silent(), soup, &spec).unwrap();
    assert!(outcome.report.certified);
    outcome
}

fn linear(p: DVec3) -> [f32; 4] {
    [0.5 + 0.3 * p.x, 0.5 + 0.2 * p.y - 0.2 * p.z, 0.5 + 0.3 * p.z, 1.0].map(|c| c as f32)
}

/// Random points of the soup's triangles: the triangle's corners and their weights there, and the same of the quads, split
/// into triangles, at the nearest point.
fn random_points(soup: &TriangleSoup, quads: &QuadMesh, mut visit: impl FnMut(DVec3, [([u32; 3], [f64; 3]); 2])) {
    let faces: Vec<[u32; 3]> = quads.quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    let mesh = TriMesh::try_new(quads.positions.clone(), faces).unwrap();
    let (index, mut random) = (SurfaceIndex::new(&mesh), Random::new(1));
    for polygon in soup.polygons() {
        let (r, s) = (random.unit().sqrt(), random.unit());
        let weights = [1.0 - r, r * (1.0 - s), r * s];
        let corners = [polygon[0], polygon[1], polygon[2]];
        let p = (0..3).map(|k| weights[k] * soup.positions[corners[k] as usize]).sum();
        let at = index.closest(p);
        visit(p, [(corners, weights), (mesh.face(at.face as usize), at.barycentric)]);
    }
}

#[test]
fn colours_of_the_input_are_those_of_the_quads_at_the_same_place() {
    let mut soup = sample("torus", 3000, 0.0, 0).unwrap();
    soup.colours = soup.positions.iter().map(|&p| linear(p)).collect();
    let outcome = run(&soup, 800, Preserve::default());
    let (quads, colours) = (&outcome.quads, &outcome.attributes.colours);
    let (area, mut worst) = (4.0 * std::f64::consts::PI.powi(2) * 0.4, 0.0_f64);
    random_points(&soup, quads, |p, [_, (corners, weights)]| {
        for (k, expected) in linear(p).into_iter().enumerate() {
            let made: f64 = (0..3).map(|i| weights[i] * f64::from(colours[corners[i] as usize][k])).sum();
            worst = worst.max((made - f64::from(expected)).abs());
        }
    });
    // The colours change by 0.3 per unit of length, and the two surfaces are a small part of an edge apart.
    let edge = (area / 800.0).sqrt();
    assert!(worst < 0.3 * 0.25 * edge, "{worst} with edges of {edge}");
}

#[test]
fn weights_of_joints_are_those_of_the_quads_at_the_same_place() {
    let mut soup = sample("torus", 3000, 0.0, 0).unwrap();
    // Joints around the torus, and one more inside of each: every place hangs on four.
    let influences = |p: DVec3| {
        let at = (p.y.atan2(p.x) / std::f64::consts::TAU).rem_euclid(1.0) * 5.0;
        let (below, share) = (at.floor().min(4.0) as u16, at.fract());
        let (inner, next) = (0.5 - p.z, (below + 1) % 5);
        let ring = [(below, 1.0 - share), (next, share)];
        Influences::of(ring.into_iter().flat_map(|(j, w)| [(2 * j, inner * w), (2 * j + 1, (1.0 - inner) * w)]))
            .unwrap()
    };
    soup.skin = soup.positions.iter().map(|&p| influences(p)).collect();
    let outcome = run(&soup, 800, Preserve::default());
    let (quads, skin) = (&outcome.quads, &outcome.attributes.skin);
    assert_eq!(skin.len(), quads.positions.len());
    let (mut worst, mut mean, mut n) = (0.0_f64, 0.0, 0.0);
    let blend =
        |of: &[Influences], corners: [u32; 3], weights| Influences::blend(weights, corners.map(|v| of[v as usize]));
    random_points(&soup, quads, |_, [(of, at), (corners, weights)]| {
        let difference = blend(skin, corners, weights).difference(&blend(&soup.skin, of, at));
        worst = worst.max(difference);
        (mean, n) = (mean + difference, n + 1.0);
    });
    let slope = 5.0 / (std::f64::consts::TAU * 0.6);
    let edge = (4.0 * std::f64::consts::PI.powi(2) * 0.4 / 800.0).sqrt();
    // Quads blur the weights where a triangle of the input begins to hang on the next joint, by a part of an edge.
    assert!(worst < 0.5 * slope * edge && mean / n < 0.02, "{worst}, on average {} with edges of {edge}", mean / n);
}

#[test]
fn the_sides_of_two_cubes_keep_their_materials() {
    let one = sample("cube", 300, 0.0, 0).unwrap();
    let n = one.positions.len() as u32;
    let mut soup = one.clone();
    // The second cube stands close beside the first one.
    soup.positions.extend(one.positions.iter().map(|p| *p + 1.01 * DVec3::X));
    one.polygons().for_each(|p| soup.push_polygon(&[p[0] + n, p[1] + n, p[2] + n]));
    let extent = one.positions.iter().fold(0.0_f64, |e, p| e.max(p.abs().max_element()));
    let shift = |c: usize| 1.01 * c as f64 * DVec3::X;
    let side = |corners: &[DVec3]| {
        let centre = corners.iter().sum::<DVec3>() / corners.len() as f64;
        let axis = centre.abs().max_position();
        (2 * axis + usize::from(centre[axis] > 0.0)) as u32
    };
    let m = one.n_polygons();
    soup.materials = (0..soup.n_polygons())
        .map(|p| {
            let corners: Vec<_> = soup.polygon(p).iter().map(|&v| soup.positions[v as usize] - shift(p / m)).collect();
            6 * (p / m) as u32 + side(&corners)
        })
        .collect();
    soup.material_names = (0..12).map(|m| format!("m{m}")).collect();
    assert!((extent - 0.5).abs() < 1e-9, "the cubes are 0.01 apart");
    let outcome = run(&soup, 600, Preserve::default());
    let (quads, attributes) = (&outcome.quads, &outcome.attributes);
    assert_eq!(attributes.material_names, soup.material_names);
    let mut area = [0.0; 12];
    for (quad, &material) in quads.quads.iter().zip(&attributes.materials) {
        let [a, b, c, d] = quad.map(|v| quads.positions[v as usize]);
        let cube = usize::from(a.x + b.x + c.x + d.x > 4.0 * 0.505);
        assert_eq!(material, 6 * cube as u32 + side(&[a, b, c, d].map(|p| p - shift(cube))));
        area[material as usize] += 0.5 * (c - a).cross(d - b).length();
    }
    assert!(area.iter().all(|a| (a - 1.0).abs() < 1e-6), "{area:?}");
}

#[test]
fn quads_are_the_same_whatever_they_carry() {
    let plain = sample("sphere", 1000, 0.0, 0).unwrap();
    let mut painted = plain.clone();
    painted.colours = painted.positions.iter().map(|&p| linear(p)).collect();
    painted.uv = painted.indices.iter().map(|&v| [painted.positions[v as usize].x as f32, 0.5]).collect();
    let none = Preserve { materials: false, vertex_colours: false, uv: false, skin: false };
    let outcomes =
        [run(&plain, 300, Preserve::default()), run(&painted, 300, none), run(&painted, 300, Preserve::default())];
    assert!(outcomes[0].attributes.is_empty() && outcomes[1].attributes.is_empty());
    let carried = &outcomes[2].attributes;
    assert_eq!(
        (carried.colours.len(), carried.uv.len()),
        (outcomes[2].quads.positions.len(), outcomes[2].quads.quads.len())
    );
    for outcome in &outcomes[1..] {
        assert_eq!(outcome.quads, outcomes[0].quads);
    }
    // Without seams the coordinates of a vertex are the same in all its quads: what they are on the surface.
    let mut known = vec![[NONE as f32; 2]; outcomes[2].quads.positions.len()];
    for (quad, uv) in outcomes[2].quads.quads.iter().zip(&carried.uv) {
        for (&v, uv) in quad.iter().zip(uv) {
            let before = std::mem::replace(&mut known[v as usize], *uv);
            assert!(before[0] > 2.0 || (before[0] - uv[0]).abs() < 1e-3, "{before:?}, {uv:?}");
            assert!((f64::from(uv[0]) - outcomes[2].quads.positions[v as usize].x).abs() < 0.05);
            assert_eq!(uv[1], 0.5);
        }
    }
}
