//! Where the singularity graph comes from.

use crate::engine::mesh::{Surface, TriMesh, prev};
use crate::engine::methods::harmonic::cut_mesh::CutMesh;
use crate::engine::methods::harmonic::error::HarmonicError;
use crate::engine::methods::harmonic::graph::{SingularityGraph, graph_of};
use crate::engine::methods::harmonic::charts::SeamlessMap;
use crate::engine::methods::harmonic::meta_system::find_integers;
use crate::engine::methods::harmonic::separatrices::cut_separatrices;
use crate::engine::methods::harmonic::working::Working;
use crate::engine::parameterize::{GridMap, Iso, MapSystem, untangle};
use crate::engine::problem::Problem;
use crate::engine::run::{RunContext, Stage};
use crate::engine::topology::Singularity;

/// How much smoother than asked for the field is in each attempt, as a share of what is left.
const SMOOTHER: [f64; 5] = [0.0, 0.5, 0.8, 0.95, 1.0];
/// Each attempt takes this share of what is left of the progress: mostly the first one succeeds.
const SHARE_OF_ATTEMPT: f64 = 0.7;

/// A singularity graph with the mesh that it is cut into.
#[derive(Clone, Debug)]
pub(super) struct Sourced {
    pub(super) surface: Surface,
    /// Per halfedge, the coordinate line of a feature or boundary that it is on.
    pub(super) iso: Vec<Iso>,
    pub(super) graph: SingularityGraph,
    /// Meta-vertices that are held: singular ones and corners.
    pub(super) is_held: Vec<bool>,
    pub(super) singularities: Vec<Singularity>,
}

/// The graph of separatrices of the seamless map of a smooth field. The field is as smooth as was asked for; where its map
/// folds or it has more than `most` singularities, it is made smoother.
pub(super) fn from_map(
    ctx: &RunContext,
    working: &Working,
    problem: &Problem,
    most: Option<usize>,
) -> Result<Sourced, HarmonicError> {
    let asked = problem.wishes.smoothing;
    let mut best: Option<Sourced> = None;
    let mut cause = HarmonicError::Fold;
    for share in SMOOTHER {
        let smoothing = asked + share * (1.0 - asked);
        match with_smoothing(&ctx.attempt(SHARE_OF_ATTEMPT), working, problem, smoothing) {
            Err(HarmonicError::Cancelled(stop)) => return Err(stop.into()),
            Err(error) => cause = error,
            Ok(found) => {
                let n = found.singularities.len();
                if best.as_ref().is_none_or(|b| n < b.singularities.len()) {
                    best = Some(found);
                }
                if most.is_none_or(|most| n <= most) {
                    break;
                }
            }
        }
    }
    best.ok_or(cause)
}

fn with_smoothing(
    ctx: &RunContext,
    working: &Working,
    problem: &Problem,
    smoothing: f64,
) -> Result<Sourced, HarmonicError> {
    let (mesh, frames) = (&working.surface.mesh, &working.frames);
    let field = ctx.stage(Stage::Field, |ctx| working.field(ctx, problem, smoothing))?;
    let corners = &working.surface.features.corners;
    let weight = vec![1.0; mesh.n_faces()];
    let system = ctx.stage(Stage::Map, |ctx| {
        MapSystem::new(ctx, mesh, frames, &field, &working.followed(problem), corners, weight)
    })?;
    ctx.stage(Stage::Round, |ctx| {
        let scale = 1.0 / problem.edge_length;
        let rounded = system.round(&ctx.span(0.0, 0.5), mesh, scale)?;
        let mut map = system.map(mesh, &rounded)?;
        map.uv = system.seamless_corners().iter().map(|z| scale * z).collect();
        let mut is_held: Vec<bool> = field.quarter_index.iter().map(|&q| q != 0).collect();
        corners.iter().for_each(|&v| is_held[v as usize] = true);
        hold_crossings(mesh, &map, &mut is_held);
        if untangle(&ctx.span(0.5, 0.7), mesh, frames, &mut map, &is_held, scale)? > 0 {
            return Err(HarmonicError::Fold);
        }
        let uv = std::mem::take(&mut map.uv);
        let mut map = SeamlessMap::new(mesh, uv, map);
        map.straighten();
        let mut cut = CutMesh::new(&working.surface, Some(map));
        cut_separatrices(&ctx.span(0.7, 0.8), &mut cut, &mut is_held)?;
        is_held.resize(cut.n_vertices(), false);
        let mut graph = graph_of(&mut cut, &is_held)?;
        graph.check_turning()?;
        let wanted = problem.wishes.adapts_count.then_some(problem.quads);
        find_integers(&ctx.span(0.8, 1.0), &mut graph, &is_held, wanted)?;
        let (surface, charts, _) = cut.finish()?;
        Ok(Sourced { surface, iso: charts.iso, graph, is_held, singularities: field.singularities() })
    })
}

/// Holds the vertices where lines of features and boundary cross or turn: both their coordinates are known.
fn hold_crossings(mesh: &TriMesh, map: &GridMap, is_held: &mut [bool]) {
    for v in 0..mesh.n_vertices() as u32 {
        let mut quarters = 0u8;
        let mut is_fixed = [false; 2];
        for h in mesh.fan(v) {
            let p = prev(h);
            for axis in [map.iso[h], map.iso[p]].into_iter().filter(|&iso| iso != Iso::None) {
                is_fixed[usize::from((axis == Iso::V) != (quarters % 2 == 1))] = true;
            }
            quarters = (quarters + 4 - map.rotation[p]) & 3;
        }
        is_held[v as usize] |= is_fixed == [true; 2];
    }
}
