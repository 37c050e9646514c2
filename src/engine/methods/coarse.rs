//! Quads from a coarse triangle mesh: a remesh of the right density, its triangles taken as polygons, one subdivision.

use glam::DVec3;

use crate::engine::mesh::remesh::{LocalSize, remesh_with_middles};
use crate::engine::mesh::{IsotropicOptions, Surface};
use crate::engine::methods::subdivide::{Polygon, subdivide};
use crate::engine::methods::{Parameter, Parameters, Range, Value};
use crate::engine::problem::Problem;
use crate::engine::quad::QuadDraft;
use crate::engine::run::{Cancelled, RunContext};

/// Remeshings until the count is accepted as it is.
const TRIES: usize = 3;
/// Relative error of the count that ends the search for the edge length.
const CLOSE_ENOUGH: f64 = 0.08;
/// How far a loose remesh may stray from the surface, in its own edges.
const LOOSE_TOLERANCE: f64 = 0.5;
/// Inputs of more triangles than this per triangle wanted are first brought down in one sweep.
const DENSE: f64 = 20.0;

/// How near the coarse triangles must stay to the surface.
pub(super) const FIDELITY: Parameter = Parameter {
    name: "fidelity",
    help: "How near the coarse triangles must stay to the surface.",
    range: Range::Choice(&[
        (
            "strict",
            "Every triangle agrees with the surface's normals; where the surface is folded in itself, triangles stay small.",
        ),
        ("loose", "Folds below the size of the triangles are passed over."),
        ("exact", "The triangles of the input themselves, however many they are."),
    ]),
};

/// Makes about `problem.quads` quads: `polygons` joins the triangles of the remesh, or leaves them as they are, into
/// polygons that give `quads_per_triangle` quads for each triangle. The quads have the topology of the surface, and its
/// corners and curves. Their number is near the one asked for unless features or thin places force more.
pub(super) fn coarse_quads(
    ctx: &RunContext,
    problem: &Problem,
    parameters: &Parameters,
    quads_per_triangle: f64,
    polygons: impl Fn(&RunContext, &Surface) -> Result<Vec<Polygon>, Cancelled>,
) -> Result<QuadDraft, Cancelled> {
    let Problem { surface, index, quads, .. } = problem;
    if parameters.get(&FIDELITY) == Value::Choice("exact") {
        return Ok(subdivide(surface, &polygons(ctx, surface)?, &surface.features.corners, &[]));
    }
    let is_loose = parameters.get(&FIDELITY) == Value::Choice("loose");
    let local = |p: DVec3| problem.log_size_at(p).exp();
    let size: Option<LocalSize<'_>> = if problem.is_even() { None } else { Some(&local) };
    let target = quads.max(1.0);
    let triangles = target / quads_per_triangle;
    // Edges come out shorter than asked for by about this much.
    let mut edge = (surface.mesh.total_area() / triangles * 4.0 / 3f64.sqrt() * 1.2).sqrt();
    let options = |edge: f64| match is_loose {
        false => IsotropicOptions::coarse(edge),
        true => IsotropicOptions { strict: false, tolerance: LOOSE_TOLERANCE * edge, ..IsotropicOptions::coarse(edge) },
    };
    let base;
    let mut start: &Surface = surface;
    if surface.mesh.n_faces() as f64 > DENSE * triangles {
        let first = IsotropicOptions {
            sweeps: 1,
            room_at_features: false,
            strict: !is_loose,
            ..IsotropicOptions::dense(0.3 * edge)
        };
        base = remesh_with_middles(&ctx.span(0.0, 0.3), surface, index, &first, size)?.surface;
        start = &base;
    }
    let ctx = ctx.span(0.3, 1.0);
    let mut best: Option<(f64, QuadDraft)> = None;
    for _ in 0..TRIES {
        let ctx = ctx.attempt(0.6);
        let coarse = remesh_with_middles(&ctx, start, index, &options(edge), size)?;
        let polygons = polygons(&ctx, &coarse.surface)?;
        let draft = subdivide(&coarse.surface, &polygons, &surface.features.corners, &coarse.curve_middles);
        let ratio = draft.mesh.quads.len() as f64 / target;
        let error = ratio.ln().abs();
        if best.as_ref().is_none_or(|(least, _)| error < *least) {
            best = Some((error, draft));
        }
        if error < CLOSE_ENOUGH {
            break;
        }
        edge *= ratio.sqrt().clamp(0.5, 2.0);
    }
    let (_, draft) = best.expect("there is at least one try");
    Ok(draft)
}
