//! The components of a model up to the point where densities are tried.

use std::path::Path;

use quadrille::engine::field::BranchOptions;
use quadrille::engine::mesh::condition::{ConditionOptions, condition};
use quadrille::engine::mesh::{FeatureOptions, Surface, detect_features};
use quadrille::engine::methods::quad_cover::{MAX_FACES, Prepared, QuadCoverOptions, prepare};
use quadrille::engine::methods::{Working, working_surface};
use quadrille::engine::pipeline::{Optimise, RemeshSpec, Target};
use quadrille::engine::problem::split;
use quadrille::engine::run::RunContext;

use crate::model::read;

/// Length of the shortest sharp chains that are followed, in quad edges, as in a run.
const SHORTEST_FEATURE: f64 = 4.0;

/// A component's working mesh, its map's system, and the density asked for.
pub(super) struct Component {
    pub(super) working: Working,
    pub(super) prepared: Prepared,
    /// Grid units per model unit.
    pub(super) scale: f64,
}

/// Field and map of each component of a file. Sizes are those that the detail asks for, and there is neither a second
/// attempt nor symmetry.
pub(super) fn components(ctx: &RunContext, model: &str, spec: &RemeshSpec) -> Result<Vec<Component>, String> {
    let text = |e: &dyn std::fmt::Display| format!("{model}: {e}");
    let soup = read(Path::new(model))?;
    let conditioned = condition(ctx, &soup, &ConditionOptions::default()).map_err(|e| text(&e))?;
    let Target::Quads(quads) = spec.target else { return Err("a number of quads is wanted".to_owned()) };
    let edge_length = (conditioned.mesh.total_area() / quads.max(1) as f64).sqrt();
    let options = FeatureOptions {
        angle_degrees: spec.features.angle_degrees,
        min_length: SHORTEST_FEATURE * edge_length,
        ..FeatureOptions::default()
    };
    let features = detect_features(&conditioned, &soup, &options);
    let surface = Surface { mesh: conditioned.mesh, features };
    let branch_points = match spec.optimise {
        Optimise::None => None,
        other => Some(BranchOptions { create: other == Optimise::Balance, price: BranchOptions::PRICE }),
    };
    let component = |problem| {
        let working = working_surface(ctx, &problem, MAX_FACES).map_err(|e| text(&e))?;
        let options = QuadCoverOptions::of(&problem, &working, branch_points.clone());
        let prepared = prepare(ctx, &working.surface, &options).map_err(|e| text(&e))?;
        Ok(Component { working, prepared, scale: 1.0 / problem.edge_length })
    };
    split(&surface, edge_length, spec.keeps_count(), &spec.wishes(), &[], &[], &[]).into_iter().map(component).collect()
}
