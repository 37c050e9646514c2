//! The identities of the calculus.

use crate::engine::calculus::{OneForm, Periods, Side, Signs, Stars, dual_basis, harmonic_basis};
use crate::engine::mesh::TriMesh;
use crate::engine::mesh::shapes::sample_surface;
use crate::engine::numerics::{Random, cholesky_lower};
use crate::engine::run::RunContext;

fn sample(name: &str, triangles: usize) -> TriMesh {
    sample_surface(name, triangles).unwrap().mesh
}

/// The mesh without the fans of vertices that share no neighbours.
fn with_holes(mesh: &TriMesh, holes: usize) -> TriMesh {
    let mut gone = vec![false; mesh.n_faces()];
    let mut is_near = vec![false; mesh.n_vertices()];
    let mut n = 0;
    for v in 0..mesh.n_vertices() as u32 {
        let ring: Vec<u32> = mesh.fan(v).map(|h| mesh.target(h)).collect();
        if n == holes || is_near[v as usize] || ring.iter().any(|&w| is_near[w as usize]) {
            continue;
        }
        n += 1;
        mesh.fan(v).for_each(|h| gone[h / 3] = true);
        ring.iter().flat_map(|&w| mesh.fan(w)).for_each(|h| is_near[mesh.target(h) as usize] = true);
    }
    assert_eq!(n, holes);
    let faces: Vec<[u32; 3]> = (0..mesh.n_faces()).filter(|&f| !gone[f]).map(|f| mesh.face(f)).collect();
    let mut new = vec![u32::MAX; mesh.n_vertices()];
    let mut positions = Vec::new();
    let faces = faces.iter().map(|face| {
        face.map(|v| {
            if new[v as usize] == u32::MAX {
                new[v as usize] = positions.len() as u32;
                positions.push(mesh.position(v));
            }
            new[v as usize]
        })
    });
    let faces = faces.collect();
    TriMesh::try_new(positions, faces).unwrap()
}

fn largest(values: impl IntoIterator<Item = f64>) -> f64 {
    values.into_iter().map(f64::abs).fold(0.0, f64::max)
}

#[test]
fn differentials_of_differentials_vanish_with_any_signs() {
    let mesh = sample("genus2", 1500);
    let mut random = Random::new(3);
    let mut signs = Signs::trivial(&mesh);
    // Sheets exchanged over random faces: still trivial. Then along a path: two branch points.
    (0..mesh.n_faces())
        .filter(|_| random.below(2) == 1)
        .collect::<Vec<_>>()
        .iter()
        .for_each(|&f| signs.exchange(&mesh, f));
    assert!(signs.branch_points(&mesh).is_empty() && signs.trivialisation(&mesh).is_some());
    let h = mesh.outgoing(17);
    signs.turn(&mesh, h);
    let mut ends = vec![17, mesh.target(h)];
    ends.sort_unstable();
    assert_eq!(signs.branch_points(&mesh), ends);
    assert!(signs.trivialisation(&mesh).is_none());
    let mut function: Vec<f64> = (0..mesh.n_vertices()).map(|_| random.below(1000) as f64).collect();
    ends.iter().for_each(|&v| function[v as usize] = 0.0);
    let form = OneForm::differential(&mesh, &signs.corners(&mesh), &function);
    assert_eq!(form.mismatch(&mesh, &signs), 0.0);
    assert_eq!(largest(form.curl()), 0.0);
    assert!(form.mismatch(&mesh, &Signs::trivial(&mesh)) > 1.0, "the signs are felt");
}

#[test]
fn bases_have_the_right_dimension_and_are_closed_coclosed_and_dual() {
    let closed = [("sphere", 0), ("torus", 1), ("genus2", 2), ("genus5", 5)];
    for (name, genus) in closed {
        for holes in [0, 1, 3] {
            let mesh = with_holes(&sample(name, 2500), holes);
            let stars = Stars::new(&mesh);
            for side in [Side::Tangential, Side::Normal] {
                let basis = harmonic_basis(&RunContext::silent(), &mesh, &stars, side, 0).unwrap();
                assert_eq!(basis.forms.len(), 2 * genus + (holes.max(1) - 1), "{name} {holes} {side:?}");
                let ones = vec![1.0; mesh.n_halfedges()];
                for (j, form) in basis.forms.iter().enumerate() {
                    assert_eq!(form.mismatch(&mesh, &Signs::trivial(&mesh)), 0.0);
                    assert!(largest(form.curl()) < 1e-10, "{name} {holes}");
                    let flow = stars.divergence(&mesh, &ones, form);
                    let is_free = |v: &usize| side == Side::Tangential || !mesh.is_boundary_vertex(*v as u32);
                    assert!(
                        largest((0..flow.len()).filter(is_free).map(|v| flow[v])) < 1e-10,
                        "{name} {holes} {side:?}"
                    );
                    if side == Side::Normal {
                        let edges = (0..mesh.n_halfedges()).filter(|&h| mesh.is_boundary(h));
                        assert!(largest(edges.map(|h| form.along[h])) < 1e-12);
                    }
                    for (i, generator) in basis.generators.iter().enumerate() {
                        let expected = f64::from(u8::from(i == j));
                        assert!((form.integral(&generator.chain) - expected).abs() < 1e-9, "{name} {i} {j}");
                    }
                }
            }
        }
    }
}

#[test]
fn chains_are_closed_or_lead_from_boundary_to_boundary() {
    let mesh = with_holes(&sample("torus", 2000), 3);
    let stars = Stars::new(&mesh);
    for (side, open) in [(Side::Tangential, 0), (Side::Normal, 2)] {
        let basis = harmonic_basis(&RunContext::silent(), &mesh, &stars, side, 5).unwrap();
        let mut n_open = 0;
        for generator in &basis.generators {
            let chain = &generator.chain;
            assert!(chain.windows(2).all(|pair| pair[0].to(&mesh) == pair[1].from(&mesh)));
            let (first, last) = (chain[0].from(&mesh), chain[chain.len() - 1].to(&mesh));
            if first != last {
                n_open += 1;
                assert!(mesh.is_boundary_vertex(first) && mesh.is_boundary_vertex(last));
            }
        }
        assert!(n_open >= open, "{side:?} {n_open}");
    }
}

#[test]
fn energies_are_positive_and_riemann_s_relations_hold() {
    for name in ["torus", "genus2", "genus5"] {
        let mut errors = Vec::new();
        for triangles in [2000, 8000] {
            let mesh = sample(name, triangles);
            let stars = Stars::new(&mesh);
            let forms = harmonic_basis(&RunContext::silent(), &mesh, &stars, Side::Tangential, 0).unwrap().forms;
            let periods = Periods::new(&stars, &forms);
            let n = periods.n;
            let symmetric =
                |m: &[f64], sign: f64, n: usize| largest((0..n * n).map(|k| m[k] - sign * m[(k % n) * n + k / n]));
            assert!(symmetric(&periods.energy, 1.0, n) < 1e-9);
            assert!(cholesky_lower(n, &periods.energy).is_some());
            assert!(symmetric(&periods.intersection, -1.0, n) < 1e-9);
            assert!(largest(periods.intersection.iter().map(|x| x - x.round())) < 1e-8, "intersections are integers");
            let s = periods.conjugation().unwrap();
            let square = |k: usize| (0..n).map(|m| s[(k / n) * n + m] * s[m * n + k % n]).sum::<f64>();
            let star = largest((0..n * n).map(|k| square(k) + f64::from(u8::from(k / n == k % n))));
            let (real, imaginary) = periods.riemann().unwrap();
            let g = n / 2;
            assert!(cholesky_lower(g, &imaginary).is_some());
            assert!(symmetric(&imaginary, 1.0, g) < 1e-9);
            errors.push(star + symmetric(&real, 1.0, g));
        }
        assert!(errors[1] < 0.5 * errors[0] && errors[1] < 0.1, "{name} {errors:?}");
    }
}

#[test]
fn the_modulus_of_a_torus_converges_with_the_square_of_the_edges() {
    // A torus of revolution of radii R and r is conformal to a rectangle of sides in proportion √(R² − r²) : r.
    let exact = (1.0_f64 - 0.16).sqrt() / 0.4;
    let error = |triangles: usize| {
        let mesh = sample("torus", triangles);
        let stars = Stars::new(&mesh);
        let forms = harmonic_basis(&RunContext::silent(), &mesh, &stars, Side::Tangential, 0).unwrap().forms;
        let (real, imaginary) = Periods::new(&stars, &forms).riemann().unwrap();
        // Up to a change of basis: reduced to the fundamental domain of the modular group.
        let (mut x, mut y) = (real[0], imaginary[0]);
        for _ in 0..50 {
            x -= x.round();
            let square = x * x + y * y;
            if square >= 1.0 - 1e-9 {
                break;
            }
            (x, y) = (-x / square, y / square);
        }
        assert!(x.abs() < 1e-2, "{x}");
        ((y - exact).abs(), mesh.n_faces() as f64)
    };
    let (coarse, fine) = (error(2000), error(8000));
    let order = 2.0 * (coarse.0 / fine.0).ln() / (fine.1 / coarse.1).ln();
    assert!(order > 1.7 && fine.0 < 0.01, "{coarse:?} {fine:?} {order}");
}

#[test]
fn forms_dual_to_other_chains_are_found() {
    let mesh = sample("genus2", 2000);
    let stars = Stars::new(&mesh);
    let ctx = RunContext::silent();
    let basis = harmonic_basis(&ctx, &mesh, &stars, Side::Tangential, 0).unwrap();
    let far = mesh.n_vertices() as u32 / 2;
    let others = harmonic_basis(&ctx, &mesh, &stars, Side::Tangential, far).unwrap();
    let chains: Vec<_> = others.generators.into_iter().map(|g| g.chain).collect();
    let dual = dual_basis(&basis.forms, &chains).unwrap();
    // A harmonic form is determined by its periods.
    for (a, b) in dual.iter().zip(&others.forms) {
        assert!(largest(a.along.iter().zip(&b.along).map(|(x, y)| x - y)) < 1e-9);
    }
    assert!(dual_basis(&basis.forms, &vec![chains[0].clone(); 4]).is_none());
}
