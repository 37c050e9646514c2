//! The roads to quads that need no map.

use crate::engine::fallback::{fallback_draft, split_draft};
use crate::engine::mesh::SurfaceIndex;
use crate::engine::pipeline::component::Component;
use crate::engine::pipeline::report::Level;
use crate::engine::quad::QuadDraft;
use crate::engine::run::{Cancelled, RunContext};

/// The roads without a map, from best to surest.
#[derive(Clone, Copy)]
pub(super) enum Road {
    /// Pairs of triangles of a coarse remesh, subdivided once, with this many times the quads asked for: thin places
    /// need more.
    Paired(u32),
    /// The triangles of the input, split: the quads lie in the surface itself.
    SplitInput,
}

impl Road {
    pub(super) fn level(self) -> Level {
        match self {
            Road::Paired(_) => Level::L3,
            Road::SplitInput => Level::L4,
        }
    }

    pub(super) fn draft(
        self,
        ctx: &RunContext,
        component: &Component,
        index: &SurfaceIndex,
    ) -> Result<QuadDraft, Cancelled> {
        let surface = &component.surface;
        match self {
            Road::Paired(times) => {
                let quads = f64::from(times) * component.quads;
                fallback_draft(ctx, surface, index, quads.ceil() as usize)
            }
            Road::SplitInput => Ok(split_draft(surface)),
        }
    }
}
