//! From a draft to the best quads that can be made of it without another attempt: a list of steps, each of which is kept
//! if and only if the quality rises.

use crate::engine::field::FrameKind;
use crate::engine::mend::{MendOptions, mend};
use crate::engine::pipeline::attempt::Regularity;
use crate::engine::pipeline::judged::{Judged, PART_LOST, judge};
use crate::engine::problem::Problem;
use crate::engine::quad::{OptimiseOptions, QuadDraft, improve_connectivity, optimise, reach_out, remove_doublets};
use crate::engine::run::{Cancelled, RunContext, Stage, StopReason};

/// Sweeps of the optimiser.
const SWEEPS: usize = 20;

/// Drafts of which more than this share of the quads fails (or more than a few) are bad as a whole: mending them costs
/// seconds and leaves a part of them as bad as it was. Another map is what they need.
const MOST: f64 = 0.05;
const FEW: usize = 20;

/// Rings of quads around pulled vertices that come after them: a pull is shorter than two edges.
const RINGS: usize = 5;

/// What is polished: quads that were made for `problem`, which `whole` became when something was given up or refined.
pub(super) struct Polisher<'a> {
    pub(super) ctx: &'a RunContext,
    pub(super) whole: &'a Problem,
    pub(super) problem: &'a Problem,
}

/// A step: from the draft as it came and the best quads so far to candidates, best guess first.
type Step = for<'a> fn(&Polisher<'a>, &QuadDraft, Regularity, &Judged) -> Result<Vec<QuadDraft>, Cancelled>;

/// The steps in order, for quads that have their certificate.
const STEPS: [Step; 3] = [without_doublets, reaching, reconnected];

/// How far quads are polished.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Depth {
    /// Until they are certified: quads that stand by while something better is tried.
    Valid,
    /// As far as it goes.
    Best,
}

impl Polisher<'_> {
    /// The best quads that come of a draft: certified, or with the reasons why not.
    ///
    /// # Errors
    /// A stop; a deadline only as long as nothing is certified.
    pub(super) fn polish(&self, draft: QuadDraft, regularity: Regularity, depth: Depth) -> Result<Judged, Cancelled> {
        let mut best = self.valid(&draft, regularity, depth)?;
        if !best.is_certified() || depth == Depth::Valid {
            return Ok(best);
        }
        for step in STEPS {
            match self.improved(step, &draft, regularity, &best) {
                // There is something to deliver, whatever the deadline says.
                Err(Cancelled(StopReason::Deadline)) => break,
                better => best = better?.unwrap_or(best),
            }
        }
        Ok(best)
    }

    /// What a step gives if that is better.
    fn improved(
        &self,
        step: Step,
        draft: &QuadDraft,
        regularity: Regularity,
        best: &Judged,
    ) -> Result<Option<Judged>, Cancelled> {
        let mut better: Option<Judged> = None;
        for candidate in step(self, draft, regularity, best)? {
            let candidate = self.judged(candidate)?;
            if candidate.quality > better.as_ref().unwrap_or(best).quality {
                better = Some(candidate);
            }
        }
        Ok(better)
    }

    /// Quads whose certificate passes, if there are any: relaxed; or as they came, because where the surface is folded below
    /// the size of the quads moving them does more harm than good. Those that only stand by are taken as they came.
    fn valid(&self, draft: &QuadDraft, regularity: Regularity, depth: Depth) -> Result<Judged, Cancelled> {
        let plain = |best: Option<Judged>| {
            let plain = self.mended(draft.clone())?;
            Ok(best.into_iter().fold(plain, Judged::max_by_quality))
        };
        if depth == Depth::Valid {
            return plain(None);
        }
        let relaxed = match regularity {
            Regularity::Regular => self.relaxed(draft.clone(), Vec::new())?,
            Regularity::Irregular => self.reconnected(draft.clone())?,
        };
        let best = self.mended(relaxed)?;
        if best.is_certified() { Ok(best) } else { plain(Some(best)) }
    }

    fn judged(&self, draft: QuadDraft) -> Result<Judged, Cancelled> {
        judge(self.ctx, self.whole, self.problem, draft)
    }

    /// The draft, or what comes of it when single quads that fail are mended, whichever is better.
    fn mended(&self, draft: QuadDraft) -> Result<Judged, Cancelled> {
        let judged = self.judged(draft)?;
        let most = FEW.max((MOST * judged.draft.mesh.quads.len() as f64) as usize);
        if judged.is_certified() || judged.quality.refused > most {
            return Ok(judged);
        }
        let Problem { surface, index, .. } = self.problem;
        let options = MendOptions { edge_length: self.whole.judged_edge };
        let mended =
            self.ctx.stage(Stage::Optimise, |ctx| mend(ctx, surface, index, judged.draft.clone(), &options))?;
        if mended.discs == 0 {
            return Ok(judged);
        }
        Ok(self.judged(mended.draft)?.max_by_quality(judged))
    }

    fn reconnected(&self, draft: QuadDraft) -> Result<QuadDraft, Cancelled> {
        let Problem { surface, index, .. } = self.problem;
        let draft = self.ctx.stage(Stage::Optimise, |ctx| improve_connectivity(ctx, surface, index, draft))?;
        self.relaxed(draft, Vec::new())
    }

    /// Whether quads are only made valid: a given field whose frames have lengths and angles says what they look like.
    fn keeps_shapes(&self) -> bool {
        self.problem.field.as_ref().is_some_and(|field| field.kind() == FrameKind::Skew)
    }

    /// The draft with its vertices moved to where they are best, except those that are held.
    fn relaxed(&self, draft: QuadDraft, held: Vec<bool>) -> Result<QuadDraft, Cancelled> {
        let Problem { surface, index, edge_length, log_size, strokes, .. } = self.problem;
        let options = OptimiseOptions {
            edge_length: *edge_length,
            iterations: if self.keeps_shapes() { 0 } else { SWEEPS },
            log_size: log_size.clone(),
            strokes: strokes.to_vec(),
            held,
        };
        self.ctx.stage(Stage::Optimise, |ctx| optimise(ctx, surface, index, draft, &options))
    }
}

impl Judged {
    /// Whichever is better; the first of equals.
    fn max_by_quality(self, other: Self) -> Self {
        if self.quality >= other.quality { self } else { other }
    }
}

/// Without vertices of two quads.
fn without_doublets(
    work: &Polisher<'_>,
    _: &QuadDraft,
    _: Regularity,
    best: &Judged,
) -> Result<Vec<QuadDraft>, Cancelled> {
    let Problem { surface, index, .. } = work.problem;
    let single = work.ctx.stage(Stage::Optimise, |ctx| remove_doublets(ctx, surface, index, &best.draft))?;
    Ok(single.into_iter().collect())
}

/// The vertices within so many rings of quads around those that are marked.
fn within_rings(quads: &[[u32; 4]], mut marked: Vec<bool>, rings: usize) -> Vec<bool> {
    for _ in 0..rings {
        let touched: Vec<[u32; 4]> = quads.iter().copied().filter(|q| q.iter().any(|&v| marked[v as usize])).collect();
        touched.concat().into_iter().for_each(|v| marked[v as usize] = true);
    }
    marked
}

/// With tips pulled out to the surface, relaxed around them and not.
fn reaching(work: &Polisher<'_>, _: &QuadDraft, _: Regularity, best: &Judged) -> Result<Vec<QuadDraft>, Cancelled> {
    let Problem { surface, index, edge_length, .. } = work.problem;
    let reach =
        |draft: &QuadDraft| work.ctx.stage(Stage::Optimise, |ctx| reach_out(ctx, surface, index, draft, *edge_length));
    let Some(reached) = reach(&best.draft)? else { return Ok(Vec::new()) };
    // Those that were pulled stay; the others near them come after them.
    let before = &best.draft.mesh.positions;
    let pulled: Vec<bool> = reached.mesh.positions.iter().enumerate().map(|(v, p)| before.get(v) != Some(p)).collect();
    let near = within_rings(&reached.mesh.quads, pulled.clone(), RINGS);
    let held = pulled.iter().zip(near).map(|(&pulled, near)| pulled || !near).collect();
    let relaxed = work.relaxed(reached.clone(), held)?;
    let relaxed = reach(&relaxed)?.unwrap_or(relaxed);
    Ok(vec![relaxed, reached])
}

/// With other connectivity, where a part of the surface is cut off: it may not be then.
fn reconnected(
    work: &Polisher<'_>,
    draft: &QuadDraft,
    regularity: Regularity,
    best: &Judged,
) -> Result<Vec<QuadDraft>, Cancelled> {
    if regularity == Regularity::Irregular || best.away <= PART_LOST {
        return Ok(Vec::new());
    }
    let Problem { surface, index, edge_length, .. } = work.problem;
    let other = work.reconnected(draft.clone())?;
    let reached = work.ctx.stage(Stage::Optimise, |ctx| reach_out(ctx, surface, index, &other, *edge_length))?;
    Ok(vec![reached.unwrap_or(other)])
}
