//! What the method is asked for.

use glam::DVec3;

use crate::engine::field::{BranchOptions, FrameField, FrameKind, Frames, GivenBranchPoints};
use crate::engine::mesh::{Surface, TriMesh};
use crate::engine::methods::Working;
use crate::engine::problem::{Align, Boundary, Problem};

/// What the method is asked for.
#[derive(Clone, Debug)]
pub struct QuadCoverOptions {
    /// Length of a quad edge in model units.
    pub edge_length: f64,
    /// Per vertex the logarithm of the size relative to the edge length; empty if all quads are to be alike.
    pub log_size: Vec<f64>,
    /// Number of quads wanted on this component; `None` keeps the edge length.
    pub quads: Option<f64>,
    /// 0 follows curvature, 1 is as smooth as possible.
    pub smoothing: f64,
    /// Whether curvature guides the field at all.
    pub guided: bool,
    /// Whether and how branch points are moved.
    pub branch_points: Option<BranchOptions>,
    /// The field to follow on the faces of the working mesh, instead of one from curvature.
    pub field: Option<FrameField>,
    /// Lines to follow, polylines in model units.
    pub strokes: Vec<Vec<DVec3>>,
    /// Whether grid lines may meet the boundary at any angle.
    pub boundary_free: bool,
}

impl QuadCoverOptions {
    /// What a problem asks of the method on a working mesh that stands for its surface.
    pub fn of(problem: &Problem, working: &Working, branch_points: Option<BranchOptions>) -> Self {
        let wishes = &problem.wishes;
        let has_boundary = problem.surface.mesh.topology().boundaries > 0;
        Self {
            edge_length: problem.edge_length,
            log_size: working.log_size.clone(),
            quads: wishes.adapts_count.then_some(problem.quads),
            smoothing: wishes.smoothing,
            guided: wishes.align == Align::Curvature && problem.field.is_none(),
            branch_points,
            field: problem.field.as_ref().map(|field| field.carried(&problem.surface.mesh, &working.surface.mesh)),
            strokes: problem.strokes.to_vec(),
            boundary_free: wishes.boundary == Boundary::Free && has_boundary,
        }
    }

    /// The charts and the metric of field and map. Frames that say sizes themselves live in the metric of the mesh.
    pub(super) fn frames(&self, mesh: &TriMesh) -> Frames {
        let is_skew = self.exact().is_some_and(|field| field.kind() == FrameKind::Skew);
        Frames::scaled(mesh, if is_skew { &[] } else { &self.log_size })
    }

    /// The field that is followed exactly.
    pub(super) fn exact(&self) -> Option<&FrameField> {
        self.field.as_ref().filter(|field| field.branch_points() == GivenBranchPoints::Keep)
    }

    /// Per halfedge, whether field and map follow it.
    pub(super) fn followed(&self, surface: &Surface) -> Vec<bool> {
        let mut flags = surface.features.halfedge_flags(&surface.mesh);
        if self.boundary_free {
            flags.iter_mut().enumerate().for_each(|(h, flag)| *flag &= !surface.mesh.is_boundary(h));
        }
        flags
    }

    /// Vertices that must lie on grid points.
    pub(super) fn corners(&self, surface: &Surface) -> Vec<u32> {
        let corners = surface.features.corners.iter().copied();
        corners.filter(|&v| !self.boundary_free || !surface.mesh.is_boundary_vertex(v)).collect()
    }
}
