//! New vertices on edges and in faces.

use glam::DVec3;

use crate::engine::mesh::remesh::edit::EditMesh;
use crate::engine::mesh::{NONE, next};

impl EditMesh {
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
}
