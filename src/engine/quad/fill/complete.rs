//! The door: a graph in, quads out.

use crate::engine::mesh::Topology;
use crate::engine::quad::QuadDraft;
use crate::engine::quad::QuadMesh;
use crate::engine::quad::fill::chains::make_simple;
use crate::engine::quad::fill::embedded_graph::EmbeddedGraph;
use crate::engine::quad::fill::embedded_graph::Tag;
use crate::engine::quad::fill::faces::Faces;
use crate::engine::quad::fill::faces::components;
use crate::engine::quad::fill::parity::pair_odd_faces;
use crate::engine::quad::fill::parity::widen;
use crate::engine::quad::fill::polygons::fill_face;
use crate::engine::quad::fill::simplify::Folds;
use crate::engine::quad::fill::simplify::contract_collapsed;
use crate::engine::quad::fill::simplify::drop_collapsed;
use crate::engine::quad::fill::simplify::prune;
use crate::engine::run::Cancelled;
use crate::engine::run::RunContext;

/// A face with more sides than this is not a hole but a lost region.
const MAX_SIDES: u32 = 4096;

/// What was done to come from a graph to quads. All zero for the graph of a map without folds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct FillReport {
    /// Grid points that were copies of others in a fold.
    pub joined_points: usize,
    /// Arcs removed because they bound nothing.
    pub pruned_arcs: usize,
    /// Closed bubbles of folds removed.
    pub bubbles: usize,
    /// Faces with an odd number of sides.
    pub odd_faces: usize,
    /// Faces that were not quads and were filled.
    pub holes: usize,
    /// Quads in these.
    pub filled_quads: usize,
    /// Arcs split so that no two join the same two points.
    pub split_arcs: usize,
}

impl FillReport {
    /// Whether nothing had to be repaired but folds, which leave no trace.
    pub fn is_clean(&self) -> bool {
        self.holes == 0 && self.odd_faces == 0 && self.split_arcs == 0
    }
}

/// Why a graph could not be completed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub(crate) enum FillError {
    /// The run was stopped.
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
    /// The faces of the graph are not disks.
    #[error(
        "they make {components} pieces, the largest with Euler characteristic {euler} and {boundaries} boundary loops, but the surface has {expected_euler} and {expected_boundaries}"
    )]
    Topology {
        /// Pieces of the graph that are not bubbles.
        components: usize,
        /// Of the largest piece.
        euler: i64,
        /// Of the largest piece.
        boundaries: usize,
        /// Of the surface.
        expected_euler: i64,
        /// Of the surface.
        expected_boundaries: usize,
    },
    /// A step could not be done.
    #[error("{step} failed")]
    Stuck {
        /// The step.
        step: &'static str,
    },
}

/// Completes a graph on a connected surface of this topology to a pure quad mesh of the same topology.
pub(crate) fn complete(
    ctx: &RunContext,
    mut graph: EmbeddedGraph,
    expected: &Topology,
) -> Result<(QuadDraft, FillReport), FillError> {
    let mut report = FillReport { joined_points: contract_collapsed(&mut graph), ..FillReport::default() };
    report.pruned_arcs = prune(&mut graph, Folds::Undo);
    report.pruned_arcs += drop_collapsed(&mut graph);
    report.pruned_arcs += prune(&mut graph, Folds::Undo);
    ctx.check()?;
    report.bubbles = keep_main_piece(&mut graph, expected)?;
    report.holes = widen(&mut graph);
    report.odd_faces = pair_odd_faces(ctx, &mut graph)?;
    for first in Faces::new(&graph).inside(|len| len != 4) {
        ctx.check()?;
        let sides = graph.face(first).take(MAX_SIDES as usize + 1).count() as u32;
        if sides % 2 == 1 || !(4..=MAX_SIDES).contains(&sides) {
            return Err(FillError::Stuck { step: "filling a hole" });
        }
        report.filled_quads += fill_face(&mut graph, first);
        report.holes += 1;
    }
    report.pruned_arcs += prune(&mut graph, Folds::Keep);
    report.split_arcs = make_simple(ctx, &mut graph)?.ok_or(FillError::Stuck { step: "separating parallel edges" })?;
    check(&graph, expected)?;
    Ok((draft(&graph), report))
}

/// Removes pieces of the graph that are bubbles of folds, and returns how many.
fn keep_main_piece(graph: &mut EmbeddedGraph, expected: &Topology) -> Result<usize, FillError> {
    let (component, numbers) = components(graph);
    let is_bubble = |c: usize| numbers[c].euler == 2 && numbers[c].boundaries == 0;
    let fits = |c: usize| numbers[c].euler == expected.euler && numbers[c].boundaries == expected.boundaries;
    let largest = (0..numbers.len()).max_by_key(|&c| (fits(c), numbers[c].arcs, std::cmp::Reverse(c)));
    let largest = largest.ok_or(FillError::Stuck { step: "finding grid points" })?;
    let others = (0..numbers.len()).filter(|&c| c != largest && !is_bubble(c)).count();
    if others > 0 || !fits(largest) {
        return Err(FillError::Topology {
            components: others + 1,
            euler: numbers[largest].euler,
            boundaries: numbers[largest].boundaries,
            expected_euler: expected.euler,
            expected_boundaries: expected.boundaries,
        });
    }
    for arc in 0..graph.alive.len() as u32 {
        if graph.alive[arc as usize] && component[2 * arc as usize] != largest as u32 {
            graph.remove(arc);
        }
    }
    Ok(numbers.len() - 1)
}

/// Proves what the steps promise.
fn check(graph: &EmbeddedGraph, expected: &Topology) -> Result<(), FillError> {
    if !Faces::new(graph).inside(|len| len != 4).is_empty() {
        return Err(FillError::Stuck { step: "making all faces quads" });
    }
    let (_, numbers) = components(graph);
    match numbers[..] {
        [n] if n.euler == expected.euler && n.boundaries == expected.boundaries => Ok(()),
        _ => Err(FillError::Stuck { step: "keeping the topology" }),
    }
}

fn draft(graph: &EmbeddedGraph) -> QuadDraft {
    let mut number = vec![u32::MAX; graph.nodes.len()];
    let used = (0..graph.n_darts()).filter(|&d| graph.is_alive(d));
    used.for_each(|d| number[graph.origin(d) as usize] = 0);
    let mut draft = QuadDraft::default();
    for (n, node) in graph.nodes.iter().enumerate().filter(|(n, _)| number[*n] == 0).collect::<Vec<_>>() {
        number[n] = draft.anchors.len() as u32;
        draft.anchors.push(node.anchor);
        draft.mesh.positions.push(node.position);
    }
    let quads = Faces::new(graph).inside(|_| true).into_iter().map(|first| {
        let mut quad = [0; 4];
        quad.iter_mut().zip(graph.face(first)).for_each(|(v, d)| *v = number[graph.origin(d) as usize]);
        quad
    });
    draft.mesh = QuadMesh { quads: quads.collect(), ..draft.mesh };
    for arc in (0..graph.alive.len()).filter(|&arc| graph.alive[arc] && graph.tag[arc] == Tag::Feature) {
        let ends = [2 * arc, 2 * arc + 1].map(|d| number[graph.node[d] as usize]);
        draft.feature_edges.push([ends[0].min(ends[1]), ends[0].max(ends[1])]);
    }
    draft.feature_edges.sort_unstable();
    draft
}
