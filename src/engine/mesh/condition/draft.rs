//! A manifold in the making.

use glam::DVec3;

use crate::engine::mesh::NONE;
use crate::engine::mesh::next;

/// An oriented 2-manifold with its way back to the soup. Halfedges as in [`crate::engine::mesh::TriMesh`].
#[derive(Clone, Debug)]
pub(super) struct Draft {
    /// Positions in scaled units.
    pub(super) positions: Vec<DVec3>,
    /// Position of the soup per vertex.
    pub(super) origin: Vec<u32>,
    /// Whether the vertex is not exactly at the place of its origin.
    pub(super) moved: Vec<bool>,
    /// Corners per face.
    pub(super) faces: Vec<[u32; 3]>,
    /// Opposite halfedge or [`NONE`].
    pub(super) twin: Vec<u32>,
    /// Polygon of the soup per face.
    pub(super) polygon: Vec<u32>,
}

impl Draft {
    /// First vertex of halfedge `h`.
    pub(super) fn start(&self, h: u32) -> u32 {
        self.faces[h as usize / 3][h as usize % 3]
    }

    /// Second vertex of halfedge `h`.
    pub(super) fn end(&self, h: u32) -> u32 {
        self.start(next(h as usize) as u32)
    }

    /// Makes `h` and `t` opposite halfedges; either may be [`NONE`].
    pub(super) fn glue(&mut self, h: u32, t: u32) {
        if h != NONE {
            self.twin[h as usize] = t;
        }
        if t != NONE {
            self.twin[t as usize] = h;
        }
    }

    /// Splits the edge of `h` at its midpoint. Returns the halfedges that are called otherwise now, old and new name.
    pub(super) fn split_edge(&mut self, h: u32) -> Vec<(u32, u32)> {
        let t = self.twin[h as usize];
        let (a, b) = (self.start(h), self.end(h));
        let m = self.positions.len() as u32;
        self.positions.push(0.5 * (self.positions[a as usize] + self.positions[b as usize]));
        self.origin.push(self.origin[a.min(b) as usize]);
        self.moved.push(true);
        let (new_h, renamed) = self.split_side(h, m);
        if t == NONE {
            return vec![renamed];
        }
        let (new_t, renamed_too) = self.split_side(t, m);
        self.glue(h, new_t);
        self.glue(t, new_h);
        vec![renamed, renamed_too]
    }

    /// Cuts the face of `h` from `m` on `h` to the opposite corner. `h` keeps its first half; returns the halfedge of
    /// the second half, and the one that went to the new face.
    fn split_side(&mut self, h: u32, m: u32) -> (u32, (u32, u32)) {
        let f = h as usize / 3;
        let after = next(h as usize) as u32;
        let [b, c] = [self.end(h), self.end(after)];
        let new = 3 * self.faces.len() as u32;
        self.faces.push([m, b, c]);
        self.polygon.push(self.polygon[f]);
        self.twin.extend([NONE; 3]);
        self.faces[f][after as usize % 3] = m;
        self.glue(new + 1, self.twin[after as usize]);
        self.glue(after, new + 2);
        (new, (after, new + 1))
    }

    /// Keeps the faces for which `keep` holds and the vertices they use, in order. Sides to faces that go become open.
    pub(super) fn retain(&mut self, keep: &[bool]) {
        let mut face = vec![NONE; self.faces.len()];
        let mut used = vec![false; self.positions.len()];
        let mut n = 0;
        for f in (0..face.len()).filter(|&f| keep[f]) {
            face[f] = n;
            n += 1;
            for v in self.faces[f] {
                used[v as usize] = true;
            }
        }
        let mut vertex = vec![NONE; self.positions.len()];
        let mut n = 0;
        for v in (0..used.len()).filter(|&v| used[v]) {
            vertex[v] = n;
            n += 1;
        }
        let faces = || (0..face.len()).filter(|&f| keep[f]);
        let vertices = || (0..used.len()).filter(|&v| used[v]);
        let rename = |t: u32| match t {
            NONE => NONE,
            t if face[t as usize / 3] == NONE => NONE,
            t => 3 * face[t as usize / 3] + t % 3,
        };
        self.twin = faces().flat_map(|f| 3 * f..3 * f + 3).map(|h| rename(self.twin[h])).collect();
        self.polygon = faces().map(|f| self.polygon[f]).collect();
        self.faces = faces().map(|f| self.faces[f].map(|v| vertex[v as usize])).collect();
        self.positions = vertices().map(|v| self.positions[v]).collect();
        self.origin = vertices().map(|v| self.origin[v]).collect();
        self.moved = vertices().map(|v| self.moved[v]).collect();
    }
}
