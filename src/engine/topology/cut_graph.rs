//! Cutting a surface open into a disk that contains every singularity in its boundary, and combing the charts so that
//! rotations are the identity everywhere but on the cut.
//!
//! The dual spanning forest crosses the edges that are dearest to cut; the edges that it does not cross form a graph whose
//! loose ends at regular interior vertices are pruned. What remains is the cheapest cut graph. Its maximal chains between
//! nodes carry one rotation and one translation (period jump) each. O(F log F).

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use crate::engine::mesh::TriMesh;
use crate::engine::topology::matching::Matching;

/// A maximal chain of cut edges between two nodes of the cut graph (or a closed chain without nodes).
#[derive(Clone, Debug)]
pub struct Segment {
    /// Halfedges along the chain, each starting where the last ended; their faces lie to the left.
    pub halfedges: Vec<usize>,
    /// The rotation across every halfedge of the chain.
    pub quarters: u8,
}

/// The cut graph of a combed surface.
#[derive(Clone, Debug)]
pub struct CutGraph {
    /// Per halfedge, the segment that it belongs to and whether it runs along the segment's direction.
    pub segment_of: Vec<Option<(u32, bool)>>,
    /// The segments.
    pub segments: Vec<Segment>,
}

/// Combs the matching and cuts the surface. `quarter_index` is the index in quarters per vertex, used for interior
/// vertices only; `cost` says per halfedge, the same for twins and not negative, how dear it is to cut it. Returns
/// the cut graph, the combed matching, and per face the quarter turns applied to its chart (`z_f := i^k z_f`).
pub fn cut_and_comb(
    mesh: &TriMesh,
    matching: &Matching,
    quarter_index: &[i32],
    cost: &[f64],
) -> (CutGraph, Matching, Vec<u8>) {
    let mut combed = matching.clone();
    let (crossed, turns) = comb(mesh, &mut combed, cost);
    let is_cut = prune(mesh, crossed, quarter_index);
    let (segments, segment_of) = trace_segments(mesh, &combed, &is_cut, quarter_index);
    (CutGraph { segment_of, segments }, combed, turns)
}

/// Prim's algorithm on the dual graph.
fn comb(mesh: &TriMesh, combed: &mut Matching, cost: &[f64]) -> (Vec<bool>, Vec<u8>) {
    let mut crossed = vec![false; mesh.n_halfedges()];
    let mut turns = vec![0u8; mesh.n_faces()];
    let mut reached = vec![false; mesh.n_faces()];
    let mut heap = BinaryHeap::new();
    // Costs are not negative: their bits are ordered like themselves.
    let sides = |f: usize| (3 * f..3 * f + 3).map(|h| (cost[h].to_bits(), Reverse(h)));
    for seed in 0..mesh.n_faces() {
        if reached[seed] {
            continue;
        }
        reached[seed] = true;
        heap.extend(sides(seed));
        while let Some((_, Reverse(h))) = heap.pop() {
            let Some(t) = mesh.twin(h).filter(|&t| !reached[t / 3]) else { continue };
            // z_f = i^m z_g: with z_g := i^m z_g the rotation across h becomes the identity.
            let m = combed.across(h);
            combed.turn_chart(mesh, t / 3, m);
            turns[t / 3] = m;
            (crossed[h], crossed[t]) = (true, true);
            reached[t / 3] = true;
            heap.extend(sides(t / 3));
        }
    }
    (crossed, turns)
}

fn prune(mesh: &TriMesh, crossed: Vec<bool>, quarter_index: &[i32]) -> Vec<bool> {
    let mut is_cut: Vec<bool> = (0..mesh.n_halfedges()).map(|h| !crossed[h] && !mesh.is_boundary(h)).collect();
    let mut degree = vec![0u32; mesh.n_vertices()];
    for h in (0..mesh.n_halfedges()).filter(|&h| is_cut[h]) {
        degree[mesh.origin(h) as usize] += 1;
    }
    let keeps = |v: u32| mesh.is_boundary_vertex(v) || quarter_index[v as usize] != 0;
    let mut loose: Vec<u32> = (0..mesh.n_vertices() as u32).filter(|&v| degree[v as usize] == 1 && !keeps(v)).collect();
    while let Some(v) = loose.pop() {
        let end = mesh.fan(v).find(|&h| is_cut[h]);
        let Some((h, t)) = end.and_then(|h| mesh.twin(h).map(|t| (h, t))) else { continue };
        (is_cut[h], is_cut[t]) = (false, false);
        degree[v as usize] -= 1;
        let other = mesh.target(h);
        degree[other as usize] -= 1;
        if degree[other as usize] == 1 && !keeps(other) {
            loose.push(other);
        }
    }
    is_cut
}

fn trace_segments(
    mesh: &TriMesh,
    combed: &Matching,
    is_cut: &[bool],
    quarter_index: &[i32],
) -> (Vec<Segment>, Vec<Option<(u32, bool)>>) {
    let degree = |v: u32| {
        let leaving = mesh.fan(v).filter(|&h| is_cut[h]).count();
        // At a boundary vertex the last edge of the fan has no outgoing halfedge, but it is never cut.
        leaving
    };
    let is_node = |v: u32| quarter_index[v as usize] != 0 || mesh.is_boundary_vertex(v) || degree(v) != 2;
    let mut segment_of = vec![None; mesh.n_halfedges()];
    let mut segments = Vec::new();
    let mut trace = |start: usize, segment_of: &mut Vec<Option<(u32, bool)>>| {
        let id = segments.len() as u32;
        let mut halfedges = Vec::new();
        let mut h = start;
        loop {
            halfedges.push(h);
            segment_of[h] = Some((id, true));
            if let Some(t) = mesh.twin(h) {
                segment_of[t] = Some((id, false));
            }
            let end = mesh.target(h);
            if is_node(end) {
                break;
            }
            match mesh.fan(end).find(|&n| is_cut[n] && segment_of[n].is_none()) {
                Some(n) => h = n,
                None => break,
            }
        }
        segments.push(Segment { halfedges, quarters: combed.across(start) });
    };
    for h in 0..mesh.n_halfedges() {
        if is_cut[h] && segment_of[h].is_none() && is_node(mesh.origin(h)) {
            trace(h, &mut segment_of);
        }
    }
    for h in 0..mesh.n_halfedges() {
        if is_cut[h] && segment_of[h].is_none() {
            trace(h, &mut segment_of);
        }
    }
    (segments, segment_of)
}
