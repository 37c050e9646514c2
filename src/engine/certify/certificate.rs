//! The certificate of a quad mesh: all checks in order, and the measures.

use crate::engine::certify::{
    Check, Defect, QuadReport, QuadTopology, Violation, boundary, components, curves, distance, measure_topology,
    orientation, shape,
};
use crate::engine::mesh::{Surface, SurfaceIndex, SurfacePart};
use crate::engine::quad::QuadMesh;
use crate::engine::run::{Cancelled, RunContext};
use glam::DVec3;
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
    /// Where the quads and the surface are furthest apart, in model units; nothing where they are not apart.
    pub farthest: Option<DVec3>,
}

impl Certificate {
    fn new(violations: Vec<Violation>, measures: QuadReport) -> Self {
        Self { certified: violations.is_empty(), violations, measures, farthest: None }
    }
}

/// Checks the quads against the surface that they were made for, and measures them. `index` is the index of
/// `surface.mesh`; `edge_length` is the one asked for, in model units, 0 if it is not known. Components are judged one by
/// one, each against its own component of the surface, so that a model is certified exactly if its parts are. O((n + f) log f) for n quads and samples over f faces.
///
/// ```
/// use glam::DVec3;
/// use quadrille::engine::mesh::{Features, Surface, SurfaceIndex, TriMesh};
/// use quadrille::engine::{certify::certify, quad::QuadMesh, run::RunContext};
///
/// let positions = vec![DVec3::ZERO, DVec3::X, DVec3::X + DVec3::Y, DVec3::Y];
/// let mesh = TriMesh::try_new(positions.clone(), vec![[0, 1, 2], [0, 2, 3]])?;
/// let surface = Surface { mesh, features: Features { edges: Vec::new(), corners: vec![0, 1, 2, 3] } };
/// let quads = QuadMesh { positions, quads: vec![[0, 1, 2, 3]] };
/// let index = SurfaceIndex::new(&surface.mesh);
/// let certificate = certify(&RunContext::silent(), &surface, &index, &quads, 1.0)?;
/// assert!(certificate.certified && certificate.violations.is_empty());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// Only that the run was stopped: bad quads make a certificate that says so.
pub fn certify(
    ctx: &RunContext,
    surface: &Surface,
    index: &SurfaceIndex,
    quads: &QuadMesh,
    edge_length: f64,
) -> Result<Certificate, Cancelled> {
    ctx.check()?;
    let counts = QuadReport { count: quads.quads.len(), vertices: quads.positions.len(), ..QuadReport::default() };
    let topology = match measure_topology(quads) {
        Ok(topology) => topology,
        Err(violations) => return Ok(Certificate::new(violations, counts)),
    };
    let Some(triangles) = distance::triangulate(quads) else {
        let violation = Violation::unequal(Check::VertexFan, 1, 0);
        return Ok(Certificate::new(violation.into_iter().collect(), counts));
    };
    let judged = judge(&ctx.span(0.1, 0.5), surface, index, quads, &topology, edge_length)?;
    let mut measures = shape::measure(quads, &topology, |v| judged.is_corner[v]);
    let diagonal = surface.mesh.diagonal();
    let limit = |face: u32| judged.far.get(face as usize).copied().unwrap_or(f64::INFINITY);
    let quad_index = SurfaceIndex::new(&triangles);
    let distances = distance::measure(&ctx.span(0.5, 1.0), &surface.mesh, index, &triangles, &quad_index, limit)?;
    let relative = |d: f64| if diagonal > 0.0 { d / diagonal } else { f64::NAN };
    measures.hausdorff_max = relative(distances.max);
    measures.hausdorff_mean = relative(distances.mean);
    measures.feature_error_max = relative(judged.distances.iter().copied().fold(0.0, f64::max));
    measures.feature_error_mean = relative(shape::mean(&judged.distances));
    measures.flipped = judged.violations.iter().filter(|v| v.check == Check::Flipped).map(|v| v.count).sum();
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
    let mut violations = judged.violations;
    let infinite = numbers.iter().filter(|x| !x.is_finite()).count();
    if infinite > 0 {
        violations.extend(Violation::unequal(Check::Finite, infinite, 0));
    }
    let known = violations.iter().find(|v| v.check == Check::Far).map(|v| v.witnesses.clone()).unwrap_or_default();
    let beneath = distances.far.iter().copied().filter(|f| !known.contains(&f.0));
    join(&mut violations, Violation::at_places(Check::Far, beneath));
    Ok(Certificate { farthest: distances.farthest, ..Certificate::new(violations, measures) })
}

/// Per component of the quads, the distance beyond which a quad is far from the surface.
fn far_of_components(quads: &QuadMesh, topology: &QuadTopology, edge_length: f64) -> Vec<f64> {
    let mut sums = vec![(0.0, 0.0); topology.components.len()];
    for (quad, &c) in quads.quads.iter().zip(&topology.component) {
        let p = quad.map(|v| quads.positions[v as usize]);
        let sum = &mut sums[c as usize];
        sum.0 += (0..4).map(|k| p[k].distance(p[(k + 1) % 4])).sum::<f64>();
        sum.1 += 4.0;
    }
    sums.into_iter().map(|(sum, n)| Defect::far(edge_length.max(sum / n))).collect()
}

fn join(all: &mut Vec<Violation>, more: impl IntoIterator<Item = Violation>) {
    for violation in more {
        match all.iter_mut().find(|v| v.check == violation.check) {
            Some(known) => known.join(violation),
            None => all.push(violation),
        }
    }
}

/// What the checks against the surface found.
struct Judged {
    violations: Vec<Violation>,
    /// Per vertex of the quads, whether a corner of the surface is there.
    is_corner: Vec<bool>,
    /// From samples of the curves to the quads' edges, in model units.
    distances: Vec<f64>,
    /// Per face of the surface, the distance beyond which it is far from its quads; infinite where it has none.
    far: Vec<f64>,
}

/// Pairs components and judges each pair; places are named as in the whole.
fn judge(
    ctx: &RunContext,
    surface: &Surface,
    index: &SurfaceIndex,
    quads: &QuadMesh,
    topology: &QuadTopology,
    edge_length: f64,
) -> Result<Judged, Cancelled> {
    let diagonal = surface.mesh.diagonal();
    let surface_parts = surface.parts();
    let quad_parts = components::parts(quads, topology);
    let (mut pairs, violations) = components::pair(ctx, &surface.mesh, index, &surface_parts, &quad_parts, topology)?;
    if surface_parts.len() == 1 && quad_parts.len() == 1 {
        // However little they fit: what else is wrong is said as well.
        pairs = vec![(0, 0)];
    }
    let limits = far_of_components(quads, topology, edge_length);
    let mut far = vec![f64::INFINITY; surface.mesh.n_faces()];
    for &(s, c) in &pairs {
        surface_parts[s].halfedges.iter().for_each(|h| far[*h as usize / 3] = limits[c]);
    }
    // Curves begin at their lowest vertex and ties go to the lowest face: everything is judged in the numbers that it has as
    // a part, so that a component passes in the whole if and only if it passes alone.
    let is_own_part = |part: &SurfacePart| {
        surface_parts.len() == 1 && part.vertices.iter().copied().eq(0..part.vertices.len() as u32)
    };
    let of_pair = |&(s, c): &(usize, usize)| {
        let (part, own) = (&surface_parts[s], &quad_parts[c]);
        let mut judged = match measure_topology(&own.mesh) {
            Ok(topology) => {
                let built = (!is_own_part(part)).then(|| SurfaceIndex::new(&part.surface.mesh));
                let index = built.as_ref().unwrap_or(index);
                judge_pair(ctx, &part.surface, index, &own.mesh, &topology, edge_length, diagonal)?
            }
            Err(violations) => Judged { violations, is_corner: Vec::new(), distances: Vec::new(), far: Vec::new() },
        };
        for violation in &mut judged.violations {
            for place in &mut violation.witnesses {
                *place = match violation.check {
                    Check::Flipped | Check::ZeroArea | Check::Folded | Check::Far => own.quads[*place as usize],
                    Check::Corner | Check::FeatureCurve | Check::BoundaryCurve => part.vertices[*place as usize],
                    _ => own.vertices[*place as usize],
                };
            }
        }
        Ok((c, judged))
    };
    let judged: Vec<(usize, Judged)> = pairs.par_iter().map(of_pair).collect::<Result<_, Cancelled>>()?;
    let mut all = Judged { violations, is_corner: vec![false; quads.positions.len()], distances: Vec::new(), far };
    for (c, part) in judged {
        for (&v, is_corner) in quad_parts[c].vertices.iter().zip(part.is_corner) {
            all.is_corner[v as usize] = is_corner;
        }
        all.distances.extend(part.distances);
        join(&mut all.violations, part.violations);
    }
    Ok(all)
}

/// The checks of one connected component of the quads against its component of the surface. `diagonal` is the one of the
/// whole model: files round coordinates relative to it, however small a component is.
fn judge_pair(
    ctx: &RunContext,
    surface: &Surface,
    index: &SurfaceIndex,
    quads: &QuadMesh,
    topology: &QuadTopology,
    edge_length: f64,
    diagonal: f64,
) -> Result<Judged, Cancelled> {
    let curves = curves::check(ctx, surface, quads, topology, diagonal)?;
    let mut violations = orientation::check(ctx, surface, index, quads, topology, edge_length)?;
    violations.extend(curves.violations);
    violations.extend(boundary::check(&surface.mesh, quads, topology));
    Ok(Judged { violations, is_corner: curves.is_corner, distances: curves.distances, far: Vec::new() })
}
