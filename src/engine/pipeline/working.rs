//! The triangles that the map lives on: fine enough for the density, with room between features.

use std::collections::BTreeMap;

use crate::engine::mesh::Surface;
use crate::engine::mesh::SurfaceIndex;
use crate::engine::mesh::{IsotropicOptions, remesh_isotropic};
use crate::engine::pipeline::spec::WorkingMesh;
use crate::engine::quad::Anchor;
use crate::engine::quad::QuadDraft;
use crate::engine::run::Cancelled;
use crate::engine::run::RunContext;

/// A working surface and how its corners are numbered on the surface that it stands for.
#[derive(Clone, Debug)]
pub(super) struct Working {
    pub(super) surface: Surface,
    /// Per corner of the working surface (sorted), the vertex of the original surface at the same place.
    corner_of: BTreeMap<u32, u32>,
}

/// Triangle edge relative to a quad edge: singularities need triangles between them.
const EDGE_SHARE: f64 = 0.42;

/// Makes the working surface for quads of this edge length.
pub(super) fn working_surface(
    ctx: &RunContext,
    surface: &Surface,
    index: &SurfaceIndex,
    edge_length: f64,
    choice: WorkingMesh,
) -> Result<Working, Cancelled> {
    let working = match choice {
        WorkingMesh::Input => surface.clone(),
        WorkingMesh::Auto => {
            let options = IsotropicOptions::dense(EDGE_SHARE * edge_length);
            remesh_isotropic(ctx, surface, index, &options)?
        }
    };
    let key = |p: glam::DVec3| p.to_array().map(f64::to_bits);
    let at: BTreeMap<[u64; 3], u32> =
        surface.features.corners.iter().map(|&v| (key(surface.mesh.position(v)), v)).collect();
    let corner_of = working
        .features
        .corners
        .iter()
        .filter_map(|&v| at.get(&key(working.mesh.position(v))).map(|&original| (v, original)))
        .collect();
    Ok(Working { surface: working, corner_of })
}

impl Working {
    /// A draft made on the working surface, its corners renumbered to the original surface.
    pub(super) fn to_surface(&self, mut draft: QuadDraft) -> QuadDraft {
        for anchor in &mut draft.anchors {
            if let Anchor::Corner(v) = *anchor {
                *anchor = self.corner_of.get(&v).map_or(Anchor::Curve, |&original| Anchor::Corner(original));
            }
        }
        draft
    }
}
