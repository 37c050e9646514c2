//! Measures of the quads that need no surface: counts, edge lengths, angles, scaled Jacobians.

use crate::engine::certify::{QuadReport, QuadTopology};
use crate::engine::quad::QuadMesh;
use glam::DVec3;
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::f64::consts::TAU;

/// Twice the area vector of the quad with these corners: the cross product of its diagonals.
pub(super) fn area_vector([a, b, c, d]: [DVec3; 4]) -> DVec3 {
    (c - a).cross(d - b)
}

pub(super) fn corners(quads: &QuadMesh, q: usize) -> [DVec3; 4] {
    quads.quads[q].map(|v| quads.positions[v as usize])
}

/// Fills in counts, valences, topology and element shape. `is_corner` tells quad vertices at corners of the surface.
pub(super) fn measure(quads: &QuadMesh, topology: &QuadTopology, is_corner: impl Fn(usize) -> bool) -> QuadReport {
    let mut valences = BTreeMap::new();
    let mut irregular_boundary = 0;
    for (v, &valence) in topology.valence.iter().enumerate() {
        if topology.is_boundary_vertex[v] {
            irregular_boundary += usize::from(valence != 3 && !is_corner(v));
        } else {
            *valences.entry(valence as usize).or_insert(0) += 1;
        }
    }
    let lengths: Vec<f64> = topology
        .edges
        .iter()
        .map(|e| quads.positions[e[0] as usize].distance(quads.positions[e[1] as usize]))
        .collect();
    let shapes: Vec<([f64; 4], f64)> =
        (0..quads.quads.len()).into_par_iter().map(|q| quad_shape(corners(quads, q))).collect();
    let angles: Vec<f64> = shapes.iter().flat_map(|(angles, _)| *angles).collect();
    let jacobians: Vec<f64> = shapes.iter().map(|&(_, jacobian)| jacobian).collect();
    QuadReport {
        count: quads.quads.len(),
        vertices: quads.positions.len(),
        irregular_interior: valences.iter().filter(|&(&valence, _)| valence != 4).map(|(_, n)| n).sum(),
        irregular_boundary,
        valences: valences.into_iter().collect(),
        components: topology.components.len(),
        boundaries: topology.boundaries(),
        genus: topology.genus(),
        rsd_edge: relative_deviation(&lengths),
        rsd_angle: relative_deviation(&angles),
        scaled_jacobian_min: jacobians.iter().copied().reduce(f64::min).unwrap_or(0.0),
        scaled_jacobian_mean: mean(&jacobians),
        ..QuadReport::default()
    }
}

/// The four angles in radians (0 to 2π, above π at a reflex corner) and the least scaled Jacobian of the corners.
fn quad_shape(p: [DVec3; 4]) -> ([f64; 4], f64) {
    let normal = area_vector(p).normalize_or_zero();
    let mut least = f64::INFINITY;
    let angles = std::array::from_fn(|k| {
        let (e1, e2) = (p[(k + 1) % 4] - p[k], p[(k + 3) % 4] - p[k]);
        let cross = e1.cross(e2);
        let (sine, lengths) = (cross.dot(normal), e1.length() * e2.length());
        least = least.min(if lengths > 0.0 { sine / lengths } else { 0.0 });
        let angle = cross.length().atan2(e1.dot(e2));
        if sine < 0.0 { TAU - angle } else { angle }
    });
    (angles, least)
}

pub(super) fn mean(values: &[f64]) -> f64 {
    if values.is_empty() { 0.0 } else { values.iter().sum::<f64>() / values.len() as f64 }
}

/// The least scaled Jacobian of the corners of a quad, −1 to 1.
pub fn scaled_jacobian(corners: [DVec3; 4]) -> f64 {
    quad_shape(corners).1
}

fn relative_deviation(values: &[f64]) -> f64 {
    let mean = mean(values);
    if mean <= 0.0 {
        return 0.0;
    }
    let variance = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / values.len() as f64;
    variance.sqrt() / mean
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::dvec3;

    #[test]
    fn the_shape_of_known_quads() {
        let square = [DVec3::ZERO, DVec3::X, dvec3(1.0, 1.0, 0.0), DVec3::Y];
        let (angles, jacobian) = quad_shape(square);
        assert!((jacobian - 1.0).abs() < 1e-12 && angles.iter().all(|a| (a - TAU / 4.0).abs() < 1e-12));
        let arrow = [DVec3::ZERO, DVec3::X, dvec3(0.25, 0.25, 0.0), DVec3::Y];
        let (angles, jacobian) = quad_shape(arrow);
        assert!(jacobian < 0.0 && angles[2] > TAU / 2.0);
        assert!((angles.iter().sum::<f64>() - TAU).abs() < 1e-12);
        assert!((relative_deviation(&[1.0, 3.0]) - 0.5).abs() < 1e-12);
    }
}
