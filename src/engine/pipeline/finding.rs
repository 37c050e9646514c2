//! What is worth a warning about quads that have their certificate.

use glam::DVec3;

use crate::engine::certify::Certificate;
use crate::engine::mesh::Surface;
use crate::engine::pipeline::report::FeatureReport;
use crate::engine::pipeline::spec::{RemeshSpec, Target};
use crate::engine::quad::QuadMesh;
use crate::engine::run::{Warning, WarningKind};

/// From this many quads on a count is met within 5 %, below it within 10 % (contract: `adapt_count`).
const MANY_QUADS: u64 = 500;
/// Quads and surface further apart than this many quad edges are worth a warning (contract: "certified").
const FAR: f64 = 2.0;

/// Certified quads and what they were made for.
pub(super) struct Finding<'a> {
    pub(super) quads: &'a QuadMesh,
    pub(super) certificate: &'a Certificate,
    pub(super) surface: &'a Surface,
    /// The edge length asked for, in model units.
    pub(super) edge_length: f64,
}

impl Finding<'_> {
    /// The warnings, each with its places.
    pub(super) fn warnings(&self, spec: &RemeshSpec, features: &FeatureReport) -> Vec<Warning> {
        let found = [self.count_missed(spec), dropped(features), self.far()];
        found.into_iter().flatten().collect()
    }

    fn count_missed(&self, spec: &RemeshSpec) -> Option<Warning> {
        let Target::Quads(wanted) = spec.target else { return None };
        let quads = self.quads.quads.len();
        let tolerance = if wanted < MANY_QUADS { 0.1 } else { 0.05 };
        let is_missed = (quads as f64 - wanted as f64).abs() > tolerance * wanted as f64;
        (spec.adapt_count && is_missed).then(|| WarningKind::CountMissed { quads, wanted }.into())
    }

    fn far(&self) -> Option<Warning> {
        let distance = self.certificate.measures.hausdorff_max;
        let edges = distance * self.surface.mesh.diagonal() / self.edge_length;
        let places: Vec<DVec3> = self.certificate.farthest.into_iter().collect();
        (edges > FAR).then(|| Warning::new(WarningKind::Far { edges, distance }, None, &places))
    }
}

fn dropped(features: &FeatureReport) -> Option<Warning> {
    let FeatureReport { detected, dropped, .. } = *features;
    let kind = WarningKind::FeaturesDropped { dropped, detected };
    (dropped > 0).then(|| Warning::new(kind, None, &features.dropped_at))
}
