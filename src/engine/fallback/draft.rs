//! The two lowest rungs of the ladder.

use crate::engine::fallback::pair::pair_triangles;
use crate::engine::fallback::subdivide::subdivide;
use crate::engine::mesh::remesh::remesh_with_middles;
use crate::engine::mesh::{IsotropicOptions, NONE, Surface, SurfaceIndex, remesh_isotropic};
use crate::engine::quad::QuadDraft;
use crate::engine::run::{Cancelled, RunContext};

/// Remeshings until the count is accepted as it is.
const TRIES: usize = 3;
/// Relative error of the count that ends the search for the edge length.
const CLOSE_ENOUGH: f64 = 0.08;

/// Level L3: an isotropic triangle mesh, its triangles joined in pairs, and one subdivision. `original` is the index of
/// `surface`. The quads have the topology of `surface`, and its corners ([`crate::engine::quad::Anchor::Corner`] names
/// vertices of it) and curves. Their number is near `target_quads` unless features or thin places force more.
///
/// # Errors
/// [`Cancelled`] only.
pub fn fallback_draft(
    ctx: &RunContext,
    surface: &Surface,
    original: &SurfaceIndex,
    target_quads: usize,
) -> Result<QuadDraft, Cancelled> {
    let target = target_quads.max(1) as f64;
    // Two triangles make a polygon, a polygon makes four quads.
    let triangles = 0.5 * target;
    let mut edge = (surface.mesh.total_area() / triangles * 4.0 / 3f64.sqrt() * 1.2).sqrt();
    let base;
    let mut start = surface;
    if surface.mesh.n_faces() as f64 > 20.0 * triangles {
        let options = IsotropicOptions {
            sweeps: 1,
            room_at_features: false,
            strict: true,
            ..IsotropicOptions::dense(0.3 * edge)
        };
        base = remesh_isotropic(ctx, surface, original, &options)?;
        start = &base;
    }
    let mut best: Option<(f64, QuadDraft)> = None;
    for _ in 0..TRIES {
        let coarse = remesh_with_middles(ctx, start, original, &IsotropicOptions::coarse(edge))?;
        let polygons = pair_triangles(ctx, &coarse.surface)?;
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

/// Level L4: every triangle of `surface` becomes three quads in its plane. Needs nothing but a valid surface.
pub fn split_draft(surface: &Surface) -> QuadDraft {
    let polygons: Vec<_> = surface.mesh.faces().iter().map(|&[a, b, c]| [a, b, c, NONE]).collect();
    subdivide(surface, &polygons, &surface.features.corners, &[])
}
