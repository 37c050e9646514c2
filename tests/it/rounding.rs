//! What roundings of a map's integers cost, measured as `cargo bench -- rounding` does.

#[path = "../bench/ways.rs"]
mod ways;

use quadrille::engine::mesh::shapes::sample_surface;
use quadrille::engine::methods::quad_cover::{QuadCoverOptions, prepare};
use quadrille::engine::numerics::Random;
use quadrille::engine::parameterize::MapSystem;
use quadrille::engine::run::RunContext;
use ways::{Candidate, Form, found, means};

fn system(name: &str, quads: f64) -> (MapSystem, f64) {
    let surface = sample_surface(name, 2000).expect("a sample");
    let edge_length = (surface.mesh.total_area() / quads).sqrt();
    let options = QuadCoverOptions {
        edge_length,
        log_size: Vec::new(),
        quads: None,
        smoothing: 0.5,
        guided: true,
        branch_points: None,
        field: None,
        strokes: Vec::new(),
        boundary_free: false,
    };
    (prepare(&RunContext::silent(), &surface, &options).expect(name).system, 1.0 / edge_length)
}

/// The trace of the period matrix predicts direct rounding, and what it leaves of the reduced one the search.
#[test]
fn rounding_costs_what_the_period_matrix_predicts() {
    for name in ["genus2", "dumbbell", "gear", "noisy_blob", "ellipsoid"] {
        let (system, scale) = system(name, 300.0);
        let means = means(&system, 0, 60).unwrap();
        let is_near = |found: f64, predicted: f64| (found / predicted - 1.0).abs() < 0.25;
        assert!(is_near(means.direct, means.predicted_direct), "{name}: {means:?}");
        assert!(is_near(means.search, means.predicted_search), "{name}: {means:?}");
        let [one, two, three] = means.r_search;
        assert!(means.search <= three && three <= two && two <= one && one <= means.direct, "{name}: {means:?}");
        assert!(means.search <= means.greedy, "{name}: {means:?}");
        let own = found(&system, &system.period_form().unwrap(), scale).unwrap();
        assert!(own >= 0.0 && own < 3.0 * means.direct / (scale * scale), "{name}: {own} {means:?}");
    }
}

#[test]
fn wider_searches_are_never_worse_than_narrower_ones_or_direct_rounding() {
    let n = 40;
    for seed in 0..12 {
        let mut random = Random::new(seed);
        let b: Vec<f64> = (0..n * n).map(|_| random.unit() - 0.5).collect();
        let entry = |i: usize, j: usize| (0..n).map(|k| b[k * n + i] * b[k * n + j]).sum::<f64>();
        let rows = (0..n * n).map(|k| entry(k / n, k % n) + if k / n == k % n { 0.05 } else { 0.0 }).collect();
        let form = Form { n, rows };
        let target: Vec<f64> = (0..n).map(|_| 7.0 * random.unit()).collect();
        let energy = |q: &[f64]| form.value(&q.iter().zip(&target).map(|(q, t)| q - t).collect::<Vec<_>>());
        let mut candidate = Candidate::new(&form, &target, target.iter().map(|t| t.round()).collect());
        let mut last = candidate.energy;
        for r in 1..=3 {
            candidate.search(r);
            assert!(candidate.energy <= last);
            assert!((candidate.energy - energy(&candidate.q)).abs() < 1e-9);
            last = candidate.energy;
        }
        // No single or double change of the result is better.
        for i in 0..n {
            for j in 0..n {
                for (s, t) in [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)] {
                    let mut q = candidate.q.clone();
                    q[i] += s;
                    q[j] += t;
                    assert!(energy(&q) > last - 1e-9);
                }
            }
        }
    }
}
