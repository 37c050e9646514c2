//! Local stiffening [bommes_2009, section 6]: faces whose singular values vary against their neighbours' get more
//! weight until nothing is flipped. The integers stay; one numeric factorisation per round.

use crate::engine::field::Frames;
use crate::engine::mesh::TriMesh;
use crate::engine::methods::quad_cover::error::QuadCoverError;
use crate::engine::parameterize::GridMap;
use crate::engine::parameterize::MapMeasures;
use crate::engine::parameterize::MapSystem;
use crate::engine::parameterize::RoundedIntegers;
use crate::engine::parameterize::measure_map;
use crate::engine::parameterize::singular_values;
use crate::engine::run::RunContext;

/// Rounds of stiffening at most.
const MAX_ROUNDS: usize = 2;
/// Largest addition to a face's weight in one round.
const MAX_ADDITION: f64 = 5.0;

/// Returns the map with the fewest flipped triangles among the rounds.
pub(super) fn stiffen(
    ctx: &RunContext,
    mesh: &TriMesh,
    frames: &Frames,
    system: &MapSystem,
    rounded: &RoundedIntegers,
    grid: GridMap,
    measures: MapMeasures,
) -> Result<(GridMap, MapMeasures), QuadCoverError> {
    let mut weight = vec![1.0; mesh.n_faces()];
    let (mut best, mut last) = ((grid.clone(), measures), grid);
    for round in 0..MAX_ROUNDS {
        if best.1.flipped == 0 {
            break;
        }
        ctx.check()?;
        ctx.advance(round as f64 / MAX_ROUNDS as f64);
        add_weight(mesh, frames, rounded.scale, &last, &mut weight);
        let Ok(grid) = system.map_weighted(mesh, frames, rounded, &weight) else { break };
        let measures = measure_map(mesh, frames, &grid, rounded.scale);
        if measures.flipped < best.1.flipped {
            best = (grid.clone(), measures);
        }
        last = grid;
    }
    Ok(best)
}

/// Adds weight where the distortion differs from the neighbours' and where a face is flipped.
fn add_weight(mesh: &TriMesh, frames: &Frames, scale: f64, grid: &GridMap, weight: &mut [f64]) {
    let distortion: Vec<f64> = (0..mesh.n_faces())
        .map(|f| {
            let (s1, s2) = singular_values(mesh, frames, &grid.uv, f);
            (s1 / scale - 1.0).abs() + (s2 / scale - 1.0).abs()
        })
        .collect();
    let addition: Vec<f64> = (0..mesh.n_faces())
        .map(|f| {
            let neighbours: Vec<f64> =
                (3 * f..3 * f + 3).filter_map(|h| mesh.twin(h)).map(|t| distortion[t / 3]).collect();
            let mean = neighbours.iter().sum::<f64>() / neighbours.len().max(1) as f64;
            let (_, s2) = singular_values(mesh, frames, &grid.uv, f);
            let flipped = if s2 <= 0.0 { 1.0 } else { 0.0 };
            ((distortion[f] - mean).abs() + flipped).min(MAX_ADDITION)
        })
        .collect();
    // Weights are smoothed once over neighbours: a single stiff face would only push its flip next door.
    for f in 0..mesh.n_faces() {
        let around: f64 = (3 * f..3 * f + 3).filter_map(|h| mesh.twin(h)).map(|t| addition[t / 3]).sum();
        weight[f] += 0.5 * addition[f] + around / 6.0;
    }
}
