//! From a draft to quads with a certificate, or to the reason why not.

use glam::DVec3;

use crate::engine::certify::{Certificate, Check, certify};
use crate::engine::mesh::SurfaceIndex;
use crate::engine::pipeline::component::Component;
use crate::engine::quad::{OptimiseOptions, QuadDraft, improve_connectivity, optimise, repair_quads};
use crate::engine::run::{Cancelled, RunContext, Stage};

/// Drafts with more quads than this times the number asked for (split triangles of the input) are not worth improving.
const MOST_IMPROVED: usize = 5;
/// Sweeps of the optimiser.
const OPTIMISE_ITERATIONS: usize = 20;
/// Quads this many edges away from the surface, or the surface from them, stand for something else.
const FARTHEST: f64 = 4.0;

/// When the connectivity of a draft is improved.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Improve {
    /// First of all: it comes from pairs of triangles, which are valid before they are good, or never.
    First,
    /// Only if its quads fail: it comes from a map.
    IfBad,
}

/// A draft after all that could be done for it.
pub(super) struct Finished {
    pub(super) draft: QuadDraft,
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
/// is folded below the size of the quads, moving them does more harm than good.
pub(super) fn finish(
    ctx: &RunContext,
    component: &Component,
    index: &SurfaceIndex,
    draft: QuadDraft,
    improve: Improve,
) -> Result<Finished, Cancelled> {
    let work = Work { ctx, component, index };
    if draft.mesh.quads.len() > MOST_IMPROVED * component.quads.ceil() as usize {
        let refusal = work.judge(&draft)?;
        return Ok(Finished { draft, refusal });
    }
    let surface = &component.surface;
    let options = OptimiseOptions { edge_length: component.edge_length, iterations: OPTIMISE_ITERATIONS };
    let optimised = |draft: QuadDraft, improve: bool| {
        ctx.stage(Stage::Optimise, || {
            let draft = if improve { improve_connectivity(ctx, surface, index, draft)? } else { draft };
            optimise(ctx, surface, index, draft, &options)
        })
    };
    if improve == Improve::First {
        let as_it_came = work.mend(draft.clone())?;
        if as_it_came.refusal.is_some() {
            return Ok(as_it_came);
        }
        let better = work.mend(optimised(draft, true)?)?;
        return Ok(if better.refusal.is_none() { better } else { as_it_came });
    }
    let first = work.mend(optimised(draft.clone(), false)?)?;
    if first.refusal.is_none() {
        return Ok(first);
    }
    let second = work.mend(optimised(first.draft, true)?)?;
    if second.refusal.is_none() {
        return Ok(second);
    }
    let as_it_came = work.mend(draft)?;
    Ok(Finished { refusal: as_it_came.refusal.and(first.refusal), ..as_it_came })
}

struct Work<'a> {
    ctx: &'a RunContext,
    component: &'a Component,
    index: &'a SurfaceIndex,
}

impl Work<'_> {
    /// The draft, with bad quads mended if it passes then.
    fn mend(&self, draft: QuadDraft) -> Result<Finished, Cancelled> {
        let Some(refusal) = self.judge(&draft)? else { return Ok(Finished { draft, refusal: None }) };
        let surface = &self.component.surface;
        let mended = self.ctx.stage(Stage::Optimise, || repair_quads(self.ctx, surface, self.index, &draft))?;
        match mended {
            Some(mended) if self.judge(&mended)?.is_none() => Ok(Finished { draft: mended, refusal: None }),
            _ => Ok(Finished { draft, refusal: Some(refusal) }),
        }
    }

    fn judge(&self, draft: &QuadDraft) -> Result<Option<Refusal>, Cancelled> {
        let surface = &self.component.surface;
        let certificate = self.ctx.stage(Stage::Certify, || certify(self.ctx, surface, self.index, &draft.mesh))?;
        let diagonal = surface.mesh.diagonal();
        let away = certificate.measures.hausdorff_max * diagonal / self.component.edge_length;
        if let Some(violation) = certificate.violations.first() {
            return Ok(Some(Refusal { cause: violation.to_string(), places: self.places(&certificate, draft) }));
        }
        let cause = format!("the quads and the surface are up to {away:.1} edges apart");
        Ok((away > FARTHEST).then_some(Refusal { cause, places: Vec::new() }))
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
