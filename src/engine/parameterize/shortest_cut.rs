//! What it costs to cut an edge, so that the cheapest cut graph joins near singularities by shortest paths
//! (`[kaelberer_2013]` section 6.3.1; the greedy cut graph of `[erickson_2005]`).

use crate::engine::mesh::{ShortestPaths, TriMesh};

/// Per halfedge 0 on shortest paths to the nearest source, elsewhere the length of the path between sources across it,
/// model units. Sources are the vertices of nonzero index and the boundary. O(F log F).
pub(super) fn cut_costs(mesh: &TriMesh, quarter_index: &[i32]) -> Vec<f64> {
    let is_source = |&v: &u32| quarter_index[v as usize] != 0 || mesh.is_boundary_vertex(v);
    let mut sources: Vec<u32> = (0..mesh.n_vertices() as u32).filter(is_source).collect();
    if sources.is_empty() && mesh.n_vertices() > 0 {
        sources.push(0);
    }
    let paths = ShortestPaths::new(mesh, sources.into_iter());
    // Twins must agree to the last bit.
    let mut costs: Vec<f64> =
        (0..mesh.n_halfedges()).map(|h| paths.across(mesh, h.min(mesh.twin(h).unwrap_or(h)))).collect();
    for h in paths.by.into_iter().flatten() {
        costs[h] = 0.0;
        if let Some(t) = mesh.twin(h) {
            costs[t] = 0.0;
        }
    }
    costs
}
