//! The list of stages of one run, from a soup to certified quads.

use crate::engine::attributes::{Origin, Preserve, QuadAttributes, carry, corner_normals};
use crate::engine::certify::{certify, new_crossings};
use crate::engine::field::{FrameField, strokes_off_surface};
use crate::engine::mesh::condition::{ConditionOptions, condition};
use crate::engine::mesh::{Conditioned, Detected, Surface, SurfaceIndex, TriangleSoup};
use crate::engine::methods::Level;
use crate::engine::pipeline::costs::{Size, plan_of_model};
use crate::engine::pipeline::error::RemeshError;
use crate::engine::pipeline::finding::Finding;
use crate::engine::pipeline::make::{Asked, make};
use crate::engine::pipeline::make_symmetric::symmetric;
use crate::engine::pipeline::outcome::MapOutcome;
use crate::engine::pipeline::report::{FeatureReport, InputReport, Repairs, Report};
use crate::engine::pipeline::sizing::sizes;
use crate::engine::pipeline::spec::{NonOrientable, RemeshSpec};
use crate::engine::pipeline::surface::{edge_length, features};
use crate::engine::quad::QuadMesh;
use crate::engine::run::{Cancelled, RunContext, Stage, StopReason, Warning, WarningKind};

/// Everything a run gives.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// The quads of all components.
    pub quads: QuadMesh,
    /// What they carry of the input.
    pub attributes: QuadAttributes,
    /// The parameterisation of the components that have one.
    pub map: Option<MapOutcome>,
    /// The conditioned surface, for certifying the quads again after they were written and re-read.
    pub surface: Surface,
    /// The report; its certificate is of the quads in memory.
    pub report: Report,
}

/// Runs the engine on one model.
///
/// ```
/// use quadrille::engine::mesh::shapes::sample;
/// use quadrille::engine::pipeline::{RemeshSpec, Target, remesh};
/// use quadrille::engine::run::RunContext;
///
/// let soup = sample("torus", 2000, 0.0, 0).expect("one of the samples");
/// let spec = RemeshSpec { target: Target::Quads(300), ..RemeshSpec::default() };
/// let outcome = remesh(&RunContext::silent(), &soup, &spec)?;
/// assert!(outcome.report.certified);
/// assert_eq!(outcome.quads.quads.len(), outcome.report.quads.count);
/// # Ok::<(), quadrille::engine::pipeline::RemeshError>(())
/// ```
///
/// # Errors
/// [`RemeshError`]: the input is refused, the run was stopped, or no certified quads were found.
pub fn remesh(ctx: &RunContext, soup: &TriangleSoup, spec: &RemeshSpec) -> Result<Outcome, RemeshError> {
    let guess = Size::of(soup.n_polygons() as f64, spec);
    let ctx = &ctx.planned(plan_of_model(&guess, spec));
    let conditioned = ctx.stage(Stage::Condition, |ctx| {
        let options = ConditionOptions { cut_non_orientable: spec.non_orientable == NonOrientable::Cut };
        condition(ctx, soup, &options).map_err(RemeshError::from)
    })?;
    let edge_length = edge_length(&conditioned, spec)?;
    let quads = conditioned.mesh.total_area() / (edge_length * edge_length);
    let ctx = &ctx.planned(plan_of_model(&Size { triangles: conditioned.mesh.n_faces() as f64, quads }, spec));
    let Detected { features, detail, dropped } =
        ctx.stage(Stage::Features, |_| Ok::<_, Cancelled>(features(&conditioned, soup, spec, edge_length)))?;
    let Conditioned { mesh, polygon, repairs, mut warnings, origin, .. } = conditioned;
    let surface = Surface { mesh, features };
    let field = match &spec.field {
        None => None,
        Some(given) => Some(FrameField::on_surface(given, soup, &surface.mesh, &polygon)?),
    };
    let asked = Asked { spec, edge_length, field: field.as_ref() };
    let log_size = ctx.stage(Stage::Features, |ctx| {
        sizes(ctx, &surface, &origin, soup, &asked, &mut warnings).map_err(RemeshError::from)
    })?;
    for stroke in strokes_off_surface(&surface.mesh, &spec.strokes, edge_length) {
        warnings.push(WarningKind::StrokeOffSurface { stroke }.into());
    }
    let (made, symmetry) = match symmetric(ctx, &surface, &log_size, &asked, &mut warnings)? {
        Some(made) => made,
        None => (make(ctx, surface.clone(), &log_size, &detail, &origin, &asked)?, Vec::new()),
    };
    // Where the deadline passed and every component has quads nevertheless, they are delivered, if judging and writing
    // them ends soon.
    let late = (ctx.stopped() == Some(StopReason::Deadline)).then(|| ctx.late());
    let ctx = late.as_ref().unwrap_or(ctx);
    warnings.extend(made.warnings);
    let index = SurfaceIndex::new(&made.surface.mesh);
    let certificate = ctx.stage(Stage::Certify, |ctx| {
        certify(ctx, &made.surface, &index, &made.quads, edge_length).map_err(RemeshError::from)
    })?;
    if !certificate.certified {
        let cause: Vec<String> = certificate.violations.iter().map(ToString::to_string).collect();
        return Err(RemeshError::NotCertified { cause: cause.join("; ") });
    }
    let mut attributes = if has_attributes(soup, spec.preserve) {
        // A surface that was mirrored is not the one that the attributes belong to.
        let own = spec.symmetry.is_wanted().then(|| SurfaceIndex::new(&surface.mesh));
        let origin = Origin::new(soup, &surface.mesh, &polygon, own.as_ref().unwrap_or(&index));
        match ctx.stage(Stage::Write, |ctx| carry(ctx, &origin, &made.quads, &made.component, spec.preserve)) {
            // The quads are there: they are worth more than what they would have carried.
            Err(Cancelled(StopReason::Deadline)) => {
                let what = "the deadline passed before attributes were carried to the quads".to_owned();
                warnings.push(WarningKind::AttributesLost { what }.into());
                QuadAttributes::default()
            }
            carried => carried?,
        }
    } else {
        QuadAttributes::default()
    };
    match ctx.stage(Stage::Write, |ctx| corner_normals(ctx, &made.quads, &made.feature_edges)) {
        Err(Cancelled(StopReason::Deadline)) => {
            let what = "the deadline passed before the quads had normals".to_owned();
            warnings.push(WarningKind::AttributesLost { what }.into());
        }
        normals => attributes.normals = normals?,
    }
    let features = FeatureReport::of(&surface.mesh, &dropped, &made.given_up, made.surface.features.edges.len());
    let crossings = ctx.stage(Stage::Certify, |ctx| {
        new_crossings(ctx, &made.surface.mesh, &index, &made.quads, edge_length).map_err(RemeshError::from)
    })?;
    if !crossings.is_empty() {
        let kind = WarningKind::SheetsIntersect { pairs: crossings.len() };
        warnings.push(Warning::new(kind, None, &crossings));
    }
    let result = Finding { quads: &made.quads, certificate: &certificate, surface: &made.surface, edge_length };
    warnings.extend(result.warnings(spec, &features));
    let topology = surface.mesh.topology();
    let report = Report {
        method: spec.method.name(),
        certified: true,
        cut_by_deadline: late.is_some(),
        level: made.levels.iter().copied().max().unwrap_or(Level::L0),
        component_levels: made.levels,
        input: InputReport {
            vertices: surface.mesh.n_vertices(),
            triangles: surface.mesh.n_faces(),
            components: topology.components,
            boundaries: topology.boundaries,
            genus: topology.genus,
            feature_edges: made.surface.features.edges.len(),
            repairs: Repairs { counts: repairs },
        },
        edge_length,
        features,
        symmetry,
        quads: certificate.measures,
        map: made.map.as_ref().map(|m| m.report.clone()),
        warnings,
    };
    Ok(Outcome { quads: made.quads, attributes, map: made.map, surface: made.surface, report })
}

fn has_attributes(soup: &TriangleSoup, wanted: Preserve) -> bool {
    wanted.materials && !soup.materials.is_empty()
        || wanted.vertex_colours && !soup.colours.is_empty()
        || wanted.uv && !soup.uv.is_empty()
        || wanted.skin && !soup.skin.is_empty()
        || !soup.objects.is_empty()
}

#[cfg(test)]
mod tests;
