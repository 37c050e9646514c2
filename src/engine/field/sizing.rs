//! Sizes of quads that vary over the surface: wanted ones from curvature and colour, and the graded ones that they
//! become.
//!
//! Sizes are logarithms per vertex, relative to one edge length for all. They are blended, limited
//! in their gradient so that neighbours differ little `[borouchaki_1998]`, and shifted so that the number of quads that
//! they amount to stays the number asked for.

use crate::engine::field::curvature::largest_curvature;
use crate::engine::mesh::TriMesh;
use crate::engine::mesh::prev;
use crate::engine::numerics::PathSearch;
use crate::engine::run::Cancelled;
use crate::engine::run::RunContext;

/// Largest gradient of the edge length: from one quad to the next it grows by about this share.
pub const MAX_GRADIENT: f64 = 0.3;
/// Wanted edge lengths are from 1 / this to this times the edge length for all.
const MAX_FACTOR: f64 = 4.0;

/// Radius, in quad edges, over which curvature is averaged: detail of half a quad may ask for smaller quads.
const CURVATURE_RADIUS: f64 = 0.35;
/// The limit that is worked with, so that the last shift cannot exceed the one that is promised.
const GRADIENT: f64 = 0.98 * MAX_GRADIENT;
/// Rounds of limiting and shifting.
const ROUNDS: usize = 16;
/// A shift (of logarithms) as small as this is the last.
const LAST_SHIFT: f64 = 0.01;
/// Halvings of the interval in which the turn per quad is searched for.
const HALVINGS: usize = 40;

/// Wanted sizes by curvature: the larger absolute principal curvature turns every quad through the same angle, from a
/// quarter to four times the edge length; the angle is such that there are as many quads as of the edge length for all.
/// `is_feature` is a flag per halfedge: creases are no curvature.
pub fn curvature_sizes(mesh: &TriMesh, is_feature: &[bool], edge_length: f64) -> Vec<f64> {
    let curvature = largest_curvature(mesh, is_feature, CURVATURE_RADIUS * edge_length);
    let bound = MAX_FACTOR.ln();
    let at = |log_turn: f64| -> Vec<f64> {
        let size = |k: &f64| (log_turn - (k * edge_length).max(1e-9).ln()).clamp(-bound, bound);
        curvature.iter().map(size).collect()
    };
    // With more turn per quad there are fewer quads.
    let (mut low, mut high) = (-24.0, 24.0);
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        if quads_of(mesh, &at(middle)) > mesh.total_area() { low = middle } else { high = middle }
    }
    at(0.5 * (low + high))
}

/// Area of the surface in units of the squared sizes: times 1 / (edge length)², the number of quads.
pub fn quads_of(mesh: &TriMesh, log_size: &[f64]) -> f64 {
    let mean = |f: usize| mesh.face(f).iter().map(|&v| log_size[v as usize]).sum::<f64>() / 3.0;
    (0..mesh.n_faces()).map(|f| mesh.area(f) * (-2.0 * mean(f)).exp()).sum()
}

/// The wanted sizes with their gradient limited to [`MAX_GRADIENT`] and as many quads as of the edge length for all.
/// O(n log n) per round.
///
/// # Errors
/// [`Cancelled`] only.
pub fn graded_sizes(ctx: &RunContext, mesh: &TriMesh, wanted: &[f64], edge_length: f64) -> Result<Vec<f64>, Cancelled> {
    let area = mesh.total_area();
    let mut shift = 0.0;
    let mut graded = wanted.to_vec();
    for _ in 0..ROUNDS {
        ctx.check()?;
        graded = limited(mesh, wanted.iter().map(|w| edge_length * (w + shift).exp()).collect());
        graded.iter_mut().for_each(|size| *size = (*size / edge_length).ln());
        let off = 0.5 * (quads_of(mesh, &graded) / area).ln();
        shift += off;
        if off.abs() <= LAST_SHIFT {
            break;
        }
    }
    let off = 0.5 * (quads_of(mesh, &graded) / area).ln();
    graded.iter_mut().for_each(|log| *log += off);
    Ok(graded)
}

/// Lowers sizes (model units) until none exceeds a neighbour's by more than the gradient allows.
fn limited(mesh: &TriMesh, size: Vec<f64>) -> Vec<f64> {
    // Sizes are positive: a size is the shortest way to a vertex where each begins as large as it wants to be.
    let mut search = PathSearch::new(mesh.n_vertices());
    for (v, &size) in (0u32..).zip(&size) {
        search.start(v, size);
    }
    while let Some((size, v)) = search.nearest() {
        for h in mesh.fan(v) {
            for w in [mesh.target(h), mesh.origin(prev(h))] {
                search.reach(w, size + GRADIENT * mesh.position(v).distance(mesh.position(w)), h as u32, v);
            }
        }
    }
    (0..mesh.n_vertices() as u32).map(|v| search.distance(v)).collect()
}

/// The wanted size for a colour (RGBA, 0 to 1): density is 1/4 at black, 1 at middle grey and 4 at white, by the mean of
/// red, green and blue.
pub fn colour_size(colour: [f32; 4]) -> f64 {
    let mean = colour[..3].iter().map(|&c| f64::from(c).clamp(0.0, 1.0)).sum::<f64>() / 3.0;
    // Density is one over the squared size.
    -(mean - 0.5) * 4f64.ln()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::mesh::shapes::sample_surface;

    fn steepest(mesh: &TriMesh, log_size: &[f64], edge_length: f64) -> f64 {
        let at = |v: u32| edge_length * log_size[v as usize].exp();
        let slope = |h: usize| {
            let (a, b) = (mesh.origin(h), mesh.target(h));
            (at(a) - at(b)).abs() / mesh.position(a).distance(mesh.position(b))
        };
        (0..mesh.n_halfedges()).map(slope).fold(0.0, f64::max)
    }

    #[test]
    fn graded_sizes_keep_the_number_of_quads_and_the_gradient() {
        for name in ["ellipsoid", "dumbbell", "half_pipe", "plate_with_holes", "rounded_box", "trefoil"] {
            let surface = sample_surface(name, 6000).unwrap();
            let mesh = &surface.mesh;
            let flags = surface.features.halfedge_flags(mesh);
            for quads in [300.0, 3000.0] {
                let edge_length = (mesh.total_area() / quads).sqrt();
                let mut wanted = curvature_sizes(mesh, &flags, edge_length);
                // A jump, which no mesh could follow.
                wanted.iter_mut().skip(mesh.n_vertices() / 2).for_each(|w| *w += 1.5);
                assert!(steepest(mesh, &wanted, edge_length) > 2.0 * MAX_GRADIENT, "{name}: nothing to limit");
                let graded = graded_sizes(&RunContext::silent(), mesh, &wanted, edge_length).unwrap();
                let count = quads_of(mesh, &graded) / (edge_length * edge_length);
                assert!((count / quads - 1.0).abs() < 1e-9, "{name}: {count} of {quads}");
                let steepest = steepest(mesh, &graded, edge_length);
                assert!(steepest <= MAX_GRADIENT && steepest > 0.5 * MAX_GRADIENT, "{name}: {steepest}");
            }
        }
    }

    #[test]
    fn sizes_follow_curvature() {
        // On a sphere and on flat faces there is nothing to choose.
        for name in ["sphere", "cube"] {
            let surface = sample_surface(name, 4000).unwrap();
            let flags = surface.features.halfedge_flags(&surface.mesh);
            let edge_length = (surface.mesh.total_area() / 1000.0).sqrt();
            let sizes = curvature_sizes(&surface.mesh, &flags, edge_length);
            assert!(sizes.iter().all(|s| s.abs() < 0.2), "{name}");
        }
        let surface = sample_surface("ellipsoid", 8000).unwrap();
        let flags = surface.features.halfedge_flags(&surface.mesh);
        let edge_length = (surface.mesh.total_area() / 2000.0).sqrt();
        let sizes = curvature_sizes(&surface.mesh, &flags, edge_length);
        let count = quads_of(&surface.mesh, &sizes) / (edge_length * edge_length);
        assert!((count / 2000.0 - 1.0).abs() < 1e-3, "{count}");
        let longest = |v: &usize| surface.mesh.position(*v as u32).abs().max_element();
        let order = |v: &usize, w: &usize| longest(v).total_cmp(&longest(w));
        let tip = (0..sizes.len()).max_by(order).unwrap();
        let smallest = sizes.iter().copied().fold(f64::INFINITY, f64::min);
        assert!(sizes[tip] < smallest + 0.3 && smallest < -0.4, "{} {smallest}", sizes[tip]);
    }

    #[test]
    fn colours_scale_the_density_from_a_quarter_to_four() {
        let density = |grey: f32| (-2.0 * colour_size([grey, grey, grey, 0.3])).exp();
        for (grey, expected) in [(0.0, 0.25), (0.5, 1.0), (1.0, 4.0), (7.0, 4.0)] {
            assert!((density(grey) / expected - 1.0).abs() < 1e-6, "{grey}");
        }
        assert!((colour_size([1.0, 0.0, 0.5, 1.0])).abs() < 1e-6);
    }
}
