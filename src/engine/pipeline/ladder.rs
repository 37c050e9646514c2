//! The ladder of one component: the map first, then roads that need less, until a certificate passes.
//!
//! Every candidate goes through the same optimisation and the same certificate. A panic in the map's road is contained:
//! it costs the component its level, never the run.

use std::panic::{AssertUnwindSafe, catch_unwind};

use crate::engine::certify::certify;
use crate::engine::fallback::{fallback_draft, split_draft};
use crate::engine::mesh::SurfaceIndex;
use crate::engine::mesh::{IsotropicOptions, remesh_isotropic};
use crate::engine::methods::quad_cover::{QuadCoverMap, QuadCoverOptions, quad_cover};
use crate::engine::pipeline::component::Component;
use crate::engine::pipeline::report::Level;
use crate::engine::pipeline::spec::{Align, RemeshSpec};
use crate::engine::pipeline::working::{Working, corner_map, renumber_corners, working_surface};
use crate::engine::quad::QuadDraft;
use crate::engine::quad::extract::extract_quads;
use crate::engine::quad::{OptimiseOptions, improve_connectivity, optimise};
use crate::engine::run::Cancelled;
use crate::engine::run::RunContext;
use crate::engine::run::Stage;

/// What became of one component.
#[derive(Debug)]
pub(super) struct Solved {
    pub(super) draft: QuadDraft,
    pub(super) level: Level,
    /// The map, also when the quads come from another level.
    pub(super) map: Option<(Working, QuadCoverMap)>,
    /// Whether the detected features of the component were given up.
    pub(super) gives_up_features: bool,
    pub(super) warnings: Vec<String>,
}

/// Flipped triangles of a map after which no other field is tried.
const HOPELESS_FLIPS: usize = 400;
/// Integers of a map after which no other field is tried: rounding them takes longer than a fallback.
const HOPELESS_INTEGERS: usize = 500;

/// Drafts with more quads than this times the number asked for (split triangles of the input) are not worth improving.
const MOST_IMPROVED: usize = 3;

/// Sweeps of the optimiser.
const OPTIMISE_ITERATIONS: usize = 20;

/// One rung of the ladder.
#[derive(Clone, Copy)]
enum Rung {
    /// Field and map, with this smoothing of the field.
    Map(f64),
    /// A road without a map.
    Plain(Road),
}

/// The rungs in order, and whether the features that were detected are given up on them. Features go before the map
/// does only when pairs of triangles could not keep them either: then they are detail below the size of the quads.
fn rungs(spec: &RemeshSpec) -> [(Rung, bool); 8] {
    [
        (Rung::Map(spec.smoothing), false),
        (Rung::Map(0.5 + 0.5 * spec.smoothing), false),
        (Rung::Plain(Road::Paired), false),
        (Rung::Map(spec.smoothing), true),
        (Rung::Plain(Road::SplitCoarse), false),
        (Rung::Plain(Road::Paired), true),
        (Rung::Plain(Road::SplitInput), false),
        (Rung::Plain(Road::SplitInput), true),
    ]
}

/// Finds certified quads for a component.
///
/// # Errors
/// A stop of the run, or the cause why even the last level failed.
pub(super) fn climb(
    ctx: &RunContext,
    component: &Component,
    spec: &RemeshSpec,
) -> Result<Result<Solved, String>, Cancelled> {
    let index = SurfaceIndex::new(&component.surface.mesh);
    // Features that the user named are never given up.
    let bare = (spec.features.edges.is_empty()).then(|| component.without_features()).flatten();
    let mut warnings = Vec::new();
    let mut kept_map: Option<(Working, QuadCoverMap)> = None;
    let mut no_second_field = false;
    let mut last = String::new();
    for (rung, gives_up_features) in rungs(spec) {
        ctx.check()?;
        let component = match (&bare, gives_up_features) {
            (_, false) => component,
            (Some(bare), true) => bare,
            (None, true) => continue,
        };
        let (draft, map, level) = match rung {
            Rung::Map(_) if no_second_field && !gives_up_features => continue,
            Rung::Map(smoothing) => {
                match catch_unwind(AssertUnwindSafe(|| by_map(ctx, component, &index, spec, smoothing))) {
                    Ok(Ok((draft, map))) => (draft, Some(map), Level::L0),
                    Ok(Err(Failure::Cancelled(c))) => return Err(c),
                    Ok(Err(Failure::Cause(cause, map))) => {
                        warnings.push(format!("no quads from the map: {cause}"));
                        // Without a map another field fails the same way: too many integers, or a failed solve.
                        no_second_field |= map.as_deref().is_none_or(is_hopeless);
                        kept_map = kept_map.or(map.map(|map| *map));
                        continue;
                    }
                    Err(_) => {
                        warnings.push("no quads from the map: an internal error was contained".to_owned());
                        continue;
                    }
                }
            }
            Rung::Plain(road) => {
                let draft = ctx.stage(Stage::Fallback, || road.draft(ctx, component, &index))?;
                (draft, None, road.level())
            }
        };
        let (draft, cause) = finish(ctx, component, &index, draft)?;
        no_second_field |= map.as_ref().is_some_and(is_hopeless);
        let Some(cause) = cause else {
            if gives_up_features {
                warnings.push("sharp edges were given up: they are detail below the size of the quads".to_owned());
            }
            let map = map.or(kept_map);
            return Ok(Ok(Solved { draft, level, map, gives_up_features, warnings }));
        };
        warnings.push(format!("quads of level {level:?} were not certified: {cause}"));
        kept_map = kept_map.or(map);
        last = cause;
    }
    Ok(Err(last))
}

/// The roads without a map, from best to surest.
#[derive(Clone, Copy)]
enum Road {
    /// Pairs of triangles of a coarse remesh, subdivided once.
    Paired,
    /// The triangles of a coarse remesh, split.
    SplitCoarse,
    /// The triangles of the input, split: the quads lie in the surface itself.
    SplitInput,
}

impl Road {
    fn level(self) -> Level {
        match self {
            Road::Paired => Level::L3,
            Road::SplitCoarse | Road::SplitInput => Level::L4,
        }
    }

    fn draft(self, ctx: &RunContext, component: &Component, index: &SurfaceIndex) -> Result<QuadDraft, Cancelled> {
        let surface = &component.surface;
        match self {
            Road::Paired => {
                let draft = fallback_draft(ctx, surface, index, component.quads.ceil() as usize)?;
                improve_connectivity(ctx, surface, index, draft)
            }
            Road::SplitCoarse => {
                // Three quads to a triangle: triangles of 4/√3 squared edges have three squared quad edges of area.
                let edge = component.edge_length * (3.0 * 4.0 / 3.0_f64.sqrt()).sqrt();
                let options = IsotropicOptions { tolerance: 0.1 * edge, ..IsotropicOptions::coarse(edge) };
                let coarse = remesh_isotropic(ctx, surface, index, &options)?;
                let corner_of = corner_map(&coarse, surface);
                Ok(renumber_corners(split_draft(&coarse), &corner_of))
            }
            Road::SplitInput => Ok(split_draft(surface)),
        }
    }
}

/// Whether another try with another field would only take time: maps with this many flipped triangles come from detail
/// far below the size of the quads.
fn is_hopeless(map: &(Working, QuadCoverMap)) -> bool {
    map.1.measures.flipped > HOPELESS_FLIPS || map.1.n_integers > HOPELESS_INTEGERS
}

enum Failure {
    Cancelled(Cancelled),
    Cause(String, Option<Box<(Working, QuadCoverMap)>>),
}

impl From<Cancelled> for Failure {
    fn from(c: Cancelled) -> Self {
        Self::Cancelled(c)
    }
}

fn by_map(
    ctx: &RunContext,
    component: &Component,
    index: &SurfaceIndex,
    spec: &RemeshSpec,
    smoothing: f64,
) -> Result<(QuadDraft, (Working, QuadCoverMap)), Failure> {
    use crate::engine::methods::quad_cover::QuadCoverError;
    use crate::engine::quad::extract::ExtractError;
    let edge_length = component.edge_length;
    let working =
        ctx.stage(Stage::Refine, || working_surface(ctx, &component.surface, index, edge_length, spec.working_mesh))?;
    let options = QuadCoverOptions {
        edge_length,
        quads: spec.adapt_count.then_some(component.quads),
        smoothing,
        guided: spec.align == Align::Curvature,
    };
    let map = quad_cover(ctx, &working.surface, &options).map_err(|e| match e {
        QuadCoverError::Cancelled(c) => Failure::Cancelled(c),
        other => Failure::Cause(other.to_string(), None),
    })?;
    let extracted =
        ctx.stage(Stage::Extract, || extract_quads(ctx, &working.surface.mesh, &working.surface.features, &map.grid));
    match extracted {
        Ok(extraction) => Ok((renumber_corners(extraction.draft, &working.corner_of), (working, map))),
        Err(ExtractError::Cancelled(c)) => Err(Failure::Cancelled(c)),
        Err(e) => Err(Failure::Cause(e.to_string(), Some(Box::new((working, map))))),
    }
}

/// Optimises a draft and asks the certificate; the cause is what it found wrong. Where the optimised quads fail, their
/// connectivity is improved once, and at last the draft is judged as it came.
fn finish(
    ctx: &RunContext,
    component: &Component,
    index: &SurfaceIndex,
    draft: QuadDraft,
) -> Result<(QuadDraft, Option<String>), Cancelled> {
    let surface = &component.surface;
    let options = OptimiseOptions { edge_length: component.edge_length, iterations: OPTIMISE_ITERATIONS };
    let judge = |draft: &QuadDraft| -> Result<Option<String>, Cancelled> {
        let certificate = ctx.stage(Stage::Certify, || certify(ctx, surface, index, &draft.mesh))?;
        Ok(certificate.violations.first().map(ToString::to_string))
    };
    if draft.mesh.quads.len() > MOST_IMPROVED * component.quads.ceil() as usize {
        let as_it_came = judge(&draft)?;
        return Ok((draft, as_it_came));
    }
    let optimised = ctx.stage(Stage::Optimise, || optimise(ctx, surface, index, draft.clone(), &options))?;
    let Some(cause) = judge(&optimised)? else { return Ok((optimised, None)) };
    let improved = ctx.stage(Stage::Optimise, || {
        let improved = improve_connectivity(ctx, surface, index, optimised)?;
        optimise(ctx, surface, index, improved, &options)
    })?;
    if judge(&improved)?.is_none() {
        return Ok((improved, None));
    }
    let as_it_came = judge(&draft)?;
    Ok((draft, as_it_came.map(|_| cause)))
}
