//! The surface that quads are made for: its features, and how long their edges are to be.

use glam::DVec3;

use crate::engine::mesh::{Conditioned, Detected, FeatureOptions, TriMesh, TriangleSoup, detect_features_and_detail};
use crate::engine::numerics::rounded;
use crate::engine::pipeline::error::RemeshError;
use crate::engine::pipeline::spec::{RemeshSpec, Target};

/// Loose feature chains shorter than this many quad edges are noise: a scan has hundreds, and each would cost
/// singularities.
pub(super) const SHORTEST_FEATURE: f64 = 4.0;

/// Most quads that an edge length may amount to.
const MAX_QUADS: f64 = 1e7;

pub(super) fn edge_length(conditioned: &Conditioned, spec: &RemeshSpec) -> Result<f64, RemeshError> {
    let area = conditioned.mesh.total_area();
    match spec.target {
        Target::Quads(n) => Ok(rounded((area / n.max(1) as f64).sqrt())),
        Target::EdgeLength(edge_length) => {
            let quads = area / (edge_length * edge_length);
            if quads > MAX_QUADS {
                return Err(RemeshError::TooManyQuads { edge_length, quads, limit: MAX_QUADS });
            }
            Ok(edge_length)
        }
    }
}

/// The features, and what is known of those that are none.
pub(super) fn features(
    conditioned: &Conditioned,
    soup: &TriangleSoup,
    spec: &RemeshSpec,
    edge_length: f64,
) -> Detected {
    let options = FeatureOptions {
        angle_degrees: spec.features.angle_degrees,
        materials: spec.features.materials,
        normals: spec.features.normals,
        explicit: spec.features.edges.clone(),
        min_length: SHORTEST_FEATURE * edge_length,
    };
    detect_features_and_detail(conditioned, soup, &options)
}

/// The middle of an edge; how a report names edges that were given up, whatever surface they are found on again.
pub(super) fn middle(mesh: &TriMesh, edge: [u32; 2]) -> DVec3 {
    let [a, b] = edge.map(|v| mesh.position(v));
    0.5 * (a + b)
}
