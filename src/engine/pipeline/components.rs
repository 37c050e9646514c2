//! All components of a model, side by side.

use rayon::prelude::*;

use crate::engine::pipeline::error::RemeshError;
use crate::engine::pipeline::solve::{Solution, Stopped, solve};
use crate::engine::pipeline::spec::RemeshSpec;
use crate::engine::problem::Problem;
use crate::engine::run::{RunContext, Stage, Warning, WarningKind};

/// Components in parallel, largest first so that the pool is never left waiting for a late large one.
/// # Errors
/// A stop of the run, or a component without certified quads.
pub(super) fn solve_all(
    ctx: &RunContext,
    problems: &[Problem],
    spec: &RemeshSpec,
) -> Result<Vec<Solution>, RemeshError> {
    let weights: Vec<f64> = problems.iter().map(|c| c.quads).collect();
    let parts = ctx.stages(Stage::Refine, Stage::Optimise).side_by_side(&weights);
    let mut order: Vec<usize> = (0..problems.len()).collect();
    order.sort_by(|&a, &b| problems[b].quads.total_cmp(&problems[a].quads).then(a.cmp(&b)));
    let stopped = |component: usize, Stopped { stop, causes }| match causes.is_empty() {
        true => RemeshError::Cancelled(stop),
        false => RemeshError::DeadlineExceeded { component, causes: causes.join("; "), stop },
    };
    let mut solved: Vec<(usize, Result<Solution, String>)> = order
        .into_par_iter()
        .with_max_len(1)
        .map(|c| {
            let result = solve(&parts[c], &problems[c], spec).map_err(|e| stopped(c, e))?;
            parts[c].advance(1.0);
            Ok((c, result))
        })
        .collect::<Result<_, RemeshError>>()?;
    solved.sort_by_key(|(c, _)| *c);
    solved
        .into_iter()
        .map(|(component, result)| result.map_err(|cause| RemeshError::NoQuads { component, cause }))
        .collect()
}

/// At most this many warnings of components are listed one by one.
const MAX_COMPONENT_WARNINGS: usize = 20;

/// What is to be said about components: the first warnings one by one, and how many more there are.
pub(super) fn warnings_of(solved: &[Solution]) -> Vec<Warning> {
    let name = |c: usize| (solved.len() > 1).then_some(c as u32);
    let of = |(c, s): (usize, &Solution)| {
        let named = move |w: &Warning| Warning { component: name(c), ..w.clone() };
        s.warnings.iter().map(named).collect::<Vec<_>>()
    };
    let mut all = solved.iter().enumerate().flat_map(of);
    let mut warnings: Vec<Warning> = all.by_ref().take(MAX_COMPONENT_WARNINGS).collect();
    let more = all.count();
    if more > 0 {
        warnings.push(WarningKind::MoreWarnings { warnings: more }.into());
    }
    warnings
}
