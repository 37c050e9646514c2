//! The order of the steps: valid first, then good.

use glam::DVec3;
use rayon::prelude::*;

use crate::engine::mesh::Surface;
use crate::engine::mesh::SurfaceIndex;
use crate::engine::mesh::closest_on_segment;
use crate::engine::quad::Anchor;
use crate::engine::quad::QuadDraft;
use crate::engine::quad::optimise::curves::trace_curves;
use crate::engine::quad::optimise::fit::fit_curves;
use crate::engine::quad::optimise::incidence::counted_edges;
use crate::engine::quad::optimise::relax::{Moving, relax};
use crate::engine::quad::optimise::shape::{area_vector, centre};
use crate::engine::quad::optimise::state::State;
use crate::engine::quad::optimise::surface_walker::SurfaceWalker;
use crate::engine::quad::optimise::untangle::lift_worst;
use crate::engine::quad::optimise::untangle::untangle;
use crate::engine::run::Cancelled;
use crate::engine::run::RunContext;

/// Rounds of averaging of the wanted sizes over neighbouring quads.
const SIZE_ROUNDS: usize = 8;
/// Quads worse than this are lifted one by one in the end.
const WORST: f64 = 0.4;
/// Strokes guide the quads whose centres are within this many edges.
const GUIDED: f64 = 1.0;

/// How the quads are optimised.
#[derive(Clone, Debug, PartialEq)]
pub struct OptimiseOptions {
    /// Most rounds of relaxation; 20 is plenty, 0 only makes the draft valid.
    pub iterations: usize,
    /// Target edge length h in model units. Quads near it are drawn to it; where the draft's are much larger or
    /// smaller, they keep their size.
    pub edge_length: f64,
    /// Per vertex of the surface the logarithm of the local size relative to the target; empty if it is the same
    /// everywhere.
    pub log_size: Vec<f64>,
    /// Lines that quads near them are to be turned along, polylines in model units.
    pub strokes: Vec<Vec<DVec3>>,
    /// Per vertex of the draft whether it stays where it is; empty: none does.
    pub held: Vec<bool>,
}

/// Moves the vertices of a draft over the surface until its quads are valid and then good; quads and anchors stay.
///
/// Afterwards every vertex of a surface anchor lies in a triangle of the surface, every vertex of a curve anchor on a
/// feature curve or the boundary, in the order of its chain, and every corner exactly on its surface vertex. No quad
/// gets worse than it was or than 0.3 (scaled Jacobian), whichever is less. A draft whose parts do not fit together
/// (indices or lengths) is returned as it is. O(n) per round after one sparse factorisation.
///
/// # Errors
/// [`Cancelled`] if the run was asked to stop.
pub fn optimise(
    ctx: &RunContext,
    surface: &Surface,
    index: &SurfaceIndex,
    mut draft: QuadDraft,
    options: &OptimiseOptions,
) -> Result<QuadDraft, Cancelled> {
    let mean = mean_edge(&draft);
    if !(is_sound(surface, &draft) && mean > 0.0 && mean.is_finite()) {
        return Ok(draft);
    }
    let target = if options.edge_length > 0.0 && options.edge_length.is_finite() { options.edge_length } else { mean };
    let walker = SurfaceWalker::new(surface, index, target.min(mean));
    let mut state = State::new(&walker, &draft, &options.held, trace_curves(surface), 0.5 * mean);
    ctx.check()?;
    let sizes = wanted_sizes(&state, target, &options.log_size);
    ctx.advance(0.1);
    untangle(&ctx.span(0.1, 0.2), &mut state, &sizes)?;
    lift_worst(&ctx.span(0.2, 0.3), &mut state, 0.05, 24)?;
    let guides = guides(ctx, &state, &options.strokes, &sizes)?;
    relax(&ctx.span(0.3, 0.7), &mut state, &sizes, &guides, Moving::All, options.iterations)?;
    if options.iterations > 0 && fit_curves(&ctx.span(0.7, 0.75), &mut state)? {
        relax(&ctx.span(0.75, 0.9), &mut state, &sizes, &guides, Moving::Inner, options.iterations.div_ceil(2))?;
    }
    lift_worst(&ctx.span(0.9, 1.0), &mut state, WORST, if options.iterations > 0 { 8 } else { 0 })?;
    let positions = state.positions;
    draft.mesh.positions = positions;
    Ok(draft)
}

/// Per quad the direction of a stroke within reach, zero where there is none; empty without strokes.
fn guides(ctx: &RunContext, state: &State<'_>, strokes: &[Vec<DVec3>], sizes: &[f64]) -> Result<Vec<DVec3>, Cancelled> {
    if strokes.is_empty() {
        return Ok(Vec::new());
    }
    let nearest = |q: usize| {
        ctx.check()?;
        let p = centre(&state.corners(q));
        let mut best = (GUIDED * sizes[q], DVec3::ZERO);
        for ends in strokes.iter().flat_map(|line| line.windows(2)) {
            let d = closest_on_segment(p, ends[0], ends[1]).1.distance(p);
            if d < best.0 {
                best = (d, (ends[1] - ends[0]).normalize_or_zero());
            }
        }
        Ok(best.1)
    };
    (0..state.quads.len()).into_par_iter().map(nearest).collect()
}

/// Mean edge length of a draft, 0 if it has no quads or indices out of range.
pub(crate) fn mean_edge(draft: &QuadDraft) -> f64 {
    let n = draft.mesh.positions.len() as u32;
    if draft.mesh.quads.is_empty() || draft.mesh.quads.iter().flatten().any(|&v| v >= n) {
        return 0.0;
    }
    let length = |e: [u32; 2]| draft.mesh.positions[e[0] as usize].distance(draft.mesh.positions[e[1] as usize]);
    let edges = counted_edges(&draft.mesh.quads);
    edges.iter().map(|e| length(e.0)).sum::<f64>() / edges.len() as f64
}

/// Whether the parts of a draft fit together and to the surface.
pub(crate) fn is_sound(surface: &Surface, draft: &QuadDraft) -> bool {
    let n = draft.mesh.positions.len();
    let surface_vertex = |a: &Anchor| !matches!(*a, Anchor::Corner(v) if v as usize >= surface.mesh.n_vertices());
    surface.mesh.n_faces() > 0
        && draft.anchors.len() == n
        && draft.anchors.iter().all(surface_vertex)
        && draft.mesh.positions.iter().all(|p: &DVec3| p.is_finite())
        && draft.mesh.quads.iter().flatten().chain(draft.feature_edges.iter().flatten()).all(|&v| (v as usize) < n)
}

/// Edge length that every quad should have: the target where the draft is near it, its own where it is not, smoothed,
/// and scaled such that squares of these sizes have the area of the quads.
fn wanted_sizes(state: &State<'_>, target: f64, log_size: &[f64]) -> Vec<f64> {
    let targets: Vec<f64> = (0..state.quads.len()).map(|q| target * state.local_size(q, log_size)).collect();
    let areas: Vec<f64> = (0..state.quads.len()).map(|q| 0.5 * area_vector(&state.corners(q)).length()).collect();
    let mut logs: Vec<f64> =
        areas.iter().zip(&targets).map(|(a, target)| (a.max(0.0).sqrt() / target).ln().clamp(-2.5, 2.5)).collect();
    for _ in 0..SIZE_ROUNDS {
        let mean = |v: usize| {
            let corners = state.incidence.corners_of(v as u32);
            corners.iter().map(|&c| logs[c as usize / 4]).sum::<f64>() / corners.len().max(1) as f64
        };
        let at_vertices: Vec<f64> = (0..state.positions.len()).map(mean).collect();
        logs = state.quads.iter().map(|q| 0.25 * q.iter().map(|&v| at_vertices[v as usize]).sum::<f64>()).collect();
    }
    let keep = |log: f64| log * (0.2 + log.abs()).min(1.0);
    let mut sizes: Vec<f64> = logs.into_iter().zip(&targets).map(|(log, target)| target * keep(log).exp()).collect();
    let wanted: f64 = sizes.iter().map(|s| s * s).sum();
    let scale = (areas.iter().sum::<f64>() / wanted).sqrt();
    if scale > 0.0 && scale.is_finite() {
        sizes.iter_mut().for_each(|s| *s *= scale);
    }
    sizes
}
