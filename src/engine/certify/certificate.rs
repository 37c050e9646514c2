//! The certificate of a quad mesh: all checks in order, and the measures.

use crate::engine::certify::{
    Check, QuadReport, Violation, boundary, components, curves, distance, measure_topology, orientation, shape,
};
use crate::engine::mesh::{Surface, SurfaceIndex, SurfacePoint};
use crate::engine::quad::QuadMesh;
use crate::engine::run::{Cancelled, RunContext};
use rayon::prelude::*;

/// The outcome of all checks.
#[derive(Clone, Debug, PartialEq)]
pub struct Certificate {
    /// Whether there is no violation.
    pub certified: bool,
    /// The failed checks. Quads that are no manifold are told only why; nothing else is checked then.
    pub violations: Vec<Violation>,
    /// The measures; only the counts if the quads are no manifold.
    pub measures: QuadReport,
}

impl Certificate {
    fn new(violations: Vec<Violation>, measures: QuadReport) -> Self {
        Self { certified: violations.is_empty(), violations, measures }
    }
}

/// Checks the quads against the surface that they were made for, and measures them. `index` is the index of
/// `surface.mesh`. O((n + f) log f) for n quads and samples over f faces.
///
/// # Errors
/// Only that the run was stopped: bad quads make a certificate that says so.
pub fn certify(
    ctx: &RunContext,
    surface: &Surface,
    index: &SurfaceIndex,
    quads: &QuadMesh,
) -> Result<Certificate, Cancelled> {
    ctx.check()?;
    let counts = QuadReport { count: quads.quads.len(), vertices: quads.positions.len(), ..QuadReport::default() };
    let topology = match measure_topology(quads) {
        Ok(topology) => topology,
        Err(violations) => return Ok(Certificate::new(violations, counts)),
    };
    let Some(triangles) = distance::triangulate(quads) else {
        let violation = Violation { check: Check::VertexFan, count: 1, witnesses: Vec::new() };
        return Ok(Certificate::new(vec![violation], counts));
    };
    let quad_index = SurfaceIndex::new(&triangles);
    let diagonal = surface.mesh.diagonal();
    let feet: Vec<SurfacePoint> = quads
        .positions
        .par_iter()
        .enumerate()
        .map(|(i, &p)| {
            if i % 1024 == 0 {
                ctx.check()?;
            }
            Ok(index.closest(p))
        })
        .collect::<Result<_, Cancelled>>()?;
    let curves = curves::check(ctx, surface, quads, &topology, diagonal)?;
    let mut measures = shape::measure(quads, &topology, |v| curves.is_corner[v]);
    let mean_edge = curves.mean_edge;
    let mut violations = components::check(&surface.mesh, quads, &topology, &feet, &quad_index, mean_edge);
    let oriented = orientation::check(ctx, index, quads, &feet, diagonal)?;
    measures.flipped = oriented[0].as_ref().map_or(0, |v| v.count);
    violations.extend(oriented.into_iter().flatten());
    violations.extend(curves.violations);
    violations.extend(boundary::check(&surface.mesh, quads, &topology));
    let distances = distance::measure(ctx, &surface.mesh, index, &triangles, &quad_index)?;
    let relative = |d: f64| if diagonal > 0.0 { d / diagonal } else { f64::NAN };
    measures.hausdorff_max = relative(distances.max);
    measures.hausdorff_mean = relative(distances.mean);
    measures.feature_error_max = relative(curves.error.0);
    measures.feature_error_mean = relative(curves.error.1);
    let numbers = [
        measures.rsd_edge,
        measures.rsd_angle,
        measures.scaled_jacobian_min,
        measures.scaled_jacobian_mean,
        measures.hausdorff_max,
        measures.hausdorff_mean,
        measures.feature_error_max,
        measures.feature_error_mean,
    ];
    let infinite = numbers.iter().filter(|x| !x.is_finite()).count();
    if infinite > 0 {
        violations.push(Violation { check: Check::Finite, count: infinite, witnesses: Vec::new() });
    }
    Ok(Certificate::new(violations, measures))
}
