//! Quads against the normals of the surface.

use crate::engine::certify::shape::{area_vector, corners};
use crate::engine::certify::{Check, Violation};
use crate::engine::mesh::{SurfaceIndex, SurfacePoint};
use crate::engine::quad::QuadMesh;
use crate::engine::run::{Cancelled, RunContext};
use glam::DVec3;
use rayon::prelude::*;

/// A quad is flipped if its area vector opposes both the normal of the face nearest to its centroid and the mean of
/// the surface's interpolated normals at its four corners: one witness alone is unreliable where a coarse quad cuts
/// through a thin wall or noise. Where the surface lies twice in the same place, the side that agrees counts. A quad
/// has no area if its area is below 1e-12 of the square of its longer diagonal: CAD surfaces have slivers, and their
/// quads may be as thin. `feet` are the points of the surface nearest to the vertices.
pub(super) fn check(
    ctx: &RunContext,
    index: &SurfaceIndex,
    quads: &QuadMesh,
    feet: &[SurfacePoint],
    diagonal: f64,
) -> Result<[Option<Violation>; 2], Cancelled> {
    let areas: Vec<DVec3> = (0..quads.quads.len()).map(|q| area_vector(corners(quads, q))).collect();
    let is_flipped = |q: usize| {
        let area = areas[q];
        let around: DVec3 = quads.quads[q].iter().map(|&v| index.smooth_normal(&feet[v as usize])).sum();
        if area.dot(around) > 0.0 {
            return false;
        }
        let centroid = corners(quads, q).iter().sum::<DVec3>() / 4.0;
        let foot = index.closest(centroid);
        if area.dot(index.normal(foot.face)) > 0.0 {
            return false;
        }
        let reach = foot.distance + 1e-6 * diagonal;
        index.closest_where(centroid, reach, |face| area.dot(index.normal(face)) > 0.0).is_none()
    };
    let flipped: Vec<bool> = (0..quads.quads.len())
        .into_par_iter()
        .map(|q| {
            if q % 32 == 0 {
                ctx.check()?;
            }
            Ok(is_flipped(q))
        })
        .collect::<Result<_, _>>()?;
    let is_zero = |q: usize| {
        let [a, b, c, d] = corners(quads, q);
        areas[q].length() <= 1e-12 * a.distance_squared(c).max(b.distance_squared(d))
    };
    let numbers = || 0..areas.len();
    Ok([
        Violation::at(Check::Flipped, numbers().filter(|&q| flipped[q] && !is_zero(q)).map(|q| q as u32)),
        Violation::at(Check::ZeroArea, numbers().filter(|&q| is_zero(q)).map(|q| q as u32)),
    ])
}
