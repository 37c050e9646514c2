//! The field of the method: searched on a coarse mesh first, where a step costs little, and then carried over.

use glam::DVec3;
use rayon::prelude::*;

use crate::engine::field::BranchSearch;
use crate::engine::field::CrossField;
use crate::engine::field::FieldOptions;
use crate::engine::field::FieldStart;
use crate::engine::field::Frames;
use crate::engine::field::StrokeGuidance;
use crate::engine::field::curvature_guidance;
use crate::engine::field::quads_of;
use crate::engine::field::smooth_cross_field;
use crate::engine::field::stroke_guidance;
use crate::engine::field::transfer_field;
use crate::engine::mesh::IsotropicOptions;
use crate::engine::mesh::LogSize;
use crate::engine::mesh::Surface;
use crate::engine::mesh::SurfaceIndex;
use crate::engine::mesh::TriMesh;
use crate::engine::mesh::remesh_graded;
use crate::engine::methods::quad_cover::error::QuadCoverError;
use crate::engine::methods::quad_cover::options::QuadCoverOptions;
use crate::engine::run::RunContext;

/// Edges of the coarse mesh in quad edges: branch points are kept further apart than this.
const COARSE: f64 = 1.0;
/// How far the coarse mesh may stray from the surface, in its own edges: a field needs directions, not places.
const TOLERANCE: f64 = 0.3;
/// A coarse mesh is worth its making if it has at most this share of the faces.
const WORTH: f64 = 0.4;
/// Faces up to which the search goes on the working mesh itself.
const FEW_FACES: usize = 10_000;
/// Share of the guidance in the time of a field, about.
const GUIDED: f64 = 0.07;
/// Share of the search on the coarse mesh in the time of a field: fandisk at 5,000 quads, about 3.3 of 4.5 s.
const SEARCHED: f64 = 0.72;
/// Crosses are looked for within this many quad edges.
const REACH: f64 = 0.5;

/// The field on the working surface: a given one as it is, or as what the search begins with. Where branch points are searched for and the working mesh is much finer than the
/// quads, the search is done on a coarse mesh; on the working mesh they then only take their last few steps.
pub(super) fn solve_field(
    ctx: &RunContext,
    working: &Surface,
    frames: &Frames,
    strokes: Option<StrokeGuidance>,
    options: &QuadCoverOptions,
) -> Result<(CrossField, BranchSearch), QuadCoverError> {
    if let Some(given) = options.exact() {
        return Ok((given.crosses(&working.mesh, frames, &options.followed(working)), BranchSearch::default()));
    }
    if let Some(given) = &options.field {
        let start = given.start(&working.mesh, frames);
        return on_mesh(ctx, working, frames, strokes, Some(start), options);
    }
    let coarse = match options.branch_points {
        Some(_) => coarse_start(&ctx.span(0.0, SEARCHED), working, frames, options)?,
        None => None,
    };
    let (start, mut search) = coarse.map_or((None, BranchSearch::default()), |(start, search)| (Some(start), search));
    let fine = if start.is_some() { ctx.span(SEARCHED, 1.0) } else { ctx.clone() };
    let (field, after) = on_mesh(&fine, working, frames, strokes, start, options)?;
    search.go_on(after);
    Ok((field, search))
}

/// The field of a coarse mesh as seen from the working mesh.
fn coarse_start(
    ctx: &RunContext,
    working: &Surface,
    frames: &Frames,
    options: &QuadCoverOptions,
) -> Result<Option<(FieldStart, BranchSearch)>, QuadCoverError> {
    let mesh = &working.mesh;
    let edge = COARSE * options.edge_length;
    let area = if options.log_size.is_empty() { mesh.total_area() } else { quads_of(mesh, &options.log_size) };
    let faces = area * 4.0 / 3f64.sqrt() / (edge * edge);
    if mesh.n_faces() < FEW_FACES || faces > WORTH * mesh.n_faces() as f64 {
        return Ok(None);
    }
    let index = SurfaceIndex::new(mesh);
    let log_size_at = |p: DVec3| carried(mesh, &index, &options.log_size, p);
    let log_size: Option<LogSize<'_>> = if options.log_size.is_empty() { None } else { Some(&log_size_at) };
    let fidelity = IsotropicOptions { tolerance: TOLERANCE * edge, ..IsotropicOptions::dense(edge) };
    let coarse = remesh_graded(&ctx.span(0.0, 0.1), working, &index, fidelity, log_size)?;
    if coarse.mesh.n_faces() > mesh.n_faces() / 2 {
        return Ok(None);
    }
    let log_size: Vec<f64> = match log_size {
        Some(log_size) => coarse.mesh.positions().par_iter().map(|&p| log_size(p)).collect(),
        None => Vec::new(),
    };
    let coarse_frames = Frames::scaled(&coarse.mesh, &log_size);
    let strokes = stroke_guidance(&coarse.mesh, &coarse_frames, &options.strokes, options.edge_length);
    let (field, search) = on_mesh(&ctx.span(0.1, 0.95), &coarse, &coarse_frames, strokes, None, options)?;
    let start = transfer_field((&coarse.mesh, &coarse_frames, &field), (mesh, frames), REACH * options.edge_length);
    Ok(Some((start, search)))
}

/// Values at the vertices of a mesh, between them.
fn carried(mesh: &TriMesh, index: &SurfaceIndex, values: &[f64], p: DVec3) -> f64 {
    let at = index.closest(p);
    let face = mesh.face(at.face as usize);
    (0..3).map(|k| at.barycentric[k] * values[face[k] as usize]).sum()
}

fn on_mesh(
    ctx: &RunContext,
    surface: &Surface,
    frames: &Frames,
    strokes: Option<StrokeGuidance>,
    start: Option<FieldStart>,
    options: &QuadCoverOptions,
) -> Result<(CrossField, BranchSearch), QuadCoverError> {
    let mesh = &surface.mesh;
    let flags = options.followed(surface);
    let guidance = options.guided.then(|| curvature_guidance(mesh, frames, &flags, 0.7 * options.edge_length));
    ctx.advance(GUIDED);
    let field_options = FieldOptions {
        edge_length: options.edge_length,
        smoothing: options.smoothing,
        branch_points: options.branch_points.clone(),
        strokes,
        start,
    };
    Ok(smooth_cross_field(&ctx.span(GUIDED, 1.0), mesh, frames, &flags, guidance.as_ref(), &field_options)?)
}
