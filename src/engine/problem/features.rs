//! Giving up features: detail below the size of the quads.

use glam::DVec3;

use crate::engine::mesh::{Features, Surface, closest_on_segment};
use crate::engine::numerics::DisjointSets;
use crate::engine::problem::Problem;

/// Feature curves shorter than this many quad edges are given up as a whole, …
const SHORT_IN_EDGES: f64 = 6.0;
/// … or than this many radii if that is less.
const SHORT_IN_RADII: f64 = 4.0;
/// What is left of a feature curve is kept from this many quad edges on.
const STUMP: f64 = 2.0;

impl Problem {
    /// The problem without its interior features; `None` if it has none. Corners of the boundary stay.
    pub fn without_features(&self) -> Option<Self> {
        (!self.surface.features.edges.is_empty()).then(|| self.with_edges(Vec::new()))
    }

    /// The problem without the feature edges near some places: short curves as a whole, of long ones the part within
    /// `radius` (model units), and what is left of them if it is only a stump. `None` if no feature is there.
    pub fn without_features_near(&self, places: &[DVec3], radius: f64) -> Option<Self> {
        let mesh = &self.surface.mesh;
        let edges = &self.surface.features.edges;
        let ends = |e: &[u32; 2]| e.map(|v| mesh.position(v));
        let length = |e: &[u32; 2]| ends(e)[0].distance(ends(e)[1]);
        let is_near = |e: &[u32; 2]| {
            let [a, b] = ends(e);
            places.iter().any(|&p| closest_on_segment(p, a, b).1.distance(p) <= radius)
        };
        let near: Vec<bool> = edges.iter().map(is_near).collect();
        if !near.contains(&true) {
            return None;
        }
        let curve = curves(edges, &self.surface.features.corners);
        let mut sizes = vec![0.0; edges.len()];
        let mut touched = vec![false; edges.len()];
        for (e, &c) in curve.iter().enumerate() {
            sizes[c] += length(&edges[e]);
            touched[c] |= near[e];
        }
        let short = (SHORT_IN_EDGES * self.edge_length).min(SHORT_IN_RADII * radius);
        let is_given_up = |e: usize| near[e] || touched[curve[e]] && sizes[curve[e]] < short;
        let mut kept: Vec<[u32; 2]> = (0..edges.len()).filter(|&e| !is_given_up(e)).map(|e| edges[e]).collect();
        // Stumps: curves with a loose end that was none before.
        loop {
            let curve = curves(&kept, &self.surface.features.corners);
            let (before, now) = (Features::degrees(edges, mesh), Features::degrees(&kept, mesh));
            let mut sizes = vec![0.0; kept.len()];
            let mut loose = vec![false; kept.len()];
            for (e, &c) in curve.iter().enumerate() {
                sizes[c] += length(&kept[e]);
                loose[c] |= kept[e].iter().any(|&v| now[v as usize] == 1 && before[v as usize] > 1);
            }
            let is_stump = |e: usize| loose[curve[e]] && sizes[curve[e]] < STUMP * self.edge_length;
            let next: Vec<[u32; 2]> = (0..kept.len()).filter(|&e| !is_stump(e)).map(|e| kept[e]).collect();
            if next.len() == kept.len() {
                break;
            }
            kept = next;
        }
        Some(self.with_edges(kept))
    }

    /// The same problem with some of its feature edges only, in their order.
    fn with_edges(&self, edges: Vec<[u32; 2]>) -> Self {
        let mesh = &self.surface.mesh;
        let features = self.surface.features.restricted(mesh, edges);
        Self { surface: Surface { mesh: mesh.clone(), features }.into(), ..self.clone() }
    }
}

/// Per edge, the first edge of its curve: edges that meet where there is no corner.
fn curves(edges: &[[u32; 2]], corners: &[u32]) -> Vec<usize> {
    let mut curves = DisjointSets::new(edges.len());
    let mut ends: Vec<(u32, usize)> = edges.iter().enumerate().flat_map(|(e, v)| [(v[0], e), (v[1], e)]).collect();
    ends.sort_unstable();
    for group in ends.chunk_by(|a, b| a.0 == b.0) {
        if let [(v, e), (_, f)] = *group
            && corners.binary_search(&v).is_err()
        {
            curves.join(e as u32, f as u32);
        }
    }
    curves.names().into_iter().map(|e| e as usize).collect()
}
