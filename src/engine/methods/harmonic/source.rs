//! Where the singularity graph comes from.

use crate::engine::field::Frames;
use crate::engine::mesh::{Surface, TriMesh, prev};
use crate::engine::methods::harmonic::charts::{SeamlessMap, seamless_grid};
use crate::engine::methods::harmonic::cut_mesh::CutMesh;
use crate::engine::methods::harmonic::error::HarmonicError;
use crate::engine::methods::harmonic::given::GivenGraph;
use crate::engine::methods::harmonic::graph::{MetaEdge, SingularityGraph};
use crate::engine::methods::harmonic::meta_system::{complete_integers, find_integers};
use crate::engine::methods::harmonic::outline::{given_graph, graph_of};
use crate::engine::methods::harmonic::routes::{cut_edges, open_boundary, place};
use crate::engine::methods::harmonic::separatrices::cut_separatrices;
use crate::engine::methods::harmonic::solve::{BoundaryValues, OnMesh};
use crate::engine::methods::harmonic::working::Working;
use crate::engine::parameterize::{GridMap, Iso, MapSystem, untangle};
use crate::engine::problem::Problem;
use crate::engine::run::{RunContext, Stage};
use crate::engine::topology::Singularity;

/// How much smoother than asked for the field is in each attempt, as a share of what is left, and the size in quad edges
/// below which detail of the surface gives it no singularities ("the support of this estimator must be chosen sufficiently
/// large", `[tong_2006]` section 3.2).
const SMOOTHER: [(f64, f64); 6] = [(0.0, 1.0), (0.5, 1.5), (0.8, 2.0), (1.0, 3.0), (1.0, 5.0), (1.0, 8.0)];
/// Attempts against folds alone: where three fields fold, features bend the map, which no field mends.
const FOR_FOLDS: usize = 3;
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
    /// Of a given graph.
    pub(super) given: Option<GivenIntegers>,
}

/// What a given graph says of its integers.
#[derive(Clone, Debug)]
pub(super) struct GivenIntegers {
    /// Per meta-edge its extent, where it is given.
    extents: Vec<Option<i64>>,
    /// Per given meta-vertex its vertex in the mesh.
    at: Vec<u32>,
}

impl Sourced {
    /// The graph on its mesh.
    pub(super) fn on_mesh<'a>(&'a self, frames: &'a Frames, boundary: BoundaryValues) -> OnMesh<'a> {
        let Self { surface, graph, is_held, iso, .. } = self;
        OnMesh { mesh: &surface.mesh, frames, graph, is_held, iso, boundary }
    }

    /// Integers for the graph, near the real lengths of its edges.
    ///
    /// # Errors
    /// [`HarmonicError`] with the meta-face and the equation if there are none.
    pub(super) fn find_integers(&mut self, ctx: &RunContext, problem: &Problem) -> Result<(), HarmonicError> {
        let wanted = problem.wishes.adapts_count.then_some(problem.quads);
        match &self.given {
            None => find_integers(ctx, &mut self.graph, &self.is_held, wanted),
            Some(GivenIntegers { extents, at }) => {
                let wanted = wanted.filter(|_| extents.iter().all(Option::is_none));
                let completed = complete_integers(ctx, &mut self.graph, extents, wanted);
                completed.map_err(|error| in_words(error, &self.graph, at))
            }
        }
    }
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
    let attempts = if most.is_some() { SMOOTHER.len() } else { FOR_FOLDS };
    for (share, detail) in SMOOTHER.into_iter().take(attempts) {
        let smoothing = asked + share * (1.0 - asked);
        match with_smoothing(&ctx.attempt(SHARE_OF_ATTEMPT), working, problem, smoothing, detail) {
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
    detail: f64,
) -> Result<Sourced, HarmonicError> {
    let (mesh, frames) = (&working.surface.mesh, &working.frames);
    let field = ctx.stage(Stage::Field, |ctx| working.field(ctx, problem, smoothing, detail))?;
    let corners = &working.surface.features.corners;
    let weight = vec![1.0; mesh.n_faces()];
    let followed = working.followed(problem);
    let system = ctx.stage(Stage::Map, |ctx| MapSystem::new(ctx, mesh, frames, &field, &followed, corners, weight))?;
    ctx.stage(Stage::Round, |ctx| {
        let scale = 1.0 / problem.edge_length;
        let uv = system.seamless_corners().iter().map(|z| scale * z).collect();
        let direction: Vec<f64> = system.gradients().iter().map(|[x, _]| x.to_angle()).collect();
        let mut map = seamless_grid(mesh, frames, &direction, &followed, uv);
        let mut is_held: Vec<bool> = field.quarter_index.iter().map(|&q| q != 0).collect();
        corners.iter().for_each(|&v| is_held[v as usize] = true);
        hold_crossings(mesh, &map, &mut is_held);
        // Lines may pass by what stays folded; where one is lost or a meta-face does not turn once, another field is tried.
        untangle(&ctx.span(0.0, 0.5), mesh, frames, &mut map, &is_held, scale)?;
        let mut map = SeamlessMap::new(mesh, map);
        map.straighten();
        let mut cut = CutMesh::new(&working.surface, Some(map));
        cut_separatrices(&ctx.span(0.5, 0.9), &mut cut, &mut is_held)?;
        is_held.resize(cut.n_vertices(), false);
        let graph = graph_of(&mut cut, &is_held)?;
        graph.check_turning()?;
        let (surface, charts, _) = cut.finish()?;
        let singularities = field.singularities();
        Ok(Sourced { surface, iso: charts.iso, graph, is_held, singularities, given: None })
    })
}

/// A graph as it was given.
pub(super) fn from_given(
    ctx: &RunContext,
    working: &Working,
    problem: &Problem,
    given: &GivenGraph,
) -> Result<Sourced, HarmonicError> {
    let mut cut = CutMesh::new(&working.surface, None);
    let at = place(given, problem, &mut cut)?;
    let second = cut_edges(ctx, &mut cut, given, &at)?;
    if let Some([a, b]) = open_boundary(&cut) {
        let [p, q] = [a, b].map(|v| cut.position(v));
        let cause = format!("no meta-edge runs along the boundary between {p} and {q}");
        return Err(HarmonicError::Given { cause });
    }
    let mut is_node = vec![false; cut.n_vertices()];
    let mut is_held = vec![false; cut.n_vertices()];
    for (&v, vertex) in at.iter().zip(&given.vertices) {
        is_node[v as usize] = true;
        is_held[v as usize] = vertex.is_held;
    }
    let mut graph = given_graph(&cut, &is_node, given, &at, &second)?;
    if let Err(error) = graph.check_turning() {
        // A model that is inside out has been turned: what was left is right.
        graph.mirror();
        if graph.check_turning().is_err() {
            graph.mirror();
            return Err(in_words(error, &graph, &at));
        }
    }
    let of_edge = |edge: &MetaEdge| given.edges[cut.line[edge.path[0]] as usize].extent;
    let extents = graph.edges.iter().map(of_edge).collect();
    graph.edges.iter_mut().for_each(|edge| edge.real = edge.length / problem.edge_length);
    let mut iso = vec![Iso::None; 3 * cut.n_faces()];
    for edge in graph.edges.iter().filter(|edge| edge.path.iter().all(|&h| cut.is_followed(h))) {
        let line = |tag: u8| if tag.is_multiple_of(2) { Iso::V } else { Iso::U };
        for &h in &edge.path {
            iso[h] = line(edge.tags[0]);
            cut.twin(h).into_iter().for_each(|t| iso[t] = line(edge.tags[1]));
        }
    }
    let (surface, _, _) = cut.finish()?;
    let singularities = graph.singularities(&surface.mesh);
    let given = Some(GivenIntegers { extents, at });
    Ok(Sourced { surface, iso, graph, is_held, singularities, given })
}

/// A failure at a meta-face as one that names the given meta-vertices around it; `at` says where these are in the mesh.
fn in_words(error: HarmonicError, graph: &SingularityGraph, at: &[u32]) -> HarmonicError {
    use HarmonicError::{Given, OneSided, Open, Turning};
    let (Turning { face, .. } | Open { face, .. } | OneSided { face, .. }) = error else { return error };
    let name = |v: u32| at.iter().position(|&own| own == v).map_or_else(|| "?".to_owned(), |i| i.to_string());
    let sides = graph.faces[face as usize].iter();
    let around: Vec<String> = sides.map(|&side| name(graph.vertices[graph.start(side) as usize])).collect();
    Given { cause: format!("{error} (around it are meta-vertices {})", around.join(", ")) }
}

/// Holds the vertices where lines of features and boundary cross or turn: both their coordinates are known.
pub(super) fn hold_crossings(mesh: &TriMesh, map: &GridMap, is_held: &mut [bool]) {
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
