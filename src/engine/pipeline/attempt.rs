//! One attempt at a component: a method, its parameters and the problem as it is put to it, as data; and the quads that come
//! out of any of the three doors.

use crate::engine::methods::{BoundaryLines, Level, MapProduct, MethodError, MethodRef, Parameters, Product};
use crate::engine::problem::Problem;
use crate::engine::quad::extract::{ExtractError, extract_inner_quads, extract_quads};
use crate::engine::quad::{Anchor, LayoutError, QuadDraft, quads_of_layout};
use crate::engine::run::{Cancelled, RunContext, Stage};

/// What is to be tried.
#[derive(Clone, Debug)]
pub(super) struct Attempt {
    pub(super) method: MethodRef,
    pub(super) parameters: Parameters,
    pub(super) problem: Problem,
    /// What this attempt changes, in a few words that follow "quads by …".
    pub(super) change: &'static str,
}

/// How regular the connectivity of a draft is as it comes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Regularity {
    /// As a field or a layout has it: changed only where quads fail.
    Regular,
    /// By chance: improved first of all.
    Irregular,
}

/// Quads of a product.
#[derive(Debug)]
pub(super) struct Extracted {
    pub(super) draft: QuadDraft,
    pub(super) regularity: Regularity,
    pub(super) level: Level,
    pub(super) map: Option<Box<MapProduct>>,
}

/// An attempt gave no quads.
#[derive(Debug)]
pub(super) enum NoQuads {
    Cancelled(Cancelled),
    Cause {
        cause: String,
        map: Option<Box<MapProduct>>,
    },
    /// The method's parameters ask for what cannot be.
    Refused {
        cause: String,
    },
}

impl From<Cancelled> for NoQuads {
    fn from(stop: Cancelled) -> Self {
        Self::Cancelled(stop)
    }
}

impl Attempt {
    /// Lets the method propose, and makes quads of the product.
    ///
    /// # Errors
    /// A stop, or why there are no quads, with the map where one was made.
    pub(super) fn quads(&self, ctx: &RunContext) -> Result<Extracted, NoQuads> {
        let product = self.method.0.propose(ctx, &self.problem, &self.parameters).map_err(|error| match error {
            MethodError::Cancelled(stop) => NoQuads::Cancelled(stop),
            MethodError::Nothing { cause, map } => NoQuads::Cause { cause, map },
            MethodError::Refused { cause } => NoQuads::Refused { cause },
        })?;
        let level = self.method.0.level();
        match product {
            Product::Map(map) => {
                let draft = quads_of_map(ctx, map.as_ref());
                match draft {
                    Ok(draft) => Ok(Extracted { draft, regularity: Regularity::Regular, level, map: Some(map) }),
                    Err(ExtractError::Cancelled(stop)) => Err(NoQuads::Cancelled(stop)),
                    Err(error) => Err(NoQuads::Cause { cause: error.to_string(), map: Some(map) }),
                }
            }
            Product::Layout(layout) => {
                let Problem { index, edge_length, quads, wishes, .. } = &self.problem;
                let quads = wishes.adapts_count.then_some(*quads);
                let draft = ctx.stage(Stage::Extract, |ctx| quads_of_layout(ctx, index, &layout, *edge_length, quads));
                match draft {
                    Ok(draft) => Ok(Extracted { draft, regularity: Regularity::Regular, level, map: None }),
                    Err(LayoutError::Cancelled(stop)) => Err(NoQuads::Cancelled(stop)),
                    Err(error) => Err(NoQuads::Cause { cause: error.to_string(), map: None }),
                }
            }
            Product::Quads(draft) => Ok(Extracted { draft, regularity: Regularity::Irregular, level, map: None }),
        }
    }
}

fn quads_of_map(ctx: &RunContext, map: &MapProduct) -> Result<QuadDraft, ExtractError> {
    let extract = match map.boundary {
        BoundaryLines::Free => extract_inner_quads,
        BoundaryLines::OnGrid => extract_quads,
    };
    let surface = &map.surface;
    let mut draft = ctx.stage(Stage::Extract, |ctx| extract(ctx, &surface.mesh, &surface.features, &map.grid))?.draft;
    // Corners are numbered as on the problem's own surface.
    for anchor in &mut draft.anchors {
        if let Anchor::Corner(v) = *anchor {
            *anchor = map.corner_of.get(&v).map_or(Anchor::Curve, |&home| Anchor::Corner(home));
        }
    }
    Ok(draft)
}
