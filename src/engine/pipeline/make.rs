//! The quads of a surface: its components solved and put together, not judged as a whole yet.

use std::sync::Arc;

use glam::DVec3;

use crate::engine::field::FrameField;
use crate::engine::mesh::{Features, Surface};
use crate::engine::methods::Level;
use crate::engine::pipeline::components::{solve_all, warnings_of};
use crate::engine::pipeline::error::RemeshError;
use crate::engine::pipeline::outcome::{MapOutcome, assemble_map};
use crate::engine::pipeline::solve::Solution;
use crate::engine::pipeline::spec::RemeshSpec;
use crate::engine::pipeline::surface::middle;
use crate::engine::problem::{Problem, split};
use crate::engine::quad::{QuadDraft, QuadMesh};
use crate::engine::run::{RunContext, Warning};

/// Quads that are not judged yet, and what they belong to.
pub(super) struct Made {
    /// What they are to be judged by: features that were given up are gone.
    pub(super) surface: Surface,
    pub(super) quads: QuadMesh,
    /// Edges of the quads on features that were kept, (lower, higher), sorted.
    pub(super) feature_edges: Vec<[u32; 2]>,
    /// Component of the surface per quad.
    pub(super) component: Vec<u32>,
    pub(super) map: Option<MapOutcome>,
    /// Per component.
    pub(super) levels: Vec<Level>,
    /// Feature edges that were given up, by their middles.
    pub(super) given_up: Vec<DVec3>,
    pub(super) warnings: Vec<Warning>,
}

/// What the quads of a surface are to be like.
#[derive(Clone, Copy)]
pub(super) struct Asked<'a> {
    pub(super) spec: &'a RemeshSpec,
    /// In model units.
    pub(super) edge_length: f64,
    /// The field to follow on the faces of the surface, where one was given.
    pub(super) field: Option<&'a FrameField>,
}

/// Solves the components of a surface. `origin` says per vertex which one of the input it is, or is empty.
pub(super) fn make(
    ctx: &RunContext,
    mut surface: Surface,
    log_size: &[f64],
    detail: &[u32],
    origin: &[u32],
    asked: &Asked<'_>,
) -> Result<Made, RemeshError> {
    let Asked { spec, edge_length, field } = *asked;
    let mut problems =
        split(&surface, edge_length, spec.keeps_count(), &spec.wishes(), log_size, detail, &spec.strokes);
    for problem in &mut problems {
        problem.inputs = problem.vertices.iter().filter_map(|&v| origin.get(v as usize).copied()).collect();
        problem.field = field.map(|field| Arc::new(field.of_part(&problem.halfedges)));
    }
    let solved = solve_all(ctx, &problems, spec)?;
    let levels: Vec<Level> = solved.iter().map(|s| s.level).collect();
    let given_up = give_up_features(&mut surface, &problems, &solved);
    let warnings = warnings_of(&solved);
    let map = assemble_map(&problems, &solved, spec.working_mesh);
    let mut draft = QuadDraft::default();
    let mut component = Vec::new();
    for (c, s) in (0..).zip(solved) {
        draft.append(s.draft);
        component.resize(draft.mesh.quads.len(), c);
    }
    let QuadDraft { mesh: quads, mut feature_edges, .. } = draft;
    feature_edges.sort_unstable();
    Ok(Made { surface, quads, feature_edges, component, map, levels, given_up, warnings })
}

/// Takes the features that components gave up out of the surface that the certificate compares with. The middles of
/// their edges.
fn give_up_features(surface: &mut Surface, problems: &[Problem], solved: &[Solution]) -> Vec<DVec3> {
    if solved.iter().all(|s| s.kept_features.is_none()) {
        return Vec::new();
    }
    let mut features = Features::default();
    for (problem, solved) in problems.iter().zip(solved) {
        let own = solved.kept_features.as_ref().unwrap_or(&problem.surface.features);
        let name = |v: u32| problem.vertices[v as usize];
        features.edges.extend(own.edges.iter().map(|e| e.map(name)).map(|[a, b]| [a.min(b), a.max(b)]));
        features.corners.extend(own.corners.iter().map(|&v| name(v)));
    }
    features.edges.sort_unstable();
    features.corners.sort_unstable();
    let given_up = surface.features.without(&features).map(|e| middle(&surface.mesh, e)).collect();
    surface.features = features;
    given_up
}
