//! A triangle mesh that curves are cut into by splitting edges, with the charts of a map carried along.
//!
//! Halfedge `3 f + k` runs from corner `k` of face `f` to the next one, as in [`TriMesh`]; splits add faces and vertices and
//! rename none, so that a finished mesh has the same numbers.

use glam::{DVec2, DVec3};

use crate::engine::mesh::{Features, MeshError, NONE, Surface, TriMesh, next, prev};
use crate::engine::methods::harmonic::charts::SeamlessMap;
use crate::engine::parameterize::{Iso, rotate};

/// A new vertex lies at least this share of the edge away from its ends, wherever the map has it: the homotopy of the curves
/// matters, their places do not, and thin triangles spoil the Laplacian.
const LEAST_SHARE: f64 = 0.15;

/// A mesh while curves are cut into it.
#[derive(Clone, Debug)]
pub(super) struct CutMesh {
    positions: Vec<DVec3>,
    faces: Vec<[u32; 3]>,
    twin: Vec<u32>,
    /// Some halfedge that leaves the vertex.
    outgoing: Vec<u32>,
    /// The map that is carried along; of a mesh without a map all zero.
    pub(super) map: SeamlessMap,
    /// Per halfedge, the curve that it lies on; the same for twins.
    pub(super) line: Vec<u32>,
    /// Per halfedge, whether it lies on a feature curve (not on the boundary).
    feature: Vec<bool>,
    corners: Vec<u32>,
}

impl CutMesh {
    pub(super) fn new(surface: &Surface, map: Option<SeamlessMap>) -> Self {
        let mesh = &surface.mesh;
        let n = mesh.n_halfedges();
        let map = map.unwrap_or_else(|| SeamlessMap {
            uv: vec![DVec2::ZERO; n],
            rotation: vec![0; n],
            translation: vec![DVec2::ZERO; n],
            iso: vec![Iso::None; n],
        });
        Self {
            positions: mesh.positions().to_vec(),
            faces: mesh.faces().to_vec(),
            twin: (0..n).map(|h| mesh.twin(h).map_or(NONE, |t| t as u32)).collect(),
            outgoing: (0..mesh.n_vertices() as u32).map(|v| mesh.outgoing(v) as u32).collect(),
            map,
            line: vec![NONE; n],
            feature: (0..n).map(|h| surface.features.is_edge(mesh.origin(h), mesh.target(h))).collect(),
            corners: surface.features.corners.clone(),
        }
    }

    pub(super) fn n_faces(&self) -> usize {
        self.faces.len()
    }

    pub(super) fn n_vertices(&self) -> usize {
        self.positions.len()
    }

    pub(super) fn origin(&self, h: usize) -> u32 {
        self.faces[h / 3][h % 3]
    }

    pub(super) fn position(&self, v: u32) -> DVec3 {
        self.positions[v as usize]
    }

    pub(super) fn twin(&self, h: usize) -> Option<usize> {
        let t = self.twin[h];
        (t != NONE).then_some(t as usize)
    }

    pub(super) fn is_line(&self, h: usize) -> bool {
        self.line[h] != NONE
    }

    /// Whether an edge is on a feature curve or the boundary.
    pub(super) fn is_followed(&self, h: usize) -> bool {
        self.feature[h] || self.twin[h] == NONE
    }

    /// Puts an edge on a curve.
    pub(super) fn mark(&mut self, h: usize, line: u32) {
        self.line[h] = line;
        if let Some(t) = self.twin(h) {
            self.line[t] = line;
        }
    }

    /// Whether a vertex lies on a curve.
    pub(super) fn is_on_line(&self, v: u32) -> bool {
        self.fan(v).into_iter().any(|h| self.is_line(h) || self.is_line(prev(h)))
    }

    /// The halfedges that leave `v`, counter-clockwise, from the boundary where it has one.
    pub(super) fn fan(&self, v: u32) -> Vec<usize> {
        let start = self.outgoing[v as usize] as usize;
        let mut first = start;
        while let Some(t) = self.twin(first) {
            first = next(t);
            if first == start {
                break;
            }
        }
        let mut fan = vec![first];
        let mut h = first;
        while let Some(n) = self.twin(prev(h)).filter(|&n| n != first) {
            fan.push(n);
            h = n;
        }
        fan
    }

    /// Splits the edge of `h` at about `share` of its way from its origin; `z` is the map there, in the chart of the face of `h`.
    /// The new vertex is joined to the third corners of both faces, and the face of `h` keeps the half at its origin.
    pub(super) fn split_edge(&mut self, h: usize, share: f64, z: DVec2) -> u32 {
        let m = self.positions.len() as u32;
        let (a, b) = (self.origin(h), self.origin(next(h)));
        self.positions.push(self.position(a).lerp(self.position(b), share.clamp(LEAST_SHARE, 1.0 - LEAST_SHARE)));
        let twin = self.twin(h);
        let there = twin.map(|_| self.map.to_twin(h, z));
        let g = self.halve(h, m, z);
        if let (Some(t), Some(there)) = (twin, there) {
            let g2 = self.halve(t, m, there);
            (self.twin[h], self.twin[g2]) = (g2 as u32, h as u32);
            (self.twin[g], self.twin[t]) = (t as u32, g as u32);
            self.outgoing[a as usize] = g2 as u32 + 1;
        }
        self.outgoing.push(g as u32);
        self.outgoing[b as usize] = g as u32 + 1;
        if twin.is_none() {
            self.outgoing[a as usize] = h as u32;
        }
        m
    }

    /// Cuts the face of `h` from `m` on `h` to its third corner; the first halfedge of the new face, from `m` on.
    fn halve(&mut self, h: usize, m: u32, z: DVec2) -> usize {
        let (n, p) = (next(h), prev(h));
        let (b, c) = (self.origin(n), self.origin(p));
        let g = 3 * self.faces.len();
        self.faces[h / 3][n % 3] = m;
        self.faces.push([m, b, c]);
        self.map.uv.extend([z, self.map.uv[n], self.map.uv[p]]);
        self.map.uv[n] = z;
        let outer = self.twin[n];
        self.twin.extend([NONE, outer, n as u32]);
        if outer != NONE {
            self.twin[outer as usize] = g as u32 + 1;
        }
        self.twin[n] = g as u32 + 2;
        self.map.rotation.extend([self.map.rotation[h], self.map.rotation[n], 0]);
        self.map.translation.extend([self.map.translation[h], self.map.translation[n], DVec2::ZERO]);
        self.map.iso.extend([self.map.iso[h], self.map.iso[n], Iso::None]);
        self.line.extend([self.line[h], self.line[n], NONE]);
        self.feature.extend([self.feature[h], self.feature[n], false]);
        self.clear(n);
        g
    }

    /// What runs across a face is on no curve and changes no chart.
    fn clear(&mut self, h: usize) {
        (self.map.rotation[h], self.map.translation[h], self.map.iso[h]) = (0, DVec2::ZERO, Iso::None);
        (self.line[h], self.feature[h]) = (NONE, false);
    }

    /// Puts a vertex into face `f` at a place with these barycentric coordinates; `z` is the map there.
    pub(super) fn split_face(&mut self, f: usize, barycentric: [f64; 3], z: DVec2) -> u32 {
        let m = self.positions.len() as u32;
        let [a, b, c] = self.faces[f];
        let at = [a, b, c].iter().zip(barycentric).map(|(&v, w)| self.position(v) * w).sum();
        self.positions.push(at);
        let [za, zb, zc] = [0, 1, 2].map(|k| self.map.uv[3 * f + k]);
        let (h1, h2) = (3 * f + 1, 3 * f + 2);
        let g = 3 * self.faces.len();
        let (g1, g2) = (g, g + 3);
        self.faces[f] = [a, b, m];
        self.faces.extend([[b, c, m], [c, a, m]]);
        self.map.uv[3 * f + 2] = z;
        self.map.uv.extend([zb, zc, z, zc, za, z]);
        let (outer1, outer2) = (self.twin[h1], self.twin[h2]);
        self.twin.extend([outer1, g2 as u32 + 2, h1 as u32, outer2, h2 as u32, g1 as u32 + 1]);
        for (outer, inner) in [(outer1, g1), (outer2, g2)] {
            if outer != NONE {
                self.twin[outer as usize] = inner as u32;
            }
        }
        for old in [h1, h2] {
            self.map.rotation.extend([self.map.rotation[old], 0, 0]);
            self.map.translation.extend([self.map.translation[old], DVec2::ZERO, DVec2::ZERO]);
            self.map.iso.extend([self.map.iso[old], Iso::None, Iso::None]);
            self.line.extend([self.line[old], NONE, NONE]);
            self.feature.extend([self.feature[old], false, false]);
        }
        self.clear(h1);
        self.clear(h2);
        (self.twin[h1], self.twin[h2]) = (g1 as u32 + 2, g2 as u32 + 1);
        self.outgoing[a as usize] = 3 * f as u32;
        self.outgoing[b as usize] = g1 as u32;
        self.outgoing[c as usize] = g2 as u32;
        self.outgoing.push(h2 as u32);
        m
    }

    /// Changes the chart of face `f`: `z ↦ i^quarters z + shift`.
    pub(super) fn turn_chart(&mut self, f: usize, quarters: u8, shift: DVec2) {
        for h in 3 * f..3 * f + 3 {
            self.map.uv[h] = rotate(self.map.uv[h], quarters) + shift;
            let Some(t) = self.twin(h) else { continue };
            // z_f = i^m z_t + τ becomes i^q (i^m z_t + τ) + s.
            let m = (self.map.rotation[h] + quarters) & 3;
            let tau = rotate(self.map.translation[h], quarters) + shift;
            let back = (4 - m) & 3;
            (self.map.rotation[h], self.map.translation[h]) = (m, tau);
            (self.map.rotation[t], self.map.translation[t]) = (back, -rotate(tau, back));
        }
        if quarters % 2 == 1 {
            for h in 3 * f..3 * f + 3 {
                self.map.iso[h] = match self.map.iso[h] {
                    Iso::None => Iso::None,
                    Iso::U => Iso::V,
                    Iso::V => Iso::U,
                };
            }
        }
    }

    /// The cut surface, with the curves of `map` and `line` in its numbers.
    ///
    /// # Errors
    /// [`MeshError`] never comes from a manifold that was cut.
    pub(super) fn finish(self) -> Result<(Surface, SeamlessMap, Vec<u32>), MeshError> {
        let mut edges: Vec<[u32; 2]> = (0..3 * self.faces.len())
            .filter(|&h| self.feature[h])
            .map(|h| [self.origin(h), self.origin(next(h))])
            .map(|[a, b]| [a.min(b), a.max(b)])
            .collect();
        edges.sort_unstable();
        edges.dedup();
        let mesh = TriMesh::try_new(self.positions, self.faces)?;
        Ok((Surface { mesh, features: Features { edges, corners: self.corners } }, self.map, self.line))
    }
}
