//! The modified Laplacian against the formulas of the paper, case by case.

use glam::{DVec2, DVec3};

use crate::engine::field::Frames;
use crate::engine::mesh::{TriMesh, next};
use crate::engine::methods::harmonic::continuity::{Charts, Hold, ModifiedLaplacian, half_cotangents};
use crate::engine::numerics::Random;
use crate::engine::parameterize::rotate;

const N: u32 = 6;
const TAU: DVec2 = DVec2::new(3.0, -5.0);

/// A square of N × N cells, a little uneven.
fn square() -> TriMesh {
    let mut random = Random::new(5);
    let mut p = Vec::new();
    for y in 0..=N {
        for x in 0..=N {
            let inner = x % N != 0 && y % N != 0;
            let by = if inner { 0.3 } else { 0.0 };
            let jitter = DVec3::new(random.unit() - 0.5, random.unit() - 0.5, 0.0) * by;
            p.push(DVec3::new(f64::from(x), f64::from(y), 0.0) + jitter);
        }
    }
    let v = |x: u32, y: u32| y * (N + 1) + x;
    let cell = |i: u32| (i % N, i / N);
    let faces = (0..N * N).map(cell).flat_map(|(x, y)| {
        let [a, b, c, d] = [v(x, y), v(x + 1, y), v(x + 1, y + 1), v(x, y + 1)];
        [[a, b, c], [a, c, d]]
    });
    TriMesh::try_new(p, faces.collect()).unwrap()
}

/// Transitions of a path from vertex to vertex, `z_left = i^m z_right + τ`.
fn cut_along(mesh: &TriMesh, path: &[u32], m: u8, tau: DVec2) -> (Vec<u8>, Vec<DVec2>) {
    let (mut rotation, mut translation) = (vec![0; mesh.n_halfedges()], vec![DVec2::ZERO; mesh.n_halfedges()]);
    for ends in path.windows(2) {
        let h = mesh.fan(ends[0]).find(|&h| mesh.target(h) == ends[1]).unwrap();
        let (t, back) = (mesh.twin(h).unwrap(), (4 - m) & 3);
        (rotation[h], translation[h]) = (m, tau);
        (rotation[t], translation[t]) = (back, -rotate(tau, back));
    }
    (rotation, translation)
}

/// Straight up at this x, from boundary to boundary.
fn upwards(x: u32) -> Vec<u32> {
    (0..=N).map(|y| y * (N + 1) + x).collect()
}

/// Whether the face lies to the left of the line up at x = 3: decided by cells, not by places.
fn is_left(f: usize) -> bool {
    (f as u32 / 2) % N < 3
}

#[test]
fn every_case_of_continuity_gives_the_rows_of_the_paper() {
    let mesh = square();
    let frames = Frames::new(&mesh);
    let weight = half_cotangents(&mesh, &frames);
    for m in 0..4u8 {
        let (rotation, translation) = cut_along(&mesh, &upwards(3), m, TAU);
        let laplacian =
            ModifiedLaplacian::new(&mesh, &frames, &Charts { rotation: &rotation, translation: &translation });
        let (entries, right) = laplacian.rows();
        let mut random = Random::new(u64::from(m));
        let x: Vec<DVec2> = (0..mesh.n_vertices()).map(|_| DVec2::new(random.unit(), random.unit())).collect();
        let corner: Vec<DVec2> =
            (0..mesh.n_halfedges()).map(|c| laplacian.at_corner(c, x[mesh.origin(c) as usize])).collect();
        for y in 1..N {
            let i = y * (N + 1) + 3;
            let mut row = [-right[2 * i as usize], -right[2 * i as usize + 1]];
            for &(r, c, value) in &entries {
                if r / 2 == i {
                    row[(r % 2) as usize] += value * x[c as usize / 2][c as usize % 2];
                }
            }
            // The side of the first corner is the paper's minus, and z− = i^k z+ + c.
            let root = mesh.outgoing(i);
            let minus_is_left = is_left(root / 3);
            let (k, c) = match minus_is_left {
                true => (m, TAU),
                false => ((4 - m) & 3, -rotate(TAU, (4 - m) & 3)),
            };
            let own = x[i as usize];
            let mut paper = DVec2::ZERO;
            for h in mesh.fan(i) {
                let p = crate::engine::mesh::prev(h);
                for (edge, other) in [(h, next(h)), (p, p)] {
                    let (w, j) = (weight[edge], corner[other]);
                    paper += w * match (is_left(h / 3) == minus_is_left, k) {
                        // Free, and regular with P = c: the plus side adds w (u_i − P − u_j).
                        (true, _) => own - j,
                        (false, 0) => own - j - c,
                        // Reverse: w (u_i + u_j − Q1), w (v_i + v_j − Q2).
                        (false, 2) => own + j - c,
                        // Switch, with R2 = c.x and R1 = c.y: w (u_i + v_j − R2), w (v_i − u_j − R1).
                        (false, 1) => DVec2::new(own.x + j.y - c.x, own.y - j.x - c.y),
                        // Reverse switch: u− = v+ + c.x, v− = −u+ + c.y.
                        _ => DVec2::new(own.x - j.y - c.x, own.y + j.x - c.y),
                    };
                }
            }
            assert!((DVec2::from(row) - paper).length() < 1e-12, "m = {m}, vertex {i}: {row:?} {paper}");
        }
    }
}

#[test]
fn the_matrix_is_symmetric_and_seams_close() {
    let mesh = square();
    let frames = Frames::new(&mesh);
    let (rotation, translation) = cut_along(&mesh, &upwards(3), 1, TAU);
    let charts = Charts { rotation: &rotation, translation: &translation };
    let laplacian = ModifiedLaplacian::new(&mesh, &frames, &charts);
    let n = 2 * mesh.n_vertices();
    let mut dense = vec![0.0; n * n];
    for (r, c, value) in laplacian.rows().0 {
        dense[r as usize * n + c as usize] += value;
    }
    for r in 0..n {
        for c in 0..r {
            assert!((dense[r * n + c] - dense[c * n + r]).abs() < 1e-13);
        }
    }
    let holds = [Hold { corner: 0, value: [Some(0.0), Some(0.0)] }];
    let uv = laplacian.solve(&holds).unwrap();
    for h in (0..mesh.n_halfedges()).filter(|&h| mesh.twin(h).is_some()) {
        let t = mesh.twin(h).unwrap();
        let expected = rotate(uv[next(t)], rotation[h]) + translation[h];
        assert!((uv[h] - expected).length() < 1e-9);
    }
}

#[test]
fn isolines_stay_where_a_meta_edge_moves_within_its_homotopy_class() {
    let mesh = square();
    let frames = Frames::new(&mesh);
    // Both paths begin and end at the same vertices; the second one bulges to the left.
    let straight = upwards(3);
    let bulge: Vec<u32> = {
        let v = |x: u32, y: u32| y * (N + 1) + x;
        vec![v(3, 0), v(3, 1), v(2, 1), v(2, 2), v(1, 2), v(1, 3), v(1, 4), v(2, 4), v(2, 5), v(3, 5), v(3, 6)]
    };
    let corners = [0, N, N * (N + 1), N * (N + 1) + N];
    for m in 0..4u8 {
        let solve = |path: &[u32]| {
            let (rotation, translation) = cut_along(&mesh, path, m, TAU);
            let charts = Charts { rotation: &rotation, translation: &translation };
            let holds: Vec<Hold> = corners
                .iter()
                .map(|&v| {
                    // What is held is the same point, as the left or the right chart sees it.
                    let p = mesh.position(v);
                    let left = DVec2::new(p.x + 0.3 * p.y, p.y);
                    let z = if p.x < 3.0 { left } else { rotate(left - TAU, (4 - m) & 3) };
                    Hold { corner: mesh.outgoing(v), value: [Some(z.x), Some(z.y)] }
                })
                .collect();
            ModifiedLaplacian::new(&mesh, &frames, &charts).solve(&holds).unwrap()
        };
        let (a, b) = (solve(&straight), solve(&bulge));
        let mut changed = 0;
        for c in 0..mesh.n_halfedges() {
            let same = (a[c] - b[c]).length() < 1e-9;
            // Between the two paths the left chart has become the right one.
            let moved = (a[c] - rotate(b[c], m) - TAU).length() < 1e-9;
            assert!(same || moved, "m = {m}, corner {c}: {} {}", a[c], b[c]);
            changed += usize::from(!same);
        }
        assert!(changed > 0);
    }
}
