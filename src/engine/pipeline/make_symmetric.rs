//! The quads of a surface that are their own mirror image: those of a part, with its images.

use glam::DVec3;

use crate::engine::certify::certify;
use crate::engine::mesh::{Surface, SurfaceIndex};
use crate::engine::methods::Level;
use crate::engine::pipeline::error::RemeshError;
use crate::engine::pipeline::make::{Asked, Made, make};
use crate::engine::pipeline::surface::{SHORTEST_FEATURE, middle};
use crate::engine::pipeline::symmetry::{Fold, fold, unfold_map, unfold_quads, unfold_surface};
use crate::engine::run::{RunContext, Stage, StopReason, Warning, WarningKind};

/// Solves a part of a surface and adds its images; `None` with a warning if that does not make certified quads.
pub(super) fn made_symmetric(
    ctx: &RunContext,
    whole: &Surface,
    log_size: &[f64],
    axes: &[usize],
    asked: &Asked<'_>,
    warnings: &mut Vec<Warning>,
) -> Result<Option<Made>, RemeshError> {
    let edge_length = asked.edge_length;
    let min_length = SHORTEST_FEATURE * edge_length;
    let fold = ctx.stage(Stage::Condition, |ctx| fold(ctx, whole, log_size, axes, min_length, warnings))?;
    let field = asked.field.map(|field| field.carried(&whole.mesh, &fold.surface.mesh));
    let of_part = Asked { field: field.as_ref(), ..*asked };
    let cause = match make(ctx, fold.surface.clone(), &fold.log_size, &[], &of_part) {
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
