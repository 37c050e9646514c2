//! Quads with a straight or reflex corner become five: a smaller quad inside, and one along each side.

use glam::DVec3;

use crate::engine::mesh::Surface;
use crate::engine::mesh::SurfaceIndex;
use crate::engine::quad::Anchor;
use crate::engine::quad::QuadDraft;
use crate::engine::quad::improve::repair::STRAIGHT;
use crate::engine::quad::optimise::area_vector;
use crate::engine::quad::optimise::corner_jacobians;
use crate::engine::quad::optimise::is_sound;
use crate::engine::quad::optimise::quality;
use crate::engine::run::Cancelled;
use crate::engine::run::RunContext;

/// Corners with a smaller scaled Jacobian are split close to the corner, so that the inner quad bulges towards them.
const FLAT: f64 = 0.3;
/// How far towards the middle the inner corners are put, at flat corners and at the others.
const NEAR: [f64; 4] = [0.08, 0.15, 0.25, 0.35];
const INNER: [f64; 4] = [0.3, 0.4, 0.5, 0.65];
/// More such quads than this part of all are no single faults.
const MOST: f64 = 0.02;

/// Splits every quad that has a straight or reflex corner and whose five parts have none. Where all four corners are
/// held by curves or corners of features no motion can help, but the angle at each corner can be shared by two quads.
///
/// Nothing that was there moves, so topology, curves and corners stay as they are. Returns `None` if nothing was split.
/// `index` is the one of `surface.mesh`.
///
/// # Errors
/// [`Cancelled`] if the run was asked to stop.
pub fn pillow_quads(
    ctx: &RunContext,
    surface: &Surface,
    index: &SurfaceIndex,
    draft: &QuadDraft,
) -> Result<Option<QuadDraft>, Cancelled> {
    if !is_sound(surface, draft) {
        return Ok(None);
    }
    let corners = |quad: &[u32; 4]| quad.map(|v| draft.mesh.positions[v as usize]);
    let straight: Vec<usize> = (0..draft.mesh.quads.len())
        .filter(|&q| {
            let p = corners(&draft.mesh.quads[q]);
            quality(&p, area_vector(&p).normalize_or_zero()) < STRAIGHT
        })
        .collect();
    if straight.len() > 20.max((MOST * draft.mesh.quads.len() as f64) as usize) {
        return Ok(None);
    }
    let mut split = draft.clone();
    for q in straight {
        ctx.check()?;
        let quad = draft.mesh.quads[q];
        let Some(inner) = inner_quad(index, &corners(&quad)) else { continue };
        let first = split.mesh.positions.len() as u32;
        split.mesh.positions.extend(inner);
        split.anchors.extend([Anchor::Surface; 4]);
        let new = [first, first + 1, first + 2, first + 3];
        split.mesh.quads[q] = new;
        split.mesh.quads.extend((0..4).map(|k| [quad[k], quad[(k + 1) % 4], new[(k + 1) % 4], new[k]]));
    }
    Ok((split.mesh.quads.len() > draft.mesh.quads.len()).then_some(split))
}

/// The corners of the best inner quad, in the surface if that is no worse; `None` if one of the five parts would have a
/// straight corner again.
fn inner_quad(index: &SurfaceIndex, p: &[DVec3; 4]) -> Option<[DVec3; 4]> {
    let up = area_vector(p).try_normalize()?;
    let jacobians = corner_jacobians(p, up);
    let mut best = (STRAIGHT, None);
    for middle in middles(p) {
        for near in NEAR {
            for inner in INNER {
                let at = |k: usize| p[k].lerp(middle, if jacobians[k] < FLAT { near } else { inner });
                let free: [DVec3; 4] = std::array::from_fn(at);
                let worst = least(p, &free, up);
                if worst > best.0 {
                    best = (worst, Some(free));
                }
            }
        }
    }
    let free = best.1?;
    let drawn = free.map(|c| index.closest(c).position);
    Some(if least(p, &drawn, up) >= STRAIGHT.max(0.5 * best.0) { drawn } else { free })
}

/// Places from which all four sides may be seen.
fn middles(p: &[DVec3; 4]) -> impl Iterator<Item = DVec3> {
    let sum = p.iter().sum::<DVec3>();
    let thirds = p.map(|c| (sum - c) / 3.0);
    let diagonals = [0, 1].map(|k| 0.5 * (p[k] + p[k + 2]));
    [0.25 * sum].into_iter().chain(thirds).chain(diagonals)
}

/// The worst corner of the five parts, against `up`.
fn least(p: &[DVec3; 4], inner: &[DVec3; 4], up: DVec3) -> f64 {
    let side = |k: usize| quality(&[p[k], p[(k + 1) % 4], inner[(k + 1) % 4], inner[k]], up);
    (0..4).map(side).fold(quality(inner, up), f64::min)
}
