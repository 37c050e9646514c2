//! How far from a quad edge the points of a curve may lie that it stands for.

use crate::engine::certify::QuadTopology;
use crate::engine::quad::QuadMesh;

/// A quad edge stands for a point of a curve if the point lies within this part of the mean length of the edges that
/// meet the quad edge.
pub(super) const TOLERANCE: f64 = 0.35;
/// Boundary curves are only compared with boundary edges of the quads; a boundary that zigzags from triangle to triangle
/// is followed at the resolution of the quads, so the tolerance is wider by this factor.
pub(super) const BOUNDARY_SLACK: f64 = 1.7;

/// Per edge of the quads, how far it stands for points: `TOLERANCE` of the mean length of the edges at its ends.
pub(super) fn reaches(quads: &QuadMesh, topology: &QuadTopology) -> Vec<f64> {
    let length = |e: &[u32; 2]| quads.positions[e[0] as usize].distance(quads.positions[e[1] as usize]);
    let mut sum = vec![0.0; quads.positions.len()];
    for e in &topology.edges {
        for &v in e {
            sum[v as usize] += length(e);
        }
    }
    let reach = |&[a, b]: &[u32; 2]| {
        let edges = topology.valence[a as usize] + topology.valence[b as usize];
        TOLERANCE * (sum[a as usize] + sum[b as usize]) / f64::from(edges.max(1))
    };
    topology.edges.iter().map(reach).collect()
}
