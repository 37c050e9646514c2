//! Shortest paths along edges.

use crate::engine::mesh::TriMesh;
use crate::engine::mesh::prev;
use crate::engine::numerics::PathSearch;

/// Shortest paths along edges from some vertices to all others.
#[derive(Clone, Debug)]
pub struct ShortestPaths {
    /// Per vertex its distance from the nearest source, model units; infinite where none is connected to it.
    pub distance: Vec<f64>,
    /// Per vertex the halfedge by which it was reached, in either direction; `None` for sources and what is not reached.
    pub by: Vec<Option<usize>>,
}

impl ShortestPaths {
    /// O(F log F).
    pub fn new(mesh: &TriMesh, sources: impl Iterator<Item = u32>) -> Self {
        let mut search = PathSearch::new(mesh.n_vertices());
        for v in sources {
            search.start(v, 0.0);
        }
        while let Some((here, v)) = search.nearest() {
            for h in mesh.fan(v).flat_map(|h| [h, prev(h)]) {
                search.reach(across_from(mesh, h, v), here + edge_length(mesh, h), h as u32, v);
            }
        }
        let vertices = 0..mesh.n_vertices() as u32;
        Self {
            distance: vertices.clone().map(|v| search.distance(v)).collect(),
            by: vertices.map(|v| search.via(v).map(|h| h as usize)).collect(),
        }
    }

    /// Length of the path across the edge of a halfedge: from the source of one end to that of the other.
    pub fn across(&self, mesh: &TriMesh, h: usize) -> f64 {
        self.distance[mesh.origin(h) as usize] + edge_length(mesh, h) + self.distance[mesh.target(h) as usize]
    }

    /// The vertex before `v` on its path, and how far away it is; `None` if the path begins at `v`.
    pub fn before(&self, mesh: &TriMesh, v: u32) -> Option<(u32, f64)> {
        self.by[v as usize].map(|h| (across_from(mesh, h, v), edge_length(mesh, h)))
    }
}

fn across_from(mesh: &TriMesh, h: usize, v: u32) -> u32 {
    if mesh.origin(h) == v { mesh.target(h) } else { mesh.origin(h) }
}

fn edge_length(mesh: &TriMesh, h: usize) -> f64 {
    mesh.position(mesh.origin(h)).distance(mesh.position(mesh.target(h)))
}
