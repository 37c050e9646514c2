//! Where the singularity graph comes from.

use crate::engine::mesh::Surface;
use crate::engine::methods::harmonic::cut_mesh::CutMesh;
use crate::engine::methods::harmonic::error::HarmonicError;
use crate::engine::methods::harmonic::graph::{SingularityGraph, graph_of};
use crate::engine::methods::harmonic::separatrices::{cut_separatrices, snap};
use crate::engine::methods::harmonic::working::Working;
use crate::engine::parameterize::{GridMap, MapSystem, measure_map, untangle};
use crate::engine::problem::Problem;
use crate::engine::run::{RunContext, Stage};
use crate::engine::topology::Singularity;

/// Scales tried at most so that the count is met, and how near is near enough.
const MAX_SCALES: usize = 4;
const COUNT_TOLERANCE: f64 = 0.03;

/// A singularity graph with the mesh that it is cut into.
#[derive(Clone, Debug)]
pub(super) struct Sourced {
    pub(super) surface: Surface,
    /// The charts of the meta-faces, and the curves on coordinate lines; its values are those of the map that it comes from.
    pub(super) charts: GridMap,
    pub(super) graph: SingularityGraph,
    /// Meta-vertices that are held: singular ones and corners.
    pub(super) is_held: Vec<bool>,
    pub(super) singularities: Vec<Singularity>,
    /// Grid units per model unit.
    pub(super) scale: f64,
}

/// The graph of separatrices of the integer-grid map of the smooth field.
pub(super) fn from_map(ctx: &RunContext, working: &Working, problem: &Problem) -> Result<Sourced, HarmonicError> {
    let (mesh, frames) = (&working.surface.mesh, &working.frames);
    let field = ctx.stage(Stage::Field, |ctx| working.field(ctx, problem))?;
    let corners = &working.surface.features.corners;
    let weight = vec![1.0; mesh.n_faces()];
    let system = ctx.stage(Stage::Map, |ctx| {
        MapSystem::new(ctx, mesh, frames, &field, &working.followed(problem), corners, weight)
    })?;
    ctx.stage(Stage::Round, |ctx| {
        let (mut map, scale) = round(ctx, working, problem, &system)?;
        let mut is_special: Vec<bool> = field.quarter_index.iter().map(|&q| q != 0).collect();
        corners.iter().for_each(|&v| is_special[v as usize] = true);
        untangle(&ctx.span(0.6, 0.8), mesh, frames, &mut map, &is_special, scale)?;
        snap(&mut map, |h| is_special[mesh.origin(h) as usize]);
        let mut cut = CutMesh::new(&working.surface, Some(map));
        cut_separatrices(&ctx.span(0.8, 0.9), &mut cut, &mut is_special)?;
        is_special.resize(cut.n_vertices(), false);
        let graph = graph_of(&mut cut, &is_special)?;
        let (surface, charts, _) = cut.finish()?;
        Ok(Sourced { surface, charts, graph, is_held: is_special, singularities: field.singularities(), scale })
    })
}

/// The integer-grid map that meets the count best.
fn round(
    ctx: &RunContext,
    working: &Working,
    problem: &Problem,
    system: &MapSystem,
) -> Result<(GridMap, f64), HarmonicError> {
    let mesh = &working.surface.mesh;
    let wanted = if problem.wishes.adapts_count { problem.quads } else { f64::NAN };
    let mut scale = 1.0 / problem.edge_length;
    let mut best: Option<(f64, GridMap, f64)> = None;
    for _ in 0..MAX_SCALES {
        let rounded = system.round(&ctx.span(0.0, 0.6), mesh, scale)?;
        let map = system.map(mesh, &rounded)?;
        let area = measure_map(mesh, &working.frames, &map, scale).grid_area.max(1.0);
        let off = (area / wanted).ln().abs();
        if best.as_ref().is_none_or(|b| off < b.0) {
            best = Some((off, map, scale));
        }
        if off.is_nan() || off < COUNT_TOLERANCE {
            break;
        }
        scale *= (wanted / area).sqrt().clamp(0.5, 2.0);
    }
    best.map(|(_, map, scale)| (map, scale)).ok_or(HarmonicError::NoIntegers)
}
