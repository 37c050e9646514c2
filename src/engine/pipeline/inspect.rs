//! What a run would begin with: the surface after conditioning, without quads.

use crate::engine::mesh::Detected;
use crate::engine::mesh::TriangleSoup;
use crate::engine::mesh::condition::{ConditionOptions, condition};
use crate::engine::pipeline::error::RemeshError;
use crate::engine::pipeline::report::{InputReport, Repairs};
use crate::engine::pipeline::spec::{NonOrientable, RemeshSpec};
use crate::engine::pipeline::surface::{edge_length, features};
use crate::engine::run::Cancelled;
use crate::engine::run::RunContext;
use crate::engine::run::Stage;
use crate::engine::run::Warning;

/// A surface before it is remeshed.
#[derive(Clone, Debug, PartialEq)]
pub struct Inspection {
    /// Its numbers and what had to be repaired.
    pub input: InputReport,
    /// Its area in model units.
    pub area: f64,
    /// What there is to say besides.
    pub warnings: Vec<Warning>,
}

/// Conditions a soup and finds its features as a run with this spec would.
///
/// ```
/// use quadrille::engine::mesh::shapes::sample;
/// use quadrille::engine::pipeline::{RemeshSpec, inspect};
/// use quadrille::engine::run::RunContext;
///
/// let soup = sample("genus2", 2000, 0.0, 0).expect("one of the samples");
/// let found = inspect(&RunContext::silent(), &soup, &RemeshSpec::default())?;
/// assert_eq!((found.input.components, found.input.genus), (1, 2));
/// assert!(found.input.repairs.counts.is_empty());
/// # Ok::<(), quadrille::engine::pipeline::RemeshError>(())
/// ```
///
/// # Errors
/// [`RemeshError`]: the input is refused, or the run was stopped.
pub fn inspect(ctx: &RunContext, soup: &TriangleSoup, spec: &RemeshSpec) -> Result<Inspection, RemeshError> {
    let conditioned = ctx.stage(Stage::Condition, |ctx| {
        let options = ConditionOptions { cut_non_orientable: spec.non_orientable == NonOrientable::Cut };
        condition(ctx, soup, &options).map_err(RemeshError::from)
    })?;
    let edge_length = edge_length(&conditioned, spec)?;
    let Detected { features, .. } =
        ctx.stage(Stage::Features, |_| Ok::<_, Cancelled>(features(&conditioned, soup, spec, edge_length)))?;
    let topology = conditioned.mesh.topology();
    let input = InputReport {
        vertices: conditioned.mesh.n_vertices(),
        triangles: conditioned.mesh.n_faces(),
        components: topology.components,
        boundaries: topology.boundaries,
        genus: topology.genus,
        feature_edges: features.edges.len(),
        repairs: Repairs { counts: conditioned.repairs },
    };
    Ok(Inspection { input, area: conditioned.mesh.total_area(), warnings: conditioned.warnings })
}
