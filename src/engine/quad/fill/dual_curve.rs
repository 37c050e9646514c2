//! The cheapest closed curve across given arcs: straight on through quads, or turning inside some of them.

use crate::engine::numerics::PathSearch;
use crate::engine::quad::Anchor;
use crate::engine::quad::fill::embedded_graph::EmbeddedGraph;
use crate::engine::quad::fill::faces::Faces;

/// Cost of crossing an arc, which makes one more quad.
const STEP: u32 = 4;
/// Extra cost of a turn inside a quad, which makes a node of degree three and adds an arc to the far corner: that of
/// some quads more,
const TURN: u32 = 8 * STEP;
/// and of one more for so many quads of the surface, up to so many: where there are many, some more of them are no loss.
const QUADS_PER_STEP: u32 = 500;
const MAX_STEPS: u32 = 30;
/// A turn costs so many times as much where the far corner lies on a curve or has five arcs already.
const BAD_CORNER: u32 = 3;

/// Curves across arcs: dart d stands for having come across its arc into the face to its left.
pub(super) struct CurveSearch<'a> {
    graph: &'a EmbeddedGraph,
    faces: &'a Faces,
    turn: u32,
    /// Nodes are darts; costs are whole numbers.
    search: PathSearch,
    /// A dart of every boundary arc, inside.
    inward: Vec<u32>,
}

impl<'a> CurveSearch<'a> {
    /// All faces inside must be quads.
    pub(super) fn new(graph: &'a EmbeddedGraph, faces: &'a Faces) -> Self {
        let is_outside = |d: u32| faces.outside[faces.of[d as usize] as usize];
        let inward = (0..graph.n_darts()).filter(|&d| graph.is_alive(d) && is_outside(d ^ 1)).collect();
        let turn = TURN + STEP * (faces.first.len() as u32 / QUADS_PER_STEP).min(MAX_STEPS);
        Self { graph, faces, turn, search: PathSearch::new(graph.n_darts() as usize), inward }
    }

    /// The arcs of the cheapest curve that begins with these darts, crosses each of their arcs once and none of the `taken`
    /// ones, closed or from boundary to boundary, and its cost; `None` if there is none cheaper than `limit`.
    /// O(n log n).
    pub(super) fn along(&mut self, run: &[u32], taken: &[bool], limit: u32) -> Option<(u32, Vec<u32>)> {
        let graph = self.graph;
        let (goal, start) = (*run.first()?, *run.last()?);
        let is_open = |d: u32| !taken[d as usize / 2] && run.iter().all(|r| r / 2 != d / 2);
        self.search.clear();
        let mut was_outside = false;
        let mut best = (limit, u32::MAX);
        self.search.start(start, f64::from(STEP * run.len() as u32));
        while let Some((cost, d)) = self.search.nearest() {
            let cost = cost as u32;
            if cost >= best.0 {
                break;
            }
            if self.faces.outside[self.faces.of[d as usize] as usize] {
                // From the outside the curve comes back anywhere.
                if !std::mem::replace(&mut was_outside, true) {
                    for i in 0..self.inward.len() {
                        let into = self.inward[i];
                        if into == goal {
                            best = (cost, d);
                        }
                        if is_open(into) {
                            self.reach(into, d, cost + STEP);
                        }
                    }
                }
                continue;
            }
            let opposite = graph.next(graph.next(d));
            for exit in [opposite, graph.next(d), graph.next(opposite)] {
                let turn = if exit == opposite { 0 } else { self.turning(d, exit) };
                if exit ^ 1 == goal {
                    best = best.min((cost + turn, d));
                } else if is_open(exit) {
                    self.reach(exit ^ 1, d, cost + turn + STEP);
                }
            }
        }
        (best.1 != u32::MAX).then(|| (best.0, self.path(best.1, run)))
    }

    /// Cost of a turn from one side of a face to the next or the one before.
    fn turning(&self, side: u32, exit: u32) -> u32 {
        // The corner that the curve does not turn around: the end of the side that comes later.
        let far = if self.graph.next(side) == exit { self.graph.next(exit) } else { self.graph.next(side) };
        let far = self.graph.next(far);
        let node = &self.graph.nodes[self.graph.origin(far) as usize];
        let is_bad = node.anchor != Anchor::Surface || self.graph.degree(far, 6) > 4;
        if is_bad { BAD_CORNER * self.turn } else { self.turn }
    }

    fn reach(&mut self, d: u32, from: u32, cost: u32) {
        self.search.reach(d, f64::from(cost), d / 2, from);
    }

    /// The arcs crossed an odd number of times on the way to `last`, and those where it began.
    fn path(&self, last: u32, run: &[u32]) -> Vec<u32> {
        let mut arcs: Vec<u32> = run.iter().map(|d| d / 2).collect();
        arcs.extend(self.search.steps(last));
        arcs.sort_unstable();
        // Crossed there and back is not crossed.
        arcs.chunk_by(|a, b| a == b).filter(|c| c.len() % 2 == 1).map(|c| c[0]).collect()
    }
}
