//! The ladder of one component: the map first, then roads that need less, until a certificate passes.
//!
//! Every candidate goes through the same optimisation and the same certificate (`finish`). A panic on a road is
//! contained: it costs the component its level, never the run.

use std::cell::Cell;
use std::panic::{AssertUnwindSafe, catch_unwind};

use glam::DVec3;

use crate::engine::field::BranchOptions;
use crate::engine::mesh::Features;
use crate::engine::mesh::{SurfaceIndex, small_handles};
use crate::engine::methods::quad_cover::{QuadCoverError, QuadCoverMap, QuadCoverOptions, quad_cover};
use crate::engine::pipeline::component::{Component, DensePlace};
use crate::engine::pipeline::costs::{Draft, FIRST_TRY, Size, plan_of_try};
use crate::engine::pipeline::finish::{Improve, finish, last_resort};
use crate::engine::pipeline::report::Level;
use crate::engine::pipeline::road::Road;
use crate::engine::pipeline::spec::{Boundary, Optimise, RemeshSpec};
use crate::engine::pipeline::working::{Working, renumber_corners, working_surface};
use crate::engine::quad::QuadDraft;
use crate::engine::quad::extract::{ExtractError, extract_inner_quads, extract_quads};
use crate::engine::run::Cancelled;
use crate::engine::run::RunContext;
use crate::engine::run::Stage;
use crate::engine::run::StopReason;
use crate::engine::run::{Warning, WarningKind};

/// What became of one component.
#[derive(Debug)]
pub(super) struct Solved {
    pub(super) draft: QuadDraft,
    pub(super) level: Level,
    /// The map, also when the quads come from another level.
    pub(super) map: Option<(Working, QuadCoverMap)>,
    /// The features that the quads keep, where some of the component's were given up.
    pub(super) kept_features: Option<Features>,
    pub(super) warnings: Vec<Warning>,
}

/// Flipped triangles of a map after which no other field is tried.
const HOPELESS_FLIPS: usize = 400;
/// Integers of a map after which no other field is tried: rounding them takes longer than a fallback.
const HOPELESS_INTEGERS: usize = 500;

/// Most quads of a component for which a map with finer quads than asked for is tried.
const MOST_FINER: f64 = 10_000.0;
/// Most quads for which pairs of triangles are tried.
const MOST_PAIRED: f64 = 300_000.0;
/// Most triangles of a component for which a map with finer quads is tried.
const MOST_FACES_FINER: usize = 200_000;
/// The same where there are small handles: maps lose them, and so would every rung before the last.
const MOST_FACES_OF_HANDLES: usize = 1_000_000;
/// Handles with loops shorter than so many quad edges get smaller quads where the first map or its quads failed,
const SMALL_HANDLE: f64 = 3.0;
/// so many around them,
const QUADS_AROUND: f64 = 6.0;
/// but none of less than this part of the edge length.
const SMALLEST: f64 = 0.1;
/// Most triangles of a working mesh on which branch points are searched for: everything else takes its time there, too.
const MOST_FACES_SEARCHED: usize = 500_000;

/// One rung of the ladder.
#[derive(Clone, Copy)]
enum Rung {
    /// Field and map, with this smoothing of the field.
    Map(f64),
    /// As `Map`, of a grid that the boundary cuts at any angle.
    Open(f64),
    /// As `Map`, with smaller quads around the places where quads failed.
    Denser(f64),
    /// As `Map`, of quads of this length relative to those asked for.
    Finer(f64, f64),
    /// A road without a map.
    Plain(Road),
}

/// Features this many quad edges around reflex corners are given up first: the quads are certified, so little is wrong.
const REFLEX: f64 = 0.75;

/// What a failed map is called in warnings.
const NO_QUADS_FROM_MAP: &str = "no quads from the map";

/// Which of the detected features a rung keeps.
#[derive(Clone, Copy, PartialEq)]
enum Keep {
    /// All but those near places where quads failed, within so many quad edges (0: all).
    Far(f64),
    None,
}

/// The rungs in order. Features near failed quads are detail below the size of the quads, and go first; all go before
/// the map does only when pairs of triangles could not keep them either.
fn rungs(component: &Component, spec: &RemeshSpec) -> Vec<(Rung, Keep)> {
    let (map, smoother) = (Rung::Map(spec.smoothing), Rung::Map(0.5 + 0.5 * spec.smoothing));
    let is_open = spec.boundary == Boundary::Free && component.surface.mesh.topology().boundaries > 0;
    let open = is_open.then_some((Rung::Open(spec.smoothing), Keep::Far(0.0)));
    let aligned = [
        (map, Keep::Far(0.0)),
        (Rung::Denser(spec.smoothing), Keep::Far(0.0)),
        (map, Keep::Far(REFLEX)),
        (map, Keep::Far(1.5)),
        (smoother, Keep::Far(0.0)),
        (map, Keep::Far(4.0)),
        (Rung::Finer(spec.smoothing, 0.7), Keep::Far(0.0)),
        (Rung::Plain(Road::Paired(1)), Keep::Far(0.0)),
        (map, Keep::None),
        (Rung::Plain(Road::Paired(1)), Keep::None),
        (Rung::Finer(spec.smoothing, 0.5), Keep::Far(0.0)),
        (Rung::Plain(Road::Paired(3)), Keep::Far(4.0)),
        (Rung::Plain(Road::Paired(3)), Keep::None),
        (Rung::Plain(Road::Paired(9)), Keep::Far(0.0)),
        (Rung::Plain(Road::Paired(9)), Keep::None),
        (Rung::Plain(Road::SplitInput), Keep::Far(0.0)),
        (Rung::Plain(Road::SplitInput), Keep::None),
    ];
    open.into_iter().chain(aligned).collect()
}

/// A climb under way.
struct Climb<'a> {
    whole: &'a Component,
    /// The component with smaller quads where that was of use.
    base: Component,
    index: SurfaceIndex,
    /// Places where quads of the map failed, or have reflex corners.
    places: Vec<DVec3>,
    map: Option<(Working, QuadCoverMap)>,
    no_second_field: bool,
    /// Attempts that gave no certified quads.
    failures: usize,
    /// Whether an attempt was left out because the deadline was near.
    is_out_of_time: bool,
    warnings: Vec<Warning>,
}

/// Components of more triangles than this get no quads once the deadline has passed.
const MOST_AT_DEADLINE: usize = 50_000;

/// Finds certified quads for a component. When the deadline passes before there are any, a small component still gets
/// its split triangles.
///
/// # Errors
/// A stop of the run, or the cause why even the last level failed.
pub(super) fn solve(
    ctx: &RunContext,
    component: &Component,
    spec: &RemeshSpec,
) -> Result<Result<Solved, String>, Cancelled> {
    let mut good = None;
    let stop = match climb(ctx, component, spec, &mut good) {
        Err(stop @ Cancelled(StopReason::Deadline)) => stop,
        done => return done,
    };
    if let Some(Good { solved, .. }) = good {
        return Ok(Ok(solved));
    }
    if component.surface.mesh.n_faces() > MOST_AT_DEADLINE {
        return Err(stop);
    }
    let finished = last_resort(ctx, component)?;
    if finished.refusal.is_some() {
        return Err(stop);
    }
    let effect = "there was no time for better quads than split triangles".to_owned();
    let warnings =
        vec![WarningKind::Deadline { effect }.into(), WarningKind::Fallback { level: Level::L4 as u8 }.into()];
    Ok(Ok(Solved { draft: finished.draft, level: Level::L4, map: None, kept_features: None, warnings }))
}

/// Certified quads that leave something to be wished for.
struct Good {
    /// Whether they miss the count, how many have a straight or reflex corner, and their Hausdorff distance in quad
    /// edges.
    rank: (bool, usize, f64),
    solved: Solved,
}

/// Certified quads of a map that are farther than this many edges from the surface have lost a part of it: another map
/// may keep it.
const LOST_A_PART: f64 = 2.0;

/// Quads of which there are so many more or fewer than asked for, as a share, are delivered only for want of others.
const MISSED: f64 = 0.1;
/// A warning says so where there are also so many quads more.
const MANY_MORE: f64 = 50.0;

/// Goes up the rungs; `good` is what there is to deliver when the run is stopped on the way.
fn climb(
    ctx: &RunContext,
    component: &Component,
    spec: &RemeshSpec,
    good: &mut Option<Good>,
) -> Result<Result<Solved, String>, Cancelled> {
    let mut climb = Climb {
        whole: component,
        base: component.clone(),
        index: SurfaceIndex::new(&component.surface.mesh),
        places: Vec::new(),
        map: None,
        no_second_field: false,
        failures: 0,
        is_out_of_time: false,
        warnings: Vec::new(),
    };
    let mut last = String::new();
    for (rung, keep) in rungs(component, spec) {
        ctx.check()?;
        if !matches!(rung, Rung::Map(_) | Rung::Denser(_))
            && let Some(Good { solved, .. }) = good.take()
        {
            return Ok(Ok(solved));
        }
        if keep == Keep::Far(REFLEX) && good.is_none() {
            continue;
        }
        let Some(mut component) = climb.component(keep, spec) else { continue };
        if let Rung::Finer(_, factor) = rung {
            component = component.finer(factor);
            // Where nothing could be integrated, more quads are no help; and many of them take their time.
            let is_large = component.quads > MOST_FINER || component.surface.mesh.n_faces() > MOST_FACES_FINER;
            if climb.map.is_none() || is_large {
                continue;
            }
        }
        if let Rung::Denser(_) = rung {
            let handles = if good.is_none() { climb.small_handles(ctx)? } else { Vec::new() };
            let is_large = component.surface.mesh.n_faces() > MOST_FACES_FINER && handles.is_empty();
            let places = climb.places.iter().map(|&p| p.into()).chain(handles);
            match component.denser(places) {
                Some(denser) if !is_large => component = denser,
                _ => continue,
            }
        }
        if let Rung::Plain(Road::Paired(times)) = rung
            && f64::from(times) * component.quads > MOST_PAIRED
        {
            continue;
        }
        let keeps_all = component.surface.features == climb.whole.surface.features;
        if matches!(rung, Rung::Map(_)) && climb.no_second_field && keep == Keep::Far(0.0) {
            continue;
        }
        let size = Size::of_component(&component);
        let ctx = &ctx.attempt(FIRST_TRY).planned(plan_of_try(&size, Draft::ByMap { searched: false }));
        let (draft, map, level) = match rung {
            Rung::Map(smoothing) | Rung::Open(smoothing) | Rung::Denser(smoothing) | Rung::Finer(smoothing, _) => {
                let boundary_free = matches!(rung, Rung::Open(_));
                match climb.by_map(&ctx.unhurried(), &component, spec, smoothing, boundary_free) {
                    Ok(Some((draft, map))) => (draft, Some(map), Level::L0),
                    Ok(None) => continue,
                    Err(Cancelled(StopReason::Hurry)) => {
                        climb.no_time();
                        continue;
                    }
                    Err(stop) => return Err(stop),
                }
            }
            Rung::Plain(road) => {
                let ctx = &ctx.planned(plan_of_try(&size, Draft::Plain));
                let draft = || ctx.stage(Stage::Fallback, |ctx| road.draft(ctx, &component, &climb.index));
                match contained(draft) {
                    Some(draft) => (draft?, None, road.level()),
                    None => {
                        climb.failed(internal_error(format!("no quads of level {:?}", road.level())), &[]);
                        continue;
                    }
                }
            }
        };
        let improve = match rung {
            Rung::Map(_) | Rung::Open(_) | Rung::Denser(_) | Rung::Finer(..) => Improve::IfBad,
            Rung::Plain(Road::Paired(_)) => Improve::First,
            Rung::Plain(Road::SplitInput) => Improve::FirstIfFew,
        };
        let Some(finished) = contained(|| finish(ctx, &component, &climb.index, draft, improve)) else {
            climb.failed(internal_error(format!("quads of level {level:?} were not finished")), &[]);
            continue;
        };
        let finished = finished?;
        climb.no_second_field |= !matches!(rung, Rung::Open(_)) && map.as_ref().is_some_and(is_hopeless);
        let Some(refusal) = finished.refusal else {
            let mut warnings = climb.warnings.clone();
            if level > Level::L0 {
                warnings.push(WarningKind::Fallback { level: level as u8 }.into());
            }
            if map.is_none() && !(component.is_even() && component.strokes.is_empty()) {
                warnings.push(WarningKind::GuidanceIgnored {}.into());
            }
            let (n, wanted) = (finished.draft.mesh.quads.len() as f64, climb.whole.quads);
            let is_more = spec.adapt_count && n > (1.0 + MISSED) * wanted && n > wanted + MANY_MORE;
            if map.is_some() && (!component.dense.is_empty() || matches!(rung, Rung::Finer(..)) || is_more) {
                let places: Vec<DVec3> = component.dense.iter().map(|place| place.at).collect();
                let (quads, wanted) = (n as usize, wanted.round() as usize);
                warnings.push(Warning::new(
                    WarningKind::DensityFloor { around: places.len(), quads, wanted },
                    None,
                    &places,
                ));
            }
            let kept_features = (!keeps_all).then(|| component.surface.features.clone());
            let is_map = matches!(rung, Rung::Map(_) | Rung::Denser(_) | Rung::Finer(..));
            let map = map.or_else(|| climb.map.take());
            let solved = Solved { draft: finished.draft, level, map, kept_features, warnings };
            let misses = spec.adapt_count && (n / wanted - 1.0).abs() > MISSED;
            let rank = (misses, finished.reflex.len(), finished.away);
            let solved = match good.take() {
                Some(good) if good.rank <= rank => good,
                _ => Good { rank, solved },
            };
            // After some failures the climb has taken long enough.
            let failures = climb.failures;
            let is_small = component.surface.mesh.n_faces() < MOST_FACES_FINER;
            let is_lost = solved.rank.2 > LOST_A_PART && failures < 3 && is_small;
            let is_reflex = solved.rank.1 > 0 && failures < 2 && is_small;
            // Folds of the map that were filled make other quads than its area says; another map has other folds.
            let is_off = solved.rank.0 && failures < 3 && is_small;
            if !(is_map && (is_lost || is_reflex || is_off)) {
                return Ok(Ok(solved.solved));
            }
            // Reflex corners come from features below the size of the quads, not from the field.
            climb.no_second_field |= !(is_lost || is_off);
            climb.places.extend(finished.reflex);
            *good = Some(solved);
            continue;
        };
        let cause = refusal.cause.clone();
        let kind = match rung {
            Rung::Open(_) => WarningKind::BoundaryFollowed { cause },
            _ => WarningKind::AttemptFailed { attempt: format!("quads of level {level:?} were not certified"), cause },
        };
        climb.failed(kind, &refusal.places);
        if map.is_some() && keep != Keep::None {
            let denser = matches!(rung, Rung::Denser(_)) && good.is_none();
            climb.failed_at(denser.then_some(component), refusal.places);
        }
        climb.map = climb.map.take().or(map);
        last = refusal.cause;
    }
    Ok(Err(last))
}

impl Climb<'_> {
    /// Notes where quads failed. Smaller quads stay where that leaves fewer places than before, or gave quads at all.
    fn failed_at(&mut self, denser: Option<Component>, places: Vec<DVec3>) {
        match denser {
            Some(denser) if self.places.is_empty() || places.len() < self.places.len() => {
                (self.base, self.places) = (denser, places);
            }
            _ => self.places.extend(places),
        }
    }

    /// Places of handles that quads of this size can hardly go around, and maps lose.
    fn small_handles(&self, ctx: &RunContext) -> Result<Vec<DensePlace>, Cancelled> {
        if self.whole.surface.mesh.n_faces() > MOST_FACES_OF_HANDLES {
            return Ok(Vec::new());
        }
        let edge_length = self.whole.edge_length;
        let handles = small_handles(ctx, &self.whole.surface.mesh, SMALL_HANDLE * edge_length)?;
        let size = |girth: f64| (girth / (QUADS_AROUND * edge_length)).max(SMALLEST);
        Ok(handles.iter().map(|handle| DensePlace { at: handle.centre, size: size(handle.girth) }).collect())
    }

    /// Notes an attempt that gave no certified quads.
    fn failed(&mut self, kind: WarningKind, places: &[DVec3]) {
        self.failures += 1;
        self.warnings.push(Warning::new(kind, None, places));
    }

    /// Notes, once, that there is no time for another map.
    fn no_time(&mut self) {
        if !std::mem::replace(&mut self.is_out_of_time, true) {
            let effect = "no time was left for a map: the deadline was near".to_owned();
            self.failed(WarningKind::Deadline { effect }, &[]);
        }
    }

    /// The component with the features that a rung keeps; `None` if a rung above has tried the same.
    fn component(&self, keep: Keep, spec: &RemeshSpec) -> Option<Component> {
        // Features that the user named are never given up.
        let may_give_up = spec.features.edges.is_empty();
        match keep {
            Keep::Far(0.0) => Some(self.base.clone()),
            Keep::Far(_) if self.places.is_empty() || !may_give_up => None,
            Keep::Far(edges) => self.base.without_features_near(&self.places, edges * self.whole.edge_length),
            Keep::None if may_give_up => self.base.without_features(),
            Keep::None => None,
        }
    }

    /// Quads by field and map; `None`, with a warning, if there are none.
    fn by_map(
        &mut self,
        ctx: &RunContext,
        component: &Component,
        spec: &RemeshSpec,
        smoothing: f64,
        boundary_free: bool,
    ) -> Result<Option<(QuadDraft, (Working, QuadCoverMap))>, Cancelled> {
        // Branch points are worth their search where the first map or one near it is delivered; the rungs below want
        // any map at all.
        let is_near = smoothing == spec.smoothing && component.edge_length == self.whole.edge_length;
        let is_first = self.failures < 2 && is_near;
        let is_left_out = Cell::new(0);
        let by_map = || {
            let working =
                ctx.stage(Stage::Refine, |ctx| working_surface(ctx, component, &self.index, spec.working_mesh))?;
            let triangles = working.surface.mesh.n_faces();
            let is_small = triangles < MOST_FACES_SEARCHED;
            let branch_points = match spec.optimise {
                Optimise::Relocate if is_first && is_small => Some(BranchOptions { create: false }),
                Optimise::Balance if is_first && is_small => Some(BranchOptions { create: true }),
                _ => None,
            };
            if is_first && !is_small && spec.optimise != Optimise::None {
                is_left_out.set(triangles);
            }
            let draft = Draft::ByMap { searched: branch_points.is_some() };
            let ctx = &ctx.planned(plan_of_try(&Size::of_component(component), draft));
            let options = working.options(component, spec, smoothing, branch_points);
            by_map(ctx, working, &QuadCoverOptions { boundary_free, ..options })
        };
        let made = contained(by_map);
        if is_left_out.get() > 0 {
            self.warnings.push(WarningKind::OptimiseLeftOut { triangles: is_left_out.get() }.into());
        }
        match made {
            Some(Ok(found)) => return Ok(Some(found)),
            Some(Err(Failure::Cancelled(c))) => return Err(c),
            Some(Err(Failure::Cause(cause, map))) => {
                let kind = match boundary_free {
                    true => WarningKind::BoundaryFollowed { cause },
                    false => WarningKind::AttemptFailed { attempt: NO_QUADS_FROM_MAP.to_owned(), cause },
                };
                self.failed(kind, &[]);
                // Without a map another field fails the same way: too many integers, or a failed solve.
                self.no_second_field |= !boundary_free && map.as_deref().is_none_or(is_hopeless);
                self.map = self.map.take().or(map.map(|map| *map));
            }
            None => self.failed(internal_error(NO_QUADS_FROM_MAP.to_owned()), &[]),
        }
        Ok(None)
    }
}

/// Whether another try with another field would only take time: maps with this many flipped triangles come from detail
/// far below the size of the quads.
fn is_hopeless(map: &(Working, QuadCoverMap)) -> bool {
    map.1.measures.flipped > HOPELESS_FLIPS || map.1.n_integers > HOPELESS_INTEGERS
}

fn internal_error(attempt: String) -> WarningKind {
    WarningKind::InternalError { attempt }
}

/// What the work gives, unless it panics.
fn contained<T>(work: impl FnOnce() -> T) -> Option<T> {
    catch_unwind(AssertUnwindSafe(work)).ok()
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
    working: Working,
    options: &QuadCoverOptions,
) -> Result<(QuadDraft, (Working, QuadCoverMap)), Failure> {
    let map = quad_cover(ctx, &working.surface, options).map_err(|e| match e {
        QuadCoverError::Cancelled(c) => Failure::Cancelled(c),
        other => Failure::Cause(other.to_string(), None),
    })?;
    let extract = if options.boundary_free { extract_inner_quads } else { extract_quads };
    let extracted =
        ctx.stage(Stage::Extract, |ctx| extract(ctx, &working.surface.mesh, &working.surface.features, &map.grid));
    match extracted {
        Ok(extraction) => Ok((renumber_corners(extraction.draft, &working.corner_of), (working, map))),
        Err(ExtractError::Cancelled(c)) => Err(Failure::Cancelled(c)),
        Err(e) => Err(Failure::Cause(e.to_string(), Some(Box::new((working, map))))),
    }
}
