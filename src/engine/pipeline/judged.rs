//! Quads and what the certificate says about them.

use glam::DVec3;

use crate::engine::certify::{Violation, certify, scaled_jacobian};
use crate::engine::pipeline::quality::Quality;
use crate::engine::problem::Problem;
use crate::engine::quad::QuadDraft;
use crate::engine::run::{Cancelled, RunContext, Stage};

/// Largest coordinate relative to the diagonal of a component up to which single precision is expected to hold it.
const FARTHEST_ROUNDED: f64 = 60.0;
/// Quads further from the surface than this many edges do not show a part of it.
pub(super) const PART_LOST: f64 = 2.0;
/// Counts further off than this, as a share, are missed (5 % are promised, 10 % below 500 quads).
const COUNT_MISSED: f64 = 0.1;
/// Corners with a scaled Jacobian not above this are nearly straight: evaluators see them from 0 on, and files round.
const STRAIGHT: f64 = 0.01;

/// Quads of one component, rounded to what files hold, with their certificate.
#[derive(Clone, Debug)]
pub(super) struct Judged {
    pub(super) draft: QuadDraft,
    pub(super) quality: Quality,
    /// The Hausdorff distance in quad edges.
    pub(super) away: f64,
    /// What the certificate refuses.
    pub(super) violations: Vec<Violation>,
    /// Where, in model units; not for everything that can be wrong.
    pub(super) failing: Vec<DVec3>,
    /// Where the surface is furthest from the quads, if a part of it is lost.
    pub(super) lost: Option<DVec3>,
}

impl Judged {
    /// Whether the certificate passes.
    pub(super) fn is_certified(&self) -> bool {
        self.violations.is_empty()
    }

    /// What the certificate refuses, in words.
    pub(super) fn cause(&self) -> String {
        self.violations.first().map_or_else(String::new, ToString::to_string)
    }
}

/// Judges quads that were made for `problem`; `whole` is the problem as it was asked for, before anything was given up.
/// Quads are rounded to single precision first, so that all formats hold the same; where that would move them by more than
/// a few millionths of the surface's size, they stay as they are: only files of double precision hold them.
pub(super) fn judge(
    ctx: &RunContext,
    whole: &Problem,
    problem: &Problem,
    mut draft: QuadDraft,
) -> Result<Judged, Cancelled> {
    let Problem { surface, index, .. } = problem;
    let far = draft.mesh.positions.iter().map(|p| p.abs().max_element()).fold(0.0, f64::max);
    if far < FARTHEST_ROUNDED * surface.mesh.diagonal() {
        draft.mesh.positions.iter_mut().for_each(|p| *p = p.as_vec3().as_dvec3());
    }
    let certificate = ctx.stage(Stage::Certify, |ctx| certify(ctx, surface, index, &draft.mesh, whole.judged_edge))?;
    let measures = &certificate.measures;
    let away = measures.hausdorff_max * surface.mesh.diagonal() / whole.edge_length;
    let is_straight = |quad: &&[u32; 4]| scaled_jacobian(quad.map(|v| draft.mesh.positions[v as usize])) <= STRAIGHT;
    let straight = draft.mesh.quads.iter().filter(is_straight).count();
    let off = draft.mesh.quads.len() as f64 / whole.quads - 1.0;
    let quality = Quality {
        refused: certificate.violations.iter().map(|v| v.count.max(1)).sum(),
        is_substitute: false,
        misses_count: whole.wishes.adapts_count && off.abs() > COUNT_MISSED,
        loses_a_part: away > PART_LOST,
        features_given_up: features_given_up(whole, problem),
        straight,
        doublets: measures.valences.iter().find(|(valence, _)| *valence == 2).map_or(0, |(_, n)| *n),
        distance_step: if away.is_finite() { Quality::distance_step(away) } else { usize::MAX },
        irregular: measures.irregular_interior + measures.irregular_boundary,
    };
    let failing = certificate.violations.iter().flat_map(|v| v.places.iter().copied()).collect();
    let lost = certificate.farthest.filter(|_| away > PART_LOST);
    Ok(Judged { draft, quality, away, violations: certificate.violations, failing, lost })
}

/// Length of the features that a problem lacks, in quad edges.
fn features_given_up(whole: &Problem, problem: &Problem) -> usize {
    let mesh = &whole.surface.mesh;
    let length = |[a, b]: [u32; 2]| mesh.position(a).distance(mesh.position(b));
    let lost: f64 = whole.surface.features.without(&problem.surface.features).map(length).sum();
    (lost / whole.edge_length).ceil() as usize
}
