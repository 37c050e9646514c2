//! The triangles that a map lives on.

use crate::engine::mesh::remesh::{IsotropicOptions, remesh_isotropic, remesh_with_middles};
use crate::engine::mesh::{Surface, SurfaceIndex, TriMesh, refine};
use crate::engine::run::{Cancelled, RunContext};
use glam::DVec3;
use rayon::prelude::*;

/// The logarithm of the local size of edges for points near the surface.
pub type LogSize<'a> = &'a (dyn Fn(DVec3) -> f64 + Sync);

/// Faces per face of an ideal mesh from which on a mesh is too fine: everything after it takes time in proportion. A
/// choice: 1.2 and 1.3 were run over models, what is in between 1.3 and 3 was not.
const TOO_FINE: f64 = 1.3;
/// No mesh of fewer faces is too fine.
const FEW_FACES: f64 = 2000.0;
/// Edges of a remesh, relative to the longest allowed: they come out up to 4/3 as long as that.
const REMESHED: f64 = 0.8;
/// A triangle shaped worse (1 is equilateral, 0 has no area) is bad …
const BAD_SHAPE: f64 = 0.1;
/// … and so is a mesh with a larger part of such triangles.
const BAD_PART: f64 = 0.02;

/// A surface for the cross field and the map: no edge longer than about `max_edge` times the local size, whose logarithm
/// `log_size` gives for every point of the surface (`None`: 0 everywhere), room at the features, and if possible the very
/// same surface: it is only refined, unless the triangles are too many or badly shaped; then it is remeshed, within a tenth
/// of the longest edge. Corners keep their places and their order.
///
/// # Errors
/// [`Cancelled`] only.
pub fn working_mesh(
    ctx: &RunContext,
    surface: &Surface,
    max_edge: f64,
    log_size: Option<LogSize<'_>>,
    max_faces: usize,
) -> Result<Surface, Cancelled> {
    let mesh = &surface.mesh;
    let size = |p: DVec3| log_size.map_or(1.0, |log_size| log_size(p).exp());
    let longest_edges = |mesh: &TriMesh| -> Vec<f64> {
        let sizes: Vec<f64> = mesh.positions().par_iter().map(|&p| size(p)).collect();
        let of_face = |f| mesh.face(f).iter().map(|&v| sizes[v as usize]).fold(f64::INFINITY, f64::min);
        (0..mesh.n_faces()).map(|f| max_edge * of_face(f)).collect()
    };
    let longest = longest_edges(mesh);
    // Bisection halves lengths, so refined edges are three quarters of the allowed length on average.
    let ideal: f64 = (0..mesh.n_faces()).map(|f| mesh.area(f) * 4.0 / 3f64.sqrt() / (0.75 * longest[f]).powi(2)).sum();
    let too_fine = |faces: usize| faces as f64 > (TOO_FINE * ideal).max(FEW_FACES) || faces >= max_faces;
    // Sizes of a large triangle are known at its corners alone, hence once more where it was cut.
    let refined = |surface: &Surface, longest: Vec<f64>| -> Result<Surface, Cancelled> {
        let even = refine(ctx, surface, |f| max_edge.max(longest[f as usize]), max_faces)?.surface;
        if log_size.is_none() {
            return Ok(even);
        }
        let longest = longest_edges(&even.mesh);
        Ok(refine(ctx, &even, |f| longest[f as usize], max_faces)?.surface)
    };
    if !too_fine(mesh.n_faces()) && !is_badly_shaped(mesh) {
        let refined = refined(surface, longest)?;
        if !too_fine(refined.mesh.n_faces()) {
            return Ok(refined);
        }
    }
    let options = IsotropicOptions { max_faces, ..IsotropicOptions::dense(REMESHED * max_edge) };
    let remeshed = remesh_graded(ctx, surface, &SurfaceIndex::new(&surface.mesh), options, log_size)?;
    if log_size.is_none() {
        return Ok(remeshed);
    }
    let longest = longest_edges(&remeshed.mesh);
    refined(&remeshed, longest)
}

/// [`remesh_isotropic`] with edges that are shorter or longer than the one aimed at by the local size, whose logarithm
/// `log_size` gives for every point of the surface; all alike where it is `None`.
///
/// # Errors
/// [`Cancelled`] only.
pub fn remesh_graded(
    ctx: &RunContext,
    surface: &Surface,
    original: &SurfaceIndex,
    options: IsotropicOptions,
    log_size: Option<LogSize<'_>>,
) -> Result<Surface, Cancelled> {
    let Some(log_size) = log_size else { return remesh_isotropic(ctx, surface, original, &options) };
    // Edges longer than the one aimed at are never collapsed: it is the longest, and sizes are relative to that.
    let largest = surface.mesh.positions().par_iter().map(|&p| log_size(p)).reduce(|| f64::NEG_INFINITY, f64::max);
    let target_edge = largest.exp() * options.target_edge;
    let options = IsotropicOptions { target_edge, tolerance: largest.exp() * options.tolerance, ..options };
    let relative = |p: DVec3| (log_size(p) - largest).exp();
    Ok(remesh_with_middles(ctx, surface, original, &options, Some(&relative))?.surface)
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
        working_mesh(&RunContext::silent(), surface, max_edge, None, 1_000_000).unwrap()
    }

    #[test]
    fn a_good_mesh_is_only_refined() {
        let surface = samples::torus(24, 12);
        let result = work(&surface, 0.3);
        assert_eq!(&result.mesh.positions()[..surface.mesh.n_vertices()], surface.mesh.positions());
        assert!(longest_edge(&result.mesh) <= 0.3);
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
