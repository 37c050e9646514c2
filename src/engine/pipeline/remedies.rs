//! What comes next after an attempt: a table from diagnoses to changes of the problem or of the method.

use glam::DVec3;

use crate::engine::mesh::small_handles;
use crate::engine::pipeline::attempt::Attempt;
use crate::engine::problem::{Boundary, Optimise, Problem, RefinementPoint};
use crate::engine::run::{Cancelled, RunContext};

/// What is wrong with an attempt.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Diagnosis {
    /// Certified, and no attempt could give more.
    Complete,
    /// Certified, but a part of the surface is not shown, or the count is missed: the map has folds.
    Incomplete,
    /// The certificate refuses some places.
    Local,
    /// The certificate refuses, and nowhere in particular: a handle or a boundary loop is lost.
    Global,
    /// There are no quads, though there is a map.
    NoQuads,
    /// There is nothing.
    Nothing,
}

/// What is known of a component when the next attempt is chosen.
pub(super) struct Case<'a> {
    /// As it was asked for.
    pub(super) asked: &'a Attempt,
    /// With smaller quads where that was of use.
    pub(super) base: &'a Problem,
    /// Places where quads failed so far.
    pub(super) places: &'a [DVec3],
    /// The last attempt, and what was wrong with it.
    pub(super) last: &'a Attempt,
    pub(super) diagnosis: Diagnosis,
    /// Whether features may be given up: those that the user named never are.
    pub(super) may_give_up: bool,
}

/// A row of the table.
pub(super) struct Remedy {
    /// For which diagnoses.
    pub(super) helps: &'static [Diagnosis],
    pub(super) attempt: fn(&RunContext, &Case<'_>) -> Result<Option<Attempt>, Cancelled>,
    /// How often.
    pub(super) uses: Uses,
}

/// How often a remedy is used.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Uses {
    Once,
    /// Again if the last use left fewer places that fail.
    WhileItHelps,
}

use Diagnosis::{Global, Incomplete, Local, NoQuads, Nothing};

/// The remedies, best first; each is used once, smaller quads as long as they help. Features near failed quads are detail
/// below the size of the quads, and go before the field does; all of them go before the method does.
pub(super) const REMEDIES: &[Remedy] = &[
    Remedy { helps: &[Incomplete, Local, Global, NoQuads, Nothing], attempt: aligned_boundary, uses: Uses::Once },
    Remedy { helps: &[Incomplete, Local, Global, NoQuads, Nothing], attempt: refined, uses: Uses::WhileItHelps },
    Remedy {
        helps: &[Local, Global, NoQuads],
        attempt: |_, case| Ok(without_features_within(case, 1.5)),
        uses: Uses::Once,
    },
    Remedy { helps: &[Incomplete, Local, Global, NoQuads], attempt: smoother, uses: Uses::Once },
    Remedy {
        helps: &[Local, Global, NoQuads],
        attempt: |_, case| Ok(without_features_within(case, 4.0)),
        uses: Uses::Once,
    },
    Remedy { helps: &[Global, NoQuads], attempt: |_, case| Ok(finer(case, 0.7)), uses: Uses::Once },
    Remedy { helps: &[Local, Global, NoQuads], attempt: featureless, uses: Uses::Once },
];

/// Handles with loops shorter than so many quad edges get smaller quads where a map or its quads failed,
const SMALL_HANDLE: f64 = 3.0;
/// so many around them,
const QUADS_AROUND: f64 = 6.0;
/// but none of less than this part of the edge length.
const SMALLEST: f64 = 0.1;

/// The method of the case on another problem. Branch points are searched for once: what follows a failure wants quads.
fn again(case: &Case<'_>, problem: Problem, change: &'static str) -> Attempt {
    let mut attempt = Attempt { problem, change, ..case.asked.clone() };
    attempt.problem.wishes.optimise = Optimise::None;
    attempt.problem.wishes.boundary = Boundary::Align;
    attempt
}

/// A boundary that could not be left free is followed; everything else stays as it was asked for.
fn aligned_boundary(_: &RunContext, case: &Case<'_>) -> Result<Option<Attempt>, Cancelled> {
    let is_free = case.last.problem.wishes.boundary == Boundary::Free && has_boundary(case.base);
    Ok(is_free.then(|| {
        let mut attempt =
            Attempt { problem: case.base.clone(), change: "with the boundary followed", ..case.asked.clone() };
        attempt.problem.wishes.boundary = Boundary::Align;
        attempt
    }))
}

pub(super) fn has_boundary(problem: &Problem) -> bool {
    problem.surface.mesh.topology().boundaries > 0
}

/// Smaller quads around the places that failed, and around handles that quads of this size can hardly go around.
fn refined(ctx: &RunContext, case: &Case<'_>) -> Result<Option<Attempt>, Cancelled> {
    let edge_length = case.base.edge_length;
    let handles = match case.diagnosis {
        Incomplete => Vec::new(),
        _ => small_handles(ctx, &case.base.surface.mesh, SMALL_HANDLE * edge_length)?,
    };
    let size = |girth: f64| (girth / (QUADS_AROUND * edge_length)).max(SMALLEST);
    let handles = handles.iter().map(|handle| RefinementPoint { at: handle.centre, size: size(handle.girth) });
    let halved = case.base.halved_at(case.places, SMALLEST);
    let refined = halved.as_ref().unwrap_or(case.base).refined_at(handles).or(halved);
    Ok(refined.map(|problem| {
        let optimise = case.asked.problem.wishes.optimise;
        let mut attempt = again(case, problem, "with smaller quads at some places");
        attempt.problem.wishes.optimise = optimise;
        attempt
    }))
}

/// Without the features within so many quad edges of failed places.
fn without_features_within(case: &Case<'_>, edges: f64) -> Option<Attempt> {
    if !case.may_give_up || case.places.is_empty() {
        return None;
    }
    let problem = case.base.without_features_near(case.places, edges * case.base.edge_length)?;
    Some(again(case, problem, "without the features at some places"))
}

/// A field that follows curvature half as much.
fn smoother(_: &RunContext, case: &Case<'_>) -> Result<Option<Attempt>, Cancelled> {
    let mut problem = case.base.clone();
    problem.wishes.smoothing = 0.5 + 0.5 * problem.wishes.smoothing;
    let is_other = problem.wishes.smoothing > case.base.wishes.smoothing && problem.field.is_none();
    Ok(is_other.then(|| again(case, problem, "of a smoother field")))
}

/// Smaller quads everywhere.
fn finer(case: &Case<'_>, factor: f64) -> Option<Attempt> {
    Some(again(case, case.base.with_edges_times(factor), "with more quads"))
}

/// The method without any features inside the surface.
fn featureless(_: &RunContext, case: &Case<'_>) -> Result<Option<Attempt>, Cancelled> {
    let problem = case.base.without_features().filter(|_| case.may_give_up);
    Ok(problem.map(|problem| again(case, problem, "without features")))
}
