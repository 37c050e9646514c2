//! Singularity graphs from the curves of cut meshes: what their meta-vertices, meta-edges and meta-faces are.

use std::collections::VecDeque;

use glam::DVec2;

use crate::engine::mesh::{NONE, next, prev};
use crate::engine::methods::harmonic::cut_mesh::CutMesh;
use crate::engine::methods::harmonic::error::HarmonicError;
use crate::engine::methods::harmonic::given::GivenGraph;
use crate::engine::methods::harmonic::graph::{MetaEdge, Side, SingularityGraph};
use crate::engine::methods::harmonic::regions::Regions;

/// A meta-edge that leaves its coordinate line by more than this, relative to its length, follows none.
const BENT: f64 = 1e-4;

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
