//! Holomorphic quadratic differentials `[zhao_2020]`: curves → foliation with signs → harmonic foliation whose branch points
//! are zeros → its closed conjugate → integers → integer-grid map.
//!
//! The script of the method on one closed component of genus 1 or more.

mod cluster;
mod curves;
mod differential;
mod error;
mod foliation;
mod map;
mod merge;
mod method;
mod pants;
mod polynomial;
mod shortest_loop;
mod strip;
#[cfg(test)]
mod tests;

use crate::engine::calculus::Stars;
use crate::engine::mesh::TriMesh;
use crate::engine::methods::holomorphic::curves::{CurveSystem, curve_system};
use crate::engine::methods::holomorphic::differential::harmonic_differential;
use crate::engine::methods::holomorphic::error::HolomorphicError;
use crate::engine::methods::holomorphic::foliation::Foliation;
use crate::engine::methods::holomorphic::map::{Directions, meet_count};
use crate::engine::methods::holomorphic::merge::merge_near;
use crate::engine::parameterize::{GridMap, MapMeasures, measure_map, untangle};
use crate::engine::run::{RunContext, Stage};
use crate::engine::topology::Singularity;

pub use method::Holomorphic;

/// What is asked for.
#[derive(Clone, Copy, Debug)]
struct Options {
    system: CurveSystem,
    seed: usize,
    /// Length of a quad edge in model units.
    edge_length: f64,
    /// Number of quads.
    quads: f64,
}

/// An integer-grid map with zeros of a quadratic differential as its only singularities.
struct DifferentialMap {
    grid: GridMap,
    scale: f64,
    singularities: Vec<Singularity>,
    n_integers: usize,
    measures: MapMeasures,
    curl_energy: f64,
    rounding_energy: f64,
}

/// Share of the curves in the time of a foliation, about.
const CURVES: f64 = 0.3;
/// Zeros less than so many quads apart along v become one: rounded, they would be one or none apart.
const LEAST_GAP: f64 = 0.5;

fn quadratic_differential_map(
    ctx: &RunContext,
    mesh: &TriMesh,
    options: &Options,
) -> Result<DifferentialMap, HolomorphicError> {
    let directions = ctx.stage(Stage::Field, |ctx| {
        let strips = curve_system(&ctx.span(0.0, CURVES), mesh, options.system, options.seed)?;
        let foliation = Foliation::new(mesh, &strips, &vec![1.0; strips.len()]);
        let stars = Stars::new(mesh);
        let differential = harmonic_differential(&ctx.span(CURVES, 0.95), mesh, &stars, foliation)?;
        // Grid units per unit of height, about: u and v have as many as quads are asked for.
        let energy = stars.product(&differential.form, &differential.form).max(f64::MIN_POSITIVE);
        let unit = (energy / mesh.total_area().max(f64::MIN_POSITIVE)).sqrt() * options.edge_length;
        let differential = merge_near(&ctx.span(0.95, 1.0), mesh, &stars, differential, LEAST_GAP * unit)?;
        Ok::<_, HolomorphicError>(Directions::new(mesh, &differential))
    })?;
    let system = ctx.stage(Stage::Map, |ctx| directions.system(ctx, mesh))?;
    ctx.stage(Stage::Round, |ctx| {
        let wanted = (1.0 / options.edge_length, options.quads);
        let (rounded, mut grid) = meet_count(&ctx.span(0.0, 0.9), mesh, &directions.frames, &system, wanted)?;
        let flat = directions.flat_frames(mesh);
        let left = untangle(&ctx.span(0.9, 1.0), mesh, &flat, &mut grid, &directions.pinned(), rounded.scale)?;
        let mut measures = measure_map(mesh, &directions.frames, &grid, rounded.scale);
        measures.flipped = measures.flipped.max(left);
        Ok(DifferentialMap {
            grid,
            scale: rounded.scale,
            singularities: directions.field.singularities(),
            n_integers: system.n_integers(),
            measures,
            curl_energy: rounded.curl_energy,
            rounding_energy: rounded.rounding_energy,
        })
    })
}
