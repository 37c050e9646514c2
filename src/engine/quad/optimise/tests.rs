use glam::DVec3;

use crate::engine::mesh::Features;
use crate::engine::mesh::Surface;
use crate::engine::mesh::SurfaceIndex;
use crate::engine::mesh::TriMesh;
use crate::engine::mesh::shapes::sample_surface;
use crate::engine::quad::Anchor;
use crate::engine::quad::OptimiseOptions;
use crate::engine::quad::QuadDraft;
use crate::engine::quad::QuadMesh;
use crate::engine::quad::optimise;
use crate::engine::quad::optimise::incidence::counted_edges;
use crate::engine::quad::optimise::shape::corner_jacobians;
use crate::engine::quad::optimise::shape::quality;
use crate::engine::run::RunContext;
use crate::engine::run::StopReason;

/// The unit square as n × n × 2 triangles, with its four corners.
pub(super) fn square(n: usize) -> Surface {
    let at = |i: usize, j: usize| (i * (n + 1) + j) as u32;
    let spot = |k: usize| DVec3::new((k / (n + 1)) as f64, (k % (n + 1)) as f64, 0.0) / n as f64;
    let positions = (0..(n + 1) * (n + 1)).map(spot).collect();
    let mut faces = Vec::new();
    for (i, j) in (0..n * n).map(|k| (k / n, k % n)) {
        faces.push([at(i, j), at(i + 1, j), at(i + 1, j + 1)]);
        faces.push([at(i, j), at(i + 1, j + 1), at(i, j + 1)]);
    }
    let mut corners = vec![at(0, 0), at(0, n), at(n, 0), at(n, n)];
    corners.sort_unstable();
    Surface { mesh: TriMesh::try_new(positions, faces).unwrap(), features: Features { edges: vec![], corners } }
}

/// m × m quads over the unit square.
pub(super) fn grid(surface: &Surface, m: usize) -> QuadDraft {
    let at = |i: usize, j: usize| (i * (m + 1) + j) as u32;
    let spot = |k: usize| DVec3::new((k / (m + 1)) as f64, (k % (m + 1)) as f64, 0.0) / m as f64;
    let positions: Vec<DVec3> = (0..(m + 1) * (m + 1)).map(spot).collect();
    let quads = (0..m * m).map(|k| (k / m, k % m));
    let quads = quads.map(|(i, j)| [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]).collect();
    anchored(surface, QuadMesh { positions, quads })
}

/// Anchors from coordinates: corners where the surface has one, curves on feature edges and on the boundary.
pub(super) fn anchored(surface: &Surface, mesh: QuadMesh) -> QuadDraft {
    let corner = |p: DVec3| {
        let mut corners = surface.features.corners.iter();
        corners.find(|&&c| surface.mesh.position(c).distance(p) < 1e-9).copied()
    };
    let edges = counted_edges(&mesh.quads);
    let on_feature = |p: DVec3| surface.features.edges.iter().any(|&e| off_segment(surface, e, p) < 1e-9);
    let feature_edges: Vec<[u32; 2]> = (edges.iter())
        .map(|e| e.0)
        .filter(|e| on_feature(mesh.positions[e[0] as usize].midpoint(mesh.positions[e[1] as usize])))
        .collect();
    let mut on_curve = vec![false; mesh.positions.len()];
    let boundary = edges.iter().filter(|e| e.1 == 1).map(|e| &e.0);
    boundary.chain(&feature_edges).flatten().for_each(|&v| on_curve[v as usize] = true);
    let anchor = |v: usize| match corner(mesh.positions[v]) {
        Some(c) => Anchor::Corner(c),
        None if on_curve[v] => Anchor::Curve,
        None => Anchor::Surface,
    };
    QuadDraft { anchors: (0..mesh.positions.len()).map(anchor).collect(), mesh, feature_edges }
}

pub(super) fn off_segment(surface: &Surface, [a, b]: [u32; 2], p: DVec3) -> f64 {
    let (a, b) = (surface.mesh.position(a), surface.mesh.position(b));
    crate::engine::mesh::closest_on_segment(p, a, b).1.distance(p)
}

/// The surface of the cube [-1, 1]³ as 6 m² quads, welded, put through `place`.
pub(super) fn cube_grid(m: usize, place: impl Fn(DVec3) -> DVec3) -> QuadMesh {
    let mut keys: Vec<[i64; 3]> = Vec::new();
    let mut corners: Vec<[[i64; 3]; 4]> = Vec::new();
    let n = m as i64;
    for axis in 0..3 {
        for side in [-n, n] {
            for (i, j) in (0..m * m).map(|k| (2 * (k / m) as i64 - n, 2 * (k % m) as i64 - n)) {
                let corner = |di: i64, dj: i64| {
                    let mut p = [0; 3];
                    p[axis] = side;
                    p[(axis + 1) % 3] = i + 2 * di;
                    p[(axis + 2) % 3] = j + 2 * dj;
                    p
                };
                let mut quad = [corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)];
                if side < 0 {
                    quad.reverse();
                }
                corners.push(quad);
            }
        }
    }
    keys.extend(corners.iter().flatten());
    keys.sort_unstable();
    keys.dedup();
    let number = |k: [i64; 3]| keys.binary_search(&k).unwrap() as u32;
    let point = |k: &[i64; 3]| DVec3::from_array(k.map(|x| x as f64)) / m as f64;
    QuadMesh {
        quads: corners.iter().map(|q| q.map(number)).collect(),
        positions: keys.iter().map(|k| place(point(k))).collect(),
    }
}

/// A sequence of displacements in the cube [-1, 1]³.
pub(super) fn noise(n: usize) -> Vec<DVec3> {
    let mut state = 0x2545_f491_4f6c_dd1du64;
    let mut next = || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    };
    (0..n).map(|_| DVec3::new(next(), next(), next())).collect()
}

fn options(iterations: usize, edge_length: f64) -> OptimiseOptions {
    OptimiseOptions { iterations, edge_length, log_size: Vec::new(), strokes: Vec::new(), held: Vec::new() }
}

pub(super) fn run(surface: &Surface, draft: QuadDraft, edge_length: f64) -> QuadDraft {
    let index = SurfaceIndex::new(&surface.mesh);
    let options = options(20, edge_length);
    super::optimise(&RunContext::silent(), surface, &index, draft, &options).unwrap()
}

pub(super) fn corners_of(draft: &QuadDraft, q: usize) -> [DVec3; 4] {
    draft.mesh.quads[q].map(|v| draft.mesh.positions[v as usize])
}

pub(super) fn worst_of(draft: &QuadDraft, up: impl Fn(DVec3) -> DVec3) -> f64 {
    let all = (0..draft.mesh.quads.len()).map(|q| corners_of(draft, q));
    all.map(|p| quality(&p, up(0.25 * (p[0] + p[1] + p[2] + p[3])))).fold(f64::INFINITY, f64::min)
}

#[test]
fn a_shaken_grid_on_a_square_returns_to_squares() {
    let surface = square(23);
    let m = 12;
    let even = grid(&surface, m);
    let mut draft = even.clone();
    for (v, shift) in noise(draft.anchors.len()).into_iter().enumerate() {
        if draft.anchors[v] == Anchor::Surface {
            draft.mesh.positions[v] += 0.35 / m as f64 * shift.with_z(0.0);
        }
    }
    let result = run(&surface, draft, 1.0 / m as f64);
    assert_eq!(result.mesh.quads, even.mesh.quads);
    for (p, q) in result.mesh.positions.iter().zip(&even.mesh.positions) {
        assert!(p.distance(*q) < 0.02 / m as f64, "{p} {q}");
    }
}

#[test]
fn held_vertices_stay_and_the_others_come_after_them() {
    let surface = square(23);
    let m = 12;
    let mut draft = grid(&surface, m);
    let middle = (m / 2) * (m + 1) + m / 2;
    draft.mesh.positions[middle] += DVec3::new(0.5, 0.2, 0.0) / m as f64;
    let mut held = vec![false; draft.anchors.len()];
    held[middle] = true;
    let index = SurfaceIndex::new(&surface.mesh);
    let options = OptimiseOptions { held, ..options(20, 1.0 / m as f64) };
    let result = super::optimise(&RunContext::silent(), &surface, &index, draft.clone(), &options).unwrap();
    assert_eq!(result.mesh.positions[middle], draft.mesh.positions[middle]);
    assert!(worst_of(&result, |_| DVec3::Z) > worst_of(&draft, |_| DVec3::Z) + 0.05);
}

#[test]
fn folded_quads_are_untangled() {
    let surface = square(23);
    let m = 12;
    let mut draft = grid(&surface, m);
    let at = |i: usize, j: usize| i * (m + 1) + j;
    draft.mesh.positions.swap(at(3, 3), at(4, 4));
    draft.mesh.positions.swap(at(8, 3), at(9, 3));
    let shifts = noise(25);
    for k in 0..25 {
        draft.mesh.positions[at(6 + k / 5, 6 + k % 5)] += 1.5 / m as f64 * shifts[k].with_z(0.0);
    }
    assert!(worst_of(&draft, |_| DVec3::Z) < -0.9);
    let result = run(&surface, draft, 1.0 / m as f64);
    assert!(worst_of(&result, |_| DVec3::Z) > 0.9, "{}", worst_of(&result, |_| DVec3::Z));
}

#[test]
fn quads_of_a_sphere_stay_on_it_and_become_even() {
    let surface = sample_surface("sphere", 6000).unwrap();
    let m = 8;
    let mut mesh = cube_grid(m, DVec3::normalize);
    for (p, shift) in mesh.positions.iter_mut().zip(noise(1000)) {
        *p = (*p + 0.08 * shift).normalize();
    }
    let draft = anchored(&surface, mesh);
    let result = run(&surface, draft, (4.0 * std::f64::consts::PI / (6 * m * m) as f64).sqrt());
    let index = SurfaceIndex::new(&surface.mesh);
    assert!(result.mesh.positions.iter().all(|&p| index.closest(p).distance < 1e-14));
    let all = (0..result.mesh.quads.len()).map(|q| corners_of(&result, q));
    let jacobians: Vec<f64> = all.flat_map(|p| corner_jacobians(&p, p[0].normalize())).collect();
    // Cube corners have valence 3, so 120 degrees and a scaled Jacobian of 0.87 at best.
    assert!(worst_of(&result, DVec3::normalize) > 0.75);
    assert!(jacobians.iter().sum::<f64>() / jacobians.len() as f64 > 0.96);
}

#[test]
fn any_number_of_threads_gives_the_same_bits() {
    let surface = sample_surface("genus2", 1500).unwrap();
    let mut mesh = QuadMesh { positions: surface.mesh.positions().to_vec(), quads: Vec::new() };
    // A rough draft: each triangle split into three quads.
    let edges = {
        let side = |h: usize| [surface.mesh.origin(h), surface.mesh.target(h)];
        let mut edges: Vec<[u32; 2]> = (0..surface.mesh.n_halfedges()).map(side).filter(|e| e[0] < e[1]).collect();
        edges.sort_unstable();
        edges
    };
    for [a, b] in &edges {
        mesh.positions.push(surface.mesh.position(*a).midpoint(surface.mesh.position(*b)));
    }
    let middle =
        |a: u32, b: u32| (surface.mesh.n_vertices() + edges.binary_search(&[a.min(b), a.max(b)]).unwrap()) as u32;
    for (f, &[a, b, c]) in surface.mesh.faces().iter().enumerate() {
        let centre = mesh.positions.len() as u32;
        mesh.positions.push(surface.mesh.triangle(f).into_iter().sum::<DVec3>() / 3.0);
        for [v, next, prev] in [[a, b, c], [b, c, a], [c, a, b]] {
            mesh.quads.push([v, middle(v, next), centre, middle(v, prev)]);
        }
    }
    let draft = anchored(&surface, mesh);
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| run(&surface, draft.clone(), 0.08))
    };
    assert_eq!(with(1), with(2));
}

#[test]
fn what_does_not_fit_is_left_alone_and_a_stopped_run_stops() {
    let surface = square(2);
    let options = options(5, f64::NAN);
    let index = SurfaceIndex::new(&surface.mesh);
    let ctx = RunContext::silent();
    let good = grid(&surface, 2);
    let mut broken = vec![QuadDraft::default(); 1];
    broken.push(QuadDraft { anchors: vec![], ..good.clone() });
    broken.push(QuadDraft { anchors: vec![Anchor::Corner(99); 9], ..good.clone() });
    let mut out_of_range = good.clone();
    out_of_range.mesh.quads[0][0] = 77;
    broken.push(out_of_range);
    for draft in broken {
        assert_eq!(optimise(&ctx, &surface, &index, draft.clone(), &options), Ok(draft));
    }
    let flat = optimise(&ctx, &surface, &index, good.clone(), &options).unwrap();
    assert!(flat.mesh.positions.iter().zip(&good.mesh.positions).all(|(p, q)| p.distance(*q) < 1e-9));
    ctx.stop(StopReason::Client);
    assert!(optimise(&ctx, &surface, &index, good, &options).is_err());
}
