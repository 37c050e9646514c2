//! From a draft to quads with a certificate, or to the reason why not.

use glam::DVec3;

use crate::engine::certify::{Certificate, Check, certify, scaled_jacobian};
use crate::engine::fallback::split_draft;
use crate::engine::mesh::SurfaceIndex;
use crate::engine::pipeline::component::Component;
use crate::engine::quad::{Bad, OptimiseOptions, QuadDraft};
use crate::engine::quad::{count_against, improve_connectivity, optimise, pillow_quads};
use crate::engine::quad::{reach_out, remove_doublets, repair_quads};
use crate::engine::run::{Cancelled, RunContext, Stage, StopReason};

/// Drafts with more quads than this times the number asked for (split triangles of the input) are not worth improving.
const MOST_IMPROVED: usize = 5;
/// Pairs of triangles are, up to so many quads: handles take as many as they need, whatever was asked for.
const MOST_PAIRS_IMPROVED: usize = 60_000;
/// Sweeps of the optimiser.
const OPTIMISE_ITERATIONS: usize = 20;
/// Quads this many edges away from the surface, or the surface from them, stand for something else.
const FARTHEST: f64 = 4.0;
/// From this distance on other connectivity is tried too.
const FAR: f64 = 1.5;
/// Relaxed quads are preferred to merely pulled ones if they come as near to the surface as this, in edges,
const FAR_ENOUGH: f64 = 0.55;
/// or as this times what the pulled ones do.
const NEARLY: f64 = 1.15;

/// Largest coordinate relative to the diagonal of a component up to which single precision is expected to hold it.
const FARTHEST_ROUNDED: f64 = 60.0;

/// Quads whose least scaled Jacobian is not above this have corners to be mended: what another evaluator sees must be
/// well above 0.
const STRAIGHT: f64 = 0.01;
/// How often single quads are mended, each time leaving alone what was refused before.
const TRIES: usize = 3;
/// How often quads are split: what had no room at first may have some among the parts of others.
const SPLITTINGS: usize = 3;
/// Most triangles of a component whose quads are rounded: it may cost a huge scan more rungs than it has time for.
const MOST_ROUNDED: usize = 200_000;

/// When the connectivity of a draft is improved.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Improve {
    /// First of all: it comes from pairs of triangles, which are valid before they are good, or never.
    First,
    /// First of all, unless there are many more quads than asked for: they are split triangles.
    FirstIfFew,
    /// Only if its quads fail: it comes from a map.
    IfBad,
}

/// A draft after all that could be done for it.
pub(super) struct Finished {
    pub(super) draft: QuadDraft,
    /// The Hausdorff distance in quad edges.
    pub(super) away: f64,
    /// The smallest scaled Jacobian of a corner.
    least_corner: f64,
    /// Where quads have straight or reflex corners that could not be mended, in model units.
    pub(super) reflex: Vec<DVec3>,
    /// Why it must not be delivered.
    pub(super) refusal: Option<Refusal>,
}

/// What the certificate found wrong.
pub(super) struct Refusal {
    pub(super) cause: String,
    /// Where, in model units; not for everything that can be wrong.
    pub(super) places: Vec<DVec3>,
}

/// Optimises a draft and asks the certificate. Where the optimised quads fail, single bad ones are mended; after that
/// the connectivity of all is improved once, and at last the draft is mended and judged as it came: where the surface
/// is folded below the size of the quads, moving them does more harm than good. Good quads then lose their doublets and
/// reach out for what they cut off, straight and reflex corners are mended, and at last quads that turn their back to
/// the surface.
pub(super) fn finish(
    ctx: &RunContext,
    component: &Component,
    index: &SurfaceIndex,
    draft: QuadDraft,
    improve: Improve,
) -> Result<Finished, Cancelled> {
    let few = MOST_IMPROVED * component.quads.ceil() as usize;
    let most_improved = if improve == Improve::First { few.max(MOST_PAIRS_IMPROVED) } else { few };
    let work = Work { ctx, component, index, most_improved };
    let finished = work.finish(draft.clone(), improve)?;
    if finished.refusal.is_some() {
        return Ok(finished);
    }
    // From here on there is something to deliver, whatever the deadline says.
    let finished = or_deadline(finished, |good| work.undoubled(good))?;
    let finished = or_deadline(finished, |good| work.better(draft, improve, good))?;
    let finished = or_deadline(finished, |good| work.straightened(good))?;
    let mut finished = or_deadline(finished, |good| work.faced(good))?;
    finished.reflex = reflex_quads(&finished);
    Ok(finished)
}

/// Centres of the quads with a corner that an evaluator may see as reflex.
fn reflex_quads(finished: &Finished) -> Vec<DVec3> {
    if finished.least_corner > 0.0 {
        return Vec::new();
    }
    let mesh = &finished.draft.mesh;
    let corners = mesh.quads.iter().map(|quad| quad.map(|v| mesh.positions[v as usize]));
    corners.filter(|p| scaled_jacobian(*p) <= 0.0).map(|p| p.iter().sum::<DVec3>() / 4.0).collect()
}

/// What is better than something good, or that itself if there is nothing better or the deadline passes.
fn or_deadline(
    good: Finished,
    better: impl FnOnce(&Finished) -> Result<Option<Finished>, Cancelled>,
) -> Result<Finished, Cancelled> {
    match better(&good) {
        Err(Cancelled(StopReason::Deadline | StopReason::Hurry)) | Ok(None) => Ok(good),
        Ok(Some(better)) => Ok(better),
        Err(stop) => Err(stop),
    }
}

struct Work<'a> {
    ctx: &'a RunContext,
    component: &'a Component,
    index: &'a SurfaceIndex,
    /// Drafts with more quads are judged as they are.
    most_improved: usize,
}

impl Work<'_> {
    fn finish(&self, draft: QuadDraft, improve: Improve) -> Result<Finished, Cancelled> {
        if draft.mesh.quads.len() > self.most_improved {
            return self.judged_as_it_is(draft);
        }
        if improve != Improve::IfBad {
            let as_it_came = self.mend(draft.clone())?;
            if as_it_came.refusal.is_some() {
                return Ok(as_it_came);
            }
            let better = self.mend(self.optimised(draft, true)?)?;
            return Ok(if better.refusal.is_none() { better } else { as_it_came });
        }
        let first = self.mend(self.optimised(draft.clone(), false)?)?;
        if first.refusal.is_none() {
            return Ok(first);
        }
        let second = self.mend(self.optimised(first.draft, true)?)?;
        if second.refusal.is_none() {
            return Ok(second);
        }
        let as_it_came = self.mend(draft)?;
        Ok(Finished { refusal: as_it_came.refusal.and(first.refusal), ..as_it_came })
    }

    /// Certified quads that are nearer to the surface than certified ones; `draft` is what those were made from.
    fn better(&self, draft: QuadDraft, improve: Improve, good: &Finished) -> Result<Option<Finished>, Cancelled> {
        let reached = self.reach(&good.draft)?;
        let away = reached.as_ref().map_or(good.away, |reached| reached.away);
        if away <= FAR || improve != Improve::IfBad || draft.mesh.quads.len() > self.most_improved {
            return Ok(reached);
        }
        // Something is cut off: with other connectivity it may not be.
        let other = self.mend(self.optimised(draft, true)?)?;
        if other.refusal.is_some() {
            return Ok(reached);
        }
        let other = self.reach(&other.draft)?.unwrap_or(other);
        Ok(if other.away < away { Some(other) } else { reached })
    }

    /// Certified quads with fewer doublets.
    fn undoubled(&self, good: &Finished) -> Result<Option<Finished>, Cancelled> {
        let Self { ctx, component, index, .. } = *self;
        if good.draft.mesh.quads.len() > self.most_improved {
            return Ok(None);
        }
        let single = ctx.stage(Stage::Optimise, |ctx| remove_doublets(ctx, &component.surface, index, &good.draft))?;
        let Some(single) = single else { return Ok(None) };
        let single = self.mend(single)?;
        let is_no_worse = single.refusal.is_none()
            && single.away <= (NEARLY * good.away).max(FAR_ENOUGH)
            && single.least_corner >= good.least_corner.min(STRAIGHT);
        Ok(is_no_worse.then_some(single))
    }

    /// Certified quads with fewer straight or reflex corners.
    fn straightened(&self, good: &Finished) -> Result<Option<Finished>, Cancelled> {
        let Self { ctx, component, index, .. } = *self;
        if good.least_corner > STRAIGHT || good.draft.mesh.quads.len() > self.most_improved {
            return Ok(None);
        }
        let is_better = |m: &Finished| m.away <= good.away.max(FAR);
        let mut best = self.repaired(good, Bad::Reflex)?.filter(is_better);
        for _ in 0..SPLITTINGS {
            let at_hand = best.as_ref().unwrap_or(good);
            if at_hand.least_corner > STRAIGHT {
                break;
            }
            let split =
                ctx.stage(Stage::Optimise, |ctx| pillow_quads(ctx, &component.surface, index, &at_hand.draft))?;
            let split = split.map(|draft| self.judged(draft)).transpose()?;
            let split = split.filter(|split| split.refusal.is_none() && is_better(split));
            if split.is_none() {
                break;
            }
            best = split;
        }
        Ok(best)
    }

    /// Certified quads of which fewer turn their back to the surface beneath their middle.
    fn faced(&self, good: &Finished) -> Result<Option<Finished>, Cancelled> {
        let Self { ctx, index, .. } = *self;
        if good.draft.mesh.quads.len() > self.most_improved {
            return Ok(None);
        }
        let against = |draft: &QuadDraft| ctx.stage(Stage::Optimise, |ctx| count_against(ctx, index, &draft.mesh));
        let before = against(&good.draft)?;
        if before == 0 {
            return Ok(None);
        }
        let Some(mended) = self.repaired(good, Bad::Against)? else { return Ok(None) };
        let is_no_worse = mended.away <= (NEARLY * good.away).max(FAR_ENOUGH)
            && mended.least_corner >= good.least_corner.min(STRAIGHT);
        Ok((is_no_worse && against(&mended.draft)? < before).then_some(mended))
    }

    /// Certified quads with some of the bad ones mended.
    fn repaired(&self, good: &Finished, which: Bad) -> Result<Option<Finished>, Cancelled> {
        let Self { ctx, component, index, .. } = *self;
        let mut leave = Vec::new();
        for _ in 0..TRIES {
            let mended = ctx.stage(Stage::Optimise, |ctx| {
                repair_quads(ctx, &component.surface, index, &good.draft, which, &leave)
            })?;
            let Some(mended) = mended.map(|draft| self.judged(draft)).transpose()? else { break };
            match mended.refusal {
                // Somewhere it did harm; elsewhere it may be of use.
                Some(refusal) if !refusal.places.is_empty() => leave.extend(refusal.places),
                Some(_) => break,
                None => return Ok(Some(mended)),
            }
        }
        Ok(None)
    }

    fn optimised(&self, draft: QuadDraft, improve: bool) -> Result<QuadDraft, Cancelled> {
        let Self { ctx, component, index, .. } = *self;
        let draft = match improve {
            true => ctx.stage(Stage::Optimise, |ctx| improve_connectivity(ctx, &component.surface, index, draft))?,
            false => draft,
        };
        self.relaxed(draft, Vec::new())
    }

    /// The draft with its vertices moved to where they are best, except those that are held.
    fn relaxed(&self, draft: QuadDraft, held: Vec<bool>) -> Result<QuadDraft, Cancelled> {
        let Self { ctx, component, index, .. } = *self;
        let options = OptimiseOptions {
            edge_length: component.edge_length,
            iterations: OPTIMISE_ITERATIONS,
            log_size: component.log_size.clone(),
            strokes: component.strokes.to_vec(),
            held,
        };
        ctx.stage(Stage::Optimise, |ctx| optimise(ctx, &component.surface, index, draft, &options))
    }

    /// The draft, with bad quads mended if it passes then.
    fn mend(&self, draft: QuadDraft) -> Result<Finished, Cancelled> {
        let Self { ctx, component, index, .. } = *self;
        let finished = self.judged(draft)?;
        if finished.refusal.is_none() {
            return Ok(finished);
        }
        let mended = ctx.stage(Stage::Optimise, |ctx| {
            repair_quads(ctx, &component.surface, index, &finished.draft, Bad::TurnedOver, &[])
        })?;
        let mended = mended.map(|draft| self.judged(draft)).transpose()?;
        Ok(mended.filter(|mended| mended.refusal.is_none()).unwrap_or(finished))
    }

    /// The quads with their tips pulled out to the surface, if they pass then.
    fn reach(&self, draft: &QuadDraft) -> Result<Option<Finished>, Cancelled> {
        let Self { ctx, component, index, .. } = *self;
        let reach_out = |draft: &QuadDraft| {
            ctx.stage(Stage::Optimise, |ctx| reach_out(ctx, &component.surface, index, draft, component.edge_length))
        };
        let Some(reached) = reach_out(draft)? else { return Ok(None) };
        // Those that were pulled stay; the others come after them.
        let before = &draft.mesh.positions;
        let held = reached.mesh.positions.iter().enumerate().map(|(v, p)| before.get(v) != Some(p)).collect();
        let relaxed = self.relaxed(reached.clone(), held)?;
        let relaxed = self.mend(reach_out(&relaxed)?.unwrap_or(relaxed))?;
        let reached = self.mend(reached)?;
        let is_as_near = reached.refusal.is_some() || relaxed.away <= (NEARLY * reached.away).max(FAR_ENOUGH);
        Ok(Some(if is_as_near && relaxed.refusal.is_none() { relaxed } else { reached })
            .filter(|reached| reached.refusal.is_none()))
    }

    /// Rounds the quads to what a file of single precision will hold, and judges them: all formats then hold the same.
    /// Where that would move them by more than a few millionths of the surface's size, they stay as they are: far from
    /// the origin only files of double precision will do.
    fn judged(&self, mut draft: QuadDraft) -> Result<Finished, Cancelled> {
        let far = draft.mesh.positions.iter().map(|p| p.abs().max_element()).fold(0.0, f64::max);
        let mesh = &self.component.surface.mesh;
        if far < FARTHEST_ROUNDED * mesh.diagonal() && mesh.n_faces() <= MOST_ROUNDED {
            draft.mesh.positions.iter_mut().for_each(|p| *p = p.as_vec3().as_dvec3());
        }
        self.judged_as_it_is(draft)
    }

    fn judged_as_it_is(&self, draft: QuadDraft) -> Result<Finished, Cancelled> {
        let surface = &self.component.surface;
        let certificate = self.ctx.stage(Stage::Certify, |ctx| certify(ctx, surface, self.index, &draft.mesh))?;
        let away = certificate.measures.hausdorff_max * surface.mesh.diagonal() / self.component.edge_length;
        let refusal = match certificate.violations.first() {
            Some(violation) => {
                Some(Refusal { cause: violation.to_string(), places: self.places(&certificate, &draft) })
            }
            None => (away > FARTHEST).then(|| Refusal {
                cause: format!("the quads and the surface are up to {away:.1} edges apart"),
                places: Vec::new(),
            }),
        };
        Ok(Finished {
            draft,
            away,
            least_corner: certificate.measures.scaled_jacobian_min,
            reflex: Vec::new(),
            refusal,
        })
    }

    fn places(&self, certificate: &Certificate, draft: &QuadDraft) -> Vec<DVec3> {
        let of_quad = |q: u32| draft.mesh.quads[q as usize].map(|v| draft.mesh.positions[v as usize]);
        let mut places = Vec::new();
        for violation in &certificate.violations {
            for &witness in &violation.witnesses {
                match violation.check {
                    Check::Flipped | Check::ZeroArea => places.push(of_quad(witness).iter().sum::<DVec3>() / 4.0),
                    Check::FeatureCurve | Check::Corner => places.push(self.component.surface.mesh.position(witness)),
                    _ => {}
                }
            }
        }
        places
    }
}

/// What a component gets when the deadline has passed before anything was certified: its split triangles, if they
/// pass. The steps here heed no deadline, so they are for small surfaces only.
pub(super) fn last_resort(ctx: &RunContext, component: &Component) -> Result<Finished, Cancelled> {
    let ctx = &ctx.late();
    let index = &SurfaceIndex::new(&component.surface.mesh);
    Work { ctx, component, index, most_improved: 0 }.judged_as_it_is(split_draft(&component.surface))
}
