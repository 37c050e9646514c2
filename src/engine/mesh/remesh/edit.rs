//! A triangle mesh that can be changed: implicit halfedges as in [`TriMesh`], with dead faces and vertices until the end.

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

    fn push_face(&mut self, corners: [u32; 3]) -> usize {
        self.faces.push(corners);
        self.twin.extend([NONE; 3]);
        self.segment.extend([NONE; 3]);
        self.faces.len() - 1
    }

    fn push_vertex(&mut self, p: DVec3, on_curve: bool) -> u32 {
        self.positions.push(p);
        self.outgoing.push(NONE);
        self.fixed.push(false);
        self.on_curve.push(on_curve);
        (self.positions.len() - 1) as u32
    }

    /// Moves a halfedge's twin and segment to the (new) halfedge `to`.
    fn hand_over(&mut self, from: usize, to: usize) {
        self.link(to, self.twin[from]);
        self.segment[to] = self.segment[from];
        (self.twin[from], self.segment[from]) = (NONE, NONE);
    }

    /// Puts a vertex at `p` on the edge of `h`. On a curve it stands at arc length `t` of the edge's segment. Returns
    /// the vertex and the new faces, of which the second is on the other side of the edge; the new face on either side
    /// lies at the target of that side's halfedge.
    pub(in crate::engine::mesh) fn split(&mut self, h: usize, p: DVec3, t: f64) -> (u32, [Option<usize>; 2]) {
        let (a, b, c) = (self.origin(h), self.target(h), self.apex(h));
        let twin = self.twin(h);
        let segment = self.segment(h);
        let m = self.push_vertex(p, segment.is_some());
        let f = self.push_face([m, b, c]);
        self.hand_over(next(h), 3 * f + 1);
        self.faces[h / 3][(h % 3 + 1) % 3] = m;
        self.link(next(h), (3 * f + 2) as u32);
        self.outgoing[b as usize] = (3 * f + 1) as u32;
        self.outgoing[m as usize] = 3 * f as u32;
        let mut far = None;
        if let Some(t) = twin {
            let d = self.apex(t);
            let g = self.push_face([m, a, d]);
            self.hand_over(next(t), 3 * g + 1);
            self.faces[t / 3][(t % 3 + 1) % 3] = m;
            self.link(next(t), (3 * g + 2) as u32);
            self.outgoing[a as usize] = (3 * g + 1) as u32;
            self.link(h, (3 * g) as u32);
            self.link(t, (3 * f) as u32);
            far = Some(g);
        }
        if let Some(s) = segment {
            let other = self.curves.split(s, a, m, t);
            self.segment[3 * f] = other;
            if let (Some(g), Some(t)) = (far, twin) {
                self.segment[3 * g] = s;
                self.segment[t] = other;
            }
        }
        (m, [Some(f), far])
    }

    /// Puts a vertex at `p` inside face `f`. Returns it; the two new faces are the last two.
    pub(in crate::engine::mesh) fn split_face(&mut self, f: usize, p: DVec3) -> u32 {
        let [a, b, c] = self.faces[f];
        let m = self.push_vertex(p, false);
        let g = self.push_face([b, c, m]);
        let k = self.push_face([c, a, m]);
        self.hand_over(3 * f + 1, 3 * g);
        self.hand_over(3 * f + 2, 3 * k);
        self.faces[f] = [a, b, m];
        self.link(3 * f + 1, (3 * g + 2) as u32);
        self.link(3 * g + 1, (3 * k + 2) as u32);
        self.link(3 * k + 1, (3 * f + 2) as u32);
        for (v, h) in [(a, 3 * f), (b, 3 * g), (c, 3 * k), (m, 3 * f + 2)] {
            self.outgoing[v as usize] = h as u32;
        }
        m
    }

    /// Replaces the diagonal of the two faces at `h` by the other one. The edge must be neither on a curve nor on the
    /// boundary and the new one must not exist yet.
    pub(in crate::engine::mesh) fn flip(&mut self, h: usize) {
        let Some(t) = self.twin(h) else { return };
        let (a, b, c, d) = (self.origin(h), self.target(h), self.apex(h), self.apex(t));
        let outer = [next(t), prev(h), prev(t), next(h)].map(|x| (self.twin[x], self.segment[x]));
        let (f, g) = (h / 3, t / 3);
        self.faces[f] = [a, d, c];
        self.faces[g] = [d, b, c];
        for (slot, (twin, segment)) in [3 * f, 3 * f + 2, 3 * g, 3 * g + 1].into_iter().zip(outer) {
            self.link(slot, twin);
            self.segment[slot] = segment;
        }
        self.link(3 * f + 1, (3 * g + 2) as u32);
        (self.segment[3 * f + 1], self.segment[3 * g + 2]) = (NONE, NONE);
        for (v, x) in [(a, 3 * f), (d, 3 * f + 1), (c, 3 * f + 2), (b, 3 * g + 1)] {
            self.outgoing[v as usize] = x as u32;
        }
    }

    /// Whether pulling the origin of `h` into its target keeps a manifold with the same topology and feature chains.
    /// `fan_a`, `fan_b` are the fans of the two.
    pub(in crate::engine::mesh) fn may_collapse(&self, h: usize, fan_a: &[usize], fan_b: &[usize]) -> bool {
        let (a, b, c) = (self.origin(h), self.target(h), self.apex(h));
        if self.fixed[a as usize] {
            return false;
        }
        if self.on_curve[a as usize] {
            let Some(s) = self.segment(h) else { return false };
            // Its other curve edge must go on along the same chain, and must not be in one of the faces that vanish:
            // that would leave a curve across a face's side.
            let Some((other, to)) = self.other_segment(fan_a, s) else { return false };
            if !self.curves.same_chain(s, other) || to == c || self.twin(h).is_some_and(|t| to == self.apex(t)) {
                return false;
            }
        } else if self.segment(h).is_some() {
            return false;
        }
        // Link condition: nothing is adjacent to both ends but the apices; and a face is left at each apex.
        let d = self.twin(h).map(|t| self.apex(t));
        for n in self.neighbours(fan_a).filter(|&n| n != c && Some(n) != d && n != b) {
            if self.neighbours(fan_b).any(|m| m == n) {
                return false;
            }
        }
        let open = |h: usize| self.twin[next(h)] == NONE && self.twin[prev(h)] == NONE;
        if open(h) || self.twin(h).is_some_and(open) {
            return false;
        }
        // A tetrahedron has nothing to spare; no other closed fan this small passes the link condition.
        let closed = |fan: &[usize]| self.twin[prev(fan[fan.len() - 1])] != NONE;
        let mut fan_c = Vec::new();
        for apex in [Some(c), d].into_iter().flatten() {
            self.fan(apex, &mut fan_c);
            if closed(&fan_c) && fan_c.len() <= 3 {
                return false;
            }
        }
        true
    }

    /// The curve edge that leaves the fan's vertex and is not `s`, and the vertex at its other end.
    pub(in crate::engine::mesh) fn other_segment(&self, fan: &[usize], s: u32) -> Option<(u32, u32)> {
        let closing = fan.last().map(|&h| prev(h)).filter(|&h| self.twin[h] == NONE);
        let leaving = fan.iter().map(|&h| (self.segment[h], self.target(h)));
        leaving.chain(closing.map(|h| (self.segment[h], self.origin(h)))).find(|&(r, _)| r != NONE && r != s)
    }

    /// Pulls the origin of `h`, whose fan is `fan_a`, into its target. Ask [`EditMesh::may_collapse`] before.
    pub(in crate::engine::mesh) fn collapse(&mut self, h: usize, fan_a: &[usize]) {
        let (a, b) = (self.origin(h), self.target(h));
        if let Some(s) = self.segment(h)
            && let Some((other, _)) = self.other_segment(fan_a, s)
        {
            self.curves.merge(s, other, a);
        }
        for &x in fan_a {
            self.faces[x / 3][x % 3] = b;
        }
        let sides = [Some(h), self.twin(h)];
        for side in sides.into_iter().flatten() {
            let apex = self.apex(side);
            let (p, q) = (next(side), prev(side));
            let (x, y) = (self.twin[p], self.twin[q]);
            let segment = if self.segment[p] != NONE { self.segment[p] } else { self.segment[q] };
            for (one, other) in [(x, y), (y, x)] {
                if one != NONE {
                    self.twin[one as usize] = other;
                    self.segment[one as usize] = segment;
                }
            }
            // `x` runs from the apex to an end of the collapsed edge on the side of `h`, the other way on its twin's.
            for one in [x, y].into_iter().filter(|&one| one != NONE) {
                for leaving in [one as usize, next(one as usize)] {
                    let v = self.origin(leaving);
                    if v == b || v == apex {
                        self.outgoing[v as usize] = leaving as u32;
                    }
                }
            }
        }
        for side in sides.into_iter().flatten() {
            self.faces[side / 3] = [NONE; 3];
        }
        self.outgoing[a as usize] = NONE;
    }

    /// The first disagreement between the tables, if there is one.
    #[cfg(test)]
    pub(in crate::engine::mesh) fn fault(&self) -> Option<String> {
        for h in (0..3 * self.faces.len()).filter(|&h| self.is_alive(h / 3)) {
            let (a, b) = (self.origin(h), self.target(h));
            if let Some(t) = self.twin(h)
                && (!self.is_alive(t / 3) || (self.origin(t), self.target(t)) != (b, a) || self.twin(t) != Some(h))
            {
                return Some(format!("twin of {h}"));
            }
            if self.twin(h).is_some_and(|t| self.segment(t) != self.segment(h)) {
                return Some(format!("segments at {h}"));
            }
            if let Some(s) = self.segment(h) {
                let segment = self.curves.segment(s);
                if ![[a, b], [b, a]].contains(&segment.v) || segment.t[0] >= segment.t[1] {
                    return Some(format!("segment {segment:?} of {h} from {a} to {b}"));
                }
            }
        }
        (0..self.positions.len() as u32).filter(|&v| self.is_living_vertex(v)).find_map(|v| {
            let h = self.outgoing[v as usize] as usize;
            (!self.is_alive(h / 3) || self.origin(h) != v).then(|| format!("outgoing of {v}"))
        })
    }
}
