//! What it costs to cut an edge, so that the cheapest cut graph joins near singularities by shortest paths
//! ([kaelberer_2013] section 6.3.1; the greedy cut graph of [erickson_2005]).

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use crate::engine::mesh::TriMesh;
use crate::engine::mesh::prev;

/// Per halfedge 0 on shortest paths to the nearest source, elsewhere the length of the path between sources across it,
/// model units. Sources are the vertices of nonzero index and the boundary. O(F log F).
pub(super) fn cut_costs(mesh: &TriMesh, quarter_index: &[i32]) -> Vec<f64> {
    let mut distance = vec![f64::INFINITY; mesh.n_vertices()];
    let mut parent: Vec<Option<usize>> = vec![None; mesh.n_vertices()];
    let mut heap = BinaryHeap::new();
    for v in (0..mesh.n_vertices()).filter(|&v| quarter_index[v] != 0 || mesh.is_boundary_vertex(v as u32)) {
        distance[v] = 0.0;
        heap.push(Reverse((0u64, v as u32)));
    }
    if heap.is_empty() && mesh.n_vertices() > 0 {
        distance[0] = 0.0;
        heap.push(Reverse((0, 0)));
    }
    let length = |h: usize| mesh.position(mesh.origin(h)).distance(mesh.position(mesh.target(h)));
    while let Some(Reverse((key, v))) = heap.pop() {
        let here = distance[v as usize];
        // Distances are not negative: their bits are ordered like themselves.
        if key != here.to_bits() {
            continue;
        }
        for h in mesh.fan(v).flat_map(|h| [h, prev(h)]) {
            let w = if mesh.origin(h) == v { mesh.target(h) } else { mesh.origin(h) };
            let there = here + length(h);
            if there < distance[w as usize] {
                (distance[w as usize], parent[w as usize]) = (there, Some(h));
                heap.push(Reverse((there.to_bits(), w)));
            }
        }
    }
    let cost = |h: usize| distance[mesh.origin(h) as usize] + length(h) + distance[mesh.target(h) as usize];
    // Twins must agree to the last bit.
    let mut costs: Vec<f64> = (0..mesh.n_halfedges()).map(|h| cost(h.min(mesh.twin(h).unwrap_or(h)))).collect();
    for h in parent.into_iter().flatten() {
        costs[h] = 0.0;
        if let Some(t) = mesh.twin(h) {
            costs[t] = 0.0;
        }
    }
    costs
}
