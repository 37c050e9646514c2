//! The quads of a surface that are their own mirror image: those of a part, with its images. Planes that are not across
//! the axes are found or known by their normals; then all of this happens to the turned model, and what comes of it is
//! turned back.

use glam::{DMat3, DVec3};

use crate::engine::certify::certify;
use crate::engine::mesh::{Surface, SurfaceIndex};
use crate::engine::methods::Level;
use crate::engine::pipeline::error::RemeshError;
use crate::engine::pipeline::make::{Asked, Made, make};
use crate::engine::pipeline::spec::Symmetry;
use crate::engine::pipeline::surface::{SHORTEST_FEATURE, middle};
use crate::engine::pipeline::symmetry::{
    Fold, FoundPlane, MOST, MirrorPlane, Planes, find_planes, fold, turned, unfold_map, unfold_quads, unfold_surface,
};
use crate::engine::problem::Boundary;
use crate::engine::run::{RunContext, Stage, StopReason, Warning, WarningKind};

/// Symmetry within this share of the diagonal is offered where none was asked for: more would change what is seen.
const OFFERED: f64 = 0.01;

/// Quads that are their own image, and the planes at which they are.
pub(super) type Symmetric = (Made, Vec<MirrorPlane>);

/// Quads with the symmetry asked for; `None`, with a warning, where there is none to be had. Where none is asked for, one
/// that the model has is offered.
pub(super) fn symmetric(
    ctx: &RunContext,
    whole: &Surface,
    log_size: &[f64],
    asked: &Asked<'_>,
    warnings: &mut Vec<Warning>,
) -> Result<Option<Symmetric>, RemeshError> {
    let find = |most: f64| ctx.stage(Stage::Condition, |ctx| find_planes(ctx, &whole.mesh, most));
    match &asked.spec.symmetry {
        Symmetry::Across(axes) if axes.is_empty() => {
            if asked.spec.boundary != Boundary::Free
                && let Some(best) = find(OFFERED)?.first()
            {
                warnings.push(offer(best).into());
            }
            Ok(None)
        }
        Symmetry::Across(axes) => made_symmetric(ctx, whole, log_size, &Planes::across(axes), asked, warnings),
        Symmetry::Auto => {
            let mut planes: Vec<MirrorPlane> = find(MOST)?.iter().map(|found| found.plane).collect();
            while !planes.is_empty() {
                let mut own = Vec::new();
                match made_symmetric(ctx, whole, log_size, &Planes::known(&planes), asked, &mut own) {
                    Err(RemeshError::NotSymmetric { .. }) => planes.truncate(planes.len() - 1),
                    made => {
                        warnings.extend(own);
                        return made;
                    }
                }
            }
            warnings.push(WarningKind::NoSymmetry { percent: 100.0 * MOST }.into());
            Ok(None)
        }
    }
}

fn offer(found: &FoundPlane) -> WarningKind {
    let [normal_x, normal_y, normal_z] = found.plane.normal.to_array();
    WarningKind::SymmetryOffered {
        percent: 100.0 * found.away,
        normal_x,
        normal_y,
        normal_z,
        offset: found.plane.offset,
    }
}

/// Solves a part of a surface and adds its images; `None` with a warning if that does not make certified quads.
fn made_symmetric(
    ctx: &RunContext,
    whole: &Surface,
    log_size: &[f64],
    planes: &Planes,
    asked: &Asked<'_>,
    warnings: &mut Vec<Warning>,
) -> Result<Option<Symmetric>, RemeshError> {
    let Some(turn) = planes.turn() else { return made_in_frame(ctx, whole, log_size, planes, asked, warnings) };
    let mut spec = asked.spec.clone();
    spec.strokes.iter_mut().flatten().for_each(|p| *p = turn * *p);
    let field = asked.field.map(|field| field.turned(turn));
    let in_frame = Asked { spec: &spec, field: field.as_ref(), ..*asked };
    let made = made_in_frame(ctx, &turned(whole, turn), log_size, planes, &in_frame, warnings)?;
    Ok(made.map(|(made, planes)| (made.turned(turn.transpose()), planes)))
}

/// The same where the planes lie across the axes.
fn made_in_frame(
    ctx: &RunContext,
    whole: &Surface,
    log_size: &[f64],
    planes: &Planes,
    asked: &Asked<'_>,
    warnings: &mut Vec<Warning>,
) -> Result<Option<Symmetric>, RemeshError> {
    let edge_length = asked.edge_length;
    let min_length = SHORTEST_FEATURE * edge_length;
    let fold = ctx.stage(Stage::Condition, |ctx| fold(ctx, whole, log_size, planes, min_length, warnings))?;
    let field = asked.field.map(|field| field.carried(&whole.mesh, &fold.surface.mesh));
    let of_part = Asked { field: field.as_ref(), ..*asked };
    let cause = match make(ctx, fold.surface.clone(), &fold.log_size, &[], &[], &of_part) {
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
                    None => return Ok(Some((made, fold.planes))),
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

impl Made {
    /// All of it moved by a rotation.
    fn turned(self, turn: DMat3) -> Self {
        let Self { surface, mut quads, mut map, mut given_up, mut warnings, .. } = self;
        let positions = map.iter_mut().flat_map(|map| &mut map.positions);
        let places = warnings.iter_mut().flat_map(|warning| &mut warning.places);
        quads.positions.iter_mut().chain(positions).chain(&mut given_up).chain(places).for_each(|p| *p = turn * *p);
        Self { surface: turned(&surface, turn), quads, map, given_up, warnings, ..self }
    }
}
