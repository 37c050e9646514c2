//! Shortest paths along edges.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use crate::engine::mesh::TriMesh;
use crate::engine::mesh::prev;

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
        let mut distance = vec![f64::INFINITY; mesh.n_vertices()];
        let mut by: Vec<Option<usize>> = vec![None; mesh.n_vertices()];
        let mut heap = BinaryHeap::new();
        for v in sources {
            distance[v as usize] = 0.0;
            heap.push(Reverse((0u64, v)));
        }
        while let Some(Reverse((key, v))) = heap.pop() {
            let here = distance[v as usize];
            // Distances are not negative: their bits are ordered like themselves.
            if key != here.to_bits() {
                continue;
            }
            for h in mesh.fan(v).flat_map(|h| [h, prev(h)]) {
                let w = across_from(mesh, h, v);
                let there = here + edge_length(mesh, h);
                if there < distance[w as usize] {
                    (distance[w as usize], by[w as usize]) = (there, Some(h));
                    heap.push(Reverse((there.to_bits(), w)));
                }
            }
        }
        Self { distance, by }
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
