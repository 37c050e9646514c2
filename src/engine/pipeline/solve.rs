//! One component, from the problem to its quads: methods propose, one judge chooses, the best is kept.

use std::collections::VecDeque;
use std::panic::{AssertUnwindSafe, catch_unwind};

use glam::DVec3;

use crate::engine::mesh::Features;
use crate::engine::methods::{Cuboid, Level, MapProduct, MethodRef, Parameters};
use crate::engine::pipeline::attempt::{Attempt, Extracted, NoQuads};
use crate::engine::pipeline::costs::FIRST_TRY;
use crate::engine::pipeline::judged::Judged;
use crate::engine::pipeline::plan::{Plan, costs};
use crate::engine::pipeline::polish::{Depth, Polisher};
use crate::engine::pipeline::remedies::{Diagnosis, has_boundary};
use crate::engine::pipeline::spec::RemeshSpec;
use crate::engine::pipeline::sure::{STANDBY, Sure, at_the_deadline, sure_methods};
use crate::engine::problem::{Boundary, Problem};
use crate::engine::quad::QuadDraft;
use crate::engine::run::{Cancelled, RunContext, StopReason, Warning, WarningKind};

/// What became of one component.
#[derive(Debug)]
pub(super) struct Solution {
    pub(super) draft: QuadDraft,
    pub(super) level: Level,
    /// The map, also where the quads do not come from it.
    pub(super) map: Option<Box<MapProduct>>,
    /// The features that the quads keep, where some of the component's were given up.
    pub(super) kept_features: Option<Features>,
    pub(super) warnings: Vec<Warning>,
}

/// A component has no certified quads, and there is no time left.
#[derive(Debug)]
pub(super) struct Stopped {
    pub(super) stop: Cancelled,
    /// Why attempts failed, in order; none where the run was stopped for another reason.
    pub(super) causes: Vec<String>,
}

impl From<Cancelled> for Stopped {
    fn from(stop: Cancelled) -> Self {
        Self { stop, causes: Vec::new() }
    }
}

/// Quads of an attempt, judged.
struct Candidate {
    judged: Judged,
    level: Level,
    map: Option<Box<MapProduct>>,
    attempt: Attempt,
    depth: Depth,
}

/// Finds certified quads for a component. When the deadline passes, the best certified quads so far are the answer; where
/// there are none, split triangles, if they are made before the overtime ends.
///
/// # Errors
/// A stop of the run, or the cause why there are no certified quads.
pub(super) fn solve(
    ctx: &RunContext,
    problem: &Problem,
    spec: &RemeshSpec,
) -> Result<Result<Solution, String>, Stopped> {
    let method = if is_box(problem) { MethodRef(&Cuboid) } else { spec.method };
    let mut search = Search {
        whole: problem,
        spec,
        method,
        best: None,
        map: None,
        warnings: Vec::new(),
        causes: Vec::new(),
        refused: None,
        sure: VecDeque::new(),
        asked: 0,
    };
    search.sure = sure_methods(problem, search.may_give_up()).into();
    match search.run(ctx) {
        Err(stop @ Cancelled(StopReason::Deadline)) => match search.cut(ctx, stop) {
            Err(stop @ Cancelled(StopReason::Deadline | StopReason::Overtime)) => {
                return Err(Stopped { stop, causes: search.causes });
            }
            cut => cut?,
        },
        done => done?,
    }
    Ok(search.solution())
}

/// Where the method asked for may need more than this share of the time, a sure method is asked first: a prediction from
/// sizes is within about a factor of two.
const SAFE_SHARE: f64 = 0.5;

/// Fewer quads than a box of two by two on each side leave the integers of a map no choice.
const QUADS_OF_MAP: f64 = 24.0;

/// Whether a component is so small that its quads are a box.
fn is_box(problem: &Problem) -> bool {
    let topology = problem.surface.mesh.topology();
    problem.quads < QUADS_OF_MAP && topology.boundaries == 0 && topology.genus == 0
}

struct Search<'a> {
    whole: &'a Problem,
    spec: &'a RemeshSpec,
    /// The method asked for, or a box where there are too few quads for any other.
    method: MethodRef,
    /// The best quads so far.
    best: Option<Candidate>,
    /// A map, where quads come from elsewhere.
    map: Option<Box<MapProduct>>,
    warnings: Vec<Warning>,
    /// Why attempts failed, in order.
    causes: Vec<String>,
    /// Why the method's parameters cannot be met, if they cannot: nothing else is tried then.
    refused: Option<String>,
    /// The sure methods that were not asked yet, and how many were.
    sure: VecDeque<Sure>,
    asked: usize,
}

impl Search<'_> {
    fn run(&mut self, ctx: &RunContext) -> Result<(), Cancelled> {
        let asked = Attempt {
            method: self.method,
            parameters: if self.method == self.spec.method {
                self.spec.parameters.clone()
            } else {
                Parameters::default()
            },
            problem: self.whole.clone(),
            change: "as asked for",
        };
        let is_long = costs(&asked).total() > SAFE_SHARE * self.spec.time_limit;
        let mut plan = Plan::new(asked, self.spec.effort, self.may_give_up());
        let mut is_first = true;
        while let Some(attempt) = plan.next(ctx)? {
            // Before something takes long, sure methods are asked for quads to deliver at the deadline.
            if is_long || !is_first {
                self.stand_by(ctx, STANDBY)?;
            }
            is_first = false;
            let (diagnosis, places) = self.attempt(ctx, &attempt, Depth::Best)?;
            if self.refused.is_some() {
                return Ok(());
            }
            if diagnosis == Diagnosis::Complete {
                break;
            }
            plan.learn(&attempt, diagnosis, &places);
        }
        self.settle(ctx)
    }

    /// Asks the first so many sure methods that were not asked yet until there is something certified: each again with
    /// smaller quads where it failed.
    fn stand_by(&mut self, ctx: &RunContext, methods: usize) -> Result<(), Cancelled> {
        while self.asked < methods
            && !self.is_certified()
            && let Some(sure) = self.sure.pop_front()
        {
            self.ask(ctx, &sure)?;
        }
        Ok(())
    }

    /// Asks a sure method, and again with smaller quads where it failed as long as that leaves half the places.
    fn ask(&mut self, ctx: &RunContext, sure: &Sure) -> Result<(), Cancelled> {
        self.asked += 1;
        let mut next = Some(sure.attempt(self.whole));
        let mut most = usize::MAX;
        while let Some(attempt) = next.take() {
            let (diagnosis, places) = self.attempt(ctx, &attempt, Depth::Valid)?;
            if matches!(diagnosis, Diagnosis::Local) && places.len() <= most {
                most = places.len() / 2;
                next = sure.again(&attempt, &places);
            }
        }
        Ok(())
    }

    /// The best that there is where no attempt of the method asked for was certified: from any sure method, those that miss
    /// the count only if all do, and polished after all.
    fn settle(&mut self, ctx: &RunContext) -> Result<(), Cancelled> {
        let misses = |best: &Candidate| best.judged.quality.is_substitute && best.judged.quality.misses_count;
        while let Some(sure) = self.sure.pop_front() {
            if self.is_certified() && (sure.is_exact() || !self.best.as_ref().is_some_and(misses)) {
                break;
            }
            self.ask(ctx, &sure)?;
        }
        match self.best.as_ref().filter(|best| best.judged.is_certified() && best.depth == Depth::Valid) {
            Some(best) => self.attempt(ctx, &best.attempt.clone(), Depth::Best).map(|_| ()),
            None => Ok(()),
        }
    }

    /// Features that the user named never are given up.
    fn may_give_up(&self) -> bool {
        self.spec.features.edges.is_empty()
    }

    fn is_certified(&self) -> bool {
        self.best.as_ref().is_some_and(|best| best.judged.is_certified())
    }

    /// Makes an attempt; what is wrong with it, and where.
    fn attempt(
        &mut self,
        ctx: &RunContext,
        attempt: &Attempt,
        depth: Depth,
    ) -> Result<(Diagnosis, Vec<DVec3>), Cancelled> {
        let ctx = &ctx.attempt(FIRST_TRY).planned(costs(attempt));
        let work = || {
            let Extracted { draft, regularity, level, map } = attempt.quads(ctx)?;
            let polisher = Polisher { ctx, whole: self.whole, problem: &attempt.problem };
            match polisher.polish(draft, regularity, depth) {
                Ok(judged) => Ok((judged, level, map)),
                Err(stop) => Err(NoQuads::Cancelled(stop)),
            }
        };
        // A panic costs the component an attempt, never the run.
        let Ok(made) = catch_unwind(AssertUnwindSafe(work)) else {
            let attempt = format!("no quads by {} {}", attempt.method.name(), attempt.change);
            self.warnings.push(WarningKind::InternalError { attempt }.into());
            return Ok((Diagnosis::Nothing, Vec::new()));
        };
        let (mut judged, level, map) = match made {
            Ok(made) => made,
            Err(NoQuads::Cancelled(stop)) => return Err(stop),
            Err(NoQuads::Refused { cause }) => {
                self.refused = Some(cause);
                return Ok((Diagnosis::Nothing, Vec::new()));
            }
            Err(NoQuads::Cause { cause, map }) => {
                let diagnosis = if map.is_some() { Diagnosis::NoQuads } else { Diagnosis::Nothing };
                self.map = self.map.take().or(map);
                self.failed(attempt, "no quads", cause, &[]);
                return Ok((diagnosis, Vec::new()));
            }
        };
        judged.quality.is_substitute = attempt.method != self.method;
        let (diagnosis, places) = diagnose(&judged);
        if !judged.is_certified() {
            self.failed(attempt, "no certificate", judged.cause(), &places);
        }
        if self.best.as_ref().is_none_or(|best| judged.quality > best.judged.quality) {
            let before = self.best.replace(Candidate { judged, level, map, attempt: attempt.clone(), depth });
            self.map = self.map.take().or(before.and_then(|before| before.map));
        } else {
            self.map = self.map.take().or(map);
        }
        Ok((diagnosis, places))
    }

    fn failed(&mut self, attempt: &Attempt, what: &str, cause: String, places: &[DVec3]) {
        let is_open = attempt.problem.wishes.boundary == Boundary::Free && has_boundary(&attempt.problem);
        let kind = match is_open {
            true => WarningKind::BoundaryFollowed { cause: cause.clone() },
            false => {
                let attempt = format!("{what} for quads by {} {}", attempt.method.name(), attempt.change);
                WarningKind::AttemptFailed { attempt, cause: cause.clone() }
            }
        };
        self.causes.push(format!("{} {}: {cause}", attempt.method.name(), attempt.change));
        self.warnings.push(Warning::new(kind, None, places));
    }

    /// What can be done after the deadline: certified quads are the answer, and where there are none, split triangles.
    fn cut(&mut self, ctx: &RunContext, stop: Cancelled) -> Result<(), Cancelled> {
        if self.is_certified() {
            return Ok(());
        }
        let effect = "there was no time for better quads than split triangles".to_owned();
        self.warnings.push(WarningKind::Deadline { effect }.into());
        for sure in at_the_deadline(self.whole, self.may_give_up()) {
            self.attempt(&ctx.late(), &sure.attempt(self.whole), Depth::Valid)?;
            if self.is_certified() {
                return Ok(());
            }
        }
        Err(stop)
    }

    fn solution(self) -> Result<Solution, String> {
        let Self { whole, method, best, map, mut warnings, causes, refused, .. } = self;
        if let Some(cause) = refused {
            return Err(cause);
        }
        let best = best.filter(|best| best.judged.is_certified());
        let Some(Candidate { judged, level, map: own, attempt, .. }) = best else { return Err(causes.join("; ")) };
        if attempt.method != method {
            warnings.push(WarningKind::Fallback { level: level as u8 }.into());
        }
        let by = attempt.method.0;
        if !whole.strokes.is_empty() && !by.follows_strokes() || whole.field.is_some() && !by.follows_fields() {
            warnings.push(WarningKind::GuidanceIgnored {}.into());
        }
        if let Some(triangles) = own.as_ref().and_then(|map| map.search_left_out) {
            warnings.push(WarningKind::OptimiseLeftOut { triangles }.into());
        }
        let (quads, wanted) = (judged.draft.mesh.quads.len(), whole.quads.round() as usize);
        let is_finer = attempt.problem.edge_length < whole.edge_length || !attempt.problem.refined.is_empty();
        if own.is_some() && is_finer {
            let places: Vec<DVec3> = attempt.problem.refined.iter().map(|place| place.at).collect();
            let kind = WarningKind::DensityFloor { around: places.len(), quads, wanted };
            warnings.push(Warning::new(kind, None, &places));
        }
        let features = &attempt.problem.surface.features;
        let kept_features = (*features != whole.surface.features).then(|| features.clone());
        Ok(Solution { draft: judged.draft, level, map: own.or(map), kept_features, warnings })
    }
}

fn diagnose(judged: &Judged) -> (Diagnosis, Vec<DVec3>) {
    let quality = &judged.quality;
    if !judged.is_certified() {
        let diagnosis = if judged.failing.is_empty() { Diagnosis::Global } else { Diagnosis::Local };
        return (diagnosis, judged.failing.clone());
    }
    if quality.misses_count || quality.loses_a_part {
        return (Diagnosis::Incomplete, judged.lost.into_iter().collect());
    }
    (Diagnosis::Complete, Vec::new())
}
