//! Which way faces look.

use glam::DVec3;

use crate::engine::mesh::TriangleSoup;
use crate::engine::mesh::condition::tests::{add_box, count, good, unit_box};

#[test]
fn senses_are_made_consistent_and_outward() {
    let mut soup = unit_box();
    for p in [1, 2, 4, 5] {
        soup.indices[4 * p..4 * p + 4].reverse();
    }
    let c = good(&soup);
    let volume: f64 = (0..12).map(|f| c.mesh.triangle(f)).map(|[a, b, c]| a.dot(b.cross(c)) / 6.0).sum();
    assert!((volume - 1.0).abs() < 1e-12);
    assert!(count(&c, "faces_turned") > 0);
}

#[test]
fn the_wall_of_a_cavity_keeps_facing_inward() {
    let mut soup = TriangleSoup::default();
    add_box(&mut soup, DVec3::ZERO, 3.0);
    add_box(&mut soup, DVec3::ONE, 1.0);
    for p in 6..12 {
        soup.indices[4 * p..4 * p + 4].reverse();
    }
    let c = good(&soup);
    let volume: f64 = (0..24).map(|f| c.mesh.triangle(f)).map(|[a, b, c]| a.dot(b.cross(c)) / 6.0).sum();
    assert!((volume - 26.0).abs() < 1e-12, "{volume}");
    assert!(c.repairs.is_empty() && c.warnings.is_empty());
}

/// Rooms are modelled like that.
#[test]
fn what_is_given_inside_out_stays_so_and_is_warned_of() {
    let mut soup = unit_box();
    for p in 0..6 {
        soup.indices[4 * p..4 * p + 4].reverse();
    }
    let c = good(&soup);
    let volume: f64 = (0..12).map(|f| c.mesh.triangle(f)).map(|[a, b, c]| a.dot(b.cross(c)) / 6.0).sum();
    assert!((volume + 1.0).abs() < 1e-12);
    assert!(c.repairs.is_empty() && c.warnings.len() == 1, "{:?}", c.warnings);
}
