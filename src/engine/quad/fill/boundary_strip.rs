//! Boundary strips: rows of quads between the grid and a boundary that does not follow it.
//!
//! Grid lines that end at a boundary loop all lie in one face of the graph: the loop is a hole in it. That face is walked
//! once around, every node of the walk gets a partner on the loop, and the face becomes a row of quads. The topology is
//! right by construction, wherever the partners lie.

use std::collections::BTreeMap;

use glam::DVec3;

use crate::engine::numerics::DisjointSets;
use crate::engine::quad::Anchor;
use crate::engine::quad::fill::FillError;
use crate::engine::quad::fill::boundary_strip_places::{BoundaryLoop, places};
use crate::engine::quad::fill::embedded_graph::{EmbeddedGraph, GraphNode, Tag};
use crate::engine::quad::fill::faces::Faces;
use crate::engine::run::{Cancelled, RunContext};

/// Nodes nearer to the loop than this part of their arcs leave too little room for a quad.
const TOO_NEAR: f64 = 0.5;

/// A grid line that ends at a boundary loop.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Exit {
    /// The dart clockwise of it at its last node.
    pub(crate) before: u32,
    /// Number of the loop.
    pub(crate) loop_number: usize,
    /// The point of the loop where it ends, if it is a feature curve.
    pub(crate) end: Option<usize>,
}

/// Closes the graph with a boundary strip, a row of quads, along each loop.
///
/// # Errors
/// [`FillError::Stuck`] if no grid line ends at a loop, two loops lie in one face, or the walk around a loop has fewer
/// nodes than it has corners; [`FillError::Cancelled`] if the run was stopped.
pub(crate) fn add_boundary_strips(
    ctx: &RunContext,
    graph: &mut EmbeddedGraph,
    exits: &[Exit],
    loops: &[BoundaryLoop],
) -> Result<(), FillError> {
    let mut around = Around::new(graph, exits, loops.len())?;
    around.peel(graph);
    let walks = around.walks(graph);
    for (points, walk) in loops.iter().zip(walks) {
        ctx.check()?;
        around.make_room(ctx, graph, walk.unwrap_or_default(), points)?;
    }
    around.peel(graph);
    let walks: Option<Vec<Vec<u32>>> = around.walks(graph).into_iter().collect();
    let walks = walks.ok_or(FillError::Stuck { step: "walking around a boundary loop" })?;
    for (number, (points, walk)) in loops.iter().zip(&walks).enumerate() {
        ctx.check()?;
        let mut forced = vec![None; walk.len()];
        for (&node, &(_, end)) in around.ends.iter().filter(|(_, end)| end.0 == number) {
            let at = walk.iter().position(|&d| graph.origin(d) == node);
            forced[at.ok_or(FillError::Stuck { step: "leading a feature to the boundary" })?] = Some(end);
        }
        let nodes: Vec<DVec3> = walk.iter().map(|&d| graph.nodes[graph.origin(d) as usize].position).collect();
        let places =
            places(ctx, points, &nodes, &forced)?.ok_or(FillError::Stuck { step: "placing a row of quads" })?;
        draw(graph, walk, &places, &forced);
    }
    Ok(())
}

/// What lies between the grid and the loops while arcs of the grid are taken away.
struct Around {
    faces: Faces,
    /// Faces that have become one.
    joined: DisjointSets,
    /// Per loop, a face of the one that it lies in.
    face: Vec<u32>,
    /// Per node from which a feature goes on to the boundary, the loop and the point of it. Of two features that leave one
    /// node this keeps one; the certificate then misses the other.
    ends: BTreeMap<u32, (usize, usize)>,
}

impl Around {
    fn new(graph: &EmbeddedGraph, exits: &[Exit], n_loops: usize) -> Result<Self, FillError> {
        let faces = Faces::new(graph);
        let mut votes: Vec<BTreeMap<u32, usize>> = vec![BTreeMap::new(); n_loops];
        for exit in exits {
            *votes[exit.loop_number].entry(faces.of[exit.before as usize]).or_default() += 1;
        }
        let most =
            |votes: &BTreeMap<u32, usize>| votes.iter().max_by_key(|v| (v.1, std::cmp::Reverse(v.0))).map(|v| *v.0);
        let face: Option<Vec<u32>> = votes.iter().map(most).collect();
        let face = face.ok_or(FillError::Stuck { step: "finding grid lines that end at a boundary loop" })?;
        let end = |exit: &Exit| Some((graph.origin(exit.before), (exit.loop_number, exit.end?)));
        let ends = exits.iter().filter_map(end).collect();
        Ok(Self { joined: DisjointSets::new(faces.first.len()), faces, face, ends })
    }

    fn face_of(&mut self, d: u32) -> u32 {
        self.joined.find(self.faces.of[d as usize])
    }

    /// Removes an arc, and joins the faces on its sides.
    fn remove(&mut self, graph: &mut EmbeddedGraph, d: u32) {
        let [a, b] = [d, d ^ 1].map(|d| self.face_of(d));
        self.joined.join(a, b);
        graph.remove(d / 2);
    }

    /// Removes nodes with one arc. Features that end there end a node earlier.
    fn peel(&mut self, graph: &mut EmbeddedGraph) {
        let mut work: Vec<u32> = (0..graph.n_darts()).rev().collect();
        while let Some(d) = work.pop() {
            if !graph.is_alive(d) || graph.ccw(d) != d {
                continue;
            }
            let beside = graph.cw(d ^ 1);
            self.shorten(graph, d);
            self.remove(graph, d);
            if beside != d ^ 1 {
                work.push(beside);
            }
        }
    }

    /// The feature along `d` that ends at its origin will end at its target.
    fn shorten(&mut self, graph: &EmbeddedGraph, d: u32) {
        if graph.tag_of(d) == Tag::Feature
            && let Some(end) = self.ends.remove(&graph.origin(d))
        {
            self.ends.insert(graph.target(d), end);
        }
    }

    /// Removes nodes of a walk that are too near to its loop, where nothing but the face of the loop is lost.
    fn make_room(
        &mut self,
        ctx: &RunContext,
        graph: &mut EmbeddedGraph,
        walk: Vec<u32>,
        points: &BoundaryLoop,
    ) -> Result<(), Cancelled> {
        for d in walk {
            ctx.check()?;
            let node = graph.origin(d);
            let anchor = graph.nodes[node as usize].anchor;
            let may_go = anchor == Anchor::Surface || anchor == Anchor::Curve && self.ends.contains_key(&node);
            if !graph.is_alive(d) || !may_go {
                continue;
            }
            let darts: Vec<u32> = graph.around(d).collect();
            let here = graph.nodes[node as usize].position;
            let length = |d: &u32| graph.nodes[graph.target(*d) as usize].position.distance(here);
            let mean = darts.iter().map(length).sum::<f64>() / darts.len() as f64;
            if points.nearest(here).distance > TOO_NEAR * mean {
                continue;
            }
            for d in darts {
                let is_last = graph.degree(d, 2) == 1;
                let ends_beyond = graph.degree(d ^ 1, 2) == 1;
                if is_last || ends_beyond || self.face_of(d) != self.face_of(d ^ 1) {
                    self.shorten(graph, d);
                    self.remove(graph, d);
                }
            }
        }
        Ok(())
    }

    /// Per loop the darts around its face; `None` if they are not one walk, or the face has another loop too.
    fn walks(&mut self, graph: &EmbeddedGraph) -> Vec<Option<Vec<u32>>> {
        let names = self.joined.clone().names();
        let root = |face: u32| names[face as usize];
        let mut loops: BTreeMap<u32, usize> = BTreeMap::new();
        self.face.iter().for_each(|&face| *loops.entry(root(face)).or_default() += 1);
        let mut darts: BTreeMap<u32, (u32, usize)> = BTreeMap::new();
        for d in (0..graph.n_darts()).filter(|&d| graph.is_alive(d)) {
            let face = root(self.faces.of[d as usize]);
            if loops.contains_key(&face) {
                darts.entry(face).or_insert((d, 0)).1 += 1;
            }
        }
        let walk = |&face: &u32| {
            let &(first, n) = darts.get(&root(face)).filter(|_| loops[&root(face)] == 1)?;
            let walk: Vec<u32> = graph.face(first).collect();
            (walk.len() == n).then_some(walk)
        };
        self.face.iter().map(walk).collect()
    }
}

/// Draws the row: a partner for each dart's origin, arcs to the partners and between them.
fn draw(graph: &mut EmbeddedGraph, walk: &[u32], places: &[GraphNode], forced: &[Option<usize>]) {
    let partners: Vec<u32> = places.iter().map(|&place| graph.add_node(place)).collect();
    let n = walk.len();
    let spokes: Vec<u32> = (0..n)
        .map(|i| {
            let tag = if forced[i].is_some() { Tag::Feature } else { Tag::Plain };
            let spoke = graph.add_arc([graph.origin(walk[i]), partners[i]], tag, [false; 2]);
            // No fold is to be seen between the spoke and its neighbours.
            let turn = graph.turn[walk[i] as usize];
            graph.place_after(spoke, walk[i]);
            graph.turn[spoke as usize] = (turn - 1).max(1);
            graph.turn[walk[i] as usize] = 1;
            spoke
        })
        .collect();
    let sides: Vec<u32> =
        (0..n).map(|i| graph.add_arc([partners[i], partners[(i + 1) % n]], Tag::Boundary, [true, false])).collect();
    for i in 0..n {
        let (back, spoke, onward) = (sides[(i + n - 1) % n] ^ 1, spokes[i] ^ 1, sides[i]);
        graph.place_after(spoke, back);
        graph.place_after(onward, spoke);
    }
}
