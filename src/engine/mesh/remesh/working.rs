//! The triangles that a map lives on.

use crate::engine::mesh::remesh::{IsotropicOptions, remesh_isotropic};
use crate::engine::mesh::{Surface, SurfaceIndex, TriMesh, refine};
use crate::engine::run::{Cancelled, RunContext};
use glam::DVec3;
use rayon::prelude::*;

/// Faces per face of an ideal mesh from which on a mesh is much too fine.
const TOO_FINE: f64 = 3.0;
/// A triangle shaped worse (1 is equilateral, 0 has no area) is bad …
const BAD_SHAPE: f64 = 0.1;
/// … and so is a mesh with a larger part of such triangles.
const BAD_PART: f64 = 0.02;
/// Where sizes vary, a surface is remeshed at the size that is undercut by so much of its area,
const FINER_PART: f64 = 0.2;
/// but not below this share of the common one.
const MIN_SHARE_OF_COMMON: f64 = 0.6;

/// A surface for the cross field and the map: no edge longer than about `max_edge`, room at the features, and if
/// possible the very same surface: it is only refined, unless the triangles are much too many or badly shaped; then it
/// is remeshed, within a tenth of `max_edge`. Corners keep their places and their order.
///
/// # Errors
/// [`Cancelled`] only.
pub fn working_mesh(
    ctx: &RunContext,
    surface: &Surface,
    original: &SurfaceIndex,
    max_edge: f64,
    max_faces: usize,
) -> Result<Surface, Cancelled> {
    let mesh = &surface.mesh;
    // Bisection halves lengths, so refined edges are three quarters of the allowed length on average.
    let ideal = mesh.total_area() * 4.0 / 3f64.sqrt() / (0.75 * max_edge).powi(2);
    let too_fine = |faces: usize| faces as f64 > (TOO_FINE * ideal).max(2000.0) || faces >= max_faces;
    if !too_fine(mesh.n_faces()) && !is_badly_shaped(mesh) {
        let refined = refine(ctx, surface, |_| max_edge, max_faces)?.surface;
        if !too_fine(refined.mesh.n_faces()) {
            return Ok(refined);
        }
    }
    let options = IsotropicOptions { max_faces, ..IsotropicOptions::dense(0.8 * max_edge) };
    remesh_isotropic(ctx, surface, original, &options)
}

/// As [`working_mesh`], with no edge longer than about `max_edge` times the local size, whose logarithm `log_size` gives
/// for every point of the surface. Where the surface must be remeshed that is done evenly, and small triangles are made
/// by refinement: in the end only the quads have to lie on the surface.
///
/// # Errors
/// [`Cancelled`] only.
pub fn graded_working_mesh(
    ctx: &RunContext,
    surface: &Surface,
    original: &SurfaceIndex,
    max_edge: f64,
    log_size: impl Fn(DVec3) -> f64 + Sync,
    max_faces: usize,
) -> Result<Surface, Cancelled> {
    let sizes = |mesh: &TriMesh| -> Vec<f64> { mesh.positions().par_iter().map(|&p| log_size(p)).collect() };
    let least = |mesh: &TriMesh, sizes: &[f64]| -> Vec<f64> {
        let of_face = |f| mesh.face(f).iter().map(|&v| sizes[v as usize]).fold(f64::INFINITY, f64::min);
        (0..mesh.n_faces()).map(|f| max_edge * of_face(f).exp()).collect()
    };
    let mesh = &surface.mesh;
    let own = sizes(mesh);
    let local = least(mesh, &own);
    let ideal: f64 = (0..mesh.n_faces()).map(|f| mesh.area(f) * 4.0 / 3f64.sqrt() / (0.75 * local[f]).powi(2)).sum();
    let too_fine = |faces: usize| faces as f64 > (TOO_FINE * ideal).max(2000.0) || faces >= max_faces;
    let even = if !too_fine(mesh.n_faces()) && !is_badly_shaped(mesh) {
        // Sizes of a large triangle are known at its corners alone.
        refine(ctx, surface, |f| max_edge.max(local[f as usize]), max_faces)?.surface
    } else {
        let usual = quantile(mesh, &local, FINER_PART).clamp(MIN_SHARE_OF_COMMON * max_edge, max_edge);
        remesh_isotropic(
            ctx,
            surface,
            original,
            &IsotropicOptions { max_faces, ..IsotropicOptions::dense(0.8 * usual) },
        )?
    };
    let local = least(&even.mesh, &sizes(&even.mesh));
    Ok(refine(ctx, &even, |f| local[f as usize], max_faces)?.surface)
}

/// The value that is undercut on this part of the area.
fn quantile(mesh: &TriMesh, values: &[f64], part: f64) -> f64 {
    let mut order: Vec<usize> = (0..values.len()).collect();
    order.sort_by(|&a, &b| values[a].total_cmp(&values[b]));
    let mut left = part * mesh.total_area();
    let found = order.into_iter().find(|&f| {
        left -= mesh.area(f);
        left <= 0.0
    });
    found.map_or(f64::INFINITY, |f| values[f])
}

fn is_badly_shaped(mesh: &TriMesh) -> bool {
    let bad = (0..mesh.n_faces()).filter(|&f| {
        let p = mesh.triangle(f);
        let sides: f64 = (0..3).map(|k| p[k].distance_squared(p[(k + 1) % 3])).sum();
        4.0 * 3f64.sqrt() * mesh.area(f) < BAD_SHAPE * sides
    });
    bad.count() as f64 > BAD_PART * mesh.n_faces() as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::mesh::remesh::samples;
    use glam::DVec3;

    fn longest_edge(mesh: &TriMesh) -> f64 {
        (0..3 * mesh.n_faces())
            .map(|h| mesh.position(mesh.origin(h)).distance(mesh.position(mesh.target(h))))
            .fold(0.0, f64::max)
    }

    fn work(surface: &Surface, max_edge: f64) -> Surface {
        let index = SurfaceIndex::new(&surface.mesh);
        working_mesh(&RunContext::silent(), surface, &index, max_edge, 1_000_000).unwrap()
    }

    #[test]
    fn a_good_mesh_is_only_refined() {
        let surface = samples::torus(24, 12);
        let result = work(&surface, 0.1);
        assert_eq!(&result.mesh.positions()[..surface.mesh.n_vertices()], surface.mesh.positions());
        assert!(longest_edge(&result.mesh) <= 0.1);
    }

    #[test]
    fn a_mesh_much_too_fine_becomes_coarser() {
        let surface = samples::ball(5, |_| 1.0);
        let result = work(&surface, 0.5);
        assert!(result.mesh.n_faces() * 4 < surface.mesh.n_faces());
        assert_eq!(result.mesh.topology(), surface.mesh.topology());
    }

    #[test]
    fn needles_are_remeshed() {
        let surface = samples::cuboid(DVec3::new(40.0, 1.0, 1.0));
        let result = work(&surface, 0.5);
        assert!(!is_badly_shaped(&result.mesh));
        assert!(longest_edge(&result.mesh) < 1.0);
        assert_eq!(result.features.corners.len(), 8);
    }
}
