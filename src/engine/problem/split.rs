//! Components apart, each with its share of the quads.

use std::sync::Arc;

use glam::DVec3;
use rayon::prelude::*;

use crate::engine::field::quads_of;
use crate::engine::mesh::{Surface, SurfaceIndex, SurfacePart, TriMesh};
use crate::engine::numerics::rounded;
use crate::engine::problem::{Problem, RefinementPoint, Wishes};

/// Fewest quads that a closed component of genus 0 gets: the sides of a box.
const QUADS_OF_BOX: f64 = 6.0;
/// Fewest quads that any other component gets, and more for each boundary loop and each handle: fewer cannot show its shape.
const MIN_QUADS: f64 = 24.0;
const MIN_QUADS_OF_BOUNDARY: f64 = 12.0;
const MIN_QUADS_OF_HANDLE: f64 = 24.0;

/// At most by this factor are quads longer than asked for because small components take more than their share.
const MAX_STRETCH: f64 = 1.5;

/// Fewest quads of a component.
fn least_quads(mesh: &TriMesh) -> f64 {
    let topology = mesh.topology();
    if topology.boundaries == 0 && topology.genus == 0 {
        return QUADS_OF_BOX;
    }
    MIN_QUADS + MIN_QUADS_OF_BOUNDARY * topology.boundaries as f64 + MIN_QUADS_OF_HANDLE * topology.genus as f64
}

/// The quads of a component.
struct Share {
    /// What is its by its area.
    quads: f64,
    /// What it needs.
    least: f64,
}

/// How much longer the edges of all components must be, at most [`MAX_STRETCH`], for their number of quads to be what
/// it would be if none had a least number.
fn stretch(shares: &[Share]) -> f64 {
    let sum =
        |stretch: f64| shares.iter().map(|share| (share.quads / (stretch * stretch)).max(share.least)).sum::<f64>();
    let wanted: f64 = shares.iter().map(|share| share.quads).sum();
    let (mut low, mut high) = (1.0, MAX_STRETCH);
    if sum(low) <= wanted * (1.0 + 1e-9) {
        return low;
    }
    for _ in 0..40 {
        let middle = 0.5 * (low + high);
        if sum(middle) > wanted { low = middle } else { high = middle }
    }
    high
}

/// Splits a surface; components in order of their first faces, vertices and faces of each in their order. `log_size`
/// are sizes relative to the edge length per vertex, empty if all quads are to be alike; `detail` vertices around which
/// quads are to be smaller, sorted. With `keeps_count` what small components take more than their share is taken from
/// the others.
pub fn split(
    surface: &Surface,
    edge_length: f64,
    keeps_count: bool,
    wishes: &Wishes,
    log_size: &[f64],
    detail: &[u32],
    strokes: &[Vec<DVec3>],
) -> Vec<Problem> {
    let strokes: Arc<[Vec<DVec3>]> = strokes.into();
    let parts = surface.parts();
    let sizes_of = |part: &SurfacePart| -> Vec<f64> {
        part.vertices.iter().filter_map(|&v| log_size.get(v as usize).copied()).collect()
    };
    let area_of = |part: &SurfacePart| match sizes_of(part) {
        sizes if sizes.is_empty() => part.surface.mesh.total_area(),
        sizes => quads_of(&part.surface.mesh, &sizes),
    };
    let whole_edge = edge_length;
    let edge_length = if keeps_count && parts.len() > 1 {
        let share =
            |part| Share { quads: area_of(part) / (edge_length * edge_length), least: least_quads(&part.surface.mesh) };
        edge_length * stretch(&parts.iter().map(share).collect::<Vec<_>>())
    } else {
        edge_length
    };
    let problem = |part: SurfacePart| {
        let area = part.surface.mesh.total_area();
        let least = least_quads(&part.surface.mesh);
        // A component's own edge length is the one that gives its share of the quads.
        let mut log_size = sizes_of(&part);
        let shift = 0.5 * (area_of(&part) / area).ln();
        log_size.iter_mut().for_each(|log| *log += shift);
        let edge_length = rounded((edge_length * (-shift).exp()).min((area / least).sqrt()));
        let detailed = part.vertices.iter().filter(|v| detail.binary_search(v).is_ok());
        let refined = RefinementPoint::apart(detailed.map(|&v| surface.mesh.position(v).into()), edge_length);
        Problem {
            index: Arc::new(SurfaceIndex::new(&part.surface.mesh)),
            surface: part.surface.into(),
            vertices: part.vertices.into(),
            inputs: Arc::new([]),
            halfedges: part.halfedges.into(),
            edge_length,
            judged_edge: edge_length.min(whole_edge),
            quads: area / (edge_length * edge_length),
            log_size,
            refined: refined.into(),
            strokes: strokes.clone(),
            field: None,
            wishes: *wishes,
        }
    };
    parts.into_par_iter().map(problem).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::mesh::shapes::sample_surface;
    use crate::engine::problem::{Align, Boundary, Optimise, WorkingMesh};

    const WISHES: Wishes = Wishes {
        boundary: Boundary::Align,
        align: Align::Curvature,
        smoothing: 0.5,
        optimise: Optimise::None,
        working_mesh: WorkingMesh::Auto,
        adapts_count: true,
    };

    /// A cube and the length of its side.
    fn cube(edges_per_side: f64) -> (Problem, DVec3, f64) {
        let surface = sample_surface("cube", 1200).unwrap();
        let corner = surface.mesh.position(surface.features.corners[0]);
        let side = (surface.mesh.total_area() / 6.0).sqrt();
        let problem = split(&surface, side / edges_per_side, true, &WISHES, &[], &[], &[]).remove(0);
        (problem, corner, side)
    }

    #[test]
    fn short_curves_go_as_a_whole_and_long_ones_only_near_the_place() {
        let (coarse, corner, side) = cube(4.0);
        let (all, bare) = (coarse.surface.features.edges.len(), coarse.without_features().unwrap());
        assert_eq!((bare.surface.features.edges.len(), bare.surface.features.corners.len()), (0, 0));
        assert!(bare.without_features().is_none() && bare.without_features_near(&[corner], side).is_none());
        let less = coarse.without_features_near(&[corner], 0.4 * side).unwrap();
        assert_eq!(4 * less.surface.features.edges.len(), 3 * all, "three of twelve sides");
        assert_eq!(less.surface.features.corners.len(), 7);
        let (fine, corner, side) = cube(10.0);
        assert!(fine.without_features_near(&[corner * 3.0], 0.1 * side).is_none());
        let less = fine.without_features_near(&[corner], 0.3 * side).unwrap();
        let lost = (all - less.surface.features.edges.len()) as f64 / all as f64;
        assert!((lost - 3.0 * 0.3 / 12.0).abs() < 0.03, "{lost}");
        // One corner is gone, and three loose ends are new.
        assert_eq!(less.surface.features.corners.len(), 10);
        // What is left of each side would be a stump.
        let stumps = fine.without_features_near(&[corner], 0.9 * side).unwrap();
        assert_eq!(4 * stumps.surface.features.edges.len(), 3 * all);
    }

    #[test]
    fn what_small_components_take_is_taken_from_the_others() {
        let share = |(quads, least): (f64, f64)| Share { quads, least };
        let shares = [(900.0, 24.0), (60.0, 24.0), (2.0, 24.0), (1.0, 48.0)].map(share);
        let stretch = stretch(&shares);
        let taken: f64 = shares.iter().map(|share| (share.quads / (stretch * stretch)).max(share.least)).sum();
        assert!((taken - 963.0).abs() < 1e-3, "{taken}");
        assert_eq!(super::stretch(&[(900.0, 24.0), (60.0, 24.0)].map(share)), 1.0, "none takes more than its share");
        assert_eq!(super::stretch(&[(30.0, 24.0), (1.0, 500.0)].map(share)), MAX_STRETCH);
    }

    #[test]
    fn quads_are_half_as_large_around_dense_places_and_grow_away_from_them() {
        let (cube, corner, side) = cube(10.0);
        assert!(cube.is_even());
        let denser = cube.refined_at([corner, corner * 1.01].map(RefinementPoint::from).into_iter()).unwrap();
        assert_eq!((denser.refined.len(), denser.is_even()), (1, false), "two places so near are one");
        assert!(denser.refined_at(std::iter::once(corner.into())).is_none());
        let along = DVec3::X * -corner.x.signum() * cube.edge_length;
        let sizes = [0.0, 0.9, 2.0, 3.0].map(|d| denser.log_size_at(corner + d * along).exp());
        let wanted = [0.5, 0.5, 0.8, 1.0];
        assert!(sizes.iter().zip(wanted).all(|(s, w)| (s - w).abs() < 1e-9), "{sizes:?} of {side}");
        // Half as large as so far, but no smaller than the least.
        let finer = denser.halved_at(&[corner], 0.2).unwrap();
        assert!((finer.log_size_at(corner).exp() - 0.25).abs() < 1e-9);
        assert!(finer.halved_at(&[corner], 0.2).is_none() && finer.halved_at(&[], 0.0).is_none());
        // What was asked for besides is kept.
        let log_size = vec![0.7; cube.vertices.len()];
        let larger = Problem { log_size, ..denser };
        assert!((larger.log_size_at(corner + 5.0 * along) - 0.7).abs() < 1e-9);
    }
}
