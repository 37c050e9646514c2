//! A triangle mesh that can be changed: implicit halfedges as in [`TriMesh`], with dead faces and vertices until the end.

mod collapse;
#[cfg(test)]
mod consistency;
mod flip;
mod split;

use glam::DVec3;

use crate::engine::mesh::remesh::curves::Curves;
use crate::engine::mesh::{Features, MeshError, NONE, Surface, TriMesh, next, prev};

/// An editable oriented 2-manifold with its feature network. Each operation keeps it one; the caller asks before.
#[derive(Clone, Debug)]
pub(in crate::engine::mesh) struct EditMesh {
    pub(in crate::engine::mesh) positions: Vec<DVec3>,
    /// Corners; a dead face is `[NONE; 3]`.
    pub(in crate::engine::mesh) faces: Vec<[u32; 3]>,
    twin: Vec<u32>,
    /// Some halfedge leaving each vertex, `NONE` for a dead vertex.
    outgoing: Vec<u32>,
    /// Segment of the feature network per halfedge, or `NONE`.
    segment: Vec<u32>,
    /// Per vertex: never moved, never removed.
    pub(in crate::engine::mesh) fixed: Vec<bool>,
    /// Per vertex: on the feature network or the boundary.
    pub(in crate::engine::mesh) on_curve: Vec<bool>,
    pub(in crate::engine::mesh) curves: Curves,
    corners: Vec<u32>,
}

/// What editing led to.
#[derive(Clone, Debug)]
pub(in crate::engine) struct Edited {
    pub(in crate::engine) surface: Surface,
    /// Per feature or boundary edge (as lower and higher vertex, sorted), the middle of the curve that it stands for.
    pub(in crate::engine) curve_middles: Vec<([u32; 2], DVec3)>,
}

impl EditMesh {
    pub(in crate::engine::mesh) fn new(surface: &Surface) -> Self {
        let mesh = &surface.mesh;
        let mut fixed = vec![false; mesh.n_vertices()];
        for &v in &surface.features.corners {
            fixed[v as usize] = true;
        }
        let (curves, segment) = Curves::trace(surface, &mut fixed);
        let mut on_curve = vec![false; mesh.n_vertices()];
        for h in (0..mesh.n_halfedges()).filter(|&h| segment[h] != NONE) {
            on_curve[mesh.origin(h) as usize] = true;
            on_curve[mesh.target(h) as usize] = true;
        }
        Self {
            positions: mesh.positions().to_vec(),
            faces: mesh.faces().to_vec(),
            twin: (0..mesh.n_halfedges()).map(|h| mesh.twin(h).map_or(NONE, |t| t as u32)).collect(),
            outgoing: (0..mesh.n_vertices() as u32).map(|v| mesh.outgoing(v) as u32).collect(),
            segment,
            fixed,
            on_curve,
            curves,
            corners: surface.features.corners.clone(),
        }
    }

    /// The living part as a surface. Vertices and faces keep their order, so the i-th corner is the i-th corner of the
    /// surface that the editing began with.
    pub(in crate::engine::mesh) fn finish(&self) -> Result<Edited, MeshError> {
        let mut number = vec![NONE; self.positions.len()];
        let mut positions = Vec::new();
        for v in (0..self.positions.len()).filter(|&v| self.outgoing[v] != NONE) {
            number[v] = positions.len() as u32;
            positions.push(self.positions[v]);
        }
        let living = (0..self.faces.len()).filter(|&f| self.is_alive(f));
        let faces = living.clone().map(|f| self.faces[f].map(|v| number[v as usize])).collect();
        let (mut edges, mut curve_middles) = (Vec::new(), Vec::new());
        for h in living.flat_map(|f| 3 * f..3 * f + 3).filter(|&h| self.is_edge_owner(h)) {
            let Some(s) = self.segment(h) else { continue };
            let (a, b) = (number[self.origin(h) as usize], number[self.target(h) as usize]);
            let edge = [a.min(b), a.max(b)];
            curve_middles.push((edge, self.curves.middle(s)));
            if self.twin[h] != NONE {
                edges.push(edge);
            }
        }
        edges.sort_unstable();
        curve_middles.sort_unstable_by_key(|&(edge, _)| edge);
        let corners = self.corners.iter().map(|&v| number[v as usize]).collect();
        let surface = Surface { mesh: TriMesh::try_new(positions, faces)?, features: Features { edges, corners } };
        Ok(Edited { surface, curve_middles })
    }

    pub(in crate::engine::mesh) fn is_alive(&self, f: usize) -> bool {
        self.faces[f][0] != NONE
    }
    pub(in crate::engine::mesh) fn origin(&self, h: usize) -> u32 {
        self.faces[h / 3][h % 3]
    }
    pub(in crate::engine::mesh) fn target(&self, h: usize) -> u32 {
        self.faces[h / 3][(h % 3 + 1) % 3]
    }
    /// The corner across the halfedge's face.
    pub(in crate::engine::mesh) fn apex(&self, h: usize) -> u32 {
        self.faces[h / 3][(h % 3 + 2) % 3]
    }
    pub(in crate::engine::mesh) fn twin(&self, h: usize) -> Option<usize> {
        (self.twin[h] != NONE).then_some(self.twin[h] as usize)
    }
    pub(in crate::engine::mesh) fn segment(&self, h: usize) -> Option<u32> {
        (self.segment[h] != NONE).then_some(self.segment[h])
    }
    pub(in crate::engine::mesh) fn position(&self, v: u32) -> DVec3 {
        self.positions[v as usize]
    }
    /// Whether a living halfedge stands for its edge.
    pub(in crate::engine::mesh) fn is_edge_owner(&self, h: usize) -> bool {
        self.is_alive(h / 3) && (self.twin[h] == NONE || h < self.twin[h] as usize)
    }
    pub(in crate::engine::mesh) fn is_living_vertex(&self, v: u32) -> bool {
        self.outgoing[v as usize] != NONE
    }
    pub(in crate::engine::mesh) fn length_squared(&self, h: usize) -> f64 {
        self.position(self.origin(h)).distance_squared(self.position(self.target(h)))
    }
    /// Twice the area of a face along its normal, with corner `v` (if it has it) moved to `p`.
    pub(in crate::engine::mesh) fn area_vector_moved(&self, f: usize, v: u32, p: DVec3) -> DVec3 {
        let [a, b, c] = self.faces[f].map(|w| if w == v { p } else { self.position(w) });
        (b - a).cross(c - a)
    }
    pub(in crate::engine::mesh) fn area_vector(&self, f: usize) -> DVec3 {
        self.area_vector_moved(f, NONE, DVec3::ZERO)
    }

    /// Fills `fan` with the halfedges leaving `v`, counter-clockwise, beginning at the open side if there is one.
    pub(in crate::engine::mesh) fn fan(&self, v: u32, fan: &mut Vec<usize>) {
        fan.clear();
        let begin = self.outgoing[v as usize] as usize;
        let mut start = begin;
        while let Some(t) = self.twin(start) {
            start = next(t);
            if start == begin {
                break;
            }
        }
        let mut h = start;
        loop {
            fan.push(h);
            match self.twin(prev(h)) {
                Some(n) if n != start => h = n,
                _ => break,
            }
        }
    }

    /// The neighbours of the vertex that `fan` leaves.
    pub(in crate::engine::mesh) fn neighbours<'a>(&'a self, fan: &'a [usize]) -> impl Iterator<Item = u32> + 'a {
        let last = fan.last().filter(|&&h| self.twin[prev(h)] == NONE).map(|&h| self.origin(prev(h)));
        fan.iter().map(|&h| self.target(h)).chain(last)
    }

    fn link(&mut self, h: usize, t: u32) {
        self.twin[h] = t;
        if t != NONE {
            self.twin[t as usize] = h as u32;
        }
    }
}
