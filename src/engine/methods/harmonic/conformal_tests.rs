//! Conformal meta-parameters against moduli that are known.

use crate::engine::mesh::shapes::sample_surface;
use crate::engine::methods::harmonic::tests::{problem, propose_with};
use crate::engine::methods::{Data, Harmonic, Method, Parameters, Value};

#[test]
fn the_extents_of_a_torus_are_in_the_ratio_of_its_modulus() {
    let surface = sample_surface("torus", 6000).unwrap();
    let radius = |p: &glam::DVec3| p.x.hypot(p.y);
    let [least, most] = [f64::INFINITY, 0.0].map(|start: f64| {
        surface.mesh.positions().iter().map(radius).fold(start, |a, b| if start > 1.0 { a.min(b) } else { a.max(b) })
    });
    let (large, small) = (0.5 * (most + least), 0.5 * (most - least));
    // ∫ ds / r along a meridian over 2π: a circle of radius b around one of radius a is conformal to a / √(a² − b²).
    let modulus = (large * large - small * small).sqrt() / small;
    let problem = problem(&surface, 3000.0);
    let ratio = |aim: &'static str| {
        let mut parameters = Parameters::default();
        assert!(parameters.set(Harmonic.parameters(), "aim", Value::Choice(aim)));
        let map = propose_with(&problem, &parameters).unwrap();
        assert_eq!(map.measures.flipped, 0);
        (map.measures.conformal_mean, extents(map.details.get("graph")))
    };
    let (conformal, sums) = ratio("conformal");
    let (lengths, _) = ratio("lengths");
    let found = sums[0].max(sums[1]) / sums[0].min(sums[1]);
    assert!((found / modulus - 1.0).abs() < 0.03, "{found} {modulus}");
    assert!(conformal <= lengths + 1e-9 && conformal < 2.01, "{conformal} {lengths}");
}

/// Sums of du and of dv over all meta-edges.
fn extents(graph: &Data) -> [f64; 2] {
    ["du", "dv"].map(|d| graph.get("edges").list().iter().filter_map(|edge| edge.get(d).number()).sum())
}
