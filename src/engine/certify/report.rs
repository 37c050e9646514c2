//! The measures of a quad mesh.

/// Measures of the quads. Distances relative to the bounding-box diagonal of the conditioned input, angles in degrees,
/// RSD = standard deviation / mean.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct QuadReport {
    /// Quads.
    pub count: usize,
    /// Vertices.
    pub vertices: usize,
    /// Interior vertices whose valence is not 4.
    pub irregular_interior: usize,
    /// Boundary vertices whose valence is not 3 (number of edges), corners of the surface left out.
    pub irregular_boundary: usize,
    /// Interior valence (number of quads) and how many vertices have it, ascending.
    pub valences: Vec<(usize, usize)>,
    /// Connected components.
    pub components: usize,
    /// Boundary loops.
    pub boundaries: usize,
    /// Genus, summed over components.
    pub genus: usize,
    /// RSD of edge lengths.
    pub rsd_edge: f64,
    /// RSD of corner angles.
    pub rsd_angle: f64,
    /// Minimum over quads of the minimum scaled Jacobian of the corners.
    pub scaled_jacobian_min: f64,
    /// Mean over quads of the minimum scaled Jacobian of the corners.
    pub scaled_jacobian_mean: f64,
    /// Two-sided sampled Hausdorff distance, maximum.
    pub hausdorff_max: f64,
    /// Mean distance from samples of the quads to the surface.
    pub hausdorff_mean: f64,
    /// Largest distance from a sample of a feature curve to the nearest quad edge.
    pub feature_error_max: f64,
    /// Mean of the same.
    pub feature_error_mean: f64,
    /// Quads whose normal opposes the surface's.
    pub flipped: usize,
}
