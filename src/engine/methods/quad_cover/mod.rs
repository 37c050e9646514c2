//! QuadCover `[kaelberer_2007]`, `[kaelberer_2013]`: cross field → matching → seamless map → integers →
//! integer-grid map.
//!
//! The script of the method on one connected component. The field is solved once; the map's system is factored once;
//! densities are tried by rounding alone, since the right-hand side is proportional to the scale.

mod error;
mod method;
mod options;
mod solve_field;

use crate::engine::field::BranchSearch;
use crate::engine::field::CrossField;
use crate::engine::field::Frames;
use crate::engine::field::stroke_guidance;
use crate::engine::mesh::Surface;
use crate::engine::methods::quad_cover::solve_field::solve_field;
use crate::engine::parameterize::GridMap;
use crate::engine::parameterize::MapAim;
use crate::engine::parameterize::MapError;
use crate::engine::parameterize::MapMeasures;
use crate::engine::parameterize::MapSystem;
use crate::engine::parameterize::Precision;
use crate::engine::parameterize::RoundedIntegers;
use crate::engine::parameterize::measure_map;
use crate::engine::parameterize::untangle;
use crate::engine::run::RunContext;
use crate::engine::run::Stage;

pub use error::QuadCoverError;
pub use method::{MAX_FACES, QuadCover};
pub use options::QuadCoverOptions;

/// An integer-grid map (up to flipped triangles) of one component.
#[derive(Clone, Debug)]
pub struct QuadCoverMap {
    /// The map on the working mesh.
    pub grid: GridMap,
    /// Grid units per model unit.
    pub scale: f64,
    /// The field that it follows.
    pub field: CrossField,
    /// Number of integers that were rounded.
    pub n_integers: usize,
    /// Its measures.
    pub measures: MapMeasures,
    /// What the search for branch points did.
    pub branch_search: BranchSearch,
    /// Energy of the seamless map relative to ½‖X‖².
    pub curl_energy: f64,
    /// Energy added by rounding relative to ½‖X‖².
    pub rounding_energy: f64,
}

/// Weight in the map of faces beneath strokes: it follows the field there, whatever that costs its surroundings.
const STROKE_WEIGHT: f64 = 100.0;

/// How far the count may be from the one asked for before the scale is tried again.
const COUNT_TOLERANCE: f64 = 0.02;
/// Scales tried at most.
const MAX_SCALES: usize = 4;
/// Further scales, relative to the best so far, where that is further than `COUNT_MISSED` off: few integers jump from one
/// count to another, and the area says little about where.
const NEARBY: [f64; 6] = [0.97, 1.03, 0.94, 1.06, 0.9, 1.1];
const COUNT_MISSED: f64 = 0.04;
/// Most integers for which they are tried.
const FEW_INTEGERS: usize = 200;
/// With more integers, maps are worth less where more neighbours have collapsed than this share of the integers,
/// by what is more times that: then quads of this size cannot show the shape, and finer quads can.
const FEW_FALLEN: f64 = 0.05;
const FALLEN_WEIGHT: f64 = 8.0;
/// With more integers than these only three scales are tried, or two: rounding is cubic in their number.
const MANY_INTEGERS: usize = 400;
const VERY_MANY_INTEGERS: usize = 1000;

/// Each scale takes this share of what is left of the progress: most maps need two.
const SHARE_OF_SCALE: f64 = 0.6;

/// Runs the method on the working mesh of one component.
///
/// # Errors
/// [`QuadCoverError`]; the caller then tries something else.
pub fn quad_cover(
    ctx: &RunContext,
    working: &Surface,
    options: &QuadCoverOptions,
) -> Result<QuadCoverMap, QuadCoverError> {
    let mesh = &working.mesh;
    let Prepared { frames, field, branch_search, system } = prepare(ctx, working, options)?;
    ctx.stage(Stage::Round, |ctx| {
        let (rounded, mut grid) = meet_count(&ctx.span(0.0, 0.9), working, &frames, &system, options)?;
        let pinned = pinned(working, &field);
        let gradients = options.exact().and_then(|field| field.gradients(mesh, &frames));
        let shapes = gradients.map(|gradients| frames.seen_by(mesh, &gradients));
        let shapes = shapes.as_ref().unwrap_or(&frames);
        let left = untangle(&ctx.span(0.9, 1.0), mesh, shapes, &mut grid, &pinned, rounded.scale)?;
        let mut measures = measure_map(mesh, &frames, &grid, rounded.scale);
        measures.flipped = measures.flipped.max(left);
        Ok(QuadCoverMap {
            grid,
            scale: rounded.scale,
            n_integers: system.n_integers(),
            field,
            branch_search,
            measures,
            curl_energy: rounded.curl_energy,
            rounding_energy: rounded.rounding_energy,
        })
    })
}

/// What stands before any density is tried.
#[derive(Clone, Debug)]
pub struct Prepared {
    /// Charts of the faces of the working mesh.
    pub frames: Frames,
    /// The field.
    pub field: CrossField,
    /// What the search for branch points did.
    pub branch_search: BranchSearch,
    /// The factored system of all maps that follow the field.
    pub system: MapSystem,
}

/// Field and factored system.
///
/// # Errors
/// As [`quad_cover`].
pub fn prepare(ctx: &RunContext, working: &Surface, options: &QuadCoverOptions) -> Result<Prepared, QuadCoverError> {
    let mesh = &working.mesh;
    let frames = options.frames(mesh);
    let flags = options.followed(working);
    let strokes = stroke_guidance(mesh, &frames, &options.strokes, options.edge_length);
    let (field, branch_search) =
        ctx.stage(Stage::Field, |ctx| solve_field(ctx, working, &frames, strokes.clone(), options))?;
    let weight = |f| if strokes.as_ref().is_some_and(|s| s.is_near(f)) { STROKE_WEIGHT } else { 1.0 };
    let gradients = options.exact().and_then(|field| field.gradients(mesh, &frames));
    let precision = if options.exact().is_some() { Precision::Refined } else { Precision::Usual };
    let aim = MapAim { weight: (0..mesh.n_faces()).map(weight).collect(), gradients, precision };
    let system = ctx
        .stage(Stage::Map, |ctx| MapSystem::new(ctx, mesh, &frames, &field, &flags, &options.corners(working), aim))?;
    Ok(Prepared { frames, field, branch_search, system })
}

/// Vertices that lie on integer points: singular ones and corners.
fn pinned(working: &Surface, field: &CrossField) -> Vec<bool> {
    let mut pinned: Vec<bool> = field.quarter_index.iter().map(|&q| q != 0).collect();
    for &v in &working.features.corners {
        pinned[v as usize] = true;
    }
    pinned
}

/// Rounds at the scale of the edge length, then at scales corrected by the area of the map, and keeps the best.
fn meet_count(
    ctx: &RunContext,
    working: &Surface,
    frames: &Frames,
    system: &MapSystem,
    options: &QuadCoverOptions,
) -> Result<(RoundedIntegers, GridMap), QuadCoverError> {
    let mut scale = 1.0 / options.edge_length;
    let mut best: Option<(f64, RoundedIntegers, GridMap)> = None;
    let tries = match system.n_integers() {
        n if n > VERY_MANY_INTEGERS => 2,
        n if n > MANY_INTEGERS => 3,
        _ => MAX_SCALES,
    };
    let nearby: &[f64] = if system.n_integers() > FEW_INTEGERS { &[] } else { &NEARBY };
    let mut centre = scale;
    for attempt in 0..tries + nearby.len() {
        if attempt >= tries {
            if best.as_ref().is_some_and(|b| b.0 < COUNT_MISSED) {
                break;
            }
            if attempt == tries {
                centre = best.as_ref().map_or(scale, |b| b.1.scale);
            }
            scale = centre * nearby[attempt - tries];
        }
        let ctx = &ctx.attempt(SHARE_OF_SCALE);
        let rounded = system.round(&ctx.span(0.0, 0.9), &working.mesh, scale)?;
        let grid = match system.map(&working.mesh, &rounded) {
            Err(e) if attempt + 1 == tries + nearby.len() && best.is_none() => return Err(e.into()),
            Err(_) => {
                // Fractions depend on the integers, hence on the scale: try one nearby.
                scale *= 1.03;
                continue;
            }
            Ok(grid) => grid,
        };
        let measures = measure_map(&working.mesh, frames, &grid, scale);
        let wanted = options.quads.unwrap_or(measures.grid_area);
        let off = (measures.grid_area.max(1.0) / wanted).ln().abs();
        let is_met = off < COUNT_TOLERANCE;
        let n = system.n_integers();
        let fallen = if n > FEW_INTEGERS { rounded.fallen_together as f64 / n as f64 } else { 0.0 };
        let rank = off + FALLEN_WEIGHT * (fallen - FEW_FALLEN).max(0.0);
        if best.as_ref().is_none_or(|b| rank < b.0) {
            best = Some((rank, rounded, grid));
        }
        if is_met {
            break;
        }
        scale *= (wanted / measures.grid_area.max(1.0)).sqrt().clamp(0.5, 2.0);
    }
    let (_, rounded, grid) = best.ok_or(QuadCoverError::Map(MapError::Fractions { n: system.n_integers() }))?;
    Ok((rounded, grid))
}
