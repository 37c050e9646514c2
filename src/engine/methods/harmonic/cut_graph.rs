//! The last resort of automatic graphs: where the seamless map folds and separatrices are lost, the surface is cut open along
//! the cut graph of the field instead. Its chains are meta-edges with a Du and a Dv each, of a single meta-face, and their
//! integers are those of the rounded map.

use glam::DVec2;

use crate::engine::mesh::next;
use crate::engine::methods::harmonic::continuity::{Charts, Hold, ModifiedLaplacian};
use crate::engine::methods::harmonic::error::HarmonicError;
use crate::engine::methods::harmonic::source::hold_crossings;
use crate::engine::methods::harmonic::working::Working;
use crate::engine::parameterize::{GridMap, Iso, MapSystem, measure_map};
use crate::engine::problem::Problem;
use crate::engine::run::{RunContext, Stage};
use crate::engine::topology::Singularity;

/// Scales tried at most so that the count is met, and how near is near enough.
const MAX_SCALES: usize = 3;
const COUNT_TOLERANCE: f64 = 0.04;

/// A harmonic map on the working mesh.
#[derive(Clone, Debug)]
pub(super) struct OnCutGraph {
    pub(super) grid: GridMap,
    pub(super) is_held: Vec<bool>,
    pub(super) singularities: Vec<Singularity>,
    /// Grid units per model unit.
    pub(super) scale: f64,
    /// Integers of the rounded map.
    pub(super) n_integers: usize,
}

/// The harmonic map with the integers of the rounded map of the field.
pub(super) fn on_cut_graph(
    ctx: &RunContext,
    working: &Working,
    problem: &Problem,
) -> Result<OnCutGraph, HarmonicError> {
    let (mesh, frames) = (&working.surface.mesh, &working.frames);
    let field = ctx.stage(Stage::Field, |ctx| working.field(ctx, problem, problem.wishes.smoothing, 1.0))?;
    let corners = &working.surface.features.corners;
    let weight = vec![1.0; mesh.n_faces()];
    let system = ctx.stage(Stage::Map, |ctx| {
        MapSystem::new(ctx, mesh, frames, &field, &working.followed(problem), corners, weight)
    })?;
    ctx.stage(Stage::Round, |ctx| {
        let wanted = problem.wishes.adapts_count.then_some(problem.quads);
        let mut scale = 1.0 / problem.edge_length;
        let mut best: Option<(f64, GridMap, f64)> = None;
        for attempt in 0..MAX_SCALES {
            let rounded = system.round(&ctx.part(attempt, MAX_SCALES), mesh, scale)?;
            let map = system.map(mesh, &rounded)?;
            let quads = measure_map(mesh, frames, &map, scale).grid_area.max(1.0);
            let wanted = wanted.unwrap_or(quads);
            let off = (quads / wanted).ln().abs();
            if best.as_ref().is_none_or(|b| off < b.0) {
                best = Some((off, map, scale));
            }
            if off < COUNT_TOLERANCE {
                break;
            }
            scale *= (wanted / quads).sqrt().clamp(0.5, 2.0);
        }
        let (_, map, scale) = best.ok_or(HarmonicError::NoIntegers)?;
        let mut is_held: Vec<bool> = field.quarter_index.iter().map(|&q| q != 0).collect();
        corners.iter().for_each(|&v| is_held[v as usize] = true);
        hold_crossings(mesh, &map, &mut is_held);
        if !is_held.contains(&true) {
            is_held[0] = true;
        }
        let mut holds = Vec::new();
        for corner in 0..mesh.n_halfedges() {
            let z = map.uv[corner];
            if is_held[mesh.origin(corner) as usize] {
                holds.push(Hold { corner, value: [Some(z.x), Some(z.y)] });
            }
            for end in [corner, next(corner)] {
                let z: DVec2 = map.uv[end].round();
                match map.iso[corner] {
                    Iso::None => {}
                    Iso::U => holds.push(Hold { corner: end, value: [Some(z.x), None] }),
                    Iso::V => holds.push(Hold { corner: end, value: [None, Some(z.y)] }),
                }
            }
        }
        let translation: Vec<DVec2> = map.translation.iter().map(|t| t.as_dvec2()).collect();
        let charts = Charts { rotation: &map.rotation, translation: &translation };
        let laplacian = ModifiedLaplacian::new(mesh, frames, &charts);
        let uv = laplacian.solve_with(&laplacian.factor(&holds)?, &holds);
        let singularities = field.singularities();
        Ok(OnCutGraph { grid: GridMap { uv, ..map }, is_held, singularities, scale, n_integers: system.n_integers() })
    })
}
