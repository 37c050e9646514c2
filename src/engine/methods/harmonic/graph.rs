//! The singularity graph `[tong_2006]` section 3.1: meta-vertices, meta-edges as paths of mesh edges with tags on their two
//! sides, and meta-faces, discs with a chart each.

use std::collections::VecDeque;

use glam::{DVec2, I64Vec2};

use crate::engine::mesh::{NONE, TriMesh, next, prev};
use crate::engine::methods::harmonic::cut_mesh::CutMesh;
use crate::engine::methods::harmonic::error::HarmonicError;
use crate::engine::methods::harmonic::given::GivenGraph;
use crate::engine::methods::harmonic::regions::Regions;
use crate::engine::methods::harmonic::tag::Tag;
use crate::engine::parameterize::rotate_integer;
use crate::engine::topology::Singularity;

/// A meta-edge that leaves its coordinate line by more than this, relative to its length, follows none.
const BENT: f64 = 1e-4;

/// A meta-edge: a path between two meta-vertices.
#[derive(Clone, Debug)]
pub(super) struct MetaEdge {
    /// Numbers of the meta-vertices at its ends.
    pub(super) ends: [u32; 2],
    /// Halfedges of the mesh along the path, each beginning where the last one ended, with their faces on the left; at a
    /// boundary that has its face on the right only, the halfedges of the other direction, in the order of the path.
    pub(super) path: Vec<usize>,
    /// The meta-faces on the left and on the right; `NONE` beyond a boundary.
    pub(super) faces: [u32; 2],
    /// Tags of the half meta-edges: along the path in the chart of the left face, against it in that of the right.
    pub(super) tags: [Tag; 2],
    /// Length in grid units: Du or Dv, positive.
    pub(super) extent: i64,
    /// The same in the map that the graph comes from, before it was made an integer.
    pub(super) real: f64,
    /// Length of the path, model units.
    pub(super) length: f64,
}

/// A half meta-edge as a side of a meta-face.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Side {
    /// The meta-edge.
    pub(super) edge: u32,
    /// 0 along its path, 1 against it.
    pub(super) half: usize,
}

/// A singularity graph on a cut mesh.
#[derive(Clone, Debug)]
pub(super) struct SingularityGraph {
    /// Per meta-vertex its vertex in the mesh.
    pub(super) vertices: Vec<u32>,
    pub(super) edges: Vec<MetaEdge>,
    /// The sides of each meta-face, counter-clockwise.
    pub(super) faces: Vec<Vec<Side>>,
}

impl MetaEdge {
    /// Quarter turns across: `z_left = i^m z_right + τ`.
    pub(super) fn quarters(&self) -> u8 {
        (self.tags[0] + 4 - self.tags[1] + 2) & 3
    }
}

/// The step of `extent` grid units along a tag.
pub(super) fn step(tag: Tag, extent: i64) -> I64Vec2 {
    rotate_integer(I64Vec2::new(extent, 0), tag)
}

impl SingularityGraph {
    pub(super) fn edge(&self, side: Side) -> &MetaEdge {
        &self.edges[side.edge as usize]
    }

    pub(super) fn tag(&self, side: Side) -> Tag {
        self.edge(side).tags[side.half]
    }

    /// The meta-vertex where a side begins.
    pub(super) fn start(&self, side: Side) -> u32 {
        self.edge(side).ends[side.half]
    }

    /// Where the sides of a meta-face begin in its chart; the first one at 0.
    ///
    /// # Errors
    /// [`HarmonicError::Open`] if the last side does not end at the first one.
    pub(super) fn corners(&self, face: u32) -> Result<Vec<I64Vec2>, HarmonicError> {
        let mut at = I64Vec2::ZERO;
        let mut corners = Vec::with_capacity(self.faces[face as usize].len());
        for &side in &self.faces[face as usize] {
            corners.push(at);
            at += step(self.tag(side), self.edge(side).extent);
        }
        match at {
            I64Vec2::ZERO => Ok(corners),
            I64Vec2 { x: 0, y } => Err(HarmonicError::Open { face, coordinate: 'v', sum: y }),
            I64Vec2 { x, .. } => Err(HarmonicError::Open { face, coordinate: 'u', sum: x }),
        }
    }

    /// Whether every meta-face turns once: its corners turn by four quarter turns to the left in all.
    ///
    /// # Errors
    /// [`HarmonicError::Turning`] of the first face that does not.
    pub(super) fn check_turning(&self) -> Result<(), HarmonicError> {
        for (face, sides) in (0..).zip(&self.faces) {
            let quarters = (0..sides.len()).map(|k| self.turn(sides, k)).sum();
            if quarters != 4 {
                return Err(HarmonicError::Turning { face, quarters });
            }
        }
        Ok(())
    }

    /// The tags of the same graph as seen from the other side of the surface, in charts whose u runs the other way.
    pub(super) fn mirror(&mut self) {
        let mirrored = |tag: Tag| if tag.is_multiple_of(2) { tag ^ 2 } else { tag };
        for edge in &mut self.edges {
            edge.tags = [mirrored(edge.tags[1]), mirrored(edge.tags[0])];
        }
    }

    /// Turn of the corner between a side and the next one, quarter turns to the left. Between opposite tags the full turn to the
    /// right is taken: the corner then has a whole turn of angle, instead of none.
    fn turn(&self, sides: &[Side], k: usize) -> i32 {
        match (self.tag(sides[(k + 1) % sides.len()]) + 4 - self.tag(sides[k])) & 3 {
            3 => -1,
            2 => -2,
            turn => i32::from(turn),
        }
    }

    /// The meta-vertices in the interior around which the angles of the corners are not four quarter turns.
    pub(super) fn singularities(&self, mesh: &TriMesh) -> Vec<Singularity> {
        let mut quarters = vec![4i32; self.vertices.len()];
        for sides in &self.faces {
            for (k, &side) in (0..sides.len()).zip(sides) {
                let end = self.edge(side).ends[1 - side.half];
                quarters[end as usize] -= 2 - self.turn(sides, k);
            }
        }
        let all = self.vertices.iter().zip(quarters).map(|(&vertex, quarters)| Singularity { vertex, quarters });
        all.filter(|s| s.quarters != 0 && !mesh.is_boundary_vertex(s.vertex)).collect()
    }

    /// Area of all meta-faces in grid units: how many quads there will be.
    pub(super) fn quads(&self) -> Result<f64, HarmonicError> {
        let mut twice = 0;
        for face in 0..self.faces.len() as u32 {
            let corners = self.corners(face)?;
            let n = corners.len();
            twice += (0..n).map(|k| corners[k].perp_dot(corners[(k + 1) % n])).sum::<i64>();
        }
        Ok(0.5 * twice as f64)
    }
}

/// The graph of the curves of a cut mesh whose map has them on coordinate lines. Turns the charts of `cut` so that there is
/// one per meta-face. `is_node` are vertices that are meta-vertices whatever meets there.
pub(super) fn graph_of(cut: &mut CutMesh, is_node: &[bool]) -> Result<SingularityGraph, HarmonicError> {
    let regions = Regions::new(cut);
    if let Some(face) = regions.first_open() {
        return Err(HarmonicError::NotDisc { face });
    }
    comb(cut, &regions);
    let mut graph = paths(cut, &regions, is_node);
    for edge in 0..graph.edges.len() {
        measure(cut, &mut graph, edge)?;
    }
    Ok(graph)
}

/// The graph of the curves of a cut mesh whose lines are the edges of a given one, with its tags. `at` are the vertices of the
/// mesh at which its meta-vertices are, `second` per edge the vertex after its first one.
///
/// # Errors
/// [`HarmonicError::Given`] with the meta-vertices around it if a part is no disc.
pub(super) fn given_graph(
    cut: &CutMesh,
    is_node: &[bool],
    given: &GivenGraph,
    at: &[u32],
    second: &[u32],
) -> Result<SingularityGraph, HarmonicError> {
    let regions = Regions::new(cut);
    if let Some(open) = regions.first_open() {
        let is_around = |v: u32| cut.fan(v).into_iter().any(|h| regions.of_face[h / 3] == open);
        let around: Vec<String> = (0..at.len()).filter(|&i| is_around(at[i])).map(|i| i.to_string()).collect();
        let cause = format!("the part of the surface at meta-vertices {} is not a disc", around.join(", "));
        return Err(HarmonicError::Given { cause });
    }
    let mut graph = paths(cut, &regions, is_node);
    for edge in &mut graph.edges {
        let line = cut.line[edge.path[0]] as usize;
        let own = &given.edges[line];
        let begins = graph.vertices[edge.ends[0] as usize] == at[own.ends[0] as usize];
        // The path of an edge that is closed may have been found against its direction.
        let is_along = begins && (edge.ends[0] != edge.ends[1] || cut.origin(next(edge.path[0])) == second[line]);
        edge.tags = if is_along { own.tags } else { [own.tags[1], own.tags[0]] };
    }
    Ok(graph)
}

/// One chart per part.
fn comb(cut: &mut CutMesh, regions: &Regions) {
    let mut reached = vec![false; cut.n_faces()];
    let mut queue = VecDeque::new();
    for seed in 0..cut.n_faces() {
        if std::mem::replace(&mut reached[seed], true) {
            continue;
        }
        queue.push_back(seed);
        while let Some(f) = queue.pop_front() {
            for h in 3 * f..3 * f + 3 {
                let Some(t) = cut.twin(h).filter(|&t| !cut.is_line(h) && !reached[t / 3]) else { continue };
                debug_assert_eq!(regions.of_face[f], regions.of_face[t / 3]);
                cut.turn_chart(t / 3, cut.map.rotation[h], cut.map.translation[h]);
                reached[t / 3] = true;
                queue.push_back(t / 3);
            }
        }
    }
}

/// Meta-vertices, paths and the sides of meta-faces.
fn paths(cut: &CutMesh, regions: &Regions, is_node: &[bool]) -> SingularityGraph {
    let lines_at = |v: u32| {
        let fan = cut.fan(v);
        let last = fan.last().map_or(0, |&h| prev(h));
        let leaving = fan.iter().filter(|&&h| cut.is_line(h)).count();
        leaving + usize::from(!fan.is_empty() && cut.twin(last).is_none())
    };
    let mut number = vec![NONE; cut.n_vertices()];
    let mut vertices = Vec::new();
    let mut name = |v: u32, number: &mut Vec<u32>| {
        number[v as usize] = vertices.len() as u32;
        vertices.push(v);
    };
    for v in 0..cut.n_vertices() as u32 {
        let lines = lines_at(v);
        let is_node = is_node.get(v as usize).copied().unwrap_or(false) && lines > 0;
        if is_node || (lines > 0 && lines != 2) {
            name(v, &mut number);
        }
    }
    let mut edge_of = vec![NONE; 3 * cut.n_faces()];
    let mut half_of = vec![0usize; 3 * cut.n_faces()];
    let mut is_first = vec![false; 3 * cut.n_faces()];
    let mut edges: Vec<MetaEdge> = Vec::new();
    // Closed curves without a meta-vertex come last and get one.
    for pass in 0..2 {
        for start in 0..3 * cut.n_faces() {
            if !cut.is_line(start) || edge_of[start] != NONE {
                continue;
            }
            if number[cut.origin(start) as usize] == NONE {
                if pass == 0 {
                    continue;
                }
                name(cut.origin(start), &mut number);
            }
            let id = edges.len() as u32;
            let mut path = Vec::new();
            let mut length = 0.0;
            let mut h = start;
            loop {
                path.push(h);
                length += cut.position(cut.origin(h)).distance(cut.position(cut.origin(next(h))));
                (edge_of[h], half_of[h]) = (id, 0);
                if let Some(t) = cut.twin(h) {
                    (edge_of[t], half_of[t]) = (id, 1);
                }
                let end = cut.origin(next(h));
                if number[end as usize] != NONE {
                    break;
                }
                let onwards = cut.fan(end).into_iter().find(|&n| cut.is_line(n) && edge_of[n] == NONE);
                match onwards {
                    Some(n) => h = n,
                    None => break,
                }
            }
            let (first, last) = (path[0], path[path.len() - 1]);
            is_first[first] = true;
            cut.twin(last).into_iter().for_each(|t| is_first[t] = true);
            let right = cut.twin(first).map_or(NONE, |t| regions.of_face[t / 3]);
            edges.push(MetaEdge {
                ends: [number[cut.origin(first) as usize], number[cut.origin(next(last)) as usize]],
                path,
                faces: [regions.of_face[first / 3], right],
                tags: [0; 2],
                extent: 1,
                real: 1.0,
                length,
            });
        }
    }
    let faces = sides(cut, regions, &edge_of, &half_of, &is_first);
    SingularityGraph { vertices, edges, faces }
}

/// The sides of each part, counter-clockwise: from a halfedge on a curve to the next one with the same part on its left.
fn sides(cut: &CutMesh, regions: &Regions, edge_of: &[u32], half_of: &[usize], is_first: &[bool]) -> Vec<Vec<Side>> {
    let mut faces: Vec<Vec<Side>> = vec![Vec::new(); regions.n()];
    let mut is_met = vec![false; regions.n()];
    for start in 0..edge_of.len() {
        if edge_of[start] == NONE || std::mem::replace(&mut is_met[regions.of_face[start / 3] as usize], true) {
            continue;
        }
        let sides = &mut faces[regions.of_face[start / 3] as usize];
        let mut h = start;
        loop {
            let side = Side { edge: edge_of[h], half: half_of[h] };
            if is_first[h] || sides.is_empty() {
                sides.push(side);
            }
            // Clockwise around the end, within the part.
            h = next(h);
            while edge_of[h] == NONE {
                let Some(t) = cut.twin(h) else { break };
                h = next(t);
            }
            if h == start {
                break;
            }
        }
        // The walk began within a side: that one has come twice then.
        if sides.len() > 1 && !is_first[start] && sides[0] == sides[sides.len() - 1] {
            sides.remove(0);
        }
    }
    faces
}

/// Tags and extent of a meta-edge from the map.
fn measure(cut: &CutMesh, graph: &mut SingularityGraph, id: usize) -> Result<(), HarmonicError> {
    let edge = &mut graph.edges[id];
    let along = |h: usize| cut.map.uv[next(h)] - cut.map.uv[h];
    let sum = |halfedges: &mut dyn Iterator<Item = usize>| halfedges.map(along).sum::<DVec2>();
    let left = sum(&mut edge.path.iter().copied());
    let right = sum(&mut edge.path.iter().filter_map(|&h| cut.twin(h)));
    let tag = |z: DVec2| match (z.x > 0.0, z.y > 0.0, z.x.abs() > z.y.abs()) {
        (true, _, true) => 0,
        (_, true, false) => 1,
        (false, _, true) => 2,
        _ => 3,
    };
    let [across, along] = [left.abs().min_element(), left.abs().max_element()];
    if across > BENT * along.max(1.0) {
        return Err(HarmonicError::NotStraight { edge: id as u32 });
    }
    edge.real = along;
    edge.tags[0] = tag(left);
    edge.tags[1] = if edge.faces[1] == NONE { (tag(left) + 2) & 3 } else { tag(right) };
    Ok(())
}
