//! A given singularity graph cut into a mesh: edges one after the other, each on the shortest way that crosses none before it.
//!
//! Where a way along edges of the mesh is free, it is taken, along features and boundary if it can; otherwise a way across
//! edges, which is split. The map does not depend on where a meta-edge runs, only on how it winds around the others.

use glam::DVec3;

use crate::engine::mesh::{NONE, closest_on_triangle, next, prev};
use crate::engine::methods::harmonic::cut_mesh::CutMesh;
use crate::engine::methods::harmonic::error::HarmonicError;
use crate::engine::methods::harmonic::given::{GivenGraph, Place};
use crate::engine::numerics::PathSearch;
use crate::engine::problem::Problem;
use crate::engine::run::RunContext;

/// A place is at a vertex or on an edge if its barycentric coordinates are this near to it.
const NEAR: f64 = 0.2;
/// A place that another meta-vertex takes is the same if it is this near.
const VERY_NEAR: f64 = 1e-6;
/// Edges of features and boundary are this much shorter to a way that follows them.
const FOLLOWED: f64 = 0.5;
/// Crossing edges is this much longer than running along them, where there is a choice.
const ACROSS: f64 = 1.5;

/// The vertices of the mesh at which the meta-vertices are; where there is none near enough, one is made.
///
/// # Errors
/// [`HarmonicError::Given`] if two are at the same vertex, or the input has no such vertex.
pub(super) fn place(graph: &GivenGraph, problem: &Problem, cut: &mut CutMesh) -> Result<Vec<u32>, HarmonicError> {
    let mut at: Vec<u32> = Vec::with_capacity(graph.vertices.len());
    for (i, vertex) in graph.vertices.iter().enumerate() {
        let p = match vertex.place {
            Place::At(p) => p,
            Place::Input(v) => {
                let own = problem.inputs.iter().position(|&input| input == v);
                let own = own.ok_or_else(|| HarmonicError::Given {
                    cause: format!("meta-vertex {i} is the input vertex {v}, which this component does not have"),
                })?;
                problem.surface.mesh.position(own as u32)
            }
        };
        let v = vertex_at(cut, p, &at);
        if let Some(other) = at.iter().position(|&other| other == v) {
            let cause = format!("meta-vertices {other} and {i} are at the same place");
            return Err(HarmonicError::Given { cause });
        }
        at.push(v);
    }
    Ok(at)
}

/// The vertex at the place of the mesh nearest to `p`.
fn vertex_at(cut: &mut CutMesh, p: DVec3, taken: &[u32]) -> u32 {
    let corners = |f: usize| [0, 1, 2].map(|k| cut.position(cut.origin(3 * f + k)));
    let near = |f: usize| {
        let (weights, nearest) = closest_on_triangle(p, &corners(f));
        (weights, nearest.distance_squared(p))
    };
    let nearest = (0..cut.n_faces()).map(|f| (f, near(f))).min_by(|a, b| a.1.1.total_cmp(&b.1.1).then(a.0.cmp(&b.0)));
    let Some((f, (weights, _))) = nearest else { return 0 };
    let by_weight = |a: &usize, b: &usize| weights[*a].total_cmp(&weights[*b]).then(b.cmp(a));
    let (most, least) = ((0..3).max_by(by_weight).unwrap_or(0), (0..3).min_by(by_weight).unwrap_or(0));
    let v = cut.origin(3 * f + most);
    if weights[most] > 1.0 - NEAR && !(taken.contains(&v) && weights[most] < 1.0 - VERY_NEAR) {
        return v;
    }
    if weights[least] < NEAR {
        // Opposite to the corner of the least weight.
        let h = 3 * f + (least + 1) % 3;
        let share = weights[(least + 2) % 3] / (weights[(least + 1) % 3] + weights[(least + 2) % 3]);
        return cut.split_edge(h, share, cut.map.uv[h]);
    }
    cut.split_face(f, weights, cut.map.uv[3 * f])
}

/// Cuts all edges of a graph into the mesh; edge i is line i. Per edge, the vertex after its first one.
///
/// # Errors
/// [`HarmonicError::Given`] if an edge has no way.
pub(super) fn cut_edges(
    ctx: &RunContext,
    cut: &mut CutMesh,
    graph: &GivenGraph,
    at: &[u32],
) -> Result<Vec<u32>, HarmonicError> {
    let mut second = Vec::with_capacity(graph.edges.len());
    for (i, edge) in graph.edges.iter().enumerate() {
        let [from, to] = edge.ends.map(|end| at[end as usize]);
        let mut tip = from;
        for &p in &edge.path {
            ctx.check()?;
            let stop = nearest_vertex(cut, tip, p);
            if stop != to && !at.contains(&stop) && !cut.is_on_line(stop) {
                let is_reached = cut_way(cut, tip, stop, at, i as u32);
                tip = if is_reached { stop } else { tip };
            }
        }
        if !cut_way(cut, tip, to, at, i as u32) {
            let [a, b] = edge.ends;
            let cause = format!("meta-edge {i} from meta-vertex {a} to {b} has no way that crosses no earlier edge");
            return Err(HarmonicError::Given { cause });
        }
        let own = cut.fan(from).into_iter().find(|&h| cut.line[h] == i as u32);
        let before = || cut.fan(from).into_iter().map(prev).find(|&h| cut.line[h] == i as u32).map(|h| cut.origin(h));
        second.push(own.map(|h| cut.origin(next(h))).or_else(before).unwrap_or(to));
    }
    Ok(second)
}

/// The vertex nearest to `p` that is reached from `start` by edges that come nearer all the time.
fn nearest_vertex(cut: &CutMesh, start: u32, p: DVec3) -> u32 {
    let mut at = start;
    loop {
        let fan = cut.fan(at);
        let around = fan.iter().flat_map(|&h| [cut.origin(next(h)), cut.origin(prev(h))]);
        let away = |v: u32| cut.position(v).distance_squared(p);
        match around.min_by(|&a, &b| away(a).total_cmp(&away(b)).then(a.cmp(&b))) {
            Some(v) if away(v) < away(at) => at = v,
            _ => return at,
        }
    }
}

/// Cuts the shortest way between two vertices; whether there is one.
fn cut_way(cut: &mut CutMesh, from: u32, to: u32, nodes: &[u32], line: u32) -> bool {
    if from == to {
        return false;
    }
    let along = way_along(cut, from, to, |v| nodes.contains(&v));
    // No way is shorter than the straight line.
    let straight = cut.position(from).distance(cut.position(to));
    let across = match &along {
        Some((length, _)) if *length <= ACROSS * straight => None,
        _ => way_across(cut, from, to),
    };
    match (along, across) {
        (Some((length, edges)), across) if across.as_ref().is_none_or(|a| length <= ACROSS * a.0) => {
            edges.into_iter().for_each(|h| cut.mark(h, line));
        }
        (_, Some((_, gates))) => cut_across(cut, from, &gates, line),
        _ => return false,
    }
    true
}

/// The shortest way along edges that are on no line, through vertices that are on none.
fn way_along(cut: &CutMesh, from: u32, to: u32, is_node: impl Fn(u32) -> bool) -> Option<(f64, Vec<usize>)> {
    let mut search = PathSearch::new(cut.n_vertices());
    search.start(from, 0.0);
    while let Some((here, v)) = search.nearest() {
        if v == to {
            let edges = search.steps(to).into_iter().map(|h| h as usize).collect();
            return Some((here, edges));
        }
        if v != from && (is_node(v) || cut.is_on_line(v)) {
            continue;
        }
        for h in cut.fan(v).into_iter().flat_map(|h| [h, prev(h)]).filter(|&h| !cut.is_line(h)) {
            let w = if cut.origin(h) == v { cut.origin(next(h)) } else { cut.origin(h) };
            let length = cut.position(v).distance(cut.position(w));
            let factor = if cut.is_followed(h) { FOLLOWED } else { 1.0 };
            search.reach(w, here + factor * length, h as u32, v);
        }
    }
    None
}

/// The shortest way from face to face across edges that are on no line, as the halfedges that it leaves faces by.
fn way_across(cut: &CutMesh, from: u32, to: u32) -> Option<(f64, Vec<usize>)> {
    let centre = |f: usize| (0..3).map(|k| cut.position(cut.origin(3 * f + k))).sum::<DVec3>() / 3.0;
    let mut search = PathSearch::new(cut.n_faces());
    for h in cut.fan(from) {
        search.start((h / 3) as u32, centre(h / 3).distance(cut.position(from)));
    }
    let ends: Vec<usize> = cut.fan(to).into_iter().map(|h| h / 3).collect();
    let starts: Vec<usize> = cut.fan(from).into_iter().map(|h| h / 3).collect();
    while let Some((here, f)) = search.nearest() {
        let f = f as usize;
        if ends.contains(&f) {
            let gates: Vec<usize> = search.steps(f as u32).into_iter().map(|h| h as usize).collect();
            return (!gates.is_empty()).then_some((here, gates));
        }
        for h in (3 * f..3 * f + 3).filter(|&h| !cut.is_line(h)) {
            let Some(t) = cut.twin(h).filter(|&t| !starts.contains(&(t / 3))) else { continue };
            let length = centre(f).distance(centre(t / 3));
            search.reach((t / 3) as u32, here + length, h as u32, f as u32);
        }
    }
    None
}

/// Splits the gates one after the other in their middles, and marks the way through.
fn cut_across(cut: &mut CutMesh, from: u32, gates: &[usize], line: u32) {
    let mut gates = gates.to_vec();
    debug_assert!(cut.fan(from).contains(&next(next(gates[0]))));
    for i in 0..gates.len() {
        let h = gates[i];
        let middle = cut.map.uv[h].midpoint(cut.map.uv[next(h)]);
        let before = cut.n_faces();
        let twin = cut.twin(h);
        cut.split_edge(h, 0.5, middle);
        // From the corner opposite to the gate, or the last point, to the new one.
        cut.mark(next(h), line);
        let Some(t) = twin else { return };
        match gates.get_mut(i + 1) {
            // The side after the gate has gone to the second of the two new faces.
            Some(gate) if *gate == next(t) => *gate = 3 * (before + 1) + 1,
            Some(_) => {}
            None => cut.mark(next(t), line),
        }
    }
}

/// A boundary edge that is on no line, as the vertices at its ends.
pub(super) fn open_boundary(cut: &CutMesh) -> Option<[u32; 2]> {
    let open = (0..3 * cut.n_faces()).find(|&h| cut.twin(h).is_none() && cut.line[h] == NONE);
    open.map(|h| [cut.origin(h), cut.origin(next(h))])
}
