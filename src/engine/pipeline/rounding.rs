//! How well the integers of a model's maps are rounded: a measurement, not a stage of a run.

use crate::engine::field::BranchOptions;
use crate::engine::mesh::Detected;
use crate::engine::mesh::Surface;
use crate::engine::mesh::TriangleSoup;
use crate::engine::mesh::condition::{ConditionOptions, condition};
use crate::engine::methods::quad_cover::{QuadCoverError, RoundingTrial, rounding_trial, working_surface};
use crate::engine::pipeline::error::RemeshError;
use crate::engine::pipeline::remesh::{edge_length, features};
use crate::engine::pipeline::spec::{NonOrientable, RemeshSpec};
use crate::engine::problem::{Optimise, Problem, split};
use crate::engine::run::RunContext;

/// Compares ways of rounding on the maps that a run with this spec begins with, component by component, over `offsets`
/// random real optima each. Sizes are those that the detail asks for, and there is neither a second attempt nor symmetry.
///
/// # Errors
/// [`RemeshError`]: the input is refused, the run was stopped, or a component has no map.
pub fn rounding_trials(
    ctx: &RunContext,
    soup: &TriangleSoup,
    spec: &RemeshSpec,
    offsets: usize,
) -> Result<Vec<RoundingTrial>, RemeshError> {
    let options = ConditionOptions { cut_non_orientable: spec.non_orientable == NonOrientable::Cut };
    let conditioned = condition(ctx, soup, &options)?;
    let edge_length = edge_length(&conditioned, spec)?;
    let Detected { features, detail, .. } = features(&conditioned, soup, spec, edge_length);
    let surface = Surface { mesh: conditioned.mesh, features };
    let branch_points = match spec.optimise {
        Optimise::Relocate => Some(BranchOptions { create: false, price: BranchOptions::PRICE }),
        Optimise::Balance => Some(BranchOptions { create: true, price: BranchOptions::PRICE }),
        _ => None,
    };
    let trial = |(c, problem): (usize, &Problem)| {
        let working = working_surface(ctx, problem)?;
        let options = working.options(problem, branch_points.clone());
        rounding_trial(ctx, &working.surface, &options, offsets).map_err(|e| match e {
            QuadCoverError::Cancelled(c) => RemeshError::Cancelled(c),
            other => RemeshError::NoQuads { component: c, cause: other.to_string() },
        })
    };
    split(&surface, edge_length, spec.keeps_count(), &spec.wishes(), &[], &detail, &spec.strokes)
        .iter()
        .enumerate()
        .map(trial)
        .collect()
}
