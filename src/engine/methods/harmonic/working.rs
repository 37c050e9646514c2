//! The triangles that the harmonic forms live on, and the smooth field on them.

use std::collections::BTreeMap;

use crate::engine::field::{CrossField, FieldOptions, Frames, curvature_guidance, smooth_cross_field, stroke_guidance};
use crate::engine::mesh::Surface;
use crate::engine::methods::harmonic::error::HarmonicError;
use crate::engine::methods::{self, working_surface};
use crate::engine::problem::{Align, Boundary, Problem};
use crate::engine::run::{Cancelled, RunContext};

/// Most triangles of a working mesh: every meta-edge splits those that it crosses, and the modified Laplacian of 300,000
/// triangles takes seconds to factor.
const MAX_FACES: usize = 300_000;
/// Radius over which curvature is averaged, in quad edges: noise below the size of the quads gives no singularities.
const AVERAGED: f64 = 0.7;

/// A surface with triangles that are small against the quads, and its field.
#[derive(Clone, Debug)]
pub(super) struct Working {
    pub(super) surface: Surface,
    /// Per corner of the features the vertex of the problem's surface at the same place.
    pub(super) corner_of: BTreeMap<u32, u32>,
    /// Charts in the metric in which quads of varying size are equal.
    pub(super) frames: Frames,
}

impl Working {
    pub(super) fn new(ctx: &RunContext, problem: &Problem) -> Result<Self, Cancelled> {
        let methods::Working { surface, corner_of, log_size } = working_surface(ctx, problem, MAX_FACES)?;
        let frames = Frames::scaled(&surface.mesh, &log_size);
        Ok(Self { surface, corner_of, frames })
    }

    /// Per halfedge, whether field and map follow it: features, and the boundary unless it is to be free.
    pub(super) fn followed(&self, problem: &Problem) -> Vec<bool> {
        let mesh = &self.surface.mesh;
        let mut flags = self.surface.features.halfedge_flags(mesh);
        if problem.wishes.boundary == Boundary::Free {
            flags.iter_mut().enumerate().for_each(|(h, flag)| *flag &= !mesh.is_boundary(h));
        }
        flags
    }

    /// The field, between alignment with curvature (0) and smoothness (1); 1 does without curvature. Detail smaller than
    /// `detail` quad edges is averaged, and pairs of singularities nearer than about that are cancelled.
    pub(super) fn field(
        &self,
        ctx: &RunContext,
        problem: &Problem,
        smoothing: f64,
        detail: f64,
    ) -> Result<CrossField, HarmonicError> {
        let (mesh, frames) = (&self.surface.mesh, &self.frames);
        let flags = self.followed(problem);
        let is_guided = problem.wishes.align == Align::Curvature && smoothing < 1.0;
        let edge_length = detail * problem.edge_length;
        let guidance = is_guided.then(|| curvature_guidance(mesh, frames, &flags, AVERAGED * edge_length));
        let options = FieldOptions {
            edge_length,
            smoothing,
            branch_points: None,
            strokes: stroke_guidance(mesh, frames, &problem.strokes, problem.edge_length),
            start: None,
        };
        Ok(smooth_cross_field(ctx, mesh, frames, &flags, guidance.as_ref(), &options)?.0)
    }
}
