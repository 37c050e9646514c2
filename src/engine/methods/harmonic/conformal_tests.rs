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
    let mut parameters = Parameters::default();
    assert!(parameters.set(Harmonic.parameters(), "aim", Value::Choice("conformal")));
    let map = propose_with(&problem, &parameters).unwrap();
    let sums = extents(map.details.get("graph"));
    let found = sums[0].max(sums[1]) / sums[0].min(sums[1]);
    assert!((found / modulus - 1.0).abs() < 0.03, "{found} {modulus}");
    assert!(map.measures.flipped == 0 && map.measures.conformal_mean < 2.005, "{:?}", map.measures);
}

/// Sums of du and of dv over all meta-edges.
fn extents(graph: &Data) -> [f64; 2] {
    ["du", "dv"].map(|d| graph.get("edges").list().iter().filter_map(|edge| edge.get(d).number()).sum())
}
