//! The list of stages of one run, from a soup to certified quads.

use glam::DVec3;

use crate::engine::attributes::{Origin, Preserve, QuadAttributes, carry, corner_normals};
use crate::engine::certify::{certify, new_crossings};
use crate::engine::field::strokes_off_surface;
use crate::engine::mesh::Conditioned;
use crate::engine::mesh::Features;
use crate::engine::mesh::Surface;
use crate::engine::mesh::SurfaceIndex;
use crate::engine::mesh::TriangleSoup;
use crate::engine::mesh::condition::{ConditionOptions, condition};
use crate::engine::mesh::{Detected, FeatureOptions, TriMesh, detect_features_and_detail};
use crate::engine::methods::Level;
use crate::engine::numerics::rounded;
use crate::engine::pipeline::components::{solve_all, warnings_of};
use crate::engine::pipeline::costs::{Size, plan_of_model};
use crate::engine::pipeline::error::RemeshError;
use crate::engine::pipeline::finding::Finding;
use crate::engine::pipeline::outcome::{MapOutcome, assemble_map};
use crate::engine::pipeline::report::{FeatureReport, InputReport, Repairs, Report};
use crate::engine::pipeline::sizing::sizes;
use crate::engine::pipeline::solve::Solution;
use crate::engine::pipeline::spec::{NonOrientable, RemeshSpec, Target};
use crate::engine::pipeline::symmetry::{Fold, fold, unfold_map, unfold_quads, unfold_surface};
use crate::engine::problem::{Problem, split};
use crate::engine::quad::QuadDraft;
use crate::engine::quad::QuadMesh;
use crate::engine::run::Cancelled;
use crate::engine::run::RunContext;
use crate::engine::run::Stage;
use crate::engine::run::StopReason;
use crate::engine::run::{Warning, WarningKind};

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

/// Loose feature chains shorter than this many quad edges are noise: a scan has hundreds, and each would cost
/// singularities.
pub(super) const SHORTEST_FEATURE: f64 = 4.0;

/// Most quads that an edge length may amount to.
const MAX_QUADS: f64 = 1e7;

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
    let log_size = ctx.stage(Stage::Features, |ctx| {
        sizes(ctx, &surface, &origin, soup, spec, edge_length, &mut warnings).map_err(RemeshError::from)
    })?;
    for stroke in strokes_off_surface(&surface.mesh, &spec.strokes, edge_length) {
        warnings.push(WarningKind::StrokeOffSurface { stroke }.into());
    }
    let made = match spec.symmetry.as_slice() {
        [] => None,
        axes => made_symmetric(ctx, &surface, &log_size, axes, edge_length, spec, &mut warnings)?,
    };
    let symmetry = if made.is_some() { spec.symmetry.clone() } else { Vec::new() };
    let made = match made {
        Some(made) => made,
        None => make(ctx, surface.clone(), edge_length, &log_size, &detail, &origin, spec)?,
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
        let own = (!spec.symmetry.is_empty()).then(|| SurfaceIndex::new(&surface.mesh));
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

/// Quads that are not judged yet, and what they belong to.
struct Made {
    /// What they are to be judged by: features that were given up are gone.
    surface: Surface,
    quads: QuadMesh,
    /// Edges of the quads on features that were kept, (lower, higher), sorted.
    feature_edges: Vec<[u32; 2]>,
    /// Component of the surface per quad.
    component: Vec<u32>,
    map: Option<MapOutcome>,
    /// Per component.
    levels: Vec<Level>,
    /// Feature edges that were given up, by their middles.
    given_up: Vec<DVec3>,
    warnings: Vec<Warning>,
}

/// Solves the components of a surface. `origin` says per vertex which one of the input it is, or is empty.
fn make(
    ctx: &RunContext,
    mut surface: Surface,
    edge_length: f64,
    log_size: &[f64],
    detail: &[u32],
    origin: &[u32],
    spec: &RemeshSpec,
) -> Result<Made, RemeshError> {
    let mut problems =
        split(&surface, edge_length, spec.keeps_count(), &spec.wishes(), log_size, detail, &spec.strokes);
    for problem in &mut problems {
        problem.inputs = problem.vertices.iter().filter_map(|&v| origin.get(v as usize).copied()).collect();
    }
    let solved = solve_all(ctx, &problems, spec)?;
    let levels: Vec<Level> = solved.iter().map(|s| s.level).collect();
    let given_up = give_up_features(&mut surface, &problems, &solved);
    let warnings = warnings_of(&solved);
    let map = assemble_map(&problems, &solved, spec.working_mesh);
    let mut draft = QuadDraft::default();
    let mut component = Vec::new();
    for (c, s) in (0..).zip(solved) {
        draft.append(s.draft);
        component.resize(draft.mesh.quads.len(), c);
    }
    let QuadDraft { mesh: quads, mut feature_edges, .. } = draft;
    feature_edges.sort_unstable();
    Ok(Made { surface, quads, feature_edges, component, map, levels, given_up, warnings })
}

/// Solves a part of a surface and adds its images; `None` with a warning if that does not make certified quads.
fn made_symmetric(
    ctx: &RunContext,
    whole: &Surface,
    log_size: &[f64],
    axes: &[usize],
    edge_length: f64,
    spec: &RemeshSpec,
    warnings: &mut Vec<Warning>,
) -> Result<Option<Made>, RemeshError> {
    let min_length = SHORTEST_FEATURE * edge_length;
    let fold = ctx.stage(Stage::Condition, |ctx| fold(ctx, whole, log_size, axes, min_length, warnings))?;
    let cause = match make(ctx, fold.surface.clone(), edge_length, &fold.log_size, &[], &[], spec) {
        Err(RemeshError::NoQuads { cause, .. }) => cause,
        made => match unfolded(made?, whole, &fold) {
            None => "the images do not fit together".to_owned(),
            Some(made) => {
                let late = (ctx.stopped() == Some(StopReason::Deadline)).then(|| ctx.late());
                let ctx = late.as_ref().unwrap_or(ctx);
                let index = SurfaceIndex::new(&made.surface.mesh);
                let certificate =
                    ctx.stage(Stage::Certify, |ctx| certify(ctx, &made.surface, &index, &made.quads, edge_length))?;
                match certificate.violations.first() {
                    None => return Ok(Some(made)),
                    Some(violation) => violation.to_string(),
                }
            }
        },
    };
    warnings.push(WarningKind::SymmetryDropped { cause }.into());
    Ok(None)
}

/// What was made for a part, with its images; `None` if they do not fit together.
fn unfolded(made: Made, whole: &Surface, fold: &Fold) -> Option<Made> {
    let surface = unfold_surface(&made.surface, &fold.unfoldings)?;
    let asked = unfold_surface(&fold.surface, &fold.unfoldings)?;
    let given_up = asked.features.without(&surface.features).map(|e| middle(&surface.mesh, e)).collect();
    let (quads, feature_edges) = unfold_quads(made.quads, made.feature_edges, &fold.unfoldings);
    let map = made.map.map(|map| unfold_map(map, &fold.unfoldings));
    // A component of the whole may be several of the part, and the other way round.
    let (part_of, _) = fold.surface.mesh.components();
    let (whole_of, n) = surface.mesh.components();
    let mut levels = vec![Level::L0; n];
    for (f, &c) in whole_of.iter().enumerate() {
        levels[c as usize] = levels[c as usize].max(made.levels[part_of[f % part_of.len()] as usize]);
    }
    let (component_of, index) = (whole.mesh.components().0, SurfaceIndex::new(&whole.mesh));
    let centre = |q: &[u32; 4]| q.iter().map(|&v| quads.positions[v as usize]).sum::<DVec3>() / 4.0;
    let component = quads.quads.iter().map(|q| component_of[index.closest(centre(q)).face as usize]).collect();
    Some(Made { surface, quads, feature_edges, component, map, levels, given_up, warnings: made.warnings })
}

fn has_attributes(soup: &TriangleSoup, wanted: Preserve) -> bool {
    wanted.materials && !soup.materials.is_empty()
        || wanted.vertex_colours && !soup.colours.is_empty()
        || wanted.uv && !soup.uv.is_empty()
        || wanted.skin && !soup.skin.is_empty()
        || !soup.objects.is_empty()
}

pub(super) fn edge_length(conditioned: &Conditioned, spec: &RemeshSpec) -> Result<f64, RemeshError> {
    let area = conditioned.mesh.total_area();
    match spec.target {
        Target::Quads(n) => Ok(rounded((area / n.max(1) as f64).sqrt())),
        Target::EdgeLength(edge_length) => {
            let quads = area / (edge_length * edge_length);
            if quads > MAX_QUADS {
                return Err(RemeshError::TooManyQuads { edge_length, quads, limit: MAX_QUADS });
            }
            Ok(edge_length)
        }
    }
}

/// The features, and what is known of those that are none.
pub(super) fn features(
    conditioned: &Conditioned,
    soup: &TriangleSoup,
    spec: &RemeshSpec,
    edge_length: f64,
) -> Detected {
    let options = FeatureOptions {
        angle_degrees: spec.features.angle_degrees,
        materials: spec.features.materials,
        normals: spec.features.normals,
        explicit: spec.features.edges.clone(),
        min_length: SHORTEST_FEATURE * edge_length,
    };
    detect_features_and_detail(conditioned, soup, &options)
}

/// The middle of an edge; how a report names edges that were given up, whatever surface they are found on again.
pub(super) fn middle(mesh: &TriMesh, edge: [u32; 2]) -> DVec3 {
    let [a, b] = edge.map(|v| mesh.position(v));
    0.5 * (a + b)
}

/// Takes the features that components gave up out of the surface that the certificate compares with. The middles of
/// their edges.
fn give_up_features(surface: &mut Surface, problems: &[Problem], solved: &[Solution]) -> Vec<DVec3> {
    if solved.iter().all(|s| s.kept_features.is_none()) {
        return Vec::new();
    }
    let mut features = Features::default();
    for (problem, solved) in problems.iter().zip(solved) {
        let own = solved.kept_features.as_ref().unwrap_or(&problem.surface.features);
        let name = |v: u32| problem.vertices[v as usize];
        features.edges.extend(own.edges.iter().map(|e| e.map(name)).map(|[a, b]| [a.min(b), a.max(b)]));
        features.corners.extend(own.corners.iter().map(|&v| name(v)));
    }
    features.edges.sort_unstable();
    features.corners.sort_unstable();
    let given_up = surface.features.without(&features).map(|e| middle(&surface.mesh, e)).collect();
    surface.features = features;
    given_up
}

#[cfg(test)]
mod tests;
