//! Making all faces even: odd faces are paired, and the arcs on a path from one to the other are split, which adds two
//! sides to each face between them and one to each of the pair.

use crate::engine::numerics::PathSearch;
use crate::engine::quad::fill::embedded_graph::EmbeddedGraph;
use crate::engine::quad::fill::embedded_graph::Tag;
use crate::engine::quad::fill::faces::Faces;
use crate::engine::run::Cancelled;
use crate::engine::run::RunContext;

/// Cost of crossing an arc.
const STEP: u32 = 4;
/// Extra cost of a turn inside a quad, which makes two irregular nodes.
const TURN: u32 = 6;
/// Extra cost of splitting an arc of a curve.
const CURVE: u32 = 4;
/// Extra cost of changing the number of arcs of the boundary.
const BOUNDARY: u32 = 24;

/// Splits arcs of faces of one or two arcs, all on curves, until they have four.
pub(super) fn widen(graph: &mut EmbeddedGraph) -> usize {
    let tiny = Faces::new(graph).inside(|len| len < 3);
    for &first in &tiny {
        let darts: Vec<u32> = graph.face(first).collect();
        for &d in &darts {
            for _ in 0..(4 - darts.len()) / darts.len() {
                graph.split(d);
            }
        }
    }
    tiny.len()
}

/// Makes all faces inside even and returns how many were odd. Two neighbours become one face where they share a plain
/// arc. An odd face that is left over, or near the boundary, is paired with the outside: then the boundary gets an arc.
pub(super) fn pair_odd_faces(ctx: &RunContext, graph: &mut EmbeddedGraph) -> Result<usize, Cancelled> {
    let faces = Faces::new(graph);
    let odd = faces.inside(|len| len % 2 == 1);
    let mut search = Search::new(graph, &faces);
    let mut splits = vec![0u32; graph.alive.len()];
    let mut merges = Vec::new();
    for &source in &odd {
        ctx.check()?;
        if search.matched[faces.of[source as usize] as usize] {
            continue;
        }
        let path = search.nearest(source);
        match path[..] {
            [d] if graph.tag_of(d) == Tag::Plain && !faces.outside[faces.of[d as usize ^ 1] as usize] => {
                merges.push(d / 2)
            }
            _ => path.iter().for_each(|d| splits[*d as usize / 2] += 1),
        }
    }
    for arc in merges {
        if splits[arc as usize] == 0 {
            graph.remove(arc);
        } else {
            splits[arc as usize] += 1;
        }
    }
    for (arc, n) in splits.into_iter().enumerate() {
        if n % 2 == 1 {
            graph.split(2 * arc as u32);
        }
    }
    Ok(odd.len())
}

/// Shortest paths over darts: dart e stands for having come into the face to its left across its arc.
struct Search<'a> {
    graph: &'a EmbeddedGraph,
    faces: &'a Faces,
    matched: Vec<bool>,
    /// Nodes are darts on the other side of an arc that was crossed; costs are whole numbers.
    search: PathSearch,
}

impl<'a> Search<'a> {
    fn new(graph: &'a EmbeddedGraph, faces: &'a Faces) -> Self {
        let matched = vec![false; faces.first.len()];
        Self { graph, faces, matched, search: PathSearch::new(graph.n_darts() as usize) }
    }

    fn is_goal(&self, face: u32, source: u32) -> bool {
        let f = face as usize;
        self.faces.outside[f] || (face != source && self.faces.len[f] % 2 == 1 && !self.matched[f])
    }

    /// The arcs to cross from the face at `source` to the nearest face to pair it with, as darts of the faces that are
    /// left; both faces are marked as matched. Empty if there is none.
    fn nearest(&mut self, source: u32) -> Vec<u32> {
        let graph = self.graph;
        let home = self.faces.of[source as usize];
        self.matched[home as usize] = true;
        self.search.clear();
        for d in graph.face(source) {
            self.reach(d, None, 0);
        }
        while let Some((cost, e)) = self.search.nearest() {
            let face = self.faces.of[e as usize];
            if self.is_goal(face, home) {
                self.matched[face as usize] |= !self.faces.outside[face as usize];
                return self.path(e);
            }
            let opposite = graph.next(graph.next(e));
            for d in graph.face(e).skip(1) {
                let turn = if self.faces.len[face as usize] == 4 && d != opposite { TURN } else { 0 };
                self.reach(d, Some(e), cost as u32 + turn);
            }
        }
        Vec::new()
    }

    fn reach(&mut self, exit: u32, from: Option<u32>, cost: u32) {
        let e = exit ^ 1;
        let curve = match self.graph.tag_of(exit) {
            Tag::Plain => 0,
            Tag::Feature => CURVE,
            Tag::Boundary => BOUNDARY,
        };
        let cost = f64::from(cost + STEP + curve);
        match from {
            Some(from) => self.search.reach(e, cost, exit, from),
            None => self.search.start(e, cost),
        };
    }

    fn path(&self, last: u32) -> Vec<u32> {
        self.search.nodes(last).into_iter().map(|e| e ^ 1).collect()
    }
}
