//! The certificate alone, for quads from anywhere.

use crate::engine::certify::{Certificate, certify};
use crate::engine::mesh::Surface;
use crate::engine::mesh::SurfaceIndex;
use crate::engine::mesh::TriangleSoup;
use crate::engine::mesh::condition::{ConditionOptions, condition};
use crate::engine::pipeline::error::RemeshError;
use crate::engine::pipeline::remesh::{edge_length, features};
use crate::engine::pipeline::spec::RemeshSpec;
use crate::engine::quad::QuadMesh;
use crate::engine::run::Cancelled;
use crate::engine::run::RunContext;
use crate::engine::run::Stage;

/// Certifies `quads` against the surface of `soup`, conditioned and with features as a run with this spec would have
/// them.
///
/// # Errors
/// [`RemeshError`]: the input is refused, or the run was stopped.
pub fn check(
    ctx: &RunContext,
    soup: &TriangleSoup,
    quads: &QuadMesh,
    spec: &RemeshSpec,
) -> Result<Certificate, RemeshError> {
    let conditioned = ctx.stage(Stage::Condition, || {
        let options = ConditionOptions { cut_non_orientable: spec.cut_non_orientable };
        condition(ctx, soup, &options).map_err(RemeshError::from)
    })?;
    let edge_length = edge_length(&conditioned, spec)?;
    let (features, _) =
        ctx.stage(Stage::Features, || Ok::<_, Cancelled>(features(&conditioned, soup, spec, edge_length)))?;
    let surface = Surface { mesh: conditioned.mesh, features };
    ctx.stage(Stage::Certify, || {
        certify(ctx, &surface, &SurfaceIndex::new(&surface.mesh), quads).map_err(RemeshError::from)
    })
}
