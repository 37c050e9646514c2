//! The triangles that the map lives on: fine enough for the density, with room between features.

use std::collections::BTreeMap;

use glam::DVec3;
use rayon::prelude::*;

use crate::engine::field::BranchOptions;
use crate::engine::mesh::Surface;
use crate::engine::mesh::SurfaceIndex;
use crate::engine::mesh::{graded_working_mesh, working_mesh};
use crate::engine::methods::quad_cover::QuadCoverOptions;
use crate::engine::pipeline::component::Component;
use crate::engine::pipeline::spec::{Align, RemeshSpec, WorkingMesh};
use crate::engine::quad::Anchor;
use crate::engine::quad::QuadDraft;
use crate::engine::run::Cancelled;
use crate::engine::run::RunContext;

/// A working surface and how its corners are numbered on the surface that it stands for.
#[derive(Clone, Debug)]
pub(super) struct Working {
    pub(super) surface: Surface,
    /// Per corner of the working surface (sorted), the vertex of the original surface at the same place.
    pub(super) corner_of: BTreeMap<u32, u32>,
    /// Per vertex of the working surface the logarithm of the size of quads; empty if all are to be alike.
    pub(super) log_size: Vec<f64>,
}

impl Working {
    /// What the component that this stands for asks of the method.
    pub(super) fn options(
        &self,
        component: &Component,
        spec: &RemeshSpec,
        smoothing: f64,
        branch_points: Option<BranchOptions>,
    ) -> QuadCoverOptions {
        QuadCoverOptions {
            edge_length: component.edge_length,
            log_size: self.log_size.clone(),
            quads: spec.adapt_count.then_some(component.quads),
            smoothing,
            guided: spec.align == Align::Curvature,
            branch_points,
            strokes: component.strokes.to_vec(),
            boundary_free: false,
        }
    }
}

/// Longest triangle edge relative to a quad edge: singularities need triangles between them.
const LONGEST_EDGE: f64 = 0.55;
/// Most triangles of a working mesh.
const MAX_FACES: usize = 1_000_000;

/// Makes the working surface for the quads of a component.
pub(super) fn working_surface(
    ctx: &RunContext,
    component: &Component,
    index: &SurfaceIndex,
    choice: WorkingMesh,
) -> Result<Working, Cancelled> {
    let Component { surface, edge_length, .. } = component;
    let max_edge = LONGEST_EDGE * edge_length;
    let size = |p: DVec3| component.log_size_at(index, p);
    let working = match choice {
        WorkingMesh::Input => surface.clone(),
        // Numbered by its shape: the quads are not to depend on the numbering of the input.
        WorkingMesh::Auto => {
            let surface = surface.in_canonical_order();
            match component.is_even() {
                true => working_mesh(ctx, &surface, index, max_edge, MAX_FACES)?,
                false => graded_working_mesh(ctx, &surface, index, max_edge, size, MAX_FACES)?,
            }
        }
    };
    let corner_of = corner_map(&working, surface);
    let log_size = match component.is_even() {
        true => Vec::new(),
        false => working.mesh.positions().par_iter().map(|&p| size(p)).collect(),
    };
    Ok(Working { surface: working, corner_of, log_size })
}

/// Per corner of a remeshed surface, the vertex of the original at the same place.
pub(super) fn corner_map(remeshed: &Surface, original: &Surface) -> BTreeMap<u32, u32> {
    let key = |p: glam::DVec3| p.to_array().map(f64::to_bits);
    let at: BTreeMap<[u64; 3], u32> =
        original.features.corners.iter().map(|&v| (key(original.mesh.position(v)), v)).collect();
    let corners = remeshed.features.corners.iter();
    corners.filter_map(|&v| at.get(&key(remeshed.mesh.position(v))).map(|&home| (v, home))).collect()
}

/// A draft made on a remeshed surface, its corners renumbered to the original.
pub(super) fn renumber_corners(mut draft: QuadDraft, corner_of: &BTreeMap<u32, u32>) -> QuadDraft {
    for anchor in &mut draft.anchors {
        if let Anchor::Corner(v) = *anchor {
            *anchor = corner_of.get(&v).map_or(Anchor::Curve, |&home| Anchor::Corner(home));
        }
    }
    draft
}
